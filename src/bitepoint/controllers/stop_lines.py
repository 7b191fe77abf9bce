"""Stop lines along a way, as a controller holds them: where to stand, how long, and how hard to slow down and leave.

Towards the next line v^2 stays below 2 slowing d, where d is the way that is left; off the last one below 2 leaving
(d + LEAD). Between two lines both hold.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bitepoint.errors import InputError
from bitepoint.kernels import clamp, kernel
from bitepoint.recording import Floats
from bitepoint.records import FloatArray, Record, RecordArray, quantity

STOP_LINES = 32
"""Most lines."""

REACH = 1.0
"""How far from a line a vehicle may stand, m."""

LEAD = 0.1
"""Way by which a vehicle that leaves a line is ahead of what its acceleration allows, m: else it would not begin."""

ANY_SPEED = 1e4
"""v^2 where no line limits it, m^2/s^2."""

HARDEST = 100.0
"""Acceleration that is none to keep to, m/s^2."""


class StopLines(Record):
    """Lines at which the vehicle has to stand, in the order in which they are passed; behind the last there is none."""

    dwell: float = quantity("s", 0, 3600, "how long it stands at each", default=0.0)
    at: FloatArray = quantity("m", 0, 1e6, "way to the line", shape=(33,), padded=True, default=0.0)
    slowing: FloatArray = quantity(
        "m/s^2",
        0,
        HARDEST,
        "deceleration with which it is approached; 0: no line",
        shape=(33,),
        padded=True,
        default=0.0,
    )
    braking: FloatArray = quantity(
        "m/s^2",
        0,
        2.0 * HARDEST,
        "deceleration by the brake that this takes on the slope before the line",
        shape=(33,),
        padded=True,
        default=0.0,
    )
    leaving: FloatArray = quantity(
        "m/s^2",
        0,
        HARDEST,
        "acceleration with which it is left; the highest: any",
        shape=(33,),
        padded=True,
        default=0.0,
    )


@kernel
def slowing_ahead(t: StopLines, passed: int) -> float:
    """Return the deceleration, m/s^2, with which the next line is approached; 0 where there is none."""
    return t.slowing[max(min(passed, STOP_LINES), 0)]


@kernel
def braking_ahead(t: StopLines, passed: int) -> float:
    """Return the deceleration by the brake, m/s^2, that it takes; slopes, which slow down too, make the difference."""
    return t.braking[max(min(passed, STOP_LINES), 0)]


@kernel
def way_to_line(t: StopLines, passed: int, distance: float) -> float:
    """Return how far the next line is, m, where there is one."""
    return t.at[max(min(passed, STOP_LINES), 0)] - distance


@kernel
def way_off_line(t: StopLines, passed: int, distance: float) -> float:
    """Return the place from which on a plan is followed, m: `distance`, but no less than REACH beyond the last line."""
    k = max(min(passed, STOP_LINES), 1) - 1
    return max(distance, t.at[k] + REACH) if passed > 0 else distance


@kernel
def lined_square(t: StopLines, passed: int, distance: float) -> float:
    """Return the highest v^2, m^2/s^2, that the lines before and behind allow."""
    highest = ANY_SPEED
    before = max(min(passed, STOP_LINES), 1) - 1
    if passed > 0:
        highest = 2.0 * t.leaving[before] * (max(distance - t.at[before], 0.0) + LEAD)
    slowing = slowing_ahead(t, passed)
    if slowing > 0.0:
        highest = min(highest, max(2.0 * slowing * way_to_line(t, passed, distance), 0.0))
    return highest


@kernel
def slowing_to_line(t: StopLines, passed: int, distance: float, speed: float) -> float:
    """Return the constant deceleration, m/s^2, that ends at the next line, where there is one."""
    way = max(way_to_line(t, passed, distance), 0.1 * REACH)
    return clamp(0.5 * speed * speed / way, 0.0, HARDEST)


def stop_lines(
    at: Floats | Sequence[float],
    slowing: Floats | Sequence[float],
    braking: Floats | Sequence[float],
    leaving: Floats | Sequence[float],
    dwell: float,
    where: str,
) -> RecordArray:
    """Return lines as a record, shape (1,).

    Args:
        at: ways to the lines, m, rising, shape (n,); slowing, braking, leaving: m/s^2, shape (n,); dwell: s.
        where: what an error is told to be in.

    Raises:
        InputError: more than fit, or numbers outside the ranges of the record.
    """
    n = len(at)
    if n > STOP_LINES:
        raise InputError(where, f"{n} stop lines", f"expected up to {STOP_LINES}: drive a part of the road")
    record = StopLines.zeros()
    record["dwell"] = dwell
    for name, values in (("at", at), ("slowing", slowing), ("braking", braking), ("leaving", leaving)):
        field, column = StopLines.fields[name], np.asarray(values, np.float64)
        if not ((column >= field.low) & (column <= field.high)).all():
            raise InputError(where, f"stop lines, {name}: got {column.min():g} to {column.max():g}", field.expected())
        record[name][0, :n] = column
    return record
