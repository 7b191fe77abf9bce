"""Torsional spring and damper: a damper spring, a half-shaft."""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Record, quantity


class Shaft(Record):
    """A linear torsional spring with a viscous damper beside it."""

    stiffness: float = quantity("N*m/rad", 1, 1e7, "torque per twist")
    damping: float = quantity("N*m*s/rad", 0, 1e5, "torque per twisting speed")


@kernel
def shaft_torque(s: Shaft, twist: float, twisting_speed: float) -> float:
    """Return the torque, N m, that the shaft carries at `twist` (rad) and `twisting_speed` (rad/s)."""
    return s.stiffness * twist + s.damping * twisting_speed


@kernel
def shaft_energy(s: Shaft, twist: float) -> float:
    """Return the elastic energy, J."""
    return 0.5 * s.stiffness * twist**2


@kernel
def shaft_loss(s: Shaft, twisting_speed: float) -> float:
    """Return the power that the damper turns to heat, W, >= 0."""
    return s.damping * twisting_speed**2
