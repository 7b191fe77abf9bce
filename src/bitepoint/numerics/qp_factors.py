"""What Hessian and rows of a quadratic programme determine: the inverse of the Cholesky factor, and unit normals."""

from __future__ import annotations

import math

from bitepoint.kernels import EPSILON, is_finite, kernel
from bitepoint.numerics.qp_records import NOT_FINITE, ROWS, SOLVED, VARIABLES, QpMatrices


@kernel
def qp_invert(m: QpMatrices) -> bool:
    """Write the inverse of L into the lower triangle, 0 elsewhere; return whether H is positive definite."""
    positive = True
    for i in range(m.variables):
        for j in range(i + 1):
            total = m.hessian[i, j]
            for k in range(j):
                total -= m.inverse_factor[i, k] * m.inverse_factor[j, k]
            if j < i:
                m.inverse_factor[i, j] = total * m.inverse_factor[j, j]
            else:
                positive = positive and total > 4.0 * EPSILON * m.hessian[i, i]
                m.inverse_factor[i, i] = 1.0 / math.sqrt(total)
    for j in range(m.variables):
        for i in range(j + 1, m.variables):
            total = 0.0
            for k in range(j, i):
                total -= m.inverse_factor[i, k] * m.inverse_factor[k, j]
            m.inverse_factor[i, j] = total * m.inverse_factor[i, i]
    for i in range(VARIABLES):
        for j in range(VARIABLES):
            if j > i or i >= m.variables:
                m.inverse_factor[i, j] = 0.0
            if i >= m.variables or j >= m.variables:
                m.hessian[i, j] = 0.0
    return positive


@kernel
def qp_share(m: QpMatrices) -> int:
    """Return the slab that has the normal behind the last one, or its opposite; the place behind where none has."""
    place = min(m.slabs, ROWS - 1)
    found = place
    for k in range(m.slabs):
        same = True
        opposite = True
        for j in range(VARIABLES):
            same = same and m.normals[k, j] == m.normals[place, j]
            opposite = opposite and m.normals[k, j] == -m.normals[place, j]
        if same or opposite:
            found = k
    return found


@kernel
def qp_normalise(m: QpMatrices) -> bool:
    """Write normals, slabs and scales; return whether all are finite. A row shorter than EPSILON**2 is one of zeros."""
    sum_of_all = 0.0
    m.slabs = 0
    for i in range(m.rows):
        place = min(m.slabs, ROWS - 1)
        sum_of_squares = 0.0
        for j in range(m.variables, VARIABLES):
            m.constraints[i, j] = 0.0
        for k in range(VARIABLES):
            part = 0.0
            for j in range(k + 1):
                part += m.constraints[i, j] * m.inverse_factor[k, j]
            m.normals[place, k] = part
            sum_of_squares += part**2
        sum_of_all += sum_of_squares
        scale = 0.0
        if sum_of_squares > EPSILON**2 * EPSILON**2:
            scale = 1.0 / math.sqrt(sum_of_squares)
        for k in range(VARIABLES):
            m.normals[place, k] *= scale
        m.slab[i] = 0
        if scale > 0.0:
            slab = min(max(qp_share(m), 0), ROWS - 1)
            cosine = 0.0
            for k in range(VARIABLES):
                cosine += m.normals[slab, k] * m.normals[place, k]
            if cosine < 0.0:
                scale = -scale
            m.slab[i] = slab
            if slab == m.slabs:
                m.slabs = slab + 1
        m.scales[i] = scale
    return is_finite(sum_of_all)


@kernel
def qp_factorise(m: QpMatrices) -> int:
    """Prepare `m`, whose hessian, constraints, variables and rows are given, for `qp_solve`.

    Of the Hessian the lower triangle is factorised. Places of hessian and constraints that are not in use become 0.

    Returns:
        SOLVED, or NOT_FINITE where a number is not finite or H is not positive definite.
    """
    positive = qp_invert(m)
    finite = qp_normalise(m)
    m.usable = 1 if positive and finite else 0
    return SOLVED if positive and finite else NOT_FINITE
