"""Transient fuel: a correction over speed and acceleration, beside what a steady engine takes.

    fuel = max(0, steady(torque, engine speed) + correction(v, a))
    correction = median(v <= 50 km/h | v > 50 km/h) + sum over i, j of K_ij v^i a^j      K of its own for a < 0

Outside the region of speed and acceleration that it was fitted on, the polynomial takes the nearest speed, then the
nearest acceleration, of that region.

Source: the form of the model of page 5 of the specification, "steady estimate, transient correction"; its exact
expression is lost, and this one is ours.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.numerics.tables import lookup
from bitepoint.records import Curve, FloatArray, Record, curve, quantity

TERMS = 4
"""Powers of speed and acceleration, each from 0 to TERMS - 1."""

MEDIAN_SPEED = 50.0 / 3.6
"""Speed that parts the two medians, m/s."""

_SPEED = ("speed", "m/s", 0.0, 150.0)


class TransientCorrection(Record):
    """Fuel over speed and acceleration; zero, the default, leaves the steady fuel as it is."""

    low_median: float = quantity("kg/s", -1, 1, "up to 50 km/h", default=0.0)
    high_median: float = quantity("kg/s", -1, 1, "above 50 km/h", default=0.0)
    rising: FloatArray = quantity(
        "kg/s", -1e3, 1e3, "K for a >= 0: row i, column j, powers of m/s and m/s^2", shape=(TERMS, TERMS), default=0.0
    )
    falling: FloatArray = quantity("kg/s", -1e3, 1e3, "K for a < 0, likewise", shape=(TERMS, TERMS), default=0.0)
    lowest: Curve = curve(_SPEED, ("acceleration", "m/s^2", -20, 20), "lowest acceleration of the fitted region")
    highest: Curve = curve(_SPEED, ("acceleration", "m/s^2", -20, 20), "highest acceleration of the fitted region")


@kernel
def transient_correction(c: TransientCorrection, speed: float, acceleration: float) -> float:
    """Return the fuel, kg/s of either sign, that is added at `speed` (m/s) and `acceleration` (m/s^2)."""
    v = clamp(speed, c.lowest.x[0], c.lowest.x[max(c.lowest.points - 1, 0)])
    a = clamp(acceleration, lookup(c.lowest, v), lookup(c.highest, v))
    total = c.low_median if v <= MEDIAN_SPEED else c.high_median
    power = 1.0
    for i in range(4):
        k0 = c.rising[i, 0] if a >= 0.0 else c.falling[i, 0]
        k1 = c.rising[i, 1] if a >= 0.0 else c.falling[i, 1]
        k2 = c.rising[i, 2] if a >= 0.0 else c.falling[i, 2]
        k3 = c.rising[i, 3] if a >= 0.0 else c.falling[i, 3]
        total = total + power * (k0 + a * (k1 + a * (k2 + a * k3)))
        power = power * v
    return total
