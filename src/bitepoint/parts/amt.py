"""Automated gearbox with one input shaft: it shifts through neutral, where a synchroniser brings the input to speed.

Efficiency acts in both directions, as in `gears.gear_loss_torque`, here from the torque at the output: driving, the
gears take the share 1 - efficiency of what goes in, hence 1 / efficiency - 1 of what comes out.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.records import FloatArray, Record, count, quantity

GEARS = 8
"""Most gears."""


class AutomatedGearbox(Record):
    """A gearbox with final drive, one gear at a time."""

    ratios: FloatArray = quantity(
        "1", 0, 50, "gear ratios, 1st first; 0 where there is no gear", shape=(GEARS,), padded=True
    )
    final_drive: float = quantity("1", 0.5, 50, "ratio of the final drive")
    efficiency: float = quantity("1", 0.5, 1, "share of the power that passes, in either direction", default=1.0)
    gear: int = count(1, GEARS, "gear that is engaged at the start", default=1)
    shift_time: float = quantity("s", 0, 5, "shortest time in neutral", default=0.25)
    synchroniser_torque: float = quantity("N*m", 1, 1000, "of the synchroniser, at the input shaft", default=60.0)


SYNCHRONISER_BAND = 5.0
"""Difference of speed at the input below which the synchroniser's torque falls to 0 on a line, rad/s (chosen)."""

ENGAGING_BAND = 10.0
"""Difference of speed at the input below which a gear can engage, rad/s (chosen: 1 rad/s at a wheel in a low gear)."""

LEAST_RATIO = 0.5
"""Input speed over wheel speed, final drive included, below which there is no gear."""

FRICTION_FADE_SPEED = 0.5
"""Speed at the wheel side below which the gears' friction fades to 0, rad/s (chosen: 0.16 m/s at a car's wheel)."""


@kernel
def gear_ratio(g: AutomatedGearbox, gear: int) -> float:
    """Return input speed over wheel speed in a gear, 1..8; below LEAST_RATIO there is none."""
    return g.ratios[max(min(gear, GEARS), 1) - 1] * g.final_drive


@kernel
def meshing_loss_torque(g: AutomatedGearbox, delivered: float, wheel_side_speed: float) -> float:
    """Return the torque, N m at the wheel side, that the gears' friction takes; its power is never negative.

    `delivered` is the torque at the output, N m. The loss opposes the rotation and fades near standstill.
    """
    direction = clamp(wheel_side_speed / FRICTION_FADE_SPEED, -1.0, 1.0)
    share = 1.0 / g.efficiency - 1.0 if delivered * wheel_side_speed > 0.0 else 1.0 - g.efficiency
    return share * abs(delivered) * direction


@kernel
def synchroniser_torque(g: AutomatedGearbox, difference: float) -> float:
    """Return the torque, N m at the input, that removes a difference of speed there, rad/s: wanted minus present."""
    return g.synchroniser_torque * clamp(difference / SYNCHRONISER_BAND, -1.0, 1.0)
