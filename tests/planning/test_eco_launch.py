"""The cheapest launch: against all other ways on a small grid, a continuous optimum, published figures, physics."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from bitepoint.errors import InputError
from bitepoint.models.longitudinal import driving_force, engine_torque_for, fuel_for, geared_speed
from bitepoint.models.plan import SpeedPlan
from bitepoint.models.route import Route
from bitepoint.parts.body import Road
from bitepoint.parts.torque_engine import fuel_cut_torque, fuel_flow, highest_torque
from bitepoint.planning.eco_launch import LAUNCH_GRID, Launch, best_efficiency_fuel, launch_planner
from bitepoint.planning.speed_planner import HIGHEST_PRICE, Limits, SpeedPlanner, speed_task
from bitepoint.planning.speed_program import Grid, SpeedProgram
from bitepoint.planning.speed_stage import Stage
from bitepoint.planning.speed_sweep import Sweep, sweep
from bitepoint.planning.stations import Journey
from bitepoint.records import RecordArray
from tests.planning.vehicles import FRICTION, HEAT, SHARE, hatchback, truck

PAPER = Launch(start_speed=5.0 / 3.6, end_speed=49.8 / 3.6)


@pytest.fixture(scope="module")
def car() -> RecordArray:
    return hatchback()


def road_of(grade: float) -> RecordArray:
    return Road.parse({"grade": grade, "air_density": 1.206}, "test")


def stage_cost(model: RecordArray, gear: int, q0: float, q1: float, length: float, grade: float, price: float) -> float:
    """What a stage costs, from the model's laws, in a gear above the launch speed; infinite where it cannot be."""
    v, a = 0.5 * (np.sqrt(q0) + np.sqrt(q1)), 0.5 * (q1 - q0) / length
    force = driving_force.run(model, road_of(grade), np.sqrt(0.5 * (q0 + q1)), a)
    engine = geared_speed.run(model, gear, v)
    torque = engine_torque_for.run(model, gear, force, v, a)
    speeds = geared_speed.run(model, gear, np.sqrt([q0, q1]))
    if speeds.min() < model["launch_speed"][0] or speeds.max() > model["engine"]["speed_limit"][0]:
        return np.inf
    if torque[0] > highest_torque.run(model["engine"], engine)[0]:
        return np.inf
    torque = np.maximum(torque, fuel_cut_torque.run(model["engine"], engine))
    return float((fuel_for.run(model, engine, torque, v, a)[0] + price) * length / v)


def shift_cost(model: RecordArray, old: int, new: int, v: float, tau: float, price: float) -> float:
    """What a shift itself costs."""
    before, after = (float(geared_speed.run(model, gear, v)[0]) for gear in (old, new))
    engine, mean = model["engine"], 0.5 * (before + after)
    wanted = engine["inertia"][0] * (after - before) / tau
    low, high = fuel_cut_torque.run(engine, mean)[0], highest_torque.run(engine, mean)[0]
    return float(fuel_flow.run(engine, mean, np.clip(wanted, low, high))[0]) * tau + price * tau


def exhaustive(model: RecordArray, nodes: Any, lengths: Any, grades: Any, tau: float, price: float) -> float:
    """The least cost over all sequences of nodes and gears, one shift per stage at most."""
    best = np.inf
    edges: dict[Any, float] = {}

    def edge(k: int, old: int, new: int, q0: float, q1: float) -> float:
        key = (k, old, new, q0, q1)
        if key not in edges:
            length, extra = lengths[k], 0.0
            if old != new:
                v = end = float(np.sqrt(q0))
                for _ in range(2):  # the deceleration at the middle of the shift
                    road, middle = road_of(grades[k]), 0.5 * (v + end)
                    rest = driving_force.run(model, road, middle, 0.0)
                    end = v - tau * float((rest / (driving_force.run(model, road, middle, 1.0) - rest))[0])
                length, extra = length - 0.5 * (v + end) * tau, shift_cost(model, old, new, v, tau, price)
                q0 = end**2
            edges[key] = stage_cost(model, new, q0, q1, length, grades[k], price) + extra
        return edges[key]

    for path in itertools.product(*nodes):
        for gears in itertools.product((3, 4, 5), repeat=len(lengths)):
            for first in (3, 4, 5):
                cost, old = 0.0, first
                for k, gear in enumerate(gears):
                    cost += edge(k, old, gear, path[k], path[k + 1])
                    old = gear
                    if cost >= best:
                        break
                best = min(best, cost)
    return best


