"""Small functions that every life shares, and whose meaning for NaN is defined."""

from __future__ import annotations

from bitepoint.kernels.kernel import kernel

EPSILON = 2.0**-52
"""Distance from 1 to the next float of a life: what tolerances are made of. Exported as float32 it is 2**-23."""


@kernel
def clamp(x: float, low: float, high: float) -> float:
    """Return x limited to low..high; low where x is NaN."""
    y = x if x > low else low
    return high if y > high else y


@kernel
def sign(x: float) -> float:
    """Return 1, 0 or -1 with the sign of x; 0 where x is NaN."""
    # never: 0 in a part that asks for the sign of what is not 0
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@kernel
def is_finite(x: float) -> bool:
    """Return whether x is neither NaN nor infinite."""
    return x - x == 0.0


@kernel(trusted=True)
def to_index(x: float, low: int, high: int) -> int:
    """Return x as an integer, cut towards zero and limited to low..high; low where x is NaN.

    The one way from a float to an index: whatever x is, the result is inside low..high.
    """
    y = low
    # never: in a part whose x stays below high
    if x >= high:
        y = high
    # never: else, in a part whose x stays above low
    elif x > low:
        y = int(x)
    return y
