"""Look-up in curves."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Curve


@kernel
def lookup(table: Curve, x: float) -> float:
    """Return y(x) of the curve: linear between its points, constant beyond them, the first ordinate where x is NaN."""
    a = 16 if table.points > 16 and x >= table.x[16] else 0  # halving, five times
    b = a + (8 if table.points > a + 8 and x >= table.x[a + 8] else 0)
    c = b + (4 if table.points > b + 4 and x >= table.x[b + 4] else 0)
    d = c + (2 if table.points > c + 2 and x >= table.x[c + 2] else 0)
    k = d + (1 if table.points > d + 1 and x >= table.x[d + 1] else 0)
    after = max(min(k + 1, table.points - 1), 0)
    y = table.y[k]
    if x > table.x[k] and table.x[after] > table.x[k]:
        y = y + (table.y[after] - y) * ((x - table.x[k]) / (table.x[after] - table.x[k]))
    return y


@kernel
def highest(table: Curve) -> float:
    """Return the largest ordinate of the curve."""
    peak = table.y[0]
    for i in range(1, 32):
        if i < table.points:
            peak = max(peak, table.y[i])
    return peak
