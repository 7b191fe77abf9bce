"""Dead time of a motor's torque, from what it was commanded and what it says that it gives.

    T_d(k) = T_d(k-1) + share (u(k-1-d) - T_d(k-1)),   d = 0..5 steps

Each candidate d is followed, and the forgetting sum of the squares of its error is kept. The estimate moves to the
candidate of the least sum once that is clearly less than its own: a motor that is not excited teaches nothing.
"""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import FloatArray, Record, count, quantity

DELAYS = 6
"""Candidates: 0 to 5 steps."""

PAST = DELAYS + 1

MEMORY = 0.95
"""Share of the sum of squares that is kept per step (chosen: 0.2 s at 100 Hz)."""

ADVANTAGE = 400.0
"""By how much a sum must be less than the present one's, (N m)^2 (chosen: 20 N m, once)."""


class MotorDelayState(Record):
    """Memory between two steps, and the estimate."""

    delay: int = count(0, DELAYS - 1, "estimate, steps")
    command: FloatArray = quantity("N*m", -1e5, 1e5, "commands, the last one first", shape=(PAST,))
    torque: FloatArray = quantity("N*m", -1e5, 1e5, "torque by candidate", shape=(DELAYS,))
    misfit: FloatArray = quantity("N^2*m^2", 0, 1e15, "forgetting sum of squares", shape=(DELAYS,))


@kernel
def motor_delay_reset(s: MotorDelayState, torque: float, delay: int) -> None:
    """Begin with a motor that has long been commanded and giving `torque` (N m), `delay` steps late."""
    s.delay = max(min(delay, DELAYS - 1), 0)
    for n in range(PAST):
        s.command[n] = torque
    for n in range(DELAYS):
        s.torque[n] = torque
        s.misfit[n] = 0.0


@kernel
def motor_delay_command(s: MotorDelayState, command: float) -> None:
    """Take in what is commanded from now on, N m."""
    for n in range(PAST - 1, 0, -1):
        s.command[n] = s.command[n - 1]
    s.command[0] = command


@kernel
def motor_delay_measure(s: MotorDelayState, share: float, torque: float) -> None:
    """Take in the torque that the motor gives now, N m; `share` of a step it answers in one period."""
    best = 0
    for n in range(DELAYS):
        s.torque[n] += share * (s.command[n] - s.torque[n])
        s.misfit[n] = MEMORY * s.misfit[n] + (torque - s.torque[n]) ** 2
        if s.misfit[n] < s.misfit[best]:
            best = n
    if s.misfit[best] + ADVANTAGE < s.misfit[s.delay]:
        s.delay = best
