"""Hydraulic actuator of a wet clutch: pressure, normal force, friction, and back.

    Tc = faces mu(T, slip) r_m (p A - F)          p: pressure, F: return spring at the touch of the plates

Below the kiss-point p = F / A the clutch carries nothing. Friction goes from a static to a sliding value as the slip
grows, and changes with temperature:

    mu(T, slip) = (sliding + (static - sliding) exp(-|slip| / slip_scale)) (1 + slope (T - T_ref))

Linings of automatic and dual-clutch transmissions are made for less friction at small slip than at large [1]. The
pressure follows its command with a first-order lag, and the plates keep all heat: in the seconds of a launch the oil
carries little away.

[1] Strobl et al., Forschung im Ingenieurwesen 87 (2023) 541-554, doi:10.1007/s10010-023-00669-4.
"""

from __future__ import annotations

import math

from bitepoint.kernels import clamp, kernel
from bitepoint.records import Record, count, quantity


class ClutchActuator(Record):
    """Piston, plates and friction. Default values are chosen: 280 N m at 1.1 MPa, a kiss-point of 0.19 MPa."""

    active: int = count(0, 1, "1: torque comes from pressure and friction; 0: it is what is commanded", default=0)
    faces: int = count(1, 100, "friction faces: two per lined plate", default=8)
    mean_radius: float = quantity("m", 0.01, 1, "radius at which the friction acts", default=0.07)
    piston_area: float = quantity("m^2", 1e-4, 1, "area of the piston", default=0.0042)
    spring_force: float = quantity("N", 0, 1e5, "of the return spring where the plates touch", default=800.0)
    static_friction: float = quantity("1", 0.01, 1, "friction at no slip, at the reference temperature", default=0.115)
    sliding_friction: float = quantity(
        "1", 0.01, 1, "friction at large slip, at the reference temperature: the nominal one", default=0.13
    )
    slip_scale: float = quantity("rad/s", 0.1, 1000, "slip over which the one becomes the other", default=5.0)
    temperature_slope: float = quantity(
        "1/K", -0.02, 0.02, "relative change of the friction with temperature", default=-0.001
    )
    reference_temperature: float = quantity("K", 200, 800, "where the friction values hold", default=363.15)
    temperature: float = quantity("K", 200, 800, "of the plates at the start", default=363.15)
    heat_capacity: float = quantity("J/K", 10, 1e6, "of the plates", default=1000.0)
    fill_time: float = quantity("s", 0.001, 10, "time constant of the pressure", default=0.05)


LEAST_FADE, MOST_FADE = 0.2, 2.0
"""Range of the factor that temperature makes: beyond it the straight line is no friction law (chosen)."""


@kernel
def clutch_temperature(a: ClutchActuator, heat: float) -> float:
    """Return the temperature of the plates, K, after they have taken `heat` (J)."""
    return a.temperature + heat / a.heat_capacity


@kernel
def clutch_friction(a: ClutchActuator, temperature: float, slip: float) -> float:
    """Return the friction coefficient at a temperature (K) and a slip speed of either sign (rad/s)."""
    fade = clamp(1.0 + a.temperature_slope * (temperature - a.reference_temperature), LEAST_FADE, MOST_FADE)
    rise = (a.static_friction - a.sliding_friction) * math.exp(-abs(slip) / a.slip_scale)
    return (a.sliding_friction + rise) * fade


@kernel
def torque_from_pressure(a: ClutchActuator, friction: float, pressure: float) -> float:
    """Return the torque, N m, >= 0, that the clutch can carry at a friction coefficient and a pressure (Pa)."""
    return float(a.faces) * friction * a.mean_radius * max(pressure * a.piston_area - a.spring_force, 0.0)


@kernel
def pressure_for_torque(a: ClutchActuator, friction: float, torque: float) -> float:
    """Return the pressure, Pa, at which the clutch can carry `torque` (N m): the inverse of the above.

    For a torque of 0 or less it is the kiss-point: an open clutch stays filled. With `a.sliding_friction` it is the
    nominal characteristic, which a gearbox controller has of its clutch.
    """
    return (a.spring_force + max(0.0, torque) / (float(a.faces) * friction * a.mean_radius)) / a.piston_area


@kernel
def fill_rate(a: ClutchActuator, command: float, pressure: float) -> float:
    """Return dp/dt, Pa/s, for a commanded pressure (Pa)."""
    return (command - pressure) / a.fill_time


@kernel
def friction_steepness(a: ClutchActuator) -> float:
    """Return the largest change of the torque with slip, over the nominal torque, s/rad."""
    return MOST_FADE * abs(a.static_friction - a.sliding_friction) / (a.sliding_friction * a.slip_scale)
