"""Look-up in curves."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Curve


@kernel
def lookup(table: Curve, x: float) -> float:
    """Return y(x) of the curve: linear between its points, constant beyond them, the first ordinate where x is NaN."""
    k = 0
    for i in range(1, 31):
        if i >= table.points - 1 or not (x >= table.x[i]):
            break
        k = i
    x0 = table.x[k]
    width = table.x[k + 1] - x0
    share = (x - x0) / width if x > x0 else 0.0
    return table.y[k] + min(share, 1.0) * (table.y[k + 1] - table.y[k])
