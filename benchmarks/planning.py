"""Plans of speed and gear: a launch of 150 m, 20 km of hills, and a window of predictive cruise."""

from __future__ import annotations

from tests.planning.vehicles import hatchback, hills, truck

from benchmarks.results import Figure
from benchmarks.timing import side_by_side
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
    samples = side_by_side(
        {
            "plan_launch_150_m": lambda: launch.plan(1e-3),
            "plan_hills_20_km": lambda: whole.plan(price),
            "plan_window_2_km": lambda: receding.plan(0.0, cruise.set_speed, 6),
        },
        ROUNDS,
    )
    return [Figure(name, 1e3 * samples.median(name), "ms", None, None) for name in samples.seconds]
