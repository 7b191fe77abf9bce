"""Bounds of the rates of a driveline with springs, from which the length of a substep follows."""

from __future__ import annotations

import math

from bitepoint.kernels import kernel

NEUTRAL_RELAXATION = 0.01
"""Time constant with which half-shafts unwind in neutral, s (chosen: short against a shift)."""

ROLLING_FADE_SPEED = 0.5
"""Wheel speed below which the rolling resistance fades to 0, rad/s (chosen: 0.16 m/s at a car's wheel)."""

STABILITY = 2.7
"""Longest step times fastest rate; the Runge-Kutta rule of order 4 is stable up to 2.78 on the negative real axis."""


@kernel
def spring_rate(stiffness: float, damping: float, mobility: float) -> float:
    """Return a bound of the rates, 1/s, of a spring and damper between inertias with this mobility."""
    decay = 0.5 * damping * mobility
    return decay + math.sqrt(abs(decay**2 - stiffness * mobility))
