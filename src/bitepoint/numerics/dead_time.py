"""Dead time in whole steps: a ring of past values."""

from __future__ import annotations

from bitepoint.kernels import kernel, to_index
from bitepoint.records import FloatArray, Record, count, quantity

MOST_STEPS = 255
"""Steps that a dead time can last."""


class DeadTime(Record):
    """Past values of one signal, one per step."""

    newest: int = count(0, MOST_STEPS, "place of the newest value")
    values: FloatArray = quantity("1", -1e9, 1e9, "past values, in the unit of the signal", shape=(MOST_STEPS + 1,))


@kernel
def start_dead_time(d: DeadTime, value: float) -> None:
    """Let the signal always have had `value`."""
    d.newest = 0
    for i in range(256):
        d.values[i] = value


@kernel
def delayed(d: DeadTime, value: float, delay: float, dt: float) -> float:
    """Take the signal's value of this step; return the one that it had a dead time ago.

    Args:
        delay: the dead time, s; it is rounded to whole steps, at most MOST_STEPS.
        dt: the step, s.
    """
    place = d.newest + 1
    d.newest = 0 if place > MOST_STEPS else min(place, MOST_STEPS)
    d.values[d.newest] = value
    back = d.newest - to_index(delay / dt + 0.5, 0, MOST_STEPS)
    place_then = back if back >= 0 else back + MOST_STEPS + 1
    return d.values[max(min(place_then, MOST_STEPS), 0)]
