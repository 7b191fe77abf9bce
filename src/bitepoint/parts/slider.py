"""Coulomb slider in series with a spring and its damper: friction that holds without an event.

    T = k th + c w      while |T| <= capacity: it sticks, d(th)/dt = w
    T = +-capacity      else: it slides, d(th)/dt = (T - k th) / c

with th the twist of the spring and w the speed across the whole. Sticking is the second line with T = k th + c w, so
both are one law, continuous in the capacity; a capacity of 0 lets the spring relax with k / c.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel


@kernel
def slider_torque(stiffness: float, damping: float, capacity: float, twist: float, speed: float) -> float:
    """Return the torque, N m, at a twist (rad) and a speed across (rad/s), both of the sign of the torque."""
    return clamp(stiffness * twist + damping * speed, -capacity, capacity)


@kernel
def twist_rate(stiffness: float, damping: float, torque: float, twist: float) -> float:
    """Return the rate of the twist, rad/s, under the torque (N m) of `slider_torque`; the damping must be above 0.

    The slider turns torque times (speed - rate) to heat, the damper damping times rate squared; neither is negative.
    """
    return (torque - stiffness * twist) / damping
