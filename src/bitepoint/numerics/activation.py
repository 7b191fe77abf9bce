"""Smooth steps made of + - * / alone, so that every life and every processor computes the same bits.

The C libraries of processors differ in the last bits of tanh and exp. Here tanh is its continued fraction [1], cut
after seven levels, at a quarter of the argument, followed by two doublings of the argument, all over one division.

[1] Abramowitz and Stegun, Handbook of Mathematical Functions, eq. 4.5.70.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel


@kernel
def rational_tanh(x: float) -> float:
    """Return tanh x within 1e-12, never outside -1..1; -1 where x is NaN."""
    a = 0.25 * clamp(x, -20.0, 20.0)
    b = a * a
    over = a * (1.0 + b * (17325.0 + b * (378.0 + b)) / 135135.0)
    under = 1.0 + b * (62370.0 + b * (3150.0 + b * 28.0)) / 135135.0
    twice_over = 2.0 * over * under
    twice_under = over * over + under * under
    quotient = 2.0 * twice_over * twice_under / (twice_over * twice_over + twice_under * twice_under)
    return clamp(quotient, -1.0, 1.0)


@kernel
def rational_logistic(x: float) -> float:
    """Return 1 / (1 + exp(-x)) within 1e-12; 0 where x is NaN."""
    return 0.5 + 0.5 * rational_tanh(0.5 * x)
