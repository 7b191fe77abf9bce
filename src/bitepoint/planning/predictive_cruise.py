"""Predictive cruise: speed and gear over the hills ahead, within a band around a set speed.

The same programme as for a launch, over a longer road: as a whole, or in windows that move with the vehicle. A window
does not spend the kinetic energy that is left at its end: it is worth there what the engine takes to make it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.plan import Floats, SpeedPlan
from bitepoint.models.route import Route
from bitepoint.parts.torque_engine import fuel_flow
from bitepoint.planning.speed_planner import Limits, SpeedPlanner, TimedPlan
from bitepoint.planning.speed_program import Grid
from bitepoint.planning.stations import SLOW, Journey
from bitepoint.planning.steady import energy_value, set_speed_price
from bitepoint.records import RecordArray

CRUISE_GRID = Grid(spacing=50.0, steps=24, halvings=0, refinements=2)
"""Half of it moves the fuel by some 0.1 %."""

STOPPING_GRID = Grid(spacing=50.0, steps=50, halvings=1, refinements=4, short=5.0)
"""The same for a road with stop lines: within 1 % of what stages of 5 m and eight times the steps find."""

HOLDING = 10.0
"""Price of time of a vehicle that holds its set speed, over the price at which that speed is worth driving."""

ROOM_TO_STOP = 1.5
"""Way to a line, or to a lower limit, that a window minds beyond its end, over the shortest that the vehicle takes."""

ROAD_THAT_GOES = "expected another set speed, band or cruise.minimum_acceleration, or another road"

HELD_BAND = 0.5
"""Speed by which it may fall behind where torque would do, as in a shift, m/s."""


@dataclass(frozen=True)
class Cruise:
    """How a road is driven.

    Attributes:
        set_speed: m/s, also at both ends; band: to either side, m/s.
        minimum_acceleration: m/s^2.
        horizon: of a window, m; advance: distance after which the next window is planned, m.
        dwell: at each stop line, s.
    """

    set_speed: float
    band: float
    minimum_acceleration: float = -1.0
    horizon: float = 2000.0
    advance: float = 100.0
    dwell: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.band < self.set_speed:
            raise InputError(
                "cruise", f"band: got {self.band:g} m/s", "expected more than 0 and less than the set speed"
            )
        if not 0.0 < self.advance <= self.horizon:
            raise InputError("cruise", f"advance: got {self.advance:g} m", "expected more than 0, up to the horizon")


@dataclass(frozen=True)
class CruiseComparison:
    """Predictive cruise beside a set speed over the same road, from the same speed to the same speed, in the same time.

    Attributes:
        held: the set speed, held where torque permits, never passed, in the gears that take the least fuel so.
        predictive: the plan of that time.
    """

    held: SpeedPlan
    predictive: TimedPlan

    @property
    def saving(self) -> float:
        """Share of the fuel that is saved."""
        return 1.0 - self.predictive.fuel / self.held.total_fuel

    @property
    def brake_work(self) -> tuple[float, float]:
        """What the brakes take, J: holding the set speed, and with foresight."""
        return brake_work(self.held), brake_work(self.predictive.plan)


def brake_work(plan: SpeedPlan) -> float:
    """Return what the brakes take over a plan, J."""
    return float(np.sum(plan.brake_force[:-1] * np.diff(plan.distance)))


def cruise_grid(road: Route) -> Grid:
    """Return the grid that a road is searched on."""
    return STOPPING_GRID if road.stops.size else CRUISE_GRID


def cruise_planner(
    model: RecordArray, road: Route, cruise: Cruise, *, limits: Limits | None = None, grid: Grid | None = None
) -> SpeedPlanner:
    """Return the planner of a whole road: its `plan`, `plan_at_time` and `pareto`.

    Args:
        model: one record `LongitudinalModel`; grid: None: `cruise_grid`.
    """
    v, band = cruise.set_speed, cruise.band
    journey = Journey(
        road, v, (v, v), v + band, v - band, minimum_acceleration=cruise.minimum_acceleration, dwell=cruise.dwell
    )
    return SpeedPlanner(model, journey, limits, grid or cruise_grid(road))


def set_speed_cruise(
    model: RecordArray, road: Route, cruise: Cruise, *, limits: Limits | None = None, grid: Grid | None = None
) -> SpeedPlan:
    """Return the plan that holds the set speed: below only where torque does not do, never above, brakes downhill."""
    v = cruise.set_speed
    journey = Journey(
        road, v, (v, v), v, v - HELD_BAND, minimum_acceleration=cruise.minimum_acceleration, dwell=cruise.dwell
    )
    return SpeedPlanner(model, journey, limits, grid or cruise_grid(road)).plan(
        HOLDING * max(set_speed_price(model, v), 1e-5)
    )


def compare_cruise(
    model: RecordArray, road: Route, cruise: Cruise, *, limits: Limits | None = None, grid: Grid | None = None
) -> CruiseComparison:
    """Return predictive cruise beside the held set speed at equal time.

    Raises:
        InputError: the road cannot be driven so.
    """
    held = set_speed_cruise(model, road, cruise, limits=limits, grid=grid)
    if not held.optimal:
        raise InputError("cruise", held.reason, ROAD_THAT_GOES)
    planner = cruise_planner(model, road, cruise, limits=limits, grid=grid)
    return CruiseComparison(held, planner.plan_at_time(held.total_time))


@dataclass(frozen=True)
class Window:
    """One planning of a moving vehicle: where it was, m, and the plan from there on, its distances from there."""

    position: float
    plan: SpeedPlan


class RecedingCruise:
    """Plans a road window by window, as a vehicle would that drives each plan a little way.

    Args:
        time_price: kg/s; None: that at which the set speed is worth driving on a flat road.
    """

    def __init__(
        self,
        model: RecordArray,
        road: Route,
        cruise: Cruise,
        *,
        time_price: float | None = None,
        limits: Limits | None = None,
        grid: Grid | None = None,
    ) -> None:
        self.model, self.road, self.cruise, self.limits, self.grid = model, road, cruise, limits, grid
        self.time_price = set_speed_price(model, cruise.set_speed) if time_price is None else time_price
        self.worth = energy_value(model, cruise.set_speed)
        engine = model["engine"]
        self.idle = float(fuel_flow.run(engine, engine["idle_speed"][0], 0.0)[0])

    def plan(self, position: float, speed: float, gear: int | None) -> SpeedPlan:
        """Return the plan of the window that begins at `position` (m) with `speed` (m/s) in a gear, None: any."""
        v, band = self.cruise.set_speed, self.cruise.band
        end, speeds = self.end(position)
        ahead = road_window(self.road, position, end)
        last = speeds is not None
        low, most = min(v - band, speed), min(v + band, self.seen(end))
        journey = Journey(
            ahead, speed, speeds or (0.0, most), max(v + band, speed), low, gear,
            self.cruise.minimum_acceleration, end_value=0.0 if last else self.worth, free_end=not last,
        )  # fmt: skip
        grid = STOPPING_GRID if min(speed, journey.end_speed[1]) < SLOW else CRUISE_GRID
        return SpeedPlanner(self.model, journey, self.limits, self.grid or grid).plan(self.time_price)

    def end(self, position: float) -> tuple[float, tuple[float, float] | None]:
        """Return where the window ends that begins at `position`, m, and the speeds that are given there, m/s.

        It ends at the first stop line or at the end of the road where that is within the horizon, or too near beyond
        for a vehicle to be free in its speed there; what is before a line has nothing to do with what is after it.
        """
        v, length, lines = self.cruise.set_speed, self.road.length, self.road.stops[self.road.stops > position + 1e-6]
        far = position + self.cruise.horizon
        if lines.size:
            braking = 0.5 * (v + self.cruise.band) ** 2 / max(-self.cruise.minimum_acceleration, 1e-3)
            if lines[0] <= far + ROOM_TO_STOP * braking:
                return float(lines[0]), (0.0, 0.0)
        return (length, (v, v)) if far >= length else (far, None)

    def seen(self, position: float) -> float:
        """Return the highest speed at `position` (m), m/s, from which the limits beyond are kept with ease."""
        s, limit = self.road.distance, self.road.speed_limit
        ahead = s > position
        slowing = max(-self.cruise.minimum_acceleration, 0.0) / ROOM_TO_STOP
        squared = limit[ahead] ** 2 + 2.0 * slowing * (s[ahead] - position)
        return math.sqrt(float(np.min(squared, initial=math.inf)))

    def windows(self) -> Iterator[Window]:
        """Yield the windows along the road, each from where the plan before it has led."""
        position, speed, gear = float(self.road.distance[0]), self.cruise.set_speed, None
        end = self.road.length
        while position < end - 1e-6:
            plan = self.plan(position, speed, gear)
            if not plan.optimal:
                raise InputError("cruise", f"window from {position:.0f} m: {plan.reason}", ROAD_THAT_GOES)
            cut = self._cut(plan, self.end(position)[1] is not None)
            yield Window(position, _until(plan, cut))
            position, speed = position + float(plan.distance[cut]), float(plan.speed[cut])
            gear = int(plan.gear[cut - 1]) if speed > 0.0 else None

    def drive(self) -> SpeedPlan:
        """Return what the windows drive, one after the other.

        Raises:
            InputError: the road cannot be driven within the band.
        """
        parts: list[SpeedPlan] = []
        for window in self.windows():
            before = parts[-1] if parts else None
            time, fuel = (before.time[-1], before.fuel[-1]) if before else (0.0, 0.0)
            if before is not None and before.speed[-1] == 0.0:
                time, fuel = time + self.cruise.dwell, fuel + self.cruise.dwell * self.idle
            plan = window.plan
            moved = {"distance": plan.distance + window.position, "time": plan.time + time, "fuel": plan.fuel + fuel}
            parts.append(replace(plan, **moved))
        joined: dict[str, Floats] = {}
        for name in (f.name for f in fields(SpeedPlan)):
            if isinstance(getattr(parts[0], name), np.ndarray):
                columns = [getattr(part, name)[:-1] for part in parts[:-1]] + [getattr(parts[-1], name)]
                joined[name] = np.concatenate(columns)
        return replace(parts[-1], reason=f"{len(parts)} windows", cost=np.nan, cost_to_go=None, **joined)

    def _cut(self, plan: SpeedPlan, last: bool) -> int:
        """Return the first point at which the next window may begin: a station, the advance or more from here.

        Args:
            last: the plan leads to a line or to the end of the road, and is driven to its end.
        """
        if last:
            return len(plan.distance) - 1
        far = plan.distance >= self.cruise.advance - 1e-6
        return int(np.argmax(far & ~np.concatenate(([False], plan.shifting[:-1]))))


def road_window(road: Route, start: float, end: float) -> Route:
    """Return the part of a road between two distances, m, its distance counted from the first."""
    s = road.distance
    inside = np.flatnonzero((s > start + 1e-6) & (s < end - 1e-6))
    at = np.concatenate(([start], s[inside], [end]))
    limit = road.speed_limit[np.clip(np.searchsorted(s, at + 1e-9, side="right") - 1, 0, len(s) - 1)]
    stops = road.stops[(road.stops > start + 1e-6) & (road.stops <= end)] - start
    return Route.of_grade(at - start, np.interp(at, s, road.grade), limit, stops)


def _until(plan: SpeedPlan, cut: int) -> SpeedPlan:
    """Return a plan up to one of its points."""
    arrays = {
        f.name: getattr(plan, f.name)[: cut + 1]
        for f in fields(SpeedPlan)
        if isinstance(getattr(plan, f.name), np.ndarray)
    }
    return replace(plan, cost_to_go=None, **arrays)
