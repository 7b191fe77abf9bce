"""The plan, its front of fuel against time, the shift schedule, and what the paper's programme makes of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.plan import SpeedPlan
from bitepoint.parts.torque_engine import highest_torque
from bitepoint.planning.eco_launch import Launch, best_efficiency_fuel, launch_planner
from bitepoint.planning.shift_schedule import CROSSING, HYSTERESIS, ShiftSchedule, economy_schedule
from bitepoint.planning.speed_planner import Limits, TimedPlan
from bitepoint.planning.steady import economy_speed
from bitepoint.recording import Floats
from bitepoint.records import RecordArray
from bitepoint.studies.eco_launch.euler import EULER, EXACT, GridPlan, euler_error, grid_plan
from bitepoint.studies.reproduction import Row

START, END, LENGTH = 5.0 / 3.6, 49.8 / 3.6, 150.0
SHIFT_TIME = 0.3

FRONT: Mapping[float, float] = {15.15: 13.49e-3, 14.17: 13.60e-3, 13.32: 14.05e-3, 12.51: 15.30e-3}
"""Time, s, and fuel, kg, of page 5 of the specification, where shifts cost nothing."""

BEST_EFFICIENCY = 12.6e-3
"""Fuel of the work at the wheels at the best efficiency there, kg."""

PRICES = (0.0, 1e-4, 2e-4, 4e-4, 7e-4, 1e-3, 1.5e-3, 2e-3, 3e-3)
"""Prices of time at which the front is drawn, kg/s."""

STEPS = (10.0, 5.0, 2.0, 1.0, 0.5)
"""Steps of the paper's programme that are tried, m."""

SPEEDS = 225
"""Speeds of its grid, 0.2 km/h apart."""

STEADY_ACCELERATION = 2.0
"""Acceleration at which the steps are judged over the first 10 m, m/s^2; that of a plan is 1.5 to 3 there."""

OUTPUT_DOWNSHIFT = 65.0 * math.pi / 30.0
"""Speed of the gearbox output by which a downshift lies lower, rad/s; the paper equates it with 2 km/h."""

ENGINE_POWER = 110e3
"""Of the engine of the paper's schedule, W."""

STRONGER = 1.1
"""Full load of another engine of that size over ours."""

PART_LOAD = 0.801
"""Share of the full load beyond which the torque of the stronger engine leaves the fuel map."""


@dataclass(frozen=True)
class Plans:
    """Plans of the launch, no shift cost: those of the published times; with it: the front, the cheapest first."""

    model: RecordArray
    free: Mapping[float, TimedPlan]
    front: Sequence[SpeedPlan]
    bound: float

    @property
    def cheapest(self) -> SpeedPlan:
        """The plan at no price of time."""
        return self.front[0]


def plans(model: RecordArray) -> Plans:
    """Return the plans of the launch for a vehicle, one record `LongitudinalModel`."""
    launch = Launch(START, END, LENGTH, start_gear=1)
    free = launch_planner(model, launch, limits=Limits(shift_time=0.0))
    planner = launch_planner(model, launch, limits=Limits(shift_time=SHIFT_TIME))
    front = planner.pareto(PRICES)
    front[0] = planner.plan(0.0, gap=True)
    return Plans(model, {time: free.plan_at_time(time) for time in FRONT}, front, best_efficiency_fuel(model, front[0]))


def plan_rows(found: Plans) -> Iterator[Row]:
    """Yield the figures of the plan and of the front."""
    plan = found.cheapest
    case = "plan of 150 m, the cheapest"
    yield Row(case, "last gear", 5.0, float(plan.gear[-1]), "1", 0.0)
    for gear in (3, 4, 5):
        yield Row(case, f"share of the way in gear {gear}", None, _share(plan, gear), "1")
    yield Row(case, "total_fuel", None, plan.total_fuel, "kg")
    yield Row(case, "fuel at the best efficiency", BEST_EFFICIENCY, found.bound, "kg", 0.03)
    yield Row(case, "grid_gap", 0.003, plan.grid_gap, "1", 0.0, "magnitude")
    yield Row(case, "plan_time", 0.1, plan.plan_time, "s")
    for time, fuel in FRONT.items():
        case = f"plan of 150 m in {time:g} s, shifts cost nothing"
        yield Row(case, "total_fuel", fuel, found.free[time].fuel, "kg", 0.01)


