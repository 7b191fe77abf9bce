"""Separating clutch between an engine and a motor: a friction clutch with a torsional spring and damper in series."""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.records import Record, quantity


class SeparatingClutch(Record):
    """A friction clutch, commanded by torque capacity, with its damper."""

    stiffness: float = quantity("N*m/rad", 10, 1e5, "torque of the damper per twist")
    damping: float = quantity("N*m*s/rad", 0.1, 1e3, "torque of the damper per twisting speed")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest capacity that can be commanded")


@kernel
def separating_capacity(c: SeparatingClutch, command: float) -> float:
    """Return the torque, N m, >= 0, that the clutch can carry at the commanded capacity (N m); 0 opens it."""
    return clamp(command, 0.0, c.torque_limit)
