"""Gearbox of a dual-clutch transmission in one gear: ratio, efficiency in both directions, reduced inertia."""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.records import FloatArray, Record, count, quantity


class Gearbox(Record):
    """A gearbox with final drive. Gears 1, 3, 5, 7 hang on clutch 1, the even ones on clutch 2."""

    ratios: FloatArray = quantity(
        "1", 0, 50, "gear ratios, 1st first; 0 where there is no gear", shape=(8,), padded=True
    )
    final_drive: float = quantity("1", 0.5, 50, "ratio of the final drive")
    efficiency: float = quantity("1", 0.5, 1, "share of the power that passes, in either direction")
    gear: int = count(1, 8, "engaged gear", default=1)
    odd_shaft_inertia: float = quantity("kg*m^2", 0, 10, "input shaft 1, secondary side of damper 1, odd gears")
    even_shaft_inertia: float = quantity("kg*m^2", 0, 10, "input shaft 2, secondary side of damper 2, even gears")
    layshaft_inertia: float = quantity("kg*m^2", 0, 10, "layshaft with its gears and the pinion of the final drive")
    axle_inertia: float = quantity("kg*m^2", 0, 100, "crown wheel, differential, half-shafts and wheels")


LOSS_FADE_SPEED = 0.05
"""Axle speed below which the gear loss fades to 0, rad/s (chosen: 0.015 m/s at a car's wheel)."""


@kernel
def overall_ratio(g: Gearbox) -> float:
    """Return input speed over axle speed in the engaged gear."""
    return g.ratios[g.gear - 1] * g.final_drive


@kernel
def axle_side_inertia(g: Gearbox) -> float:
    """Return the inertia, kg m^2, of all that turns with the axle in an odd gear, both clutches open.

    J6 + ig^2 (J3 i^2 + J5 + J4 i2^2) with i the ratio of the engaged gear: the even input shaft is dragged along
    through 2nd gear, preselected.
    """
    at_layshaft = g.odd_shaft_inertia * g.ratios[g.gear - 1] ** 2 + g.layshaft_inertia
    return g.axle_inertia + g.final_drive**2 * (at_layshaft + g.even_shaft_inertia * g.ratios[1] ** 2)


@kernel
def gear_loss_torque(g: Gearbox, transmitted: float, axle_speed: float) -> float:
    """Return the torque, N m at the axle, that the gears' friction takes; its power is never negative.

    `transmitted` is the lossless torque at the axle, N m. Driving, the share 1 - efficiency of it is lost; in overrun
    1 / efficiency - 1, so that again the share 1 - efficiency of what comes in is lost. The loss opposes the rotation.
    """
    direction = clamp(axle_speed / LOSS_FADE_SPEED, -1.0, 1.0)
    share = 1.0 - g.efficiency if transmitted * axle_speed > 0.0 else 1.0 / g.efficiency - 1.0
    return share * abs(transmitted) * direction