def _share(plan: SpeedPlan, gear: int) -> float:
    way: Floats = np.diff(plan.distance)
    return float(np.sum(way * (plan.gear[:-1] == gear)) / np.sum(way))


def schedule_rows(model: RecordArray, schedule: ShiftSchedule) -> Iterator[Row]:
    """Yield what can be said of fig. 6, and of the speed at the end."""
    case = "shift schedule"
    gap = float(np.max(schedule.up - schedule.down))
    yield Row(case, "downshift below upshift", HYSTERESIS, gap, "m/s", 0.01)
    final, radius = float(model["gearbox"]["final_drive"][0]), float(model["vehicle"]["wheel_radius"][0])
    yield Row(case, "the same at the gearbox output", OUTPUT_DOWNSHIFT, gap / radius * final, "rad/s", 0.05)
    crossed = np.count_nonzero(schedule.kind == CROSSING) / schedule.kind.size
    yield Row(case, "share of shifts where g_e of two gears meet", None, crossed, "1")
    best = economy_speed(model)
    yield Row("economical speed", "speed", END, best.speed, "m/s", 0.02)
    yield Row("economical speed", "gear", None, float(best.gear), "1")
    turning = float(model["gearbox"]["ratios"][0, best.gear - 1]) * final * END / radius
    lowest = float(model["launch_speed"][0])
    yield Row("economical speed", "engine speed in that gear at 49.8 km/h", None, turning, "rad/s")
    yield Row("economical speed", "lowest engine speed in gear", None, lowest, "rad/s")
    speeds: Floats = np.linspace(lowest, float(model["engine"]["speed_limit"][0]), 500)
    power = float(np.max(speeds * highest_torque.run(model["engine"], speeds)))
    yield Row("engine", "highest power", ENGINE_POWER, power, "W", 0.03)
    stronger = model.copy()
    stronger["engine"]["full_load"]["y"] *= STRONGER
    moved = np.abs(economy_schedule(stronger).up - schedule.up)
    case = "shift schedule, full load 10 % higher, same fuel"
    yield Row(case, "median change", None, float(np.median(moved)), "m/s")
    part = moved[:, schedule.throttle <= PART_LOAD]
    yield Row(case, "largest change up to 80 % throttle", None, float(part.max()), "m/s")


@dataclass(frozen=True)
class Discretised:
    """What comes of steps of each length, m: the error of the speed after 10 m (m/s), and the paper's programme."""

    errors: Mapping[float, float]
    euler: Mapping[float, GridPlan]
    exact: Mapping[float, GridPlan]


def discretised(model: RecordArray) -> Discretised:
    """Return the experiments on the paper's steps."""
    errors = {step: euler_error(STEADY_ACCELERATION, START, 10.0, step) for step in STEPS}
    speeds: Floats = np.linspace(START, END, SPEEDS)
    made: dict[str, dict[float, GridPlan]] = {EULER: {}, EXACT: {}}
    for steps, found in made.items():
        for step in STEPS:
            plan = grid_plan(model, START, END, LENGTH, round(LENGTH / step), speeds, steps)
            if plan is None:
                raise InputError("launch", f"steps of {step:g} m: no plan", "expected finer speeds")
            found[step] = plan
    return Discretised(errors, made[EULER], made[EXACT])


def euler_rows(found: Discretised, bound: float) -> Iterator[Row]:
    """Yield the error of the paper's steps, and what its programme promises beside what any engine can do.

    Args:
        bound: fuel of the cheapest plan's work at the best efficiency, kg.
    """
    for step, error in found.errors.items():
        yield Row(f"forward Euler, steps of {step:g} m", "speed too high after 10 m at 2 m/s²", None, error, "m/s")
    for step, plan in found.euler.items():
        case = f"the paper's programme, steps of {step:g} m"
        yield Row(case, "total_fuel", None, plan.fuel, "kg")
        yield Row(case, "fuel over that at the best efficiency", None, plan.fuel / bound, "1")
        yield Row(case, "kinetic energy from nothing", None, plan.gain, "J")
        yield Row(case, "speed after the first step", None, float(plan.speed[1]), "m/s")
    for step, plan in found.exact.items():
        yield Row(f"uniform speeds, exact steps of {step:g} m", "total_fuel", None, plan.fuel, "kg")