def only_gears(program: SpeedProgram, gears: tuple[int, ...], stages: int) -> Any:
    allowed = np.zeros((stages, program.gears), np.int64)
    allowed[:, [gear - 1 for gear in gears]] = 1
    return allowed


@pytest.mark.parametrize("tau", [0.2, 0.5])
@pytest.mark.parametrize("price", [0.0, 2e-3])
def test_no_other_way_on_the_grid_is_cheaper(car: RecordArray, tau: float, price: float) -> None:
    s, grade = np.array([0.0, 40.0, 80.0, 120.0, 160.0]), np.array([0.03, 0.03, -0.02, 0.0, 0.01])
    road = Route.of_grade(s, grade, np.full(5, np.inf), np.empty(0))
    journey = Journey(road, 11.0, (10.0, 14.0), 14.0, 10.0)
    program = SpeedProgram(speed_task(car, Limits(shift_time=tau)), journey, Grid(40.0, 4, 0, 0))
    program.task["time_price"] = price
    stations = program.stations(0)
    whole = np.column_stack((stations.low, (stations.high - stations.low) / 4.0, [1, 5, 5, 5, 5]))
    answer, _, _ = program._search(stations, whole, only_gears(program, (3, 4, 5), 4))  # pyright: ignore[reportPrivateUsage]
    assert answer is not None
    nodes = [[121.0], *([100.0 + 24.0 * n for n in range(5)] for _ in range(4))]
    rise = 0.5 * (grade[1:] + grade[:-1])
    assert answer.cost == pytest.approx(exhaustive(car, nodes, np.diff(s), rise, tau, price), rel=1e-9)


def test_lives_agree(car: RecordArray) -> None:
    task = speed_task(car, Limits())
    task["time_price"] = 1e-3
    plan = Sweep.zeros()
    plan["stations"], plan["gears"], plan["width"] = 4, 6, 5
    road = np.array([[5.0, 0.01, -1.0]] * 3)
    grids = np.array([[20.0, 0.0, 1], *[[20.0, 5.0, 5]] * 3])
    flags = np.concatenate((np.zeros(8), np.ones(18))).astype(np.int64)
    found: list[Any] = []
    for life in ("interpreted", "compiled"):
        value, policy = np.full(4 * 6 * 5, 1e9), np.zeros(4 * 6 * 5, np.int64)
        value[-30:] = 0.0
        edge, reach = np.zeros(6 * 5 * 16), np.zeros(25 * 5, np.int64)
        memory = (road.ravel(), grids.ravel(), flags, edge, reach, value, policy)
        sweep.run(plan, task, Stage.zeros(), *memory, life=life)
        found.append((value.copy(), policy.copy()))
    assert found[0][0][5] < 1e9
    np.testing.assert_array_equal(found[0][0], found[1][0])
    np.testing.assert_array_equal(found[0][1], found[1][1])


def collocated(model: RecordArray, length: float, speeds: tuple[float, float], price: float, curve: float) -> float:
    """The least cost of a continuous speed in 4th gear, by collocation over distance; fuel `curve` a^2 is added."""
    casadi = pytest.importorskip("casadi")
    body, gearbox, engine = model["vehicle"][0], model["gearbox"][0], model["engine"][0]
    r, lever = body["wheel_radius"], gearbox["ratios"][3] * gearbox["final_drive"] / body["wheel_radius"]
    mass = body["mass"] + model["wheel_inertia"][0] / r**2
    air = 0.5 * 1.206 * body["drag_coefficient"] * body["frontal_area"]
    n = 200
    ds, search = length / n, casadi.Opti()
    q, a = search.variable(n + 1), search.variable(n)
    middle = 0.5 * (q[1:] + q[:-1])
    time = 2.0 * ds / (casadi.sqrt(q[1:]) + casadi.sqrt(q[:-1]))
    force = mass * a + body["rolling_resistance"] * body["mass"] * 9.80665 + air * middle
    torque = force / (lever * gearbox["efficiency"]) + engine["inertia"] * lever * a
    flow = (torque + FRICTION) * lever * ds / (SHARE * HEAT) + curve * a**2 * time
    search.subject_to(q[1:] - q[:-1] == 2.0 * ds * a)
    search.subject_to(torque <= 450.0)
    search.subject_to(torque >= 0.0)
    search.subject_to((q[0] == speeds[0] ** 2, q[n] == speeds[1] ** 2))
    search.minimize(1e3 * (casadi.sum1(flow) + price * casadi.sum1(time)))
    search.set_initial(q, np.linspace(speeds[0] ** 2, speeds[1] ** 2, n + 1))
    search.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes"})
    return float(search.solve().value(search.f)) * 1e-3


