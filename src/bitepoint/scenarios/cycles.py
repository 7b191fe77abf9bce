"""Driving cycles from the definition of their segments.

The New European Driving Cycle (NEDC) is four urban cycles, ECE-15, and one extra-urban cycle, EUDC.

Source: UN Regulation 83, annex 4, appendix 1, tables 1.2 and 1.3 (operations 1..25 and 1..21); the same tables stand in
Directive 70/220/EEC, annex III, appendix 1. They give each acceleration rounded to 0.01 m/s^2; here it follows from the
speeds and the time, which are exact. Where the clutch is declared open, and while shifting, the gear is 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from bitepoint.errors import InputError
from bitepoint.recording import Floats

KMH = 1.0 / 3.6
"""1 km/h in m/s."""


@dataclass(frozen=True)
class Segment:
    """A part of a cycle with constant acceleration, from the speed at which the one before ended.

    Attributes:
        duration: s; speed_kmh: at its end, km/h.
        gear: of a car with a manual gearbox of five gears; 0: clutch open, gear change or standstill.
    """

    duration: float
    speed_kmh: float
    gear: int = 0


def _segments(*rows: tuple[float, float, int]) -> tuple[Segment, ...]:
    return tuple(Segment(*row) for row in rows)


ECE_15 = _segments(
    (11, 0, 0), (4, 15, 1), (8, 15, 1), (2, 10, 1), (3, 0, 0),
    (21, 0, 0), (5, 15, 1), (2, 15, 0), (5, 32, 2), (24, 32, 2), (8, 10, 2), (3, 0, 0),
    (21, 0, 0), (5, 15, 1), (2, 15, 0), (9, 35, 2), (2, 35, 0), (8, 50, 3), (12, 50, 3), (8, 35, 3), (13, 35, 3),
    (2, 32, 0), (7, 10, 2), (3, 0, 0),
    (7, 0, 0),
)  # fmt: skip
"""The urban cycle, 195 s."""

EUDC = _segments(
    (20, 0, 0), (5, 15, 1), (2, 15, 0), (9, 35, 2), (2, 35, 0), (8, 50, 3), (2, 50, 0), (13, 70, 4), (50, 70, 5),
    (8, 50, 4), (69, 50, 4), (13, 70, 4), (50, 70, 5), (35, 100, 5), (30, 100, 5), (20, 120, 5), (10, 120, 5),
    (16, 80, 5), (8, 50, 5), (10, 0, 0),
    (20, 0, 0),
)  # fmt: skip
"""The extra-urban cycle, 400 s."""

CYCLES: Mapping[str, Sequence[Segment]] = {"ece-15": ECE_15, "eudc": EUDC, "nedc": (*ECE_15 * 4, *EUDC)}
"""Cycles by name; each starts and ends at a standstill."""


def cycle_trace(name: str) -> tuple[Floats, Floats]:
    """Return time (s, from 0) and speed (m/s) at the ends of the segments of a cycle, each shape (segments + 1,).

    Raises:
        InputError: there is no such cycle.
    """
    if name not in CYCLES:
        raise InputError("cycle", f"got {name}", f"expected one of {', '.join(CYCLES)}")
    segments = CYCLES[name]
    time = np.array([0.0, *accumulate(segment.duration for segment in segments)])
    return time, np.array([0.0, *(segment.speed_kmh * KMH for segment in segments)])


def accelerations(segments: Sequence[Segment]) -> list[float]:
    """Return the acceleration of each segment, m/s^2; the first one starts at a standstill."""
    speeds = [0.0, *(segment.speed_kmh * KMH for segment in segments)]
    steps = zip(pairwise(speeds), segments, strict=True)
    return [(after - before) / segment.duration for (before, after), segment in steps]
