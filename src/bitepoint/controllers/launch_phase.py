"""Phases of a launch, common to the controllers that launch a vehicle."""

from __future__ import annotations

from bitepoint.kernels import kernel

WAITING = 0
SLIPPING = 1
CLOSING = 2
DRIVING = 3
PHASES = ("waiting", "slipping", "closing", "driving")


@kernel
def phase_after(phase: int, demand: float, contact: float, slip: float, closing_slip: float) -> int:
    """Return the phase after a measurement.

    Args:
        phase: the phase before it.
        demand: pedal above the threshold at which the driver wants to move off; to let the pedal go ends a launch
            that has not closed yet.
        contact: time since the clutch touched, s; up to 0 it may not close.
        slip: engine speed minus clutch speed; closing_slip: slip below which the clutch closes; rad/s.
    """
    after = min(max(phase, WAITING), DRIVING)
    if demand <= 0.0 and phase < CLOSING:
        after = WAITING
    elif phase == WAITING:
        after = SLIPPING
    elif phase == SLIPPING and contact > 0.0 and slip < closing_slip:
        after = CLOSING
    elif phase == CLOSING and slip <= 0.0:
        after = DRIVING
    return after
