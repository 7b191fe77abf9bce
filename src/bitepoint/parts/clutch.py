"""Friction clutch: it carries up to its capacity, in the direction of the slip; more makes it slip."""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.records import Record, quantity


class Clutch(Record):
    """A wet or dry friction clutch, commanded by torque capacity."""

    plate_inertia: float = quantity("kg*m^2", 1e-4, 5, "driven plate and primary side of its damper")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest capacity that can be commanded")
    torque_rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change that controllers command; the plant takes any")
    friction_gain: float = quantity("1", 0.1, 3, "true friction over the nominal one", default=1.0)


@kernel
def clutch_capacity(c: Clutch, command: float) -> float:
    """Return the torque, N m, >= 0, that the clutch can carry at the commanded capacity (N m)."""
    return c.friction_gain * clamp(command, 0.0, c.torque_limit)
