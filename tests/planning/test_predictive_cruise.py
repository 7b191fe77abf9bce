"""Predictive cruise: bands, equal time and energy, windows as good as the whole road, and where savings come from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bitepoint.errors import InputError
from bitepoint.models.route import Route
from bitepoint.planning.predictive_cruise import (
    Cruise,
    RecedingCruise,
    brake_work,
    compare_cruise,
    cruise_planner,
    road_window,
    set_speed_cruise,
)
from bitepoint.planning.steady import energy_value, set_speed_price, steady_fuel
from bitepoint.records import RecordArray
from tests.planning.vehicles import HEAT, SHARE, hills, truck

CRUISE = Cruise(set_speed=73.7 / 3.6, band=5.0 / 3.6)


@pytest.fixture(scope="module")
def model() -> RecordArray:
    return truck()


def test_the_price_of_time_makes_the_set_speed_the_cheapest(model: RecordArray) -> None:
    price = set_speed_price(model, CRUISE.set_speed)
    speed = np.linspace(16.0, 25.0, 181)
    cost = (steady_fuel(model, speed).min(axis=0) + price) / speed
    assert speed[np.argmin(cost)] == pytest.approx(CRUISE.set_speed, abs=0.1)
    assert energy_value(model, CRUISE.set_speed) == pytest.approx(1.0 / (0.94 * SHARE * HEAT), rel=1e-6)


def test_a_flat_road_leaves_nothing_to_save(model: RecordArray) -> None:
    found = compare_cruise(model, Route.flat(5000.0), CRUISE)
    assert abs(found.saving) < 2e-3
    assert found.predictive.plan.speed == pytest.approx(CRUISE.set_speed, abs=0.7)


def test_hills_are_worth_a_look_ahead(model: RecordArray) -> None:
    found = compare_cruise(model, hills(0.025), CRUISE)
    held, plan = found.held, found.predictive.plan
    assert plan.total_time == pytest.approx(held.total_time, rel=1e-3)
    for driven in (held, plan):
        assert driven.speed[[0, -1]] == pytest.approx(CRUISE.set_speed)
    assert plan.speed.max() <= CRUISE.set_speed + CRUISE.band + 0.5  # what a shift downhill gains
    assert plan.speed.min() >= CRUISE.set_speed - CRUISE.band - 0.5
    assert 0.03 < found.saving < 0.06
    spared = (found.brake_work[0] - found.brake_work[1]) / (0.94 * SHARE * HEAT)
    assert spared > 0.5 * (held.total_fuel - plan.total_fuel)
    assert found.predictive.gap < 2e-3


def test_what_the_engine_cannot_hold_it_need_not(model: RecordArray) -> None:
    s = np.array([0.0, 1000.0, 1001.0, 2500.0, 2501.0, 6000.0])
    road = Route.of_grade(s, np.array([0.0, 0.0, 0.08, 0.08, 0.0, 0.0]), np.full(6, np.inf), np.empty(0))
    held = set_speed_cruise(model, road, CRUISE)
    assert held.optimal
    assert held.speed.min() < CRUISE.set_speed - 2.0
    assert held.speed.max() <= CRUISE.set_speed + 1e-6
    assert cruise_planner(model, road, CRUISE).plan(set_speed_price(model, CRUISE.set_speed)).optimal


def test_windows_do_as_well_as_the_whole_road(model: RecordArray) -> None:
    road = hills(0.025, length=8000.0)
    receding = RecedingCruise(model, road, CRUISE)
    driven = receding.drive()
    whole = cruise_planner(model, road, CRUISE).plan(receding.time_price)
    cost = [plan.total_fuel + receding.time_price * plan.total_time for plan in (driven, whole)]
    assert cost[0] == pytest.approx(cost[1], rel=2e-3)
    assert driven.distance[-1] == pytest.approx(8000.0)
    assert (np.diff(driven.distance) > 0.0).all()
    assert (np.diff(driven.time) > 0.0).all()
    assert driven.speed[-1] == pytest.approx(CRUISE.set_speed)


def test_a_window_keeps_its_kinetic_energy(model: RecordArray) -> None:
    plan = RecedingCruise(model, Route.flat(50_000.0), CRUISE).plan(0.0, CRUISE.set_speed, 6)
    assert plan.speed[plan.distance < 1800.0] == pytest.approx(CRUISE.set_speed, abs=0.3)
    assert brake_work(plan) == 0.0


def test_a_part_of_a_road_is_that_part() -> None:
    road = hills(0.02, length=3000.0)
    part = road_window(road, 510.0, 1510.0)
    at = np.linspace(0.0, 1000.0, 77)
    assert np.interp(at, part.distance, part.grade) == pytest.approx(np.interp(at + 510.0, road.distance, road.grade))


@pytest.mark.parametrize("gap", [1.0, 3.0, 30.0])
@pytest.mark.parametrize("least", [-0.3, -4.0])
def test_two_lines_can_be_near_each_other(model: RecordArray, gap: float, least: float) -> None:
    road, cruise = Route.flat(2500.0, stops=[1200.0, 1200.0 + gap]), replace(CRUISE, minimum_acceleration=least)
    receding = RecedingCruise(model, road, cruise)
    driven, whole = receding.drive(), cruise_planner(model, road, cruise).plan(receding.time_price)
    assert driven.distance[driven.speed == 0.0] == pytest.approx(road.stops)
    cost = [plan.total_fuel + receding.time_price * plan.total_time for plan in (driven, whole)]
    assert cost[0] == pytest.approx(cost[1], rel=3e-3)


def test_a_band_goes_below_a_limit(model: RecordArray) -> None:
    s, limit = np.array([0.0, 1000.0, 3000.0, 4000.0]), np.array([80.0, 40.0, 80.0, 80.0]) / 3.6
    waves = Route.of_grade(
        np.linspace(0.0, 4000.0, 201), 0.03 * np.sin(np.linspace(0.0, 50.0, 201)), np.full(201, 1e3), np.empty(0)
    )
    cells = np.clip(np.searchsorted(s, waves.distance, side="right") - 1, 0, 3)
    road = replace(waves, speed_limit=limit[cells])
    plan = cruise_planner(model, road, CRUISE).plan(set_speed_price(model, CRUISE.set_speed))
    slow = plan.speed[(plan.distance >= 1000.0) & (plan.distance <= 3000.0)]
    assert slow.max() <= 40.0 / 3.6 + 0.05  # in a shift downhill
    assert 40.0 / 3.6 - CRUISE.band - 0.2 < slow.min() < 40.0 / 3.6 - 0.5


def test_windows_end_where_the_engine_does_not_hold_the_band(model: RecordArray) -> None:
    s = np.array([0.0, 1000.0, 1001.0, 3000.0])
    road = Route.of_grade(s, np.array([0.0, 0.0, 0.07, 0.07]), np.full(4, np.inf), np.empty(0))
    plan = RecedingCruise(model, road, CRUISE).plan(0.0, CRUISE.set_speed, 6)
    assert plan.optimal
    assert plan.speed[-1] < CRUISE.set_speed - CRUISE.band


def test_a_limit_just_behind_a_line_hardly_costs_more(model: RecordArray) -> None:
    s = np.array([0.0, 1000.0, 1001.0, 2000.0])
    price = set_speed_price(model, CRUISE.set_speed)
    costs: list[float] = []
    for limit in (25.0, 24.9):  # as good as none: but the road is cut there
        road = Route.of_grade(s, np.zeros(4), np.array([25.0, 25.0, limit, 25.0]), np.array([1000.0]))
        costs.append(cruise_planner(model, road, CRUISE).plan(price).cost)
    assert costs[1] == pytest.approx(costs[0], rel=2e-3)


def test_windows_mind_a_lower_limit_beyond_their_end(model: RecordArray) -> None:
    s, limit = np.array([0.0, 1500.0, 2500.0, 3000.0]), np.array([80.0, 30.0, 80.0, 80.0]) / 3.6
    road = Route.of_grade(s, np.zeros(4), limit, np.empty(0))
    driven = RecedingCruise(model, road, replace(CRUISE, set_speed=75.0 / 3.6, horizon=300.0)).drive()
    slow = (driven.distance >= 1500.0) & (driven.distance <= 2500.0)
    assert driven.speed[slow].max() <= 30.0 / 3.6 + 1e-6
    assert driven.speed[driven.distance < 1100.0].min() > 70.0 / 3.6


def test_where_the_band_cannot_be_kept_it_is_told(model: RecordArray) -> None:
    road, cruise = Route.flat(2000.0, stops=[1000.0]), replace(CRUISE, minimum_acceleration=-0.2)
    with pytest.raises(InputError, match=r"at 1000 m: no slower than 4\.\d+ m/s, where 0 m/s is wanted"):
        compare_cruise(model, road, cruise)


@pytest.mark.parametrize("seed", range(8))
def test_any_road_that_can_be_driven_has_a_plan_and_windows_do_nearly_as_well(model: RecordArray, seed: int) -> None:
    random = np.random.default_rng(seed)
    way = np.sort(np.append(random.uniform(0.0, 4000.0, 30), [0.0, 4000.0]))
    limit, slow = np.full(32, np.inf), np.sort(random.integers(6, 24, 2))
    limit[slow[0] : slow[1] + 1] = random.uniform(6.0, 25.0)
    first, second = np.sort(random.uniform(1100.0, 2500.0, 2))
    lines = np.array([first, first + random.uniform(1.0, 15.0), second + 30.0])
    road = Route.of_grade(way, 0.03 * np.sin(way / random.uniform(80.0, 500.0)), limit, lines)
    cruise = replace(CRUISE, minimum_acceleration=-random.choice([0.4, 1.0, 4.0]))
    receding = RecedingCruise(model, road, cruise)
    driven, whole = receding.drive(), cruise_planner(model, road, cruise).plan(receding.time_price)
    cost = [plan.total_fuel + receding.time_price * plan.total_time for plan in (driven, whole)]
    assert cost[0] == pytest.approx(cost[1], rel=0.02)


def test_half_the_grid(model: RecordArray) -> None:
    planner = cruise_planner(model, hills(0.025, length=8000.0), CRUISE)
    assert abs(planner.plan(set_speed_price(model, CRUISE.set_speed), gap=True).grid_gap) < 3e-3


def test_what_makes_no_sense(model: RecordArray) -> None:
    with pytest.raises(InputError, match="band"):
        Cruise(10.0, 11.0)
    with pytest.raises(InputError, match="advance"):
        Cruise(10.0, 1.0, horizon=100.0, advance=200.0)
    with pytest.raises(InputError, match="holds 60 m/s"):
        set_speed_price(model, 60.0)
