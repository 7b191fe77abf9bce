"""Strictly convex quadratic programmes, dense and small, by the dual active-set method.

    minimise  1/2 x' H x + f' x   subject to   low <= G x <= high

H is symmetric and positive definite; a row may lack either limit, or have both equal. With H = L L' and y = L' x the
programme is that of the point nearest to y0 = -inverse(L) f inside slabs low <= n' y <= high, whose normals n are the
rows of G inverse(L'). What H and G determine is made once, by `factorise`; `solve` starts at y0 and makes one violated
row after another active, dropping those whose multiplier would change its sign, until no row is violated. The
objective grows with each row, so that no set of rows comes twice.

All numbers are plain ratios: units are those of whoever states the programme. Tolerances are powers of EPSILON, and so
hold in float32 too.

Reference: D. Goldfarb, A. Idnani, Math. Programming 27 (1983) 1-33; their J is inverse(L') times the transposed basis,
kept in two factors, and a Householder reflection takes the place of their Givens rotations where a row is added.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from bitepoint.errors import InputError
from bitepoint.kernels import EPSILON, Kernel, is_finite, kernel
from bitepoint.numerics.qp_factors import qp_factorise, qp_invert, qp_normalise, qp_share
from bitepoint.numerics.qp_records import (
    INACCURATE,
    INFEASIBLE,
    ITERATION_CAP,
    ITERATIONS,
    NOT_FINITE,
    SOLVED,
    VARIABLES,
    QpData,
    QpMatrices,
    QpSolution,
    QpWork,
    resized,
)
from bitepoint.numerics.qp_steps import (
    ADDED,
    DROPPED,
    SOLVING,
    qp_add,
    qp_advance,
    qp_begin,
    qp_choose,
    qp_drop,
    qp_enter,
    qp_limit,
    qp_limits,
    qp_tolerance,
)
from bitepoint.numerics.unrolling import unrolled
from bitepoint.records import Record

MOST_VARIABLES, MOST_ROWS = 32, 128
MOST_UNROLLED = 8
"""Variables up to which the innermost loops are written out, at full length; larger ones run over those in use."""


@kernel
def qp_row_residual(m: QpMatrices, d: QpData, w: QpWork, s: QpSolution) -> float:
    """Return the largest distance, in terms of y and relative to its size, from a limit that is violated or active."""
    worst = 0.0
    for i in range(m.rows):
        value = m.constraints[i, 0] * s.x[0]
        for j in range(1, m.variables):
            value += m.constraints[i, j] * s.x[j]
        above = value - d.high[i]
        below = d.low[i] - value
        if s.multipliers[i] > 0.0:
            above = abs(above)
        elif s.multipliers[i] < 0.0:
            below = abs(below)
        worst = max(worst, max(above, below) * abs(m.scales[i]))  # NaN for a row of zeros without limits
    return worst / w.size if worst > 0.0 else worst


@kernel
def qp_stationarity(m: QpMatrices, d: QpData, w: QpWork, s: QpSolution) -> float:
    """Return the largest component of H x + f + G' multipliers, relative to the largest sum of what it is made of."""
    worst = 0.0
    largest = 0.0
    for j in range(m.variables):
        total = d.gradient[j]
        terms = abs(total)
        for k in range(m.variables):
            part = m.hessian[j, k] * s.x[k]
            total += part
            terms += abs(part)
        for k in range(w.members):
            part = m.constraints[w.active[k], j] * s.multipliers[w.active[k]]
            total += part
            terms += abs(part)
        worst = max(abs(total), worst)
        largest = max(terms, largest)
    return worst / largest if worst > 0.0 else worst


@kernel
def qp_finish(m: QpMatrices, d: QpData, w: QpWork, s: QpSolution) -> bool:
    """Write x, multipliers and residual; return whether they are finite."""
    canary = 0.0
    for k in range(w.members):
        slab = w.active[k]
        row = w.highest[slab] if w.forces[k] > 0.0 else w.lowest[slab]
        multiplier = w.forces[k] * m.scales[row]
        # never: else, but where rounding turned the sign of a force that is nearly 0
        if w.sides[k] * w.forces[k] >= 0.0:
            s.multipliers[row] = multiplier
        w.active[k] = row
        canary += abs(multiplier)
    for k in range(m.variables):
        part = w.point[k]
        for j in range(k + 1):
            s.x[j] += m.inverse_factor[k, j] * part
    rows = qp_row_residual(m, d, w, s)
    stationarity = qp_stationarity(m, d, w, s)
    s.residual = max(stationarity, rows)
    for j in range(m.variables):
        canary += abs(s.x[j])
    return is_finite(canary + stationarity + rows)


@kernel
def qp_clear(m: QpMatrices, s: QpSolution) -> None:
    """Write that there is no solution."""
    for j in range(VARIABLES):
        s.x[j] = 0.0
    for i in range(m.rows):
        s.multipliers[i] = 0.0
    s.residual = -1.0


