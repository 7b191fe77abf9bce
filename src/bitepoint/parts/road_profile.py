"""Road whose grade changes along it: a profile over distance, beside a constant grade and the air over it.

Between its points, which stand at a constant spacing, the grade is linear; before the first and beyond the last it
stays as it is there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bitepoint.errors import InputError
from bitepoint.kernels import clamp, kernel, to_index
from bitepoint.recording import Floats
from bitepoint.records import FloatArray, Record, RecordArray, count, nested, quantity

PROFILE_POINTS = 1024
"""Most points of a profile."""

LEAST_SPACING = 0.1
"""Shortest spacing of a profile, m."""


class GradeProfile(Record):
    """The grade over distance."""

    points: int = count(0, PROFILE_POINTS, "points in use, the first at distance 0; 0 or 1: no profile", default=0)
    spacing: float = quantity("m", LEAST_SPACING, 10_000, "distance from point to point", default=20.0)
    grades: FloatArray = quantity(
        "1", -0.5, 0.5, "rise over run at the points; positive uphill", default=0.0, shape=(1024,), padded=True
    )


class ProfiledRoad(Record):
    """The road and the air over it."""

    grade: float = quantity("1", -0.5, 0.5, "rise over run; positive uphill, added to the profile", default=0.0)
    air_density: float = quantity("kg/m^3", 0.5, 2, "density of the air", default=1.206)
    profile: GradeProfile = nested(GradeProfile, "the grade over distance")


@kernel
def grade_at(road: ProfiledRoad, distance: float) -> float:
    """Return the grade, rise over run, at a distance from the start (m)."""
    grade = road.grade
    # never: a profile, in the vectors of a vehicle on a road without one
    if road.profile.points > 1:
        place = distance / road.profile.spacing
        before = min(to_index(place, 0, 1022), road.profile.points - 2)
        k = max(before, 0)
        share = clamp(place - k, 0.0, 1.0)
        grade = grade + road.profile.grades[k] + share * (road.profile.grades[k + 1] - road.profile.grades[k])
    return grade


def grade_profile(distance: Floats | Sequence[float], grade: Floats | Sequence[float]) -> RecordArray:
    """Return the profile, shape (1,), of a road whose grade is known at some distances.

    A road with a constant spacing and up to 1024 points is taken as it is. Any other is told by as many points: each
    the mean grade, hence the rise, of the road from half a spacing before to half a spacing after it.

    Args:
        distance: along the road, m, from 0 on, increasing, shape (n,); grade: rise over run there, linear between.

    Raises:
        InputError: fewer than two points, distances that do not begin at 0 or do not increase, or a grade beyond +-0.5.
    """
    s, g = np.asarray(distance, np.float64), np.asarray(grade, np.float64)
    if s.ndim != 1 or s.shape != g.shape or s.size < 2 or s[0] != 0.0 or not (np.diff(s) > 0.0).all():
        raise InputError("road", "distances and grades do not fit", "expected as many, two at least, rising from 0 m")
    if not (np.abs(g) <= 0.5).all():
        raise InputError("road", f"got a grade of {np.abs(g).max():g}", "expected -0.5 to 0.5")
    spacing = s[-1] / (s.size - 1)
    if s.size > PROFILE_POINTS or spacing < LEAST_SPACING or np.abs(np.diff(s) - spacing).max() > 1e-6 * spacing:
        points = int(np.clip(math.floor(s[-1] / LEAST_SPACING) + 1, 2, PROFILE_POINTS))
        spacing = s[-1] / (points - 1)
        at = np.arange(points) * spacing
        ends = np.clip([at - 0.5 * spacing, at + 0.5 * spacing], 0.0, s[-1])
        rise = rise_along(s, g, ends)
        g = (rise[1] - rise[0]) / (ends[1] - ends[0])
    profile = GradeProfile.zeros()
    profile["points"], profile["spacing"] = g.size, spacing
    profile["grades"][0, : g.size] = g
    return profile


def rise_along(s: Floats, g: Floats, at: Floats) -> Floats:
    """Return the integral of a grade that is linear between its points, m, from 0 to the distances `at`."""
    whole = np.concatenate([[0.0], np.cumsum(0.5 * (g[1:] + g[:-1]) * np.diff(s))])
    k = np.clip(np.searchsorted(s, at, side="right") - 1, 0, s.size - 2)
    past = at - s[k]
    return whole[k] + past * (g[k] + 0.5 * past * (g[k + 1] - g[k]) / (s[k + 1] - s[k]))
