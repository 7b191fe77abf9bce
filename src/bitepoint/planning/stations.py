"""The stations of a plan: where a road is cut into stages, and the speeds that are allowed there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.plan import Flags, Floats
from bitepoint.models.route import Route
from bitepoint.parts.road_profile import rise_along

ROOM_TO_CHANGE = 0.2
"""Acceleration with which the lowest speed of a band is approached from where the vehicle has to be slower, m/s^2."""

EASE = 0.8
"""Share of what a vehicle can do, pull uphill or slow down, that the lowest speed of a band counts on: gears and shifts
take the rest."""

SLOW = 5.0
"""Speed below which a vehicle is slow at a place, m/s: there the stages are short."""

LEAST_BETWEEN = 8
"""Stages between two such places, at least."""


@dataclass(frozen=True)
class Journey:
    """What is to be driven.

    Attributes:
        start_speed: m/s; end_speed: lowest and highest, m/s, equal for a fixed one.
        lowest_speed, highest_speed: band, m/s. Where one has to go more slowly, and before and after it, the lowest
            gives way, as far as half the band below what is allowed.
        start_gear: engaged at the start; None: whichever is best.
        minimum_acceleration: m/s^2, what is demanded wherever the engine drives; shifts are free of it.
        dwell: time at each stop line, s.
        end_value: what the kinetic energy at the end is worth, kg of fuel per J.
        free_end: the lowest speed at the end is that of the band there, which gives way, whatever `end_speed` says.
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
    free_end: bool = False

    def __post_init__(self) -> None:
        low, high = self.end_speed
        if not 0.0 <= low <= high or self.start_speed < 0.0 or not 0.0 <= self.lowest_speed < self.highest_speed:
            raise InputError(
                "plan", f"speeds {self.start_speed:g}, {low:g}..{high:g} m/s in {self.lowest_speed:g}.."
                f"{self.highest_speed:g} m/s", "expected speeds of 0 or more, lowest first",
            )  # fmt: skip
        if self.minimum_acceleration < 0.0 or not (self.road.stops > 0.0).any():
            return
        raise InputError(
            "plan", "a vehicle that may not slow down cannot stop", "expected no stop lines, or less than 0 m/s^2"
        )


@dataclass(frozen=True)
class Stations:
    """Stations and the stages between them.

    Attributes:
        distance: m, shape (stations,); low, high: allowed v^2, m^2/s^2; stops: where the vehicle stands.
        grade: mean over each stage, shape (stages,).
    """

    distance: Floats
    low: Floats
    high: Floats
    stops: Flags
    grade: Floats

    @property
    def length(self) -> Floats:
        """Length of each stage, m."""
        return np.diff(self.distance)


@dataclass(frozen=True)
class Spacing:
    """How long stages are.

    Attributes:
        longest: m; shortest: next to a place where the vehicle is slow, m; growth: length of a stage over the way from
            there, in between.
    """

    longest: float
    shortest: float
    growth: float

    def between(self, a: float, b: float, slow: tuple[float, float], pieces: int) -> Floats:
        """Return the stations from a up to b, b left out, each stage cut into `pieces`; all in m.

        Args:
            slow: the places next to a and b where the vehicle is slow, neither between them.
        """
        first, last = slow
        near = replace(self, shortest=min(self.shortest, (last - first) / LEAST_BETWEEN))
        half = near.stages(0.5 * (last - first))

        def number(x: float) -> float:  # of stages from the first place to x, in parts of one
            return near.stages(x - first) if x - first <= last - x else 2.0 * half - near.stages(last - x)

        count = max(math.ceil(number(b) - number(a) - 1e-6), 1)
        inside: list[float] = np.linspace(number(a), number(b), count + 1)[1:-1].tolist()
        edges = [first + near.way(n) if n <= half else last - near.way(2.0 * half - n) for n in inside]
        bounds: list[float] = [a, *edges, b]
        stages: list[Floats] = [np.linspace(x, y, pieces + 1)[:-1] for x, y in pairwise(bounds)]
        return np.concatenate(stages)

    def stages(self, way: float) -> float:
        """Return how many stages, in parts of one, there are within `way` (m) of a slow place."""
        begin, end = self.shortest / self.growth, self.longest / self.growth
        growing = math.log(min(max(way, begin), end) / begin) / self.growth
        return min(way, begin) / self.shortest + growing + max(way - end, 0.0) / self.longest

    def way(self, stages: float) -> float:
        """Return the way from a slow place, m, within which there are so many stages."""
        begin, end = self.shortest / self.growth, self.longest / self.growth
        growing = min(max(stages - begin / self.shortest, 0.0), math.log(end / begin) / self.growth)
        rest = stages - min(stages, begin / self.shortest) - growing
        return min(stages * self.shortest, begin) * math.exp(growing * self.growth) + rest * self.longest


