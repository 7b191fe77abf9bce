"""From measured points to a road: distances on the ellipsoid, and a grade from smoothed elevation.

Elevation is taken to a uniform raster and smoothed by a triangle of base w, which is a moving mean over w / 2, twice.
Its ends are continued by point reflection, so that a constant grade stays as it is up to them. Of the height of hills
of wavelength L it keeps

    sinc(w / (2 L))^2,    sinc(x) = sin(pi x) / (pi x)

which is 0.97 for 1 km, 0.87 for 500 m and 0.41 for 200 m, where w is 200 m. Central differences make the grade of it.
Points that err by s metres, each for itself and d metres apart, leave an error of 4 s sqrt(d / w^3) in the grade: 0.6 %
for 1 m each 20 m.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.route import STEEPEST, Route, climb, lowest_limits
from bitepoint.recording import Floats

GPS_SMOOTHING = 200.0
"""Base of the triangle for measured elevation, m (chosen: hills of a kilometre stay, errors of a few metres go)."""

LONGEST_GAP = 1000.0
"""Between neighbouring points of elevation, m (chosen: a straight line over more would hide whole hills)."""

CLOSEST = 1.0
"""Points of a track that are closer than this to the one before are the same place, m: a receiver that stands."""

SHORTEST, LONGEST = 50.0, 2e6
"""Length of a road, m (chosen)."""

LEAST_SMOOTHING = 10.0
CELLS = 20
"""Cells of the raster in the base of the triangle."""

EQUATOR = 6_378_137.0
FLATTENING = 1.0 / 298.257223563
"""Ellipsoid of WGS 84: radius at the equator, m, and flattening (NIMA TR8350.2, table 3.1)."""


@dataclass(frozen=True)
class Points:
    """What a file tells of a road, shape (n,) each.

    Attributes:
        where: the file, for errors; row: what one of its points is called.
        distance: m; elevation: m, or None; grade: rise over run, or None. One of the two is there; where both are, the
            grade counts, and of the elevation its start.
        speed_limit: m/s, from its point on; None: none. stops: m.
        about: where it comes from.
    """

    where: str
    distance: Floats
    elevation: Floats | None = None
    grade: Floats | None = None
    speed_limit: Floats | None = None
    stops: Floats = field(default_factory=lambda: np.zeros(0))
    about: str = ""
    row: str = "row"


def track_distance(latitude: Floats, longitude: Floats) -> Floats:
    """Return the distance along a track, m from its first point, shape (n,).

    Between neighbours it is that on the ellipsoid of WGS 84 with its two radii of curvature half way, level, which is
    exact to a millionth for points a kilometre apart. Angles are in degrees, positive north and east.
    """
    north, east = np.radians(latitude), np.radians(longitude)
    middle = 0.5 * (north[1:] + north[:-1])
    turn = np.diff(east)
    turn -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))  # across the date line
    squared = FLATTENING * (2.0 - FLATTENING)
    swell = 1.0 - squared * np.sin(middle) ** 2
    along_meridian = EQUATOR * (1.0 - squared) / swell**1.5 * np.diff(north)
    along_parallel = EQUATOR / np.sqrt(swell) * np.cos(middle) * turn
    return np.concatenate([[0.0], np.cumsum(np.hypot(along_meridian, along_parallel))])


def distinct(distance: Floats) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the places of the points of a track that are not where the one before is."""
    kept = [0]
    for place in range(1, distance.size):
        if distance[place] - distance[kept[-1]] >= CLOSEST:
            kept.append(place)
    return np.array(kept)


