"""Tyres of all driven wheels together: longitudinal force over slip by the Magic Formula.

    F = load (mu sin(C atan(z - E (z - atan z))) + Sv),   z = B (s + Sh),   s = (r w - v) / max(|v|, 1 m/s)

The load is all the weight of the vehicle: it drives all wheels, or stands for its driven axle by a lower mu. Below
1 m/s the slip is one over that speed, so that the tyre is a viscous damper there.

Reference: H. B. Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, section 4.3.1, with the peak D = mu load.
"""

from __future__ import annotations

import math

from bitepoint.kernels import kernel
from bitepoint.records import Record, quantity
from bitepoint.units import STANDARD_GRAVITY


class Tyre(Record):
    """Tyres, with the wheels that they are on."""

    wheel_inertia: float = quantity("kg*m^2", 0.1, 500, "all driven wheels, hubs, half-shafts' outer ends")
    stiffness_factor: float = quantity("1", 0.1, 100, "B of the Magic Formula", default=14.0)
    shape_factor: float = quantity("1", 0.5, 2, "C of the Magic Formula", default=1.6)
    curvature_factor: float = quantity("1", -10, 1, "E of the Magic Formula", default=0.3)
    horizontal_shift: float = quantity("1", -0.1, 0.1, "Sh of the Magic Formula, a slip", default=0.0)
    vertical_shift: float = quantity("1", -0.1, 0.1, "Sv of the Magic Formula, over the load", default=0.0)


class TyreRoad(Record):
    """The road under the tyres, and the air over it."""

    grade: float = quantity("1", -0.5, 0.5, "rise over run; positive uphill", default=0.0)
    air_density: float = quantity("kg/m^3", 0.5, 2, "density of the air", default=1.2)
    friction: float = quantity("1", 0.01, 2, "highest force of the tyres over their load", default=1.05)


SLIP_SPEED = 1.0
"""Speed that the slip is related to at least, m/s."""


@kernel
def weight_along(mass: float, grade: float) -> float:
    """Return m g sin(angle), N: what pulls a mass (kg) down a grade."""
    return mass * STANDARD_GRAVITY * grade / math.sqrt(1.0 + grade**2)


@kernel
def weight_across(mass: float, grade: float) -> float:
    """Return m g cos(angle), N: what presses a mass (kg) on a road of this grade."""
    return mass * STANDARD_GRAVITY / math.sqrt(1.0 + grade**2)


@kernel
def tyre_slip(wheel_speed: float, radius: float, speed: float) -> float:
    """Return the slip at a wheel speed (rad/s), radius (m) and vehicle speed (m/s); positive when driving."""
    return (radius * wheel_speed - speed) / max(abs(speed), SLIP_SPEED)


@kernel
def tyre_force(t: Tyre, friction: float, load: float, slip: float) -> float:
    """Return the force on the vehicle, N, at a slip of either sign."""
    z = t.stiffness_factor * (slip + t.horizontal_shift)
    bent = z - t.curvature_factor * (z - math.atan(z))
    return load * (friction * math.sin(t.shape_factor * math.atan(bent)) + t.vertical_shift)


@kernel
def slip_stiffness(t: Tyre, friction: float, load: float) -> float:
    """Return dF/ds at no slip, N: for C above 1 the steepest place of the curve."""
    return load * friction * t.stiffness_factor * t.shape_factor
