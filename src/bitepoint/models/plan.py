"""What a planner hands over: speed, gear and torque over distance, with the fuel and the time that they take."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


def _nothing() -> Floats:
    return np.empty(0)


def _no_gears() -> Integers:
    return np.empty(0, np.int64)


def _no_flags() -> Flags:
    return np.empty(0, np.bool_)


@dataclass(frozen=True)
class CostToGo:
    """Least cost from each speed and gear at each station to the end of the road, of the coarsest grid that was swept.

    Attributes:
        distance: of the stations, m, shape (stations,).
        speed: of the nodes, m/s, shape (stations, nodes), even steps of its square; NaN beyond the last node.
        cost: fuel and the price of time, kg, shape (stations, gears, nodes); infinite: there is no way on.
    """

    distance: Floats
    speed: Floats
    cost: Floats


@dataclass(frozen=True)
class SpeedPlan:
    """A plan over distance, or why there is none: then figures are NaN and arrays empty.

    Arrays have shape (points,). Between two points the acceleration is constant, so v^2 is linear in distance; what
    holds on such a stretch (gear and all after it) stands at its first point, and once more at the last.

    Attributes:
        status: "optimal" on its grid, or "infeasible"; reason: a sentence.
        distance: m; speed: m/s; time: s, from the start; fuel: kg, from the start.
        gear: engaged, or being engaged while `shifting`; shifting: the vehicle rolls in neutral.
        acceleration: m/s^2; engine_torque: N m; engine_speed: rad/s, mean over time; brake_force, force: N at the
            wheels, the latter with brakes.
        time_price: kg/s, of the cost fuel + time_price * time + what shifts cost; cost: kg, terminal cost included.
        grid_gap: share by which the cost falls when the grid is halved, NaN where that was not computed.
        plan_time: what the computation took, s.
        cost_to_go: over the whole grid; None in an infeasible plan.
    """

    status: str
    reason: str
    distance: Floats = field(default_factory=_nothing)
    speed: Floats = field(default_factory=_nothing)
    time: Floats = field(default_factory=_nothing)
    fuel: Floats = field(default_factory=_nothing)
    gear: Integers = field(default_factory=_no_gears)
    shifting: Flags = field(default_factory=_no_flags)
    acceleration: Floats = field(default_factory=_nothing)
    engine_torque: Floats = field(default_factory=_nothing)
    engine_speed: Floats = field(default_factory=_nothing)
    brake_force: Floats = field(default_factory=_nothing)
    force: Floats = field(default_factory=_nothing)
    time_price: float = math.nan
    cost: float = math.nan
    grid_gap: float = math.nan
    plan_time: float = math.nan
    cost_to_go: CostToGo | None = None

    @property
    def optimal(self) -> bool:
        """Whether there is a plan."""
        return self.status == "optimal"

    @property
    def total_fuel(self) -> float:
        """Fuel, kg; NaN without a plan."""
        return float(self.fuel[-1]) if self.optimal else math.nan

    @property
    def total_time(self) -> float:
        """Time, s; NaN without a plan."""
        return float(self.time[-1]) if self.optimal else math.nan

    @property
    def shifts(self) -> int:
        """How often the gear changes with the vehicle in motion."""
        return int(self.shifting.sum())

    def speed_at(self, distance: float | Floats) -> Floats:
        """Return the planned speed, m/s, at distances (m): v^2 is linear between points."""
        return np.sqrt(np.interp(distance, self.distance, self.speed**2))

    def gear_at(self, distance: float | Floats) -> Integers:
        """Return the gear that is engaged or being engaged at distances (m)."""
        place = np.searchsorted(self.distance, distance, side="right") - 1
        return self.gear[np.clip(place, 0, len(self.gear) - 1)]
