"""Service brake of all wheels together: friction between wheel and body that follows a command with a lag.

It is a Coulomb slider in series with the elastic caliper and its mounting, see `slider`: a wheel that has come to rest
is held by the spring, on a grade too, and no torque jumps with the sign of a speed.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.records import Record, quantity


class Brake(Record):
    """The service brake."""

    torque_limit: float = quantity("N*m", 1, 1e5, "highest torque that can be commanded, all wheels")
    lag: float = quantity("s", 0.001, 1, "time constant with which the torque follows", default=0.05)
    stiffness: float = quantity("N*m/rad", 100, 1e6, "of caliper and mounting, at the wheel", default=3e4)
    damping: float = quantity("N*m*s/rad", 10, 1e5, "beside the stiffness", default=2000.0)


@kernel
def brake_rate(b: Brake, command: float, torque: float) -> float:
    """Return dT/dt, N m/s, of a brake that can hold `torque` (N m) and is commanded to hold `command` (N m)."""
    return (clamp(command, 0.0, b.torque_limit) - torque) / b.lag
