"""The stations of a plan: where a road is cut into stages, and the speeds that are allowed there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.plan import Flags, Floats
from bitepoint.models.route import Route
from bitepoint.parts.road_profile import rise_along

ROOM_TO_CHANGE = 0.2
"""Acceleration with which the lowest speed of a band is approached from where the vehicle has to be slower, m/s^2."""

SLOW = 5.0
"""Speed below which a vehicle is slow at a place, m/s: there the stages are short."""

GROWTH = 0.25
"""Longest stage beyond, over the way to such a place."""

FINER = (8, 4, 2, 2)
"""Pieces that the stages next to such a place are cut into, the nearest first."""


@dataclass(frozen=True)
class Journey:
    """What is to be driven.

    Attributes:
        start_speed: m/s; end_speed: lowest and highest, m/s, equal for a fixed one.
        lowest_speed, highest_speed: band, m/s; near places that have to be passed more slowly the lowest gives way.
        start_gear: engaged at the start; None: whichever is best.
        minimum_acceleration: m/s^2, what is demanded wherever the engine drives; shifts are free of it.
        dwell: time at each stop line, s.
        end_value: what the kinetic energy at the end is worth, kg of fuel per J.
    """

    road: Route
    start_speed: float
    end_speed: tuple[float, float]
    highest_speed: float
    lowest_speed: float = 0.0
    start_gear: int | None = None
    minimum_acceleration: float = -3.0
    dwell: float = 0.0
    end_value: float = 0.0

    def __post_init__(self) -> None:
        low, high = self.end_speed
        if not 0.0 <= low <= high or self.start_speed < 0.0 or not 0.0 <= self.lowest_speed < self.highest_speed:
            raise InputError(
                "plan", f"speeds {self.start_speed:g}, {low:g}..{high:g} m/s in {self.lowest_speed:g}.."
                f"{self.highest_speed:g} m/s", "expected speeds of 0 or more, lowest first",
            )  # fmt: skip
        if self.minimum_acceleration < 0.0 or not len(self.road.stops):
            return
        raise InputError(
            "plan", "a vehicle that may not slow down cannot stop", "expected no stop lines, or less than 0 m/s^2"
        )


@dataclass(frozen=True)
class Stations:
    """Stations and the stages between them.

    Attributes:
        distance: m, shape (stations,); low, high: allowed v^2, m^2/s^2; stops: where the vehicle stands.
        reach: v^2 that the vehicle cannot exceed from the start on, m^2/s^2.
        grade: mean over each stage, shape (stages,).
    """

    distance: Floats
    low: Floats
    high: Floats
    reach: Floats
    stops: Flags
    grade: Floats

    @property
    def length(self) -> Floats:
        """Length of each stage, m."""
        return np.diff(self.distance)


def place_stations(journey: Journey, spacing: float, short: float, halvings: int = 0) -> Stations:
    """Return the stations of a journey, at most `spacing` (m) apart, each stage then halved some times.

    `short` (m): longest stage next to a place where the vehicle is slow.

    Stop lines and changes of the limit get a station; stages between two of these are equal, but for those near a place
    where the vehicle is slow: they become shorter towards it, and the last ones are halved, and halved again.
    """
    road = journey.road
    s, limit, stop_lines = road.distance, road.speed_limit, road.stops
    changes = s[1:-1][limit[1:-1] != limit[:-2]]
    marks = np.unique(np.concatenate(([0.0, s[-1]], stop_lines, changes)))
    slow = set(stop_lines)
    slow |= {0.0} if journey.start_speed < SLOW else set()
    slow |= {marks[-1]} if journey.end_speed[1] < SLOW else set()
    pieces = [_stages(a, b, spacing, short, (a in slow, b in slow), halvings) for a, b in pairwise(marks)]
    distance = np.append(np.concatenate(pieces), marks[-1])
    stops = np.isin(distance, stop_lines)
    stops[0] = False
    low, high = _bands(journey, distance, stops, _limits(s, limit, distance))
    rise = rise_along(s, road.grade, distance)
    return Stations(distance, low, high, high, stops, np.diff(rise) / np.diff(distance))


def _stages(a: float, b: float, spacing: float, short: float, slow: tuple[bool, bool], halvings: int) -> Floats:
    """Return the stations from a up to b, b left out; `slow`: whether the vehicle is, at a and at b."""
    graded = [_graded(0.5 * (b - a) if all(slow) else b - a, spacing, short) if each else [0.0] for each in slow]
    first, last = a + graded[0][-1], b - graded[1][-1]
    uniform: Floats = np.linspace(first, last, max(int(np.ceil((last - first) / spacing - 1e-9)), 1) + 1)
    edges = np.array([*(a + x for x in graded[0][:-1]), *uniform, *(b - x for x in graded[1][-2::-1])])
    parts = np.full(len(edges) - 1, 2**halvings)
    for n, share in enumerate(FINER[: len(parts)]):
        for k in np.array((n, -1 - n))[list(slow)]:
            parts[k] = max(int(parts[k]), share * 2**halvings)
    pieces: list[Floats] = [
        np.linspace(float(x), float(y), int(p) + 1)[:-1] for (x, y), p in zip(pairwise(edges), parts, strict=True)
    ]
    return np.concatenate(pieces)


def _graded(length: float, spacing: float, short: float) -> list[float]:
    """Return the edges of stages from a slow place on that are shorter than `spacing`, up to `length`, all in m."""
    edges = [0.0]
    while (size := max(short, GROWTH * edges[-1])) < spacing and edges[-1] + size < length:
        edges.append(edges[-1] + size)
    return edges


def _limits(s: Floats, limit: Floats, distance: Floats) -> Floats:
    """Return the limit at stations: the lower one of what holds before and after."""
    after = limit[np.clip(np.searchsorted(s, distance + 1e-9, side="right") - 1, 0, len(s) - 1)]
    before = limit[np.clip(np.searchsorted(s, distance - 1e-9, side="right") - 1, 0, len(s) - 1)]
    return np.minimum(before, after)


def _bands(journey: Journey, distance: Floats, stops: Flags, limit: Floats) -> tuple[Floats, Floats]:
    high = np.minimum(limit, journey.highest_speed) ** 2
    high[stops] = 0.0
    high[-1] = min(high[-1], journey.end_speed[1] ** 2)
    high[0] = journey.start_speed**2
    low = np.minimum(journey.lowest_speed**2, high)
    low[-1] = min(journey.end_speed[0] ** 2, high[-1])
    room = 2.0 * ROOM_TO_CHANGE * distance
    low = np.minimum(np.minimum.accumulate(low - room) + room, low)
    low = np.minimum(np.minimum.accumulate((low + room)[::-1])[::-1] - room, low)
    low[0], low[-1] = high[0], min(journey.end_speed[0] ** 2, high[-1])
    return np.maximum(low, 0.0), high
