"""Steps of the dual active-set method: choose a violated row, go towards its limit, make rows active and inactive.

The entering normal n is split by the basis: d = basis n. Its first parts, those along the active normals, give the
ratios r at which the forces of active rows fall as that of the entering one grows; the rest is the direction z in which
the point moves. Names in the cited paper: point x, forces u, parts d, direction z, ratios r, triangle R transposed.
"""

from __future__ import annotations

import math

from bitepoint.kernels import EPSILON, is_finite, kernel
from bitepoint.numerics.qp_records import INFEASIBLE, NOT_FINITE, ROWS, VARIABLES, QpData, QpMatrices, QpWork

SOLVING = -1
"""Status while it is open."""

ADDED, DROPPED, STUCK = 0, 1, 2
"""Outcomes of a step: the entering row became active, an active one inactive, or neither ever will."""


@kernel
def qp_tolerance(size: float) -> float:
    """Return by how much a limit is missed that is not violated, in terms of y and of the size of the programme."""
    return math.sqrt(EPSILON) * math.sqrt(math.sqrt(EPSILON)) * size


@kernel
def qp_limits(m: QpMatrices, d: QpData, w: QpWork) -> int:
    """Limit each slab to what its rows leave of it; return SOLVING, or why not.

    Limits of different rows that miss each other by no more than rounding are equal.
    """
    status = SOLVING
    w.watched = 0
    for i in range(m.rows):
        room = d.low[i] <= d.high[i]
        low = d.low[i] * m.scales[i]
        high = d.high[i] * m.scales[i]
        # never: in a part no row of which is another one turned round
        if m.scales[i] < 0.0:
            low = d.high[i] * m.scales[i]
            high = d.low[i] * m.scales[i]
        slab = m.slab[i]
        # never: in a part no row of which is one of zeros
        if m.scales[i] == 0.0:
            # never: not, in a part that orders its limits and lets 0 between them
            room = room and d.low[i] <= 0.0 and d.high[i] >= 0.0
        # never: else, in a part that has parallel rows
        elif slab == w.watched:
            w.watch[slab] = slab
            w.watched = slab + 1
            w.low[slab] = low
            w.high[slab] = high
            w.lowest[slab] = i
            w.highest[slab] = i
        else:
            if low > w.low[slab]:
                w.low[slab] = low
                w.lowest[slab] = i
            if high < w.high[slab]:
                w.high[slab] = high
                w.highest[slab] = i
            if w.low[slab] > w.high[slab]:
                # never: not, in a part that orders its limits
                room = room and w.low[slab] - w.high[slab] <= qp_tolerance(w.size + abs(w.high[slab]))
                w.low[slab] = w.high[slab]
        # never: in a part that orders its limits and lets 0 between them
        if not room:
            if status == SOLVING:
                status = INFEASIBLE
            # never: in a part whose limits are numbers
            if not (d.low[i] <= d.high[i] or d.low[i] > d.high[i]):
                status = NOT_FINITE
    return status


@kernel
def qp_begin(m: QpMatrices, d: QpData, w: QpWork) -> int:
    """Begin at the unconstrained minimum, with no slab active; return SOLVING, or why not."""
    w.members = 0
    w.size = 0.0
    for j in range(VARIABLES):
        w.point[j] = 0.0
    for k in range(m.variables):
        total = 0.0
        for j in range(k + 1):
            total -= m.inverse_factor[k, j] * d.gradient[j]
        w.point[k] = total
        w.size += abs(total)
        for j in range(VARIABLES):
            w.basis[k, j] = 0.0
        w.basis[k, k] = 1.0
    status = qp_limits(m, d, w)
    # never: else, in a part that looks before it asks
    return status if m.usable == 1 and is_finite(w.size) else NOT_FINITE


@kernel
def qp_choose(m: QpMatrices, w: QpWork) -> None:
    """Find the slab whose limits are violated most, in terms of y; the gap is 0 where none is."""
    worst = qp_tolerance(w.size)
    gap = 0.0
    for place in range(w.watched):
        i = w.watch[place]
        value = m.normals[i, 0] * w.point[0]
        for j in range(1, m.variables):
            value += m.normals[i, j] * w.point[j]
        above = value - w.high[i]
        below = w.low[i] - value
        if above > worst:
            worst = above
            gap = above
            w.place = place
        if below > worst:
            worst = below
            gap = -below
            w.place = place
    w.entering = w.watch[w.place]
    w.gap = gap
    w.force = 0.0


@kernel
def qp_enter(m: QpMatrices, w: QpWork) -> None:
    """Split the entering normal: its parts in the basis, and the direction, which active normals do not span."""
    for j in range(m.variables):
        w.direction[j] = 0.0
    total = 0.0
    for k in range(m.variables):
        part = w.basis[k, 0] * m.normals[w.entering, 0]
        for j in range(1, m.variables):
            part += w.basis[k, j] * m.normals[w.entering, j]
        w.parts[k] = part
        if k >= w.members:
            total += part**2
            for j in range(m.variables):
                w.direction[j] += part * w.basis[k, j]
    w.square = total


