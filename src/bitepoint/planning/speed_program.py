"""The cheapest way along a road: dynamic programming on a grid of v^2 at each station, refined around its answer.

First the whole band of speeds is swept on a coarse grid. Then stages are halved, and the steps of the grid with them,
in a tube around the last answer; and at last the steps alone. With equal stages the answer before is in the tube, since
its nodes are nodes of the finer grid: the cost never rises. An answer that touches the rim of its tube is swept again
around itself.

From node to node there are accelerations in steps of dq / (2 ds) only: that is why the two are refined together, and
why the steps go on alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bitepoint.models.longitudinal import engine_speed_for
from bitepoint.models.plan import CostToGo, Floats, Integers
from bitepoint.parts.torque_engine import highest_torque
from bitepoint.planning.speed_stage import NEVER, Stage
from bitepoint.planning.speed_sweep import Sweep, sweep
from bitepoint.planning.stations import EASE, Journey, Spacing, Stations, place_stations
from bitepoint.records import RecordArray
from bitepoint.units import STANDARD_GRAVITY

REACH_POINTS = 200
"""Points of v^2 at which the highest acceleration is told, to see what the start can reach."""

MOST_STEPS = 4
"""Most steps of the first sweep where there is no way with fewer, over those of the grid."""

MOST_TURNS = 6
"""Most sweeps of one tube; each later one lies around the answer before."""


@dataclass(frozen=True)
class Grid:
    """How finely it is searched.

    Attributes:
        spacing: longest stage of the first sweep, m; steps: of v^2 from the lowest to the highest speed there.
        halvings: of the stages, each together with the steps; refinements: of the steps alone, after these.
        reach: nodes of a tube to either side of the last answer.
        short, growth: shortest stage of the first sweep, m, next to a place where the vehicle is slow, and length of a
            stage over the way from there.
    """

    spacing: float = 5.0
    steps: int = 200
    halvings: int = 0
    refinements: int = 2
    reach: int = 6
    short: float = 0.625
    growth: float = 0.2

    @property
    def halved(self) -> Grid:
        """The grid with stages and steps of half the size, in all its sweeps."""
        sizes = {name: 0.5 * getattr(self, name) for name in ("spacing", "short", "growth")}
        return replace(self, steps=2 * self.steps, **sizes)


class Steps(NamedTuple):
    """Steps between stations, arrays of shape (steps,): v^2 in m^2/s^2, gears from 1; `shift`: it begins with one."""

    start: Integers
    end: Integers
    before: Floats
    after: Floats
    old: Integers
    gear: Integers
    shift: Integers

    def gears_by_stage(self, gears: int) -> Integers:
        """Return 1 for the gear that each stage is driven in, shape (stages, gears), else 0."""
        gear = np.repeat(self.gear, self.end - self.start)
        return (gear[:, np.newaxis] == np.arange(1, gears + 1)).astype(np.int64)


class Answer(NamedTuple):
    """The best steps on a grid, their cost (kg), and whether they touch the rim of the tube that was searched."""

    stations: Stations
    steps: Steps
    cost: float
    rim: bool

    @property
    def squared(self) -> Floats:
        """v^2 at the stations, m^2/s^2; linear in distance over stations that a step passes."""
        s = self.stations.distance
        at = np.append(self.steps.start, self.steps.end[-1])
        return np.interp(s, s[at], np.append(self.steps.before, self.steps.after[-1]))


class SpeedProgram:
    """All plans of one vehicle on one journey.

    Args:
        task: the vehicle, its limits and prices: one record `SpeedTask`, which may be changed between solutions.
        journey: what is to be driven.
        grid: how finely.
    """

    def __init__(self, task: RecordArray, journey: Journey, grid: Grid) -> None:
        self.task, self.journey, self.grid = task, journey, grid
        self.gears = int(task["gears"][0])
        self._places: dict[int, Stations] = {}
        body, model = task["model"]["vehicle"], task["model"]
        self._mass = float(body["mass"][0] + model["wheel_inertia"][0] / body["wheel_radius"][0] ** 2)
        self._weight = float(body["mass"][0]) / self._mass
        self._rolling = STANDARD_GRAVITY * self._weight * float(body["rolling_resistance"][0])
        area = float(body["drag_coefficient"][0] * body["frontal_area"][0])
        self._air = 0.5 * float(task["road"]["air_density"][0]) * area / self._mass

    def stations(self, halvings: int) -> Stations:
        """Return the stations after some halvings of the stages."""
        if halvings not in self._places:
            places = self._placed(halvings)
            high = np.minimum(self._reached(places), self._slowed(places))
            self._places[halvings] = replace(places, high=np.maximum(high, places.low))
        return self._places[halvings]

    def _placed(self, halvings: int) -> Stations:
        """Return the stations with the band of speeds that is wanted."""
        spacing = Spacing(self.grid.spacing, self.grid.short, self.grid.growth)
        return self._eased(place_stations(self.journey, spacing, halvings))

    def _eased(self, places: Stations) -> Stations:
        """Return stations whose lowest speed gives way where the engine cannot hold it uphill."""
        if self.journey.lowest_speed <= 0.0:
            return places
        top = float(places.high.max()) + 1e-9
        pull = EASE * self._pull(np.linspace(0.0, top, REACH_POINTS + 1))
        low = places.low.copy()
        for k, length in enumerate(places.length):
            gain = pull[int(low[k] / top * REACH_POINTS)] - self._resistance(places.grade[k], low[k])
            low[k + 1] = max(min(low[k] + 2.0 * gain * length, low[k + 1]), 0.0)
        if not self.journey.free_end:
            low[-1] = places.low[-1]
        return replace(places, low=low)

    def obstacle(self) -> str:
        """Return where speeds alone leave no way, whatever engine and gears do; nothing where they leave one."""
        places, least = self._placed(0), self.journey.start_speed**2
        for k, length in enumerate(places.length):
            least = max(least - 2.0 * self._slowing(places.grade[k], least) * length, 0.0)
            if least > places.high[k + 1] + 1e-9:
                return _told(places, k + 1, least, "slower", places.high[k + 1])
        most: list[float] = self._reached(places).tolist()
        slow: list[int] = np.flatnonzero(np.array(most) < places.low - 1e-9).tolist()
        return _told(places, slow[0], most[slow[0]], "faster", places.low[slow[0]]) if slow else ""

    def solve(self) -> tuple[Answer | None, CostToGo]:
        """Return the best steps, None where there is no way, and the cost to go over the whole band of speeds."""
        grid, places, steps = self.grid, self.stations(0), self.grid.steps
        answer, value, grids = self._search(places, _whole(places, steps), None)
        while answer is None and steps < MOST_STEPS * grid.steps and not self.obstacle():
            steps *= 2  # no node leads to a node: finer ones may
            answer, value, grids = self._search(places, _whole(places, steps), None)
        speed, to_go = _speeds(grids, value.shape[2]), np.where(value < NEVER, value, np.inf)
        if answer is not None:
            for halvings in range(1, grid.halvings + 1):
                answer = self.refined(answer, self.stations(halvings), steps * 2**halvings)
            for refinement in range(1, grid.refinements + 1):
                answer = self.refined(answer, answer.stations, steps * 2 ** (grid.halvings + refinement))
        return answer, CostToGo(places.distance, speed, to_go)

    def refined(self, answer: Answer, stations: Stations, steps: int, gears: Integers | None = None) -> Answer:
        """Return the best steps in a tube around an answer; the answer itself where there is no way in the tube.

        Args:
            steps: of v^2 from the lowest to the highest speed of each station.
            gears: 1 for each stage (row) and gear (column) that may be driven in; None: all.
        """
        squared = np.interp(stations.distance, answer.stations.distance, answer.squared)
        reach = self.grid.reach
        for _ in range(MOST_TURNS):
            found, _, _ = self._search(stations, _tube(stations, squared, steps, reach), gears)
            if found is None:
                reach *= 2
                continue
            answer, squared = found, found.squared
            if not found.rim:
                break
        return answer

    def _search(
        self, stations: Stations, grids: Floats, gears: Integers | None
    ) -> tuple[Answer | None, NDArray[np.float64], Floats]:
        """Return the best steps, and the value of every node, kg, shape (stations, gears, width)."""
        count, width, g = len(grids), int(grids[:, 2].max()), self.gears
        allowed = np.ones((count - 1, g), np.int64) if gears is None else gears
        road = np.column_stack((stations.length.round(9), stations.grade.round(12), self._least(stations)))
        flags = self._flags(stations, road, grids, allowed)
        plan = Sweep.zeros()
        plan["stations"], plan["gears"], plan["width"] = count, g, width
        edge, reach = np.empty(g * width * (2 * width + g)), np.empty((4 * g + 1) * width, np.int64)
        value, policy = np.full((count, g, width), NEVER), np.zeros((count, g, width), np.int64)
        value[-1] = self._end_cost(grids[-1], width)
        flat = (road.ravel(), grids.ravel(), flags, edge, reach, value.reshape(-1), policy.reshape(-1))
        sweep.run(plan, self.task, Stage.zeros(), *flat)
        return self._follow(stations, grids, value, policy), value, grids

    def _least(self, stations: Stations) -> Floats:
        return np.full(len(stations.grade), self.journey.minimum_acceleration)

    def _end_cost(self, grid: Floats, width: int) -> Floats:
        """Return the cost of ending at each node of the last station, kg: less what its kinetic energy is worth."""
        squared = grid[0] + grid[1] * np.arange(width)
        return np.where(np.arange(width) < grid[2], -0.5 * self._mass * self.journey.end_value * squared, NEVER)

    def _flags(self, stations: Stations, road: Floats, grids: Floats, allowed: Integers) -> Integers:
        """Return the flags of a sweep: standing, costs as those of the stage after it; gears that may be driven in."""
        count = len(grids)
        same = np.zeros(count, np.int64)
        alike = (road[:-1] == road[1:]).all(axis=1) & (allowed[:-1] == allowed[1:]).all(axis=1)
        alike &= (grids[:-2] == grids[1:-1]).all(axis=1) & (grids[1:-1] == grids[2:]).all(axis=1)
        alike &= ~(stations.stops[1:-1] | stations.stops[2:])
        longest = (float(np.sqrt(stations.high.max())) + 1.0) * float(self.task["shift_time"][0])
        ends = np.asarray(stations.distance[:-2] + longest, np.float64)
        reached = np.asarray(np.searchsorted(stations.distance, ends) + 1, np.int64)
        unlike = np.concatenate(([0], np.cumsum(~alike)))
        inside = reached <= len(alike)
        same[: count - 2] = inside & (unlike[np.where(inside, reached, 0)] == unlike[:-1])
        standing = stations.stops | (stations.high == 0.0)
        return np.concatenate((np.column_stack((standing, same)).ravel(), allowed.ravel())).astype(np.int64)

    def _reached(self, stations: Stations) -> Floats:
        """Return the v^2, m^2/s^2, that the vehicle cannot exceed from the start on, and from each line on."""
        top = float(stations.high.max()) + 1e-9
        pull = np.maximum.accumulate(self._pull(np.linspace(0.0, top, REACH_POINTS + 1))[::-1])[::-1]
        most = stations.high.copy()
        for k, length in enumerate(stations.length):
            gain = pull[int(most[k] / top * REACH_POINTS)] - self._resistance(stations.grade[k], 0.0)
            most[k + 1] = min(most[k] + 2.0 * gain * length, most[k + 1])
        return most

    def _slowed(self, stations: Stations) -> Floats:
        """Return the v^2, m^2/s^2, from which the vehicle can still slow down to what is allowed ahead."""
        most = stations.high.copy()
        for k in range(len(most) - 2, -1, -1):
            rate = self._slowing(stations.grade[k], most[k])
            most[k] = min(most[k + 1] + 2.0 * rate * stations.length[k], most[k])
        return most

    def _slowing(self, grade: float, squared: float) -> float:
        """Return the highest deceleration from a v^2 (m^2/s^2), m/s^2: the one that is allowed, or that of a shift."""
        return max(-self.journey.minimum_acceleration, self._resistance(grade, squared), 0.0)

    def _pull(self, squared: Floats) -> Floats:
        """Return what the engine in its best gear can accelerate the vehicle by at each v^2, m/s^2, losses left out."""
        model, speed, best = self.task["model"], np.sqrt(squared), np.zeros(len(squared))
        for gear in range(1, self.gears + 1):
            torque = highest_torque.run(model["engine"], engine_speed_for.run(model, gear, speed))
            ratio = model["gearbox"]["ratios"][0, gear - 1] * model["gearbox"]["final_drive"][0]
            best = np.maximum(best, torque * ratio / model["vehicle"]["wheel_radius"][0])
        return best / self._mass

    def _resistance(self, grade: float, squared: float) -> float:
        """Return what slope, rolling and air slow the vehicle down by, m/s^2."""
        slope = math.sin(math.atan(grade))
        return self._rolling * math.sqrt(1.0 - slope**2) + STANDARD_GRAVITY * self._weight * slope + self._air * squared

    def _follow(
        self, stations: Stations, grids: Floats, value: NDArray[np.float64], policy: NDArray[np.int64]
    ) -> Answer | None:
        """Return the best steps from the start; None where there is no way."""
        count, gears, width = value.shape
        start = self.journey.start_gear
        g = int(np.argmin(value[0, :, 0])) if start is None else start - 1
        if value[0, g, 0] >= NEVER:
            return None
        k, i, rows, rim = 0, 0, list[tuple[float, ...]](), False
        while k < count - 1:
            code, j = divmod(int(policy[k, g, i]), width)
            span, new = divmod(code, 2 * gears + 1)
            if new > gears:
                g = new - gears - 1
                continue
            m, shift = k + max(span, 1), new > 0
            new = new - 1 if shift else g
            before, after = grids[k, 0] + grids[k, 1] * i, grids[m, 0] + grids[m, 1] * j
            rows.append((k, m, before, after, g + 1, new + 1, shift))
            low = j == 0 and grids[m, 0] > stations.low[m]
            rim |= low or (j == grids[m, 2] - 1 and after < stations.high[m] - 1e-9)
            k, i, g = m, j, new
        table: Floats = np.ascontiguousarray(np.array(rows).T)
        whole = table.astype(np.int64)
        steps = Steps(whole[0], whole[1], table[2], table[3], whole[4], whole[5], whole[6])
        return Answer(stations, steps, float(value[0, int(steps.old[0]) - 1, 0]), rim)


def _told(places: Stations, at: int, squared: float, side: str, wanted: float) -> str:
    """Return what v^2 is possible, m^2/s^2, and what is wanted."""
    speeds = f"no {side} than {math.sqrt(squared):.3g} m/s, where {math.sqrt(wanted):.3g} m/s is wanted"
    return f"at {places.distance[at]:.4g} m: {speeds}"


def _steps(stations: Stations, steps: int) -> tuple[Integers, Floats]:
    """Return how many steps the grid of each station has, and their size, m^2/s^2; a low band has half of `steps`."""
    band = stations.high - stations.low
    count = np.where(band > 0.5 * band.max(), steps, max(steps // 2, 1))
    return count, band / count


def _whole(stations: Stations, steps: int) -> Floats:
    """Return the grids of the whole band, shape (stations, 3): lowest v^2, step, nodes."""
    count, step = _steps(stations, steps)
    return np.column_stack((stations.low, step, np.where(step > 0.0, count + 1, 1)))


def _tube(stations: Stations, squared: Floats, steps: int, reach: int) -> Floats:
    """Return the part of the grids of the whole band that is near `squared`, likewise."""
    count, step = _steps(stations, steps)
    middle = np.round((squared - stations.low) / np.where(step > 0.0, step, 1.0))
    first = np.clip(middle - reach, 0.0, np.maximum(count - 2 * reach, 0))
    nodes = np.where(step > 0.0, np.minimum(2 * reach, count) + 1, 1)
    return np.column_stack((stations.low + np.where(step > 0.0, first, 0.0) * step, step, nodes))


def _speeds(grids: Floats, width: int) -> Floats:
    node = np.arange(width)
    squared = grids[:, :1] + grids[:, 1:2] * node
    return np.sqrt(np.where(node < grids[:, 2:3], squared, np.nan))
