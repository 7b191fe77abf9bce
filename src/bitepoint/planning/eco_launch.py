"""The cheapest launch: from a low speed to a cruising speed within a distance.

Source: the problem of page 5 of the specification; solved on v^2, where the source's Euler steps in v are wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.models.plan import Floats, SpeedPlan
from bitepoint.models.route import Route
from bitepoint.parts.torque_engine import fuel_flow, highest_torque
from bitepoint.planning.speed_planner import Limits, SpeedPlanner
from bitepoint.planning.speed_program import Grid
from bitepoint.planning.stations import Journey
from bitepoint.records import RecordArray

LAUNCH_GRID = Grid(spacing=5.0, steps=200, halvings=0, refinements=2)
"""Half of it moves the cost by some 0.1 %."""


@dataclass(frozen=True)
class Launch:
    """A launch.

    Attributes:
        start_speed: m/s; end_speed: lowest and highest, m/s; a single number is both.
        length: m, where there is no road.
        minimum_acceleration: m/s^2, demanded outside shifts.
        highest_speed: m/s; None: the highest end speed.
        start_gear: None: whichever is best.
        dwell: at each stop line, s; end_value: of the kinetic energy at the end, kg/J.
    """

    start_speed: float
    end_speed: float | tuple[float, float]
    length: float = 150.0
    minimum_acceleration: float = 0.0
    highest_speed: float | None = None
    start_gear: int | None = None
    dwell: float = 0.0
    end_value: float = 0.0

    def journey(self, road: Route | None = None) -> Journey:
        """Return it along a road, which is flat and without limits if there is none."""
        end = self.end_speed if isinstance(self.end_speed, tuple) else (self.end_speed, self.end_speed)
        return Journey(
            Route.flat(self.length) if road is None else road,
            self.start_speed,
            end,
            max(end[1] if self.highest_speed is None else self.highest_speed, self.start_speed),
            start_gear=self.start_gear,
            minimum_acceleration=self.minimum_acceleration,
            dwell=self.dwell,
            end_value=self.end_value,
        )


def launch_planner(
    model: RecordArray,
    launch: Launch,
    *,
    road: Route | None = None,
    limits: Limits | None = None,
    grid: Grid = LAUNCH_GRID,
) -> SpeedPlanner:
    """Return the planner of a launch: its `plan`, `plan_at_time` and `pareto`.

    Args:
        model: one record `LongitudinalModel`.

    Raises:
        InputError: speeds, limits or a gear that cannot be.
    """
    return SpeedPlanner(model, launch.journey(road), limits, grid)


def best_efficiency_fuel(model: RecordArray, plan: SpeedPlan) -> float:
    """Return the fuel, kg, of the work that a plan's wheels take, were the engine always at its best efficiency.

    No plan with these forces undercuts it, transient fuel left out; what the engine's own inertia takes is not counted.
    """
    work = float(np.sum(np.maximum(plan.force[:-1] + plan.brake_force[:-1], 0.0) * np.diff(plan.distance)))
    engine = model["engine"]
    limits = float(model["launch_speed"][0]), float(engine["speed_limit"][0])
    speeds: Floats = np.linspace(*limits, 200)
    shares = np.arange(0.02, 1.01, 0.01)
    speed: Floats = np.repeat(speeds, len(shares))
    torque: Floats = highest_torque.run(engine, speed) * np.tile(shares, len(speeds))
    per_joule = float(np.min(fuel_flow.run(engine, speed, torque) / (speed * torque)))
    return work / float(model["gearbox"]["efficiency"][0]) * per_joule
