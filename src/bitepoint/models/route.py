"""A road ahead: how it rises, how fast one may go, and where one has to stop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bitepoint.errors import InputError
from bitepoint.parts.road_profile import rise_along
from bitepoint.recording import Floats

STEEPEST = 0.3
"""Steepest grade of a road for motor vehicles, rise over run: the steepest public ones have about 0.35."""


LEAST_BETWEEN_STOPS = 1.0
"""Least way between two stop lines, m: a vehicle that stands at one of two nearer ones stands at both."""


@dataclass(frozen=True)
class Route:
    """A road over distance, shape (n,) each, n >= 2.

    Attributes:
        distance: m along the road, rising, from 0.
        elevation: m, linear between the points.
        grade: rise over run, positive uphill, linear between the points.
        speed_limit: m/s, from its point to the next one; infinite where there is none.
        stops: distances at which the vehicle has to stand, m, rising, shape (k,).
        about: where it comes from and what was done to it.

    Raises:
        InputError: arrays of other shapes, distances that do not rise from 0, or values that no road has.
    """

    distance: Floats
    elevation: Floats
    grade: Floats
    speed_limit: Floats
    stops: Floats
    about: str = ""

    def __post_init__(self) -> None:
        """Refuse what is no road."""
        points = self.distance.shape
        if len(points) != 1 or points[0] < 2:
            raise InputError("route", f"{self.distance.size} points", "expected two or more")
        for name in ("elevation", "grade", "speed_limit"):
            shape = getattr(self, name).shape
            if shape != points:
                raise InputError("route", f"{name} of shape {shape}", f"expected {points}, as of distance")
        if self.distance[0] != 0.0 or not (np.diff(self.distance) > 0.0).all() or not np.isfinite(self.distance[-1]):
            raise InputError("route", "distance does not rise from 0", "expected m along the road")
        if not np.isfinite(self.elevation).all():
            raise InputError("route", "elevation is not finite everywhere", "expected m")
        if not (np.abs(self.grade) <= STEEPEST).all():
            worst = int(np.argmax(np.nan_to_num(np.abs(self.grade), nan=np.inf)))
            problem = f"grade of {self.grade[worst]:.3g} at {self.distance[worst]:g} m"
            raise InputError("route", problem, f"expected rise over run, -{STEEPEST:g}..{STEEPEST:g}")
        if not (self.speed_limit > 0.0).all():
            raise InputError("route", "a speed limit that is not positive", "expected m/s, or infinity for none")
        inside = (self.stops >= 0.0) & (self.stops <= self.length)
        if self.stops.ndim != 1 or not inside.all() or not (np.diff(self.stops) > 0.0).all():
            raise InputError("route", "stops out of order or off the road", f"expected rising m of 0..{self.length:g}")
        near = np.flatnonzero(np.diff(self.stops) < LEAST_BETWEEN_STOPS - 1e-6)
        if near.size:
            lines = f"stop lines at {self.stops[near[0]]:.6g} and {self.stops[near[0] + 1]:.6g} m"
            raise InputError("route", lines, f"expected {LEAST_BETWEEN_STOPS:g} m between two at least")

    @staticmethod
    def of_grade(distance: Floats, grade: Floats, speed_limit: Floats, stops: Floats) -> Route:
        """Return a road that begins at height 0, and rises as its grade says."""
        return Route(distance, rise_along(distance, grade, distance), grade, speed_limit, stops)

    @staticmethod
    def flat(length: float, *, grade: float = 0.0, stops: Sequence[float] = ()) -> Route:
        """Return a road of one grade and no limits, `length` in m."""
        no_limit = np.full(2, np.inf)
        return Route.of_grade(np.array([0.0, length]), np.full(2, grade), no_limit, np.array(stops, np.float64))

    @property
    def length(self) -> float:
        """Length of the road, m."""
        return float(self.distance[-1])

    @property
    def climb(self) -> float:
        """All that it rises, m: descents do not count against it."""
        return climb(self.elevation)

    def cells(self, edges: Floats) -> tuple[Floats, Floats]:
        """Return mean grade and lowest speed limit (m/s) between neighbours of `edges` (m, rising), each (n - 1,).

        The mean grade keeps the difference in height, and the lowest limit errs on the slow side. Beyond its ends the
        road goes on level, with the limit that it has there.
        """
        rise = np.diff(np.interp(edges, self.distance, self.elevation))
        return rise / np.diff(edges), lowest_limits(self.distance, self.speed_limit, edges)


def climb(elevation: Floats) -> float:
    """Return the sum of all rises between neighbouring points, m."""
    return float(np.maximum(np.diff(elevation), 0.0).sum())


def lowest_limits(distance: Floats, limit: Floats, edges: Floats) -> Floats:
    """Return the lowest of limits that hold from their distance on, between neighbours of `edges`, shape (n - 1,)."""
    first = np.clip(np.searchsorted(distance, edges[:-1], "right") - 1, 0, None)
    last = np.maximum(np.searchsorted(distance, edges[1:], "left"), first + 1)  # those that begin before the cell ends
    padded = np.append(limit, np.inf)
    return np.minimum.reduceat(padded, np.column_stack([first, last]).ravel())[::2]