def place_stations(journey: Journey, spacing: Spacing, halvings: int = 0) -> Stations:
    """Return the stations of a journey, each stage halved some times.

    Stop lines and changes of the limit get a station. The stages between two of these are as long as `spacing` says, or
    all shorter by the same share, so that there is a whole number of them.
    """
    road = journey.road
    s, limit, stop_lines = road.distance, road.speed_limit, road.stops
    changes = s[1:-1][limit[1:-1] != limit[:-2]]
    marks = np.unique(np.concatenate(([0.0, s[-1]], stop_lines, changes)))
    slow = set(stop_lines.tolist())
    slow |= {0.0} if journey.start_speed < SLOW else set()
    slow |= {float(s[-1])} if journey.end_speed[1] < SLOW else set()
    far = float(s[-1]) + spacing.longest / spacing.growth
    places = np.array([-far, *sorted(slow), s[-1] + far])
    pieces: list[Floats] = []
    cuts: list[float] = marks.tolist()
    for a, b in pairwise(cuts):
        beyond = int(np.searchsorted(places, a, side="right"))
        near = float(places[beyond - 1]), float(places[beyond])
        pieces.append(spacing.between(a, b, near, 2**halvings))
    distance = np.append(np.concatenate(pieces), marks[-1])
    stops = np.isin(distance, stop_lines)
    stops[0] = False
    low, high = _bands(journey, distance, stops, _limits(s, limit, distance))
    rise = rise_along(s, road.grade, distance)
    return Stations(distance, low, high, stops, np.diff(rise) / np.diff(distance))


def _limits(s: Floats, limit: Floats, distance: Floats) -> Floats:
    """Return the limit at stations: the lower one of what holds before and after."""
    after = limit[np.clip(np.searchsorted(s, distance + 1e-9, side="right") - 1, 0, len(s) - 1)]
    before = limit[np.clip(np.searchsorted(s, distance - 1e-9, side="right") - 1, 0, len(s) - 1)]
    return np.minimum(before, after)


def _bands(journey: Journey, distance: Floats, stops: Flags, limit: Floats) -> tuple[Floats, Floats]:
    high = np.minimum(limit, journey.highest_speed) ** 2
    high[stops] = 0.0
    high[-1] = min(high[-1], journey.end_speed[1] ** 2)
    band = 0.5 * (journey.highest_speed - journey.lowest_speed)
    low = np.maximum(np.minimum(journey.lowest_speed, np.sqrt(high) - band), 0.0) ** 2
    high[0] = journey.start_speed**2
    low[0] = min(journey.lowest_speed**2, high[0])
    low[-1] = low[-1] if journey.free_end else min(journey.end_speed[0] ** 2, high[-1])
    room = 2.0 * min(ROOM_TO_CHANGE, EASE * max(-journey.minimum_acceleration, 0.0)) * distance
    low = np.minimum(np.minimum.accumulate(low - room) + room, low)
    low = np.minimum(np.minimum.accumulate((low + room)[::-1])[::-1] - room, low)
    low[0], low[-1] = high[0], low[-1] if journey.free_end else min(journey.end_speed[0] ** 2, high[-1])
    return np.maximum(low, 0.0), high
