"""Economical speed and shift schedule: crossings that are crossings, and maps that say the same in every life."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.errors import InputError
from bitepoint.models.longitudinal import geared_speed
from bitepoint.models.shift_map import mapped_gear
from bitepoint.planning.shift_schedule import CROSSING, EARLIEST, LATEST, economy_schedule, specific_fuel
from bitepoint.planning.steady import economy_speed, steady_fuel
from bitepoint.records import RecordArray
from bitepoint.report.shift_schedule import shift_schedule_figure
from tests.conftest import OTHER_LIVES
from tests.planning.vehicles import hatchback, truck


@pytest.fixture(scope="module")
def car() -> RecordArray:
    return hatchback()


def test_economy_speed_is_the_least_of_all(car: RecordArray) -> None:
    found = economy_speed(car)
    speed = np.linspace(3.0, 40.0, 5000)
    assert found.fuel_per_metre <= (steady_fuel(car, speed) / speed).min() * (1.0 + 1e-3)
    assert 3.6 * found.speed == pytest.approx(50.4, abs=0.05)  # page 5 has 49.8 km/h for a car like this
    assert found.gear == 6


def test_gears_cross_where_they_shift(car: RecordArray) -> None:
    schedule = economy_schedule(car)
    assert schedule.up.shape == (5, 20)
    crossings = 0
    for n, k in np.ndindex(*schedule.up.shape):
        share, speed = float(schedule.throttle[k]), schedule.up[n, k : k + 1]
        lower, higher = (specific_fuel(car, gear, share, speed)[0] for gear in (n + 1, n + 2))
        if schedule.kind[n, k] == CROSSING:
            crossings += 1
            assert lower == pytest.approx(higher, rel=2e-3)
        elif schedule.kind[n, k] == EARLIEST:
            assert higher <= lower
            assert geared_speed.run(car, n + 2, speed)[0] == pytest.approx(car["launch_speed"][0])
    assert crossings > 30
    np.testing.assert_allclose(schedule.up - schedule.down, 2.0 / 3.6)


def test_transient_fuel_moves_the_lines(car: RecordArray) -> None:
    other = car.copy()
    other["correction"]["rising"][0, 0, 1] = 3e-4
    for name, level in (("lowest", -20.0), ("highest", 20.0)):
        region = other["correction"][name]
        region["points"], region["x"], region["y"] = 2, 60.0, level
        region["x"][0, 0] = 0.0
    assert np.abs(economy_schedule(other).up - economy_schedule(car).up).max() > 0.5


def test_gears_too_far_apart_shift_at_the_latest() -> None:
    schedule = economy_schedule(truck(ratios=[6.0, 1.5], final_drive=4.1))
    assert (schedule.kind == LATEST).all()
    assert geared_speed.run(truck(ratios=[6.0, 1.5]), 1, schedule.up[0])[0] == pytest.approx(3000.0 * np.pi / 30.0)


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_a_shift_map_says_the_same_in_every_life(car: RecordArray, life: str) -> None:
    schedule = economy_schedule(car)
    lines = schedule.shift_map()
    gear, throttle, speed = (a.ravel() for a in np.meshgrid(np.arange(1, 7), [0.1, 0.5, 0.9], np.linspace(0.5, 30, 9)))
    found = mapped_gear.run(lines, gear, throttle, speed)
    np.testing.assert_array_equal(found, mapped_gear.run(lines, gear, throttle, speed, life=life))
    up = np.array([[np.interp(t, schedule.throttle, line) for line in schedule.up] for t in throttle])
    down = np.array([[np.interp(t, schedule.throttle, line) for line in schedule.down] for t in throttle])
    for k, now in enumerate(gear):
        wanted = now + 1 if now < 6 and speed[k] > up[k, now - 1] else now
        wanted = now - 1 if wanted == now and now > 1 and speed[k] < down[k, now - 2] else wanted
        assert found[k] == wanted


def test_picture_has_a_line_for_each_shift(car: RecordArray) -> None:
    schedule = economy_schedule(car)
    figure = shift_schedule_figure(schedule, "title")
    assert len(figure.data) == 10
    assert figure.data[2].y == pytest.approx(3.6 * schedule.up[1], abs=1e-3)


def test_what_makes_no_sense(car: RecordArray) -> None:
    with pytest.raises(InputError, match="throttles"):
        economy_schedule(car, throttles=np.array([0.5, 0.2]))
    with pytest.raises(InputError, match="1 gear"):
        economy_schedule(truck(ratios=[3.0]))
    with pytest.raises(InputError, match="no gear holds"):
        economy_speed(car, fastest=2.0)
