"""Look-up in curves and maps."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Curve, Map


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


@kernel
def lookup_map(table: Map, x: float, y: float) -> float:
    """Return z(x, y) of the map: bilinear between its points, constant beyond them.

    A coordinate that is NaN counts as the first point of its axis.
    """
    row = row_below(table, x)
    column = column_below(table, y)
    next_row = max(min(row + 1, table.x_points - 1), 0)
    next_column = max(min(column + 1, table.y_points - 1), 0)
    across = 0.0
    if x > table.x[row] and table.x[next_row] > table.x[row]:
        across = (x - table.x[row]) / (table.x[next_row] - table.x[row])
    along = 0.0
    if y > table.y[column] and table.y[next_column] > table.y[column]:
        along = (y - table.y[column]) / (table.y[next_column] - table.y[column])
    before = table.z[row, column] + (table.z[row, next_column] - table.z[row, column]) * along
    after = table.z[next_row, column] + (table.z[next_row, next_column] - table.z[next_row, column]) * along
    return before + (after - before) * across


@kernel
def row_below(table: Map, x: float) -> int:
    """Return the row of the last point of the map that is not above x, or the first."""
    a = 8 if table.x_points > 8 and x >= table.x[8] else 0
    b = a + (4 if table.x_points > a + 4 and x >= table.x[a + 4] else 0)
    c = b + (2 if table.x_points > b + 2 and x >= table.x[b + 2] else 0)
    return c + (1 if table.x_points > c + 1 and x >= table.x[c + 1] else 0)


@kernel
def column_below(table: Map, y: float) -> int:
    """Return the column of the last point of the map that is not above y, or the first."""
    a = 8 if table.y_points > 8 and y >= table.y[8] else 0
    b = a + (4 if table.y_points > a + 4 and y >= table.y[a + 4] else 0)
    c = b + (2 if table.y_points > b + 2 and y >= table.y[b + 2] else 0)
    return c + (1 if table.y_points > c + 1 and y >= table.y[c + 1] else 0)