@pytest.mark.parametrize(("price", "curve"), [(0.5e-3, 0.0), (2e-3, 0.0), (1e-3, 3e-3), (3e-3, 3e-3)])
def test_agrees_with_a_continuous_optimum(price: float, curve: float) -> None:
    model = truck(ratios=[5.37, 3.15, 2.03, 1.37], shift_time=0.5)
    model["correction"]["rising"][0, 0, 2] = model["correction"]["falling"][0, 0, 2] = curve
    for name, level in (("lowest", -20.0), ("highest", 20.0)):
        region = model["correction"][name]
        region["points"], region["x"], region["y"] = 2, 60.0, level
        region["x"][0, 0] = 0.0
    speeds, length = (9.0, 15.0), 400.0
    journey = Journey(Route.flat(length), speeds[0], (speeds[1], speeds[1]), 18.0, 8.0, 4)
    program = SpeedProgram(speed_task(model, Limits()), journey, Grid(10.0, 200, 0, 3))
    program.task["time_price"], program.task["gears"] = price, 4
    first, _ = program.solve()
    assert first is not None
    stations = first.stations
    found = program.refined(first, stations, 1600, only_gears(program, (4,), len(stations.grade)))
    best = collocated(model, length, speeds, price, curve)
    assert found.cost == pytest.approx(best, rel=5e-3)
    assert found.cost > best * (1.0 - 1e-3)  # a hair below is the continuous one's own discretisation


PUBLISHED = [(15.15, 13.49), (14.17, 13.60), (13.32, 14.05), (12.51, 15.30)]
"""Time, s, and fuel, g, of page 5 of the specification, without a cost of shifts."""


@pytest.mark.parametrize(("total_time", "grams"), PUBLISHED)
def test_the_front_of_the_specification(car: RecordArray, total_time: float, grams: float) -> None:
    found = launch_planner(car, PAPER, limits=Limits(shift_time=0.0)).plan_at_time(total_time)
    assert 1e3 * found.fuel == pytest.approx(grams, rel=0.01)
    assert abs(found.gap) < 0.005
    assert found.plan.total_time == pytest.approx(total_time, rel=1e-3) or found.plan.time_price == 0.0
    assert best_efficiency_fuel(car, found.plan) == pytest.approx(12.5e-3, rel=0.03)
    assert best_efficiency_fuel(car, found.plan) < found.plan.total_fuel


@pytest.mark.parametrize("price", [0.0, 1e-3, 4e-3])
def test_half_the_grid_hardly_moves_the_cost(car: RecordArray, price: float) -> None:
    plan = launch_planner(car, PAPER).plan(price, gap=True)
    assert abs(plan.grid_gap) < 0.003


def test_the_refined_answer_is_as_good_as_a_fine_grid_of_all_speeds(car: RecordArray) -> None:
    costs = [
        launch_planner(car, PAPER, grid=grid).plan(1e-3).cost for grid in (LAUNCH_GRID, Grid(5.0, 800, 0, 0))
    ]  # fmt: skip
    assert costs[0] == pytest.approx(costs[1], rel=5e-4)


def test_the_front_is_one(car: RecordArray) -> None:
    planner = launch_planner(car, PAPER)
    front = planner.pareto([0.0, 2e-4, 5e-4, 1e-3, 2e-3, 4e-3])
    fuel, time = ([getattr(plan, name) for plan in front] for name in ("total_fuel", "total_time"))
    assert len(front) >= 5
    assert (np.diff(fuel) > 0.0).all()
    assert (np.diff(time) < 0.0).all()


def test_a_time_between_two_gear_sequences_is_met(car: RecordArray) -> None:
    planner = launch_planner(car, PAPER)
    for total_time in (13.0, 14.2):
        found = planner.plan_at_time(total_time)
        assert found.plan.total_time == pytest.approx(total_time, rel=1e-3)
        assert found.gap < 0.01
    quick = planner.plan_at_time(5.0)
    assert quick.plan.total_time > 11.0


