"""Friction clutch of an automated gearbox, with which a vehicle moves off: it slips below the engine's launch speed.

It is a Coulomb slider in series with the torsional damper of its plate, see `slider`: it sticks, slips and opens by one
continuous law.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.records import Record, quantity


class LaunchClutch(Record):
    """The clutch, commanded by torque capacity, with the damper of its plate."""

    torque_limit: float = quantity("N*m", 1, 10_000, "highest capacity that can be commanded")
    launch_speed: float = quantity("rad/s", 20, 500, "lowest speed of the engine in gear; below, the clutch slips")
    plate_inertia: float = quantity("kg*m^2", 1e-3, 5, "driven plate and gearbox input", default=0.015)
    stiffness: float = quantity("N*m/rad", 10, 1e5, "torque of the damper per twist", default=1200.0)
    damping: float = quantity("N*m*s/rad", 0.1, 1e3, "torque of the damper per twisting speed", default=6.0)


@kernel
def launch_capacity(c: LaunchClutch, command: float) -> float:
    """Return the torque, N m, >= 0, that the clutch can carry at the commanded capacity (N m); 0 opens it."""
    return clamp(command, 0.0, c.torque_limit)
