"""A made road: hills as a sum of waves, the same each time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.route import Route
from bitepoint.records import Curve, Record, curve, quantity

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
"""Golden section: the waves start out of step by it, without chance."""


class RollingRoad(Record):
    """Grade as a sum of sine waves; the k-th wave, from 0, starts at the fraction k * 0.618 of its own length."""

    length: float = quantity("m", 100, 1_000_000, "of the road")
    spacing: float = quantity("m", 1, 1000, "of its points", default=10.0)
    waves: Curve = curve(("wavelength", "m", 50.0, 100_000.0), ("grade", "1", 0, 0.3), "amplitude of each wave")


def rolling_road(data: Mapping[str, Any], where: str) -> Route:
    """Return the road of a recipe: the keys of a `RollingRoad`, and perhaps `about`.

        grade(x) = sum g_k sin(2 pi (x / L_k + k * 0.618)),    elevation is its integral, from 0

    Raises:
        InputError: an unknown key, or a value out of range.
    """
    block = {key: value for key, value in data.items() if key != "about"}
    recipe = RollingRoad.parse(block, where, "")[0]
    points = int(recipe["waves"]["points"])
    length, grade = recipe["waves"]["x"][:points], recipe["waves"]["y"][:points]
    if grade.sum() > 0.3:
        raise InputError(where, f"waves: grades up to {grade.sum():.3g}", "expected a sum of 0.3 at most")
    cells = max(round(float(recipe["length"] / recipe["spacing"])), 1)
    x = np.linspace(0.0, float(recipe["length"]), cells + 1)
    start = 2.0 * np.pi * GOLDEN * np.arange(points)
    phase = 2.0 * np.pi * x[:, np.newaxis] / length + start
    rise = grade * length / (2.0 * np.pi) * (np.cos(start) - np.cos(phase))
    none = np.full(x.size, np.inf)
    about = str(data.get("about", f"waves of {where}"))
    return Route(x, rise.sum(axis=1), (grade * np.sin(phase)).sum(axis=1), none, np.zeros(0), about)