def assert_physical(model: RecordArray, plan: SpeedPlan, grade: float, least: float) -> None:
    body, gearbox = model["vehicle"][0], model["gearbox"][0]
    mass = body["mass"] + model["wheel_inertia"][0] / body["wheel_radius"] ** 2
    ds, q = np.diff(plan.distance), plan.speed**2
    angle = np.arctan(grade)
    slope = body["mass"] * 9.80665 * (body["rolling_resistance"] * np.cos(angle) + np.sin(angle))
    air = 0.5 * 1.206 * body["drag_coefficient"] * body["frontal_area"] * 0.5 * (q[1:] + q[:-1])
    driving = ~plan.shifting[:-1]
    gained = 0.5 * mass * np.diff(q)
    missing = gained - (plan.force[:-1] - slope - air) * ds
    np.testing.assert_allclose(missing[driving], 0.0, atol=1e-6 * mass)
    np.testing.assert_allclose(missing[~driving], 0.0, atol=2e-4 * mass)  # of air and speed in a shift
    w, torque = plan.engine_speed[:-1], plan.engine_torque[:-1]
    dt, a = np.diff(plan.time), plan.acceleration[:-1]
    ratio = gearbox["ratios"][plan.gear[:-1] - 1] * gearbox["final_drive"]
    through = (torque - model["engine"]["inertia"][0] * ratio * a / body["wheel_radius"]) * ratio
    pull = through / body["wheel_radius"] * np.where(through > 0.0, gearbox["efficiency"], 1.0 / gearbox["efficiency"])
    locked = driving & (plan.speed[:-1] * ratio / body["wheel_radius"] >= model["launch_speed"][0] * (1.0 + 1e-9))
    locked &= plan.speed[1:] * ratio / body["wheel_radius"] >= model["launch_speed"][0] * (1.0 + 1e-9)
    assert locked.sum() > 5
    np.testing.assert_allclose((pull - plan.brake_force[:-1] - plan.force[:-1])[locked], 0.0, atol=1e-6 * mass)
    assert (torque[driving] <= highest_torque.run(model["engine"], w)[driving] + 1e-6).all()
    assert (plan.acceleration[:-1][driving] >= least - 1e-6).all()
    assert (w <= model["engine"]["speed_limit"][0] * (1.0 + 1e-6)).all()
    np.testing.assert_allclose(dt[driving], 2.0 * ds[driving] / (plan.speed[:-1] + plan.speed[1:])[driving], rtol=1e-9)


@pytest.mark.parametrize("grade", [0.0, 0.04])
def test_a_plan_keeps_energy_and_limits(car: RecordArray, grade: float) -> None:
    road = Route.flat(150.0, grade=grade)
    plan = launch_planner(car, PAPER, road=road).plan(5e-4)
    assert plan.optimal
    assert plan.shifts >= 2
    assert_physical(car, plan, grade, 0.0)
    assert plan.speed[0] == pytest.approx(5.0 / 3.6)
    assert plan.speed[-1] == pytest.approx(49.8 / 3.6)
    assert plan.cost == pytest.approx(plan.total_fuel + 5e-4 * plan.total_time, rel=1e-9)
    assert plan.cost_to_go is not None
    assert np.nanmin(plan.cost_to_go.cost[0]) == pytest.approx(plan.cost, rel=0.01)


def test_a_demanded_acceleration_is_kept(car: RecordArray) -> None:
    launch = Launch(5.0 / 3.6, (12.0, 14.0), minimum_acceleration=0.5)
    plan = launch_planner(car, launch).plan(0.0)
    assert plan.optimal
    assert plan.acceleration[:-1][~plan.shifting[:-1]].min() >= 0.5 - 1e-9


