"""Look-up in curves."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Curve


@kernel
def lookup(table: Curve, x: float) -> float:
    """Return y(x) of the curve: linear between its points, constant beyond them, the first ordinate where x is NaN."""
    k = 0
    for i in range(1, 32):
        if i >= table.points or not (x >= table.x[i]):
            break
        k = i
    after = min(k + 1, 31)
    y = table.y[k]
    if x > table.x[k] and table.x[after] > table.x[k]:  # the unused points repeat the last
        y = y + (table.y[after] - y) * ((x - table.x[k]) / (table.x[after] - table.x[k]))
    return y


@kernel
def highest(table: Curve) -> float:
    """Return the largest ordinate of the curve."""
    peak = table.y[0]
    for i in range(1, 32):
        peak = max(peak, table.y[i])
    return peak
