"""A road: what is refused as none, and what its cells are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.conftest import Refused

from bitepoint.models.route import Route

FLAT: dict[str, Any] = {
    "distance": np.array([0.0, 100.0, 300.0]),
    "elevation": np.array([5.0, 15.0, 5.0]),
    "grade": np.array([0.1, 0.0, -0.05]),
    "speed_limit": np.array([20.0, 10.0, np.inf]),
    "stops": np.array([250.0]),
}


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("distance", [0.0, 100.0, 100.0], "distance does not rise from 0"),
        ("distance", [1.0, 100.0, 300.0], "distance does not rise from 0"),
        ("distance", [0.0, 100.0, np.inf], "distance does not rise from 0"),
        ("elevation", [0.0, np.nan, 0.0], "elevation is not finite"),
        ("elevation", [0.0, 1.0], "elevation of shape (2,)"),
        ("grade", [0.0, -0.4, 0.0], "grade of -0.4 at 100 m"),
        ("grade", [0.0, np.nan, 0.35], "grade of nan at 100 m"),
        ("speed_limit", [20.0, 0.0, 20.0], "a speed limit that is not positive"),
        ("speed_limit", [20.0, np.nan, 20.0], "a speed limit that is not positive"),
        ("stops", [301.0], "stops out of order or off the road"),
        ("stops", [20.0, 20.0], "stops out of order or off the road"),
        ("stops", [20.0, 20.9], "stop lines at 20 and 20.9 m"),
    ],
)
def test_what_is_no_road_is_refused(name: str, value: list[float], said: str, refused: Refused) -> None:
    refused(lambda: Route(**{**FLAT, name: np.array(value)}), "route: ", said)


def test_one_point_is_no_road(refused: Refused) -> None:
    refused(lambda: Route(*(np.zeros(1) for _ in range(4)), np.zeros(0)), "1 points")


def test_cells_keep_the_height_and_take_the_lowest_limit() -> None:
    route = Route(**FLAT)
    assert (route.length, route.climb) == (300.0, 10.0)
    grade, limit = route.cells(np.array([0.0, 50.0, 100.0, 200.0, 300.0, 400.0]))
    assert grade == pytest.approx([0.1, 0.1, -0.05, -0.05, 0.0])
    assert limit.tolist() == [20.0, 20.0, 10.0, 10.0, np.inf]
    grade, limit = route.cells(np.array([0.0, 150.0, 300.0]))
    assert grade == pytest.approx([7.5 / 150.0, -7.5 / 150.0])
    assert limit.tolist() == [10.0, 10.0]