@kernel
def qp_limit(w: QpWork) -> None:
    """Find how far the force of the entering row can grow until that of an active row falls to 0, and of which."""
    limit = -1.0
    heading = 1.0 if w.gap > 0.0 else -1.0
    for k in range(w.members - 1, -1, -1):
        total = w.parts[k]
        for j in range(k + 1, w.members):
            total -= w.triangle[j, k] * w.ratios[j]
        ratio = total * w.pivots[k]
        w.ratios[k] = ratio
        fall = heading * w.sides[k] * ratio
        if fall > 64.0 * EPSILON:
            reach = max(0.0, w.sides[k] * w.forces[k]) / fall
            if limit < 0.0 or reach < limit:
                limit = reach
                w.leaving = k
    w.limit = limit


@kernel
def qp_add(m: QpMatrices, w: QpWork) -> None:
    """Make the entering row active: reflect the free part of the basis so that one more row spans its normal."""
    q = min(w.members, VARIABLES - 1)
    for j in range(q):
        w.triangle[q, j] = w.parts[j]
    diagonal = w.parts[q]
    if q < m.variables - 1:  # else one row of the basis is left, and nothing to turn
        length = math.sqrt(w.square)
        diagonal = -length if w.parts[q] >= 0.0 else length
        share = 1.0 / (w.square + length * abs(w.parts[q]))
        w.parts[q] -= diagonal
        for j in range(m.variables):
            w.direction[j] -= diagonal * w.basis[q, j]
        for k in range(q, m.variables):
            factor = share * w.parts[k]
            for j in range(m.variables):
                w.basis[k, j] -= factor * w.direction[j]
    w.triangle[q, q] = diagonal
    w.pivots[q] = 1.0 / diagonal
    w.active[q] = w.entering
    w.forces[q] = w.force
    # never: 0, in a part between whose limits there is room
    w.sides[q] = 0.0 if w.low[w.entering] == w.high[w.entering] else (1.0 if w.gap > 0.0 else -1.0)
    w.members = min(w.members + 1, VARIABLES)
    last = max(w.watched - 1, 0)
    w.watch[w.place] = w.watch[last]
    w.watched = last


@kernel
def qp_drop(m: QpMatrices, w: QpWork) -> None:
    """Make the leaving row inactive; what it alone spanned of the entering normal goes to the direction."""
    last = min(w.watched, ROWS - 1)
    w.watch[last] = w.active[w.leaving]
    w.watched = last + 1
    for k in range(w.leaving, w.members - 1):
        w.active[k] = w.active[k + 1]
        w.sides[k] = w.sides[k + 1]
        w.forces[k] = w.forces[k + 1]
        for j in range(k):
            w.triangle[k, j] = w.triangle[k + 1, j]
        a = w.triangle[k + 1, k]
        b = w.triangle[k + 1, k + 1]
        length = math.sqrt(a**2 + b**2)
        pivot = 1.0 / length
        cosine = a * pivot
        sine = b * pivot
        w.triangle[k, k] = length
        w.pivots[k] = pivot
        for i in range(k + 2, w.members):
            a = w.triangle[i, k]
            b = w.triangle[i, k + 1]
            w.triangle[i, k] = cosine * a + sine * b
            w.triangle[i, k + 1] = cosine * b - sine * a
        a = w.parts[k]
        b = w.parts[k + 1]
        w.parts[k] = cosine * a + sine * b
        w.parts[k + 1] = cosine * b - sine * a
        for j in range(m.variables):
            a = w.basis[k, j]
            b = w.basis[k + 1, j]
            w.basis[k, j] = cosine * a + sine * b
            w.basis[k + 1, j] = cosine * b - sine * a
    w.members = max(w.members - 1, 0)
    freed = min(w.members, VARIABLES - 1)
    part = w.parts[freed]
    w.square += part**2
    for j in range(m.variables):
        w.direction[j] += part * w.basis[freed, j]


@kernel
def qp_advance(m: QpMatrices, w: QpWork) -> int:
    """Step along the direction; return ADDED at the limit of the entering row, DROPPED at a force of 0, or STUCK."""
    outcome = DROPPED
    step = w.limit
    # never: past this and the next, where the rows have a common point
    if w.limit * w.square >= abs(w.gap) or (w.limit < 0.0 and w.square > EPSILON * math.sqrt(EPSILON)):
        outcome = ADDED
        step = abs(w.gap) / w.square
    # active rows span the entering one, and none can give way; never: where the rows have a common point
    elif w.limit < 0.0:
        outcome = STUCK
    # never: unless a limit overflows in terms of y
    if not is_finite(step):
        outcome = STUCK
    # never: STUCK where the rows have a common point
    if outcome != STUCK:
        w.size += step * math.sqrt(w.square)
        if w.gap < 0.0:
            step = -step
        w.force += step
        for k in range(w.members):
            w.forces[k] -= step * w.ratios[k]
        for j in range(m.variables):
            w.point[j] -= step * w.direction[j]
        if outcome == DROPPED:
            w.gap -= step * w.square
    return outcome