@kernel
def qp_solve(m: QpMatrices, d: QpData, w: QpWork, s: QpSolution) -> int:
    """Solve the programme of factorised `m` and of `d` into `s`; return the status.

    The residual is the largest of the row residuals, distance from a limit that is violated or whose multiplier is
    not 0, and the stationarity. It is computed from H and G themselves, and is 0 for an exact solution. Infinite
    limits are no limits; a row of zeros is feasible if low <= 0 <= high.

    Returns:
        SOLVED; INFEASIBLE: no x satisfies all rows; ITERATION_CAP: not done within the cap; NOT_FINITE: a number of
        the data is NaN, f is infinite, a result overflows, or `m` was not factorised; INACCURATE: the residual is
        above the square root of EPSILON (or H is not symmetric). With any but SOLVED, x and the multipliers are 0.
    """
    qp_clear(m, s)
    status = qp_begin(m, d, w)
    outcome = ADDED
    # never: to its end in millions of programmes that were tried, see ITERATIONS; it guards against rounding
    for iteration in range(ITERATIONS + 1):
        if outcome == ADDED and status == SOLVING:
            qp_choose(m, w)
            if w.gap == 0.0:
                status = SOLVED
            else:
                qp_enter(m, w)
        s.iterations = iteration
        if status != SOLVING:
            break
        qp_limit(w)
        outcome = qp_advance(m, w)
        if outcome == ADDED:
            qp_add(m, w)
        # never: else, where the rows have a common point
        elif outcome == DROPPED:
            qp_drop(m, w)
        else:
            status = INFEASIBLE
    if status == SOLVED:
        finite = qp_finish(m, d, w, s)
        if not finite:
            status = NOT_FINITE
        elif s.residual > math.sqrt(EPSILON):
            status = INACCURATE
        if status != SOLVED:
            qp_clear(m, s)
    # never: the cap, see above
    return ITERATION_CAP if status == SOLVING else status


@dataclass(frozen=True)
class QpSolver:
    """Record types and kernels for programmes of up to `variables` and `rows`.

    Attributes:
        iterations: the cap.
        matrices, data, work, solution: types as `QpMatrices`, `QpData`, `QpWork` and `QpSolution`.
        factorise: kernel `factorise(matrices) -> status`, for each change of H or G.
        solve: kernel `solve(matrices, data, work, solution) -> status`. Its `run` takes arrays of records, so that a
            batch is solved in one call; one record of work serves all lanes.
    """

    variables: int
    rows: int
    iterations: int
    matrices: type[Record]
    data: type[Record]
    work: type[Record]
    solution: type[Record]
    factorise: Kernel[..., int]
    solve: Kernel[..., int]


@cache
def qp_solver(variables: int, rows: int) -> QpSolver:
    """Return the solver whose records hold `variables` (3 where fewer are asked for) and `rows` (1 for 0).

    Raises:
        InputError: a size outside 1..32 variables, 0..128 rows.
    """
    for what, size, least, most in (("variables", variables, 1, MOST_VARIABLES), ("rows", rows, 0, MOST_ROWS)):
        if not least <= size <= most:
            raise InputError("qp_solver", f"got {size} {what}", f"expected {least} to {most}")
    if variables < 3 or rows < 1:  # a smaller array cannot be proven to hold what lies beside the diagonal
        return qp_solver(max(variables, 3), max(rows, 1))
    types = {t.__name__: resized(t, variables, rows) for t in (QpMatrices, QpData, QpWork, QpSolution)}
    iterations = int(types["QpSolution"].fields["iterations"].high)
    meanings: dict[str, Any] = {"VARIABLES": variables, "ROWS": rows, "ITERATIONS": iterations, **types}
    write_out = variables <= MOST_UNROLLED
    for source in CALLEES_FIRST:
        name = f"{source.name}_{variables}x{rows}"
        make = source.specialise
        if write_out and source in HOT:
            make = partial(unrolled, source, lengths={"m.variables": variables})
        meanings[source.name] = make(name, meanings)
    matrices, data, work, solution = types.values()
    factorise, solve = meanings["qp_factorise"], meanings["qp_solve"]
    return QpSolver(variables, rows, iterations, matrices, data, work, solution, factorise, solve)


CALLEES_FIRST: tuple[Kernel[..., Any], ...] = (
    qp_invert, qp_share, qp_normalise, qp_factorise, qp_tolerance, qp_limits, qp_begin, qp_choose, qp_enter, qp_limit,
    qp_add, qp_drop, qp_advance, qp_row_residual, qp_stationarity, qp_finish, qp_clear, qp_solve,
)  # fmt: skip
"""All kernels."""

HOT = (qp_choose, qp_enter, qp_add, qp_drop, qp_advance, qp_row_residual, qp_stationarity)
"""Kernels that spend their time in loops over the variables."""
