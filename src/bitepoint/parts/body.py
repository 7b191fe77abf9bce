"""Body of a vehicle on a road: grade, rolling and air resistance, reduced to the wheels."""

from __future__ import annotations

import math

from bitepoint.kernels import kernel
from bitepoint.records import Record, quantity
from bitepoint.units import STANDARD_GRAVITY


class Body(Record):
    """The body, with all its mass."""

    mass: float = quantity("kg", 50, 60_000, "mass of the loaded vehicle")
    wheel_radius: float = quantity("m", 0.1, 1.5, "dynamic radius of the driven wheels")
    rolling_resistance: float = quantity("1", 0, 0.2, "rolling resistance over weight")
    drag_coefficient: float = quantity("1", 0, 2, "drag coefficient")
    frontal_area: float = quantity("m^2", 0, 20, "frontal area")


class Wheels(Record):
    """Wheels that roll without slip."""

    inertia: float = quantity("kg*m^2", 0, 1000, "of all wheels and what turns with them")


class Road(Record):
    """The road and the air over it."""

    grade: float = quantity("1", -0.5, 0.5, "rise over run; positive uphill", default=0.0)
    air_density: float = quantity("kg/m^3", 0.5, 2, "density of the air", default=1.206)


@kernel
def grade_torque(b: Body, road: Road) -> float:
    """Return m g sin(angle) r, the torque at the wheels that holds the vehicle on the grade, N m."""
    return b.mass * STANDARD_GRAVITY * b.wheel_radius * road.grade / math.sqrt(1.0 + road.grade**2)


@kernel
def rolling_torque(b: Body, road: Road) -> float:
    """Return f m g cos(angle) r, N m, >= 0; it opposes the motion."""
    return b.rolling_resistance * b.mass * STANDARD_GRAVITY * b.wheel_radius / math.sqrt(1.0 + road.grade**2)


@kernel
def air_coefficient(b: Body, road: Road) -> float:
    """Return the torque of the air resistance over the wheel speed squared, N m s^2/rad^2."""
    return 0.5 * road.air_density * b.drag_coefficient * b.frontal_area * b.wheel_radius * b.wheel_radius**2
