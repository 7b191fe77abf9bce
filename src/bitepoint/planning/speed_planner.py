"""Plans of speed and gear for one vehicle on one journey: at a price of time, at a time, and the front between both.

least  fuel + price * time + what shifts cost - what the kinetic energy at the end is worth
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.plan import SpeedPlan
from bitepoint.parts.amt import LEAST_RATIO
from bitepoint.parts.body import Road
from bitepoint.planning.plan_trace import trace
from bitepoint.planning.speed_program import Answer, Grid, SpeedProgram
from bitepoint.planning.speed_stage import SpeedTask
from bitepoint.planning.stations import Journey
from bitepoint.records import RecordArray

FIRST_PRICE = 1e-3
"""Price of time that a search for one begins with, kg/s."""

HIGHEST_PRICE = 1.0
"""Highest price of time that is tried, kg/s: there nothing is worth saving but time."""

MOST_PRICES = 12
"""Most prices that are tried for a time between two, with any gears, and again with those of the plans next to it."""

LEAST_REFINEMENTS = 4
"""Least refinements of the steps with gears that are given; so many of them are searched again at each price."""

MOST_GEARS = 3
"""Sequences of gears, of the plans next to a time, that are tried for it."""

RAMP_TIME = 0.15
"""Time without traction of a shift beyond the one in neutral, s: half of 0.1 s in which the torque goes, and half of
0.2 s in which it comes back (chosen)."""

TIME_TOLERANCE = 1e-4
"""Share of the wanted time by which a plan may miss it."""


@dataclass(frozen=True)
class Limits:
    """What a plan keeps to, beside the journey.

    Attributes:
        shift_time: time without traction of a shift, s; None: that of the gearbox in neutral and RAMP_TIME.
        shift_price: fuel that a shift is worth beyond what it takes, kg: keeps shifts few.
        acceleration: highest, m/s^2.
        air_density: kg/m^3.
    """

    shift_time: float | None = None
    shift_price: float = 0.0
    acceleration: float = 10.0
    air_density: float = 1.206


@dataclass(frozen=True)
class TimedPlan:
    """The cheapest plan of a given time.

    Attributes:
        plan: the best that was found; it misses the time by up to 1e-4 of it, more where it says so.
        fuel: what it would take at exactly that time, kg: the rest is valued at the price of time of the bound. Of the
            fastest plan, where none is fast enough, what it takes.
        bound: fuel that no plan of that time undercuts on the planner's grid, kg, from the prices that were tried: the
            convex hull of the front, in which gears make gaps. The plan itself is on a grid four times as fine.
        price: of time, kg/s, of the bound: what a second more or less is worth there.
    """

    plan: SpeedPlan
    fuel: float
    bound: float
    price: float

    @property
    def gap(self) -> float:
        """Share of the fuel by which the plan may be away from the best of its time; below 0 by what the grid gives."""
        return 1.0 - self.bound / self.fuel

    def late(self, total_time: float) -> bool:
        """Return whether the plan takes longer than `total_time` (s) because none is faster."""
        return self.price >= HIGHEST_PRICE and self.plan.total_time > total_time * (1.0 + TIME_TOLERANCE)


def speed_task(model: RecordArray, limits: Limits) -> RecordArray:
    """Return the task of a vehicle, one record.

    Raises:
        InputError: a limit that is negative.
    """
    shift_time = limits.shift_time
    if shift_time is None:
        shift_time = float(model["gearbox"]["shift_time"][0]) + RAMP_TIME
    figures = {"shift_time": shift_time, "shift_price": limits.shift_price, "acceleration": limits.acceleration}
    for name, figure in figures.items():
        if not 0.0 <= figure < math.inf:
            raise InputError("plan", f"{name}: got {figure:g}", "expected a number of 0 or more")
    task = SpeedTask.zeros()
    task["model"] = model[0]
    task["road"] = Road.parse({"air_density": limits.air_density}, "plan")
    task["shift_time"], task["shift_price"] = shift_time, limits.shift_price
    task["acceleration_limit"] = limits.acceleration
    ratios = model["gearbox"]["ratios"][0] * model["gearbox"]["final_drive"][0]
    task["gears"] = int(np.count_nonzero(ratios >= LEAST_RATIO))
    return task


class SpeedPlanner:
    """Makes plans for one vehicle on one journey.

    Args:
        model: one record `LongitudinalModel`, with any fuel model.
        journey: what is to be driven; grid: how finely it is searched.

    Raises:
        InputError: limits or a gear that cannot be.
    """

    def __init__(
        self, model: RecordArray, journey: Journey, limits: Limits | None = None, grid: Grid | None = None
    ) -> None:
        self.task, self.journey = speed_task(model, limits or Limits()), journey
        self.program = SpeedProgram(self.task, journey, grid or Grid())
        self._tried: dict[float, tuple[SpeedPlan, Answer]] = {}
        gears, start = int(self.task["gears"][0]), journey.start_gear
        if start is not None and not 1 <= start <= gears:
            raise InputError("plan", f"start_gear: got {start}", f"expected a gear of 1..{gears}")

    def plan(self, time_price: float, *, gap: bool = False) -> SpeedPlan:
        """Return the cheapest plan at a price of time, kg/s.

        Args:
            gap: also solve it on the grid of half the size, for the figure `grid_gap`.
        """
        if not 0.0 <= time_price < math.inf:
            raise InputError("plan", f"time_price: got {time_price:g} kg/s", "expected 0 or more")
        plan, _ = self._solved(time_price)
        if gap and plan.optimal:
            finer = SpeedProgram(self.task, self.journey, self.program.grid.halved).solve()[0]
            if finer is not None:
                cost = trace(self.task, finer, self.journey.dwell).cost
                plan = replace(plan, grid_gap=(plan.cost - cost) / abs(plan.cost))
        return plan

    def pareto(self, time_prices: Sequence[float]) -> list[SpeedPlan]:
        """Return the plans at these prices of time, the slowest first, without those that another one dominates."""
        plans = [plan for price in sorted(time_prices) if (plan := self.plan(price)).optimal]
        return [
            p for p in plans
            if not any(q.total_fuel < p.total_fuel and q.total_time <= p.total_time + 1e-9 for q in plans)
        ]  # fmt: skip

    def plan_at_time(self, total_time: float) -> TimedPlan:
        """Return the cheapest plan that takes `total_time` (s).

        The time falls as its price rises, in jumps where gears change. So the price is searched for with any gears, and
        then with the gears of the plans next to the wanted time, stage by stage, for which it falls evenly.
        """
        if not 0.0 < total_time < math.inf:
            raise InputError("plan", f"total_time: got {total_time:g} s", "expected a number above 0")
        slow = self._any_gears(0.0)
        if not slow.optimal or slow.total_time <= total_time:
            return TimedPlan(slow, slow.total_fuel, slow.total_fuel, 0.0)
        known = [plan for plan, _ in self._tried.values()]
        slow = min((plan for plan in known if plan.total_time > total_time), key=lambda plan: plan.total_time)
        fast = [plan.time_price for plan in known if plan.total_time <= total_time]
        _search_price(self._any_gears, total_time, slow, min(fast, default=4.0 * slow.time_price))
        known = [plan for plan, _ in self._tried.values()]
        fastest = min(known, key=lambda plan: plan.total_time)
        if fastest.total_time > total_time:
            return TimedPlan(fastest, fastest.total_fuel, fastest.total_fuel, HIGHEST_PRICE)
        tight = max(known, key=lambda plan: plan.cost - plan.time_price * total_time)
        bound, worth = tight.cost - tight.time_price * total_time, tight.time_price
        tried = sorted(self._tried.values(), key=lambda pair: abs(pair[0].total_time - total_time))
        by_gears = {pair[1].steps.gears_by_stage(8).tobytes(): pair for pair in reversed(tried)}
        near = sorted(by_gears.values(), key=lambda pair: abs(pair[0].total_time - total_time))
        plans = [self._with_gears(pair, total_time) for pair in near[:MOST_GEARS]]
        best = min(plans, key=lambda plan: _missed(plan, total_time, worth))
        return TimedPlan(best, best.total_fuel + worth * (best.total_time - total_time), bound, worth)

    def _any_gears(self, price: float) -> SpeedPlan:
        """Return the plan at a price, kg/s, which is made once."""
        if price not in self._tried:
            plan, answer = self._solved(price)
            if answer is None:
                return plan
            self._tried[price] = plan, answer
        return self._tried[price][0]

    def _solved(self, price: float) -> tuple[SpeedPlan, Answer | None]:
        begun = time.perf_counter()
        self.task["time_price"] = price
        answer, to_go = self.program.solve()
        if answer is None:
            return SpeedPlan("infeasible", self._why(), time_price=price, cost_to_go=to_go), None
        plan = trace(self.task, answer, self.journey.dwell)
        return replace(plan, plan_time=time.perf_counter() - begun, cost_to_go=to_go), answer

    def _why(self) -> str:
        low, high = self.journey.end_speed
        speeds = f"{self.journey.start_speed:g} m/s to {low:g}..{high:g} m/s"
        return self.program.obstacle() or f"no way from {speeds} keeps speeds, torque and limits"

    def _with_gears(self, near: tuple[SpeedPlan, Answer], total_time: float) -> SpeedPlan:
        """Return the plan nearest to a time among those with the gears of another, at whichever price."""
        answer = near[1]
        gears = answer.steps.gears_by_stage(int(self.task["gears"][0]))
        grid = self.program.grid
        finest = max(grid.refinements, LEAST_REFINEMENTS)
        fineness = [grid.steps * 2 ** (grid.halvings + n) for n in range(finest - LEAST_REFINEMENTS, finest + 1)]

        def these_gears(price: float) -> SpeedPlan:
            nonlocal answer
            self.task["time_price"] = price
            for steps in fineness:
                answer = self.program.refined(answer, answer.stations, steps, gears)
            return trace(self.task, answer, self.journey.dwell)

        plans = _search_price(these_gears, total_time, these_gears(0.0), near[0].time_price)
        return min(plans, key=lambda plan: _missed(plan, total_time, near[0].time_price))


def _missed(plan: SpeedPlan, total_time: float, worth: float) -> tuple[bool, float]:
    """Return what sorts plans: those that meet a time by their fuel there, then the others by what they miss.

    Args:
        worth: price of the time, kg/s, that they miss by less than the tolerance.
    """
    missed = abs(plan.total_time - total_time)
    if missed > 10.0 * TIME_TOLERANCE * total_time:
        return True, missed
    return False, plan.total_fuel + worth * (plan.total_time - total_time)


def _search_price(
    solve: Callable[[float], SpeedPlan], total_time: float, slow: SpeedPlan, price: float = FIRST_PRICE
) -> list[SpeedPlan]:
    """Return the plans at prices that close in on the one at which a plan takes `total_time` (s).

    Args:
        slow: the plan at price 0; price: where to begin.
    """
    low, plans = slow, [slow]
    price = price or FIRST_PRICE
    high = solve(min(price, HIGHEST_PRICE))
    while high.time_price < HIGHEST_PRICE and high.total_time > total_time:
        plans.append(high)
        low, high = high, solve(min(4.0 * high.time_price, HIGHEST_PRICE))
    plans.append(high)
    for _ in range(MOST_PRICES if high.total_time <= total_time else 0):
        if min(abs(plan.total_time - total_time) for plan in plans) <= TIME_TOLERANCE * total_time:
            break
        width = high.time_price - low.time_price
        share = (low.total_time - total_time) / max(low.total_time - high.total_time, 1e-9)
        middle = solve(low.time_price + width * min(max(share, 0.15), 0.85))
        plans.append(middle)
        low, high = (middle, high) if middle.total_time > total_time else (low, middle)
    return plans
