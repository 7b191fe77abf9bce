"""Plans of speed and gear: a launch of 150 m, 20 km of hills, with and without stops, a window of predictive cruise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from tests.planning.vehicles import hatchback, hills, truck

from benchmarks.results import Figure
from benchmarks.timing import side_by_side
from bitepoint.models.plan import SpeedPlan
from bitepoint.planning.eco_launch import Launch, launch_planner
from bitepoint.planning.predictive_cruise import Cruise, RecedingCruise, cruise_planner
from bitepoint.planning.steady import set_speed_price

ROUNDS = 15


def measure() -> list[Figure]:
    """Time each plan, warm."""
    launch = launch_planner(hatchback(), Launch(5.0 / 3.6, 49.8 / 3.6))
    model, road, cruise = truck(), hills(0.025), Cruise(73.7 / 3.6, 5.0 / 3.6)
    whole, price = cruise_planner(model, road, cruise), set_speed_price(model, cruise.set_speed)
    receding = RecedingCruise(model, road, cruise)
    stopping = cruise_planner(model, replace(road, stops=np.array([4000.0, 11_000.0])), cruise)
    plans: dict[str, Callable[[], SpeedPlan]] = {
        "plan_launch_150_m": lambda: launch.plan(1e-3),
        "plan_hills_20_km": lambda: whole.plan(price),
        "plan_window_2_km": lambda: receding.plan(0.0, cruise.set_speed, 6),
        "plan_stops_20_km": lambda: stopping.plan(price),
    }
    planned = {name: plan().total_time for name, plan in plans.items()}
    samples = side_by_side(plans, ROUNDS)
    return [
        Figure(name, 1e3 * samples.median(name), "ms", samples.median(name) / seconds, f"the {seconds:.0f} s it plans")
        for name, seconds in planned.items()
    ]
