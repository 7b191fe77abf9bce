"""Scenarios that are planned before they are driven: the cheapest launch, and predictive cruise.

A planner makes a plan for the vehicle of the library; the driver of the scenario follows it on the plant. Beside it
stands the baseline, the same driver who chases the speed at the end, or the set speed, with a frozen shift map.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bitepoint.assembly.settings import SET, Settings
from bitepoint.controllers import pedal_driver
from bitepoint.controllers.controller import Controller
from bitepoint.controllers.pedal_driver_records import PLAN, SPEEDS
from bitepoint.controllers.plan_table import PLAN_POINTS, plan_parameters
from bitepoint.controllers.stop_lines import HARDEST, REACH, stop_lines
from bitepoint.errors import InputError
from bitepoint.models.fuel_model import FuelModel
from bitepoint.models.longitudinal import LongitudinalModel, driving_force
from bitepoint.models.plan import Floats, SpeedPlan
from bitepoint.models.route import Route
from bitepoint.models.shift_map import with_shift_map
from bitepoint.parts.body import Road
from bitepoint.parts.road_profile import grade_profile
from bitepoint.planning.drive_tasks import LONGEST_LAUNCH, CruiseTask, LaunchTask
from bitepoint.planning.eco_launch import LAUNCH_GRID, Launch, launch_planner
from bitepoint.planning.predictive_cruise import Cruise, RecedingCruise, cruise_planner, set_speed_cruise
from bitepoint.planning.shift_schedule import economy_schedule
from bitepoint.planning.speed_planner import Limits, SpeedPlanner, TimedPlan
from bitepoint.plants.plant import Plant
from bitepoint.records import Record, RecordArray
from bitepoint.scenarios import Scenario
from bitepoint.scenarios.routes import load_route
from bitepoint.simulation.system import Part, Profile, StopRule

DRIVER = pedal_driver.CONTROLLER.name
"""The part that follows a plan."""

TASKS: dict[str, type[Record]] = {"planner": LaunchTask, "cruise": CruiseTask}
"""Settings of the planner, by the block that a scenario gives them in."""

BASELINE, ROAD, FUEL_MODEL = "baseline", "road", "fuel_model"
"""Choices: calibration of the driver, and the road; and the model of `planner.fuel_model=FILE`."""

LOG = "speed"
"""Choice of a log to be followed, which a planned drive has no use for."""

MOST_STAGES = 60
"""Stages of the first sweep of a launch."""

SLOWING_DOWN = 0.8
"""Deceleration with which the baseline comes to a lower limit, m/s^2 (chosen, a calm driver's)."""

BEFORE_LINE = 20.0
"""Way before a stop line whose mean slope the driver minds, m (chosen)."""

MOST_DURATION = 3.0
"""Longest drive over the time that is planned for it."""


@dataclass(frozen=True)
class PlannedDrive:
    """A plan, and all that is needed to drive it and others beside it.

    Attributes:
        kind: "planner" or "cruise"; baseline: name of the driver's calibration.
        model: what was planned with; planner: makes further plans.
        plan: what is driven; price: of time, kg/s, that it was made at.
        length: m; target: speed that the baseline chases, and that both are to have at the end, m/s.
        dwell: time at each stop line, s; route: None: flat.
    """

    kind: str
    baseline: str
    model: RecordArray
    planner: SpeedPlanner
    plan: SpeedPlan
    price: float
    length: float
    target: float
    dwell: float
    route: Route | None

    def prepare(self, parameters: RecordArray) -> None:
        """Put the vehicle, a record of the plant, on the road, in the gear and at the speed that the plan begins."""
        parameters["gearbox"]["gear"] = self.plan.gear[0]
        parameters["start"]["speed"] = self.plan.speed[0]
        if self.route is not None:
            parameters["road"]["profile"] = grade_profile(self.route.distance, self.route.grade)

    def chased(self, profile: Profile) -> Profile:
        """Return the speed that the baseline chases, in the place of what the scenario gives."""
        return replace(profile, time=np.zeros(1), values=np.full(1, self.target))

    @property
    def stops(self) -> Floats:
        """Where the vehicle has to stand, m: stop lines, less one at the start."""
        return np.zeros(0) if self.route is None else self.route.stops[self.route.stops > 0.0]

    @property
    def arrival(self) -> StopRule:
        """The rule that ends the drive."""
        return StopRule("arrived", f"{self.length:g} m are driven", "distance", True, self.length, 0.0)

    @property
    def longest(self) -> float:
        """Time after which the drive is given up, s."""
        return MOST_DURATION * max(self.plan.total_time, self.length / self.target)

    def followed(self, parts: Sequence[Part], plan: SpeedPlan) -> list[Part]:
        """Return the parts with a driver who follows a plan and stops where it does.

        A shift that takes no time is no point of its own. Gear and torque next to a stop line are those beyond it: the
        driver comes to it by what is told of it.
        """
        kept = np.append(np.diff(plan.distance) > 0.0, True)
        distance, speed = plan.distance[kept], plan.speed[kept]
        gear, torque = plan.gear[kept].astype(float), plan.engine_torque[kept]
        brake = plan.brake_force[kept] * self.model["vehicle"]["wheel_radius"][0]
        table = plan_parameters(distance, speed, gear, torque, brake)
        at = self.stops
        rates = [_rates(distance, speed, line, np.append(0.0, at), np.append(at, self.length)) for line in at]
        slowing, leaving = np.array(rates).reshape(-1, 2).T
        spacing = float(table["spacing"][0])
        for line in at.tolist():
            row, beyond = math.floor(line / spacing), int(np.count_nonzero(distance <= line + 1e-6)) - 1
            for name, values in (("gear", gear), ("torque", torque), ("brake", brake)):
                table[name][0, row] = values[beyond]
        return _driven_to(parts, table, PLAN, self._lines(slowing, leaving))

    def chasing(self, parts: Sequence[Part]) -> list[Part]:
        """Return the parts with the driver of the baseline, who chases the target, and brakes for limits and lines."""
        route, target = self.route, self.target
        if route is None or not (route.stops.size or (route.speed_limit < target).any()):
            return list(parts)
        edges = np.linspace(0.0, route.length, PLAN_POINTS)
        limit = np.append(route.cells(edges)[1], route.speed_limit[-1])
        squared = np.minimum(np.minimum(limit, np.append(np.inf, limit[:-1])), target) ** 2
        room = 2.0 * SLOWING_DOWN * edges
        squared = np.minimum(squared, np.minimum.accumulate((squared + room)[::-1])[::-1] - room)
        nothing, lines = np.zeros(PLAN_POINTS), np.ones(self.stops.size)
        table = plan_parameters(edges, np.sqrt(squared), nothing, nothing)
        return _driven_to(parts, table, SPEEDS, self._lines(SLOWING_DOWN * lines, HARDEST * lines))

    def _lines(self, slowing: Floats, leaving: Floats) -> RecordArray:
        """Return the stop lines with rates to and off them, m/s^2, shape (lines,)."""
        at, braking = self.stops, np.zeros(self.stops.size)
        if at.size and self.route is not None:
            road = Road.zeros(at.size)
            rise = np.interp(at, self.route.distance, self.route.elevation)
            before = np.maximum(at - BEFORE_LINE, 0.0)
            road["grade"] = (rise - np.interp(before, self.route.distance, self.route.elevation)) / (at - before)
            force = driving_force.run(self.model, road, 0.0, -slowing)
            braking = np.maximum(-force, 0.0) / self.model["vehicle"]["mass"][0]
        return stop_lines(at, slowing, braking, leaving, self.dwell, ROAD)


def _driven_to(parts: Sequence[Part], table: RecordArray, mode: int, lines: RecordArray | None = None) -> list[Part]:
    return [
        replace(part, parameters=pedal_driver.with_plan(part.parameters, table, mode, lines))
        if part.name == DRIVER
        else part
        for part in parts
    ]


def scheduled(driver: Controller, parameters: RecordArray, plant: Plant, vehicle: RecordArray) -> RecordArray:
    """Return the parameters of a supervisor, with the economy schedule of the vehicle where one is to be followed.

    Args:
        vehicle: the plant's record.
    """
    if "schedule" not in driver.calibration.fields or plant.longitudinal is None:
        return parameters
    if not parameters["calibration"]["schedule"].any():
        return parameters
    return with_shift_map(parameters, economy_schedule(plant.longitudinal(vehicle)).shift_map())


def planned_drive(scenario: Scenario, settings: Settings, vehicle: RecordArray) -> PlannedDrive | None:
    """Return the plan of a scenario that has a planner, with settings applied; None for the others.

    Args:
        vehicle: the plant's record as the files give it.

    Raises:
        InputError: a setting, a road or a fuel model that cannot be, or no plan.
    """
    if scenario.planning is None:
        return None
    if LOG in settings.choices:
        raise InputError(SET, f"{LOG}: {scenario.name} drives to a plan", "leave it out")
    kind, block = scenario.planning
    task = TASKS[kind].parse(block, scenario.where, kind)
    changes = dict(settings.group(kind))
    file = changes.pop(FUEL_MODEL, None)
    for key, value in changes.items():
        TASKS[kind].assign(task, key, value, SET, f"{kind}.")
    model = LongitudinalModel.of(vehicle)
    if file is not None:
        model = _fuelled(str(file), model)
    route = _route(scenario, settings)
    baseline = str(settings.choices.get(BASELINE, scenario.baseline))
    known = pedal_driver.CONTROLLER.calibrations()
    if baseline not in known:
        raise InputError(BASELINE, f"got {baseline}", f"expected one of {', '.join(known)}")
    plan_it = _launch if kind == "planner" else _cruise
    planner, plan, price, length, target = plan_it(task[0], model, vehicle, route)
    if not plan.optimal:
        raise InputError(kind, plan.reason, "expected other speeds or accelerations, a longer way or another road")
    return PlannedDrive(kind, baseline, model, planner, plan, price, length, target, float(task[0]["dwell"]), route)


def _rates(distance: Floats, speed: Floats, line: float, before: Floats, after: Floats) -> tuple[float, float]:
    """Return the least deceleration and acceleration, m/s^2, with which a plan can be driven to and off a line.

    Args:
        distance, speed: of the plan, m and m/s; before, after: where the ways to lines begin, and those off them end.
    """
    since, until = before[before < line].max(), after[after > line].min(initial=distance[-1])
    off = np.abs(distance - line)
    square = speed**2
    near = off > 1e-6
    to, from_ = near & (distance >= since) & (distance < line), near & (distance > line) & (distance <= until)
    rates = [float(np.max(0.5 * square[part] / off[part], initial=0.0)) for part in (to, from_)]
    return min(rates[0], HARDEST), min(rates[1], HARDEST)


def _fuelled(file: str, model: RecordArray) -> RecordArray:
    """Return the model with the fuel of a file."""
    fuel = FuelModel.load(file)
    if fuel.kind == "plain":
        mend = "expected a steady one: bitepoint identify --model fuel --vehicle FILE"
        raise InputError(file, "a plain fuel model, to which all gears are alike", mend)
    return fuel.applied(model)


def _route(scenario: Scenario, settings: Settings) -> Route | None:
    name = settings.choices.get(ROAD, scenario.route)
    route = load_route(str(name)) if name else None
    if route is not None:  # refuse what no driver can keep before anything is planned
        nothing = np.zeros(route.stops.size)
        stop_lines(route.stops, nothing, nothing, nothing, 0.0, str(name))
        if route.stops.size and route.stops[-1] >= route.length - REACH:
            mend = "expected the road to go on: a drive ends at the speed that is wanted"
            raise InputError(str(name), "a stop line at its end", mend)
    return route


def _limits(task: np.void, vehicle: RecordArray) -> Limits:
    return Limits(
        shift_time=float(task["shift_time"]),
        shift_price=float(task["shift_price"]),
        air_density=float(vehicle["road"]["air_density"][0]),
    )


_Planned = tuple[SpeedPlanner, SpeedPlan, float, float, float]
"""Planner, plan, price of time (kg/s), length of the way (m) and speed at its end (m/s)."""


def _launch(task: np.void, model: RecordArray, vehicle: RecordArray, route: Route | None) -> _Planned:
    length = float(task["length"]) if route is None else route.length
    if length > LONGEST_LAUNCH:
        mend = f"expected up to {LONGEST_LAUNCH:g} m, or the scenario predictive-cruise"
        raise InputError("planner", f"a launch over {length:g} m", mend)
    end_speed = float(task["end_speed"])
    launch = Launch(
        float(vehicle["start"]["speed"][0]),
        end_speed,
        length,
        float(task["minimum_acceleration"]),
        start_gear=int(vehicle["gearbox"]["gear"][0]),
        dwell=float(task["dwell"] + task["start_time"]),
    )
    grid = replace(LAUNCH_GRID, spacing=max(LAUNCH_GRID.spacing, length / MOST_STAGES))
    planner = launch_planner(model, launch, road=route, limits=_limits(task, vehicle), grid=grid)
    price = float(task["time_price"])
    return planner, planner.plan(price, gap=True), price, length, end_speed


def _cruise(task: np.void, model: RecordArray, vehicle: RecordArray, route: Route | None) -> _Planned:
    if route is None:
        raise InputError("road", "missing", "add --set road=FILE")
    cruise = Cruise(
        float(task["set_speed"]),
        float(task["band"]),
        float(task["minimum_acceleration"]),
        float(task["horizon"]),
        float(task["advance"]),
        float(task["dwell"] + task["start_time"]),
    )
    limits = _limits(task, vehicle)
    held = set_speed_cruise(model, route, cruise, limits=limits)
    planner = cruise_planner(model, route, cruise, limits=limits)
    if not held.optimal:
        return planner, held, 0.0, route.length, cruise.set_speed
    timed = planner.plan_at_time(held.total_time)
    plan = _windows(model, route, cruise, timed, limits) if task["receding"] else timed.plan
    return planner, plan, timed.price, route.length, cruise.set_speed


def _windows(model: RecordArray, route: Route, cruise: Cruise, timed: TimedPlan, limits: Limits) -> SpeedPlan:
    """Return what windows drive at the price of time at which the whole road would take the wanted time."""
    if not timed.plan.optimal:
        return timed.plan
    return RecedingCruise(model, route, cruise, time_price=timed.price, limits=limits).drive()