def road(points: Points, smoothing: float | None = None) -> Route:
    """Return the road through measured points.

    Args:
        smoothing: base of the triangle, m; 0: none, as the points are. None: 200 m where the grade comes of elevation,
            none where the file gives it.

    Raises:
        InputError: distances that do not rise, gaps, missing values, grades that no road has, or a road too short.
    """
    _check(points)
    if smoothing is None:
        smoothing = GPS_SMOOTHING if points.grade is None else 0.0
    x: Floats = points.distance - points.distance[0]
    length = float(x[-1])
    if smoothing and not LEAST_SMOOTHING <= smoothing <= length:
        expected = f"expected 0, or {LEAST_SMOOTHING:g} m up to the length of the road, {length:.0f} m"
        raise InputError(points.where, f"smoothing over {smoothing:g} m", expected)
    given = _elevation(x, points)
    limit = np.full_like(x, np.inf) if points.speed_limit is None else points.speed_limit
    at, height, told = x, given, ""
    if smoothing:
        at = np.linspace(0.0, length, max(round(length * CELLS / smoothing), CELLS) + 1)
        height = smoothed(np.interp(at, x, given), max(round(0.5 * smoothing / float(at[1])), 1))
        limit = np.append(lowest_limits(x, limit, at), limit[-1])
        told = f"elevation smoothed over {smoothing:g} m, climb {climb(height):.0f} of {climb(given):.0f} m"
    grade = np.gradient(height, at) if smoothing or points.grade is None else points.grade
    _check_grade(points.where, at, grade)
    about = "; ".join(part for part in (points.about, told) if part)
    try:
        return Route(at, height, grade, limit, points.stops - points.distance[0], about)
    except InputError as error:
        raise InputError(points.where, error.problem, error.mend) from None


def smoothed(values: Floats, half: int) -> Floats:
    """Return uniform samples, weighted by a triangle of base 2 * half samples; ends are continued by reflection."""
    box = np.full(half, 1.0 / half)
    padding = half - 1
    padded = np.pad(values, padding, "reflect", reflect_type="odd") if padding else values
    return np.convolve(padded, np.convolve(box, box), "valid")


def _elevation(x: Floats, points: Points) -> Floats:
    """Return the elevation of the points, m: the integral of the grade where there is one, else that of the file."""
    if points.grade is None:
        assert points.elevation is not None
        return points.elevation
    start = 0.0 if points.elevation is None else points.elevation[0]
    return start + np.concatenate([[0.0], np.cumsum(0.5 * (points.grade[1:] + points.grade[:-1]) * np.diff(x))])


def _check(points: Points) -> None:
    where, x = points.where, points.distance
    for name, values in (("distance", x), ("elevation", points.elevation), ("grade", points.grade)):
        if values is not None and not np.isfinite(values).all():
            bad = int(np.flatnonzero(~np.isfinite(values))[0]) + 1
            raise InputError(where, f"no {name} in {points.row} {bad}", "fill it in, or leave the point out")
    if x.size < 2:
        raise InputError(where, f"{x.size} points", "expected two or more, at different places")
    step = np.diff(x)
    if not (step > 0.0).all():
        bad = int(np.flatnonzero(step <= 0.0)[0]) + 2
        raise InputError(where, f"distance does not rise in {points.row} {bad}", "sort the points, leave repeated out")
    if not SHORTEST <= x[-1] - x[0] <= LONGEST:
        expected = f"expected {SHORTEST:g} m to {LONGEST / 1000:g} km; check the unit of distance"
        raise InputError(where, f"a road of {x[-1] - x[0]:g} m", expected)
    if points.grade is None and step.max() > LONGEST_GAP:
        bad = int(step.argmax()) + 1
        problem = f"a gap of {step.max():.0f} m after {points.row} {bad}"
        raise InputError(where, problem, f"expected points of elevation at most {LONGEST_GAP:g} m apart")
    if points.grade is not None:
        _check_grade(where, x, points.grade)


def _check_grade(where: str, distance: Floats, grade: Floats) -> None:
    worst = int(np.argmax(np.abs(grade)))
    if abs(grade[worst]) > STEEPEST:
        mend = f"expected rise over run, up to {STEEPEST:g}; check units, or smooth over more"
        raise InputError(where, f"grade of {grade[worst]:.3g} at {distance[worst]:.0f} m", mend)
