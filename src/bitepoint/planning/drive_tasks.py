"""What a scenario can ask of a planner: the cheapest launch, or a road within a band of speeds."""

from __future__ import annotations

from bitepoint.records import Record, count, quantity

LONGEST_LAUNCH = 1000.0
"""Way, m, over which a launch is planned; a longer road is a cruise."""


class LaunchTask(Record):
    """A launch from the speed at which the scenario starts; settings `planner.*`."""

    length: float = quantity("m", 10, LONGEST_LAUNCH, "way in which the end speed is to be reached", default=150.0)
    end_speed: float = quantity("m/s", 0.1, 70, "speed at the end", default=49.8 / 3.6)
    minimum_acceleration: float = quantity("m/s^2", -5, 5, "least that the engine gives, shifts left out", default=0.0)
    time_price: float = quantity("kg/s", 0, 1, "fuel that a second is worth; 0: the cheapest launch", default=0.0)
    shift_time: float = quantity(
        "s", 0, 3, "of a shift without traction: neutral, and half of both ramps of the torque", default=0.3
    )
    shift_price: float = quantity("kg", 0, 0.1, "fuel that a shift is worth beyond what it takes", default=0.0)
    dwell: float = quantity("s", 0, 600, "how long the vehicle stands at each stop line of the road", default=2.0)
    start_time: float = quantity("s", 0, 10, "from then until brake and clutch let it move", default=1.0)


class CruiseTask(Record):
    """A road at a set speed with a band; settings `cruise.*`."""

    set_speed: float = quantity("m/s", 1, 70, "speed at both ends, whose time the plan keeps to", default=73.7 / 3.6)
    band: float = quantity("m/s", 0.1, 20, "to either side of it", default=5.0 / 3.6)
    minimum_acceleration: float = quantity("m/s^2", -5, 0, "strongest slowing down", default=-1.0)
    shift_time: float = quantity(
        "s", 0, 3, "of a shift without traction: neutral, and half of both ramps of the torque", default=0.7
    )
    shift_price: float = quantity("kg", 0, 0.1, "fuel that a shift is worth beyond what it takes", default=0.0)
    dwell: float = quantity("s", 0, 600, "how long the vehicle stands at each stop line of the road", default=2.0)
    start_time: float = quantity("s", 0, 10, "from then until brake and clutch let it move", default=1.0)
    receding: int = count(0, 1, "1: planned in windows that move with the vehicle; 0: the whole road", default=0)
    horizon: float = quantity("m", 200, 20_000, "length of a window", default=2000.0)
    advance: float = quantity("m", 20, 5000, "after which the next window is planned", default=100.0)