def test_stop_lines_and_limits_on_the_way(car: RecordArray) -> None:
    s = np.array([0.0, 200.0, 300.0, 600.0])
    road = Route.of_grade(s, np.zeros(4), np.array([20.0, 8.0, 14.0, 14.0]), np.array([400.0]))
    plan = SpeedPlanner(car, Journey(road, 10.0, (10.0, 10.0), 20.0, dwell=5.0)).plan(1e-3)
    assert plan.optimal
    at_stop = np.flatnonzero(plan.speed == 0.0)
    assert plan.distance[at_stop] == pytest.approx([400.0])
    slow = (plan.distance >= 200.0 - 1e-9) & (plan.distance <= 300.0 + 1e-9)
    assert plan.speed[slow].max() <= 8.0 + 1e-9
    assert plan.speed[plan.distance >= 300.0].max() <= 14.0 + 1e-9
    free = SpeedPlanner(car, Journey(road, 10.0, (10.0, 10.0), 20.0)).plan(1e-3)
    idle = fuel_flow.run(car["engine"], car["engine"]["idle_speed"][0], 0.0)[0]
    assert plan.total_time - free.total_time == pytest.approx(5.0)
    assert plan.total_fuel - free.total_fuel == pytest.approx(5.0 * idle)


@pytest.mark.parametrize(("line", "least"), [(2.0, -1.0), (5.0, -1.0), (150.0, -0.7), (150.0, -0.3), (150.0, -0.1)])
def test_a_line_can_be_near_and_the_slowing_down_to_it_gentle(car: RecordArray, line: float, least: float) -> None:
    launch = Launch(5.0 / 3.6, 49.8 / 3.6, minimum_acceleration=least, dwell=2.0)
    plan = launch_planner(car, launch, road=Route.flat(300.0, stops=[line])).plan(1e-3)
    assert plan.optimal
    assert plan.speed[plan.distance == line] == pytest.approx(0.0)
    assert plan.acceleration[:-1][~plan.shifting[:-1]].min() >= least - 1e-6


def test_where_the_vehicle_cannot_slow_down_in_time_it_is_told(car: RecordArray) -> None:
    launch = Launch(8.0, 49.8 / 3.6, minimum_acceleration=-1.0)
    plan = launch_planner(car, launch, road=Route.flat(300.0, stops=[20.0])).plan(1e-3)
    assert not plan.optimal
    assert "at 20 m: no slower than 4.9 m/s, where 0 m/s is wanted" in plan.reason
    with pytest.raises(InputError, match="cannot stop"):
        launch_planner(car, PAPER, road=Route.flat(300.0, stops=[20.0]))
    assert launch_planner(car, PAPER, road=Route.flat(150.0, stops=[0.0])).plan(1e-3).optimal


def test_a_time_that_no_plan_meets_gets_the_fastest(car: RecordArray) -> None:
    road = Route.flat(400.0, grade=-0.15)
    planner = launch_planner(car, Launch(5.0 / 3.6, 49.8 / 3.6, minimum_acceleration=-1.5), road=road)
    timed = planner.plan_at_time(10.0)
    assert timed.late(10.0)
    assert timed.price == HIGHEST_PRICE
    assert timed.plan.total_time < 1.001 * planner.plan(10.0 * HIGHEST_PRICE).total_time
    met = planner.plan_at_time(timed.plan.total_time + 5.0)
    assert not met.late(timed.plan.total_time + 5.0)
    assert met.plan.total_time == pytest.approx(timed.plan.total_time + 5.0, rel=5e-3)


def test_shifts_cost(car: RecordArray) -> None:
    costs = [launch_planner(car, PAPER, limits=Limits(shift_time=tau)).plan(1e-3).cost for tau in (0.0, 0.25, 0.5)]
    assert costs[0] < costs[1] < costs[2]
    counts = [launch_planner(car, PAPER, limits=Limits(shift_price=grams)).plan(1e-3).shifts for grams in (0.0, 2e-3)]
    assert counts[1] < counts[0]


def test_what_cannot_be_driven_is_a_status_and_nonsense_an_error(car: RecordArray) -> None:
    plan = launch_planner(car, Launch(5.0 / 3.6, 40.0)).plan(1e-3)
    assert plan.status == "infeasible"
    assert np.isnan(plan.total_fuel)
    for wrong in (Launch(-1.0, 10.0), Launch(1.0, (10.0, 5.0)), Launch(1.0, 10.0, start_gear=7)):
        with pytest.raises(InputError, match="plan"):
            launch_planner(car, wrong)
    with pytest.raises(InputError, match="time_price"):
        launch_planner(car, PAPER).plan(-1.0)
    with pytest.raises(InputError, match="shift_time"):
        launch_planner(car, PAPER, limits=Limits(shift_time=-0.1))
