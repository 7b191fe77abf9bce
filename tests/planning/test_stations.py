"""Where a road is cut: short stages near places where the vehicle is slow, whole numbers of them between marks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.models.route import Route
from bitepoint.planning.stations import LEAST_BETWEEN, Journey, Spacing, place_stations

SPACING = Spacing(longest=50.0, shortest=5.0, growth=0.2)


@given(st.floats(0.0, 600.0))
def test_a_way_has_so_many_stages_as_lead_there(way: float) -> None:
    assert SPACING.way(SPACING.stages(way)) == pytest.approx(way, abs=1e-9)


@given(
    st.lists(st.integers(1, 2999), max_size=6, unique=True),
    st.lists(st.integers(1, 2999), max_size=6, unique=True),
    st.sampled_from([0.0, 20.0]),
    st.integers(0, 2),
)
def test_stations(lines: list[int], changes: list[int], start_speed: float, halvings: int) -> None:
    s = np.array([0.0, *sorted(changes), 3000.0])
    limit = 20.0 + np.arange(len(s)) % 2
    road = Route.of_grade(s, np.zeros(len(s)), limit, np.sort(np.array(lines, np.float64)))
    journey = Journey(road, start_speed, (20.0, 20.0), 25.0)
    places = place_stations(journey, SPACING, halvings)
    distance = places.distance
    assert places.length.min() > 0.0
    assert np.isin(road.stops, distance).all()
    assert np.isin(s, distance).all()
    assert (places.high[places.stops] == 0.0).all()
    assert np.count_nonzero(places.stops) == len(lines)
    slow = np.array([*road.stops, *([0.0] if start_speed == 0.0 else [])])
    coarse = place_stations(journey, SPACING).distance
    assert distance[:: 2**halvings] == pytest.approx(coarse)
    middle, length = 0.5 * (coarse[1:] + coarse[:-1]), np.diff(coarse)
    off = np.abs(middle[:, np.newaxis] - slow).min(axis=1, initial=1e9) + 0.5 * length
    assert (length <= np.clip(SPACING.growth * off, SPACING.shortest, SPACING.longest) + 1e-6).all()
    for a, b in zip(road.stops[:-1], road.stops[1:], strict=True):
        assert np.count_nonzero((distance > a) & (distance <= b)) >= LEAST_BETWEEN * 2**halvings


def test_a_road_where_the_vehicle_is_nowhere_slow_has_equal_stages() -> None:
    places = place_stations(Journey(Route.flat(1010.0), 20.0, (20.0, 20.0), 25.0), SPACING)
    assert places.length == pytest.approx(np.full(21, 1010.0 / 21))
