"""Combustion engine: steady torque over throttle and speed, its inverse, and the transient correction.

Steady torque T = (F(w) + D(w)) g - D(w), with full load F, drag D = d0 + d1 w, and filling
g = 1 - exp(-a throttle^b (w0 / max(w, w1))^c). Under acceleration an engine gives less, T - lambda dw/dt [1, eq. 8],
which acts as additional inertia lambda and is counted there, once. With a lag, the filling follows its steady value as
a lag of first order: the air path.

[1] Yang et al., Data-driven predictive control for DCT vehicles starting process, J. Chongqing Univ. 44 (2021) 10,
    doi:10.11835/j.issn.1000-582X.2020.014. Its map (fig. 5) is lost; the form above is chosen.
"""

from __future__ import annotations

import math

from bitepoint.kernels import EPSILON, clamp, kernel
from bitepoint.numerics.tables import lookup
from bitepoint.records import Curve, Record, curve, quantity


class Engine(Record):
    """A combustion engine."""

    inertia: float = quantity("kg*m^2", 0.01, 20, "crankshaft, flywheel and driving side of the clutch")
    transient_loss: float = quantity(
        "kg*m^2", 0, 5, "torque lost per acceleration of the engine (lambda of the transient correction)", default=0.0
    )
    friction: float = quantity("N*m*s/rad", 0, 1, "viscous friction of the crankshaft", default=0.0)
    lag: float = quantity("s", 0, 5, "time constant with which the filling follows", default=0.0)
    torque_gain: float = quantity("1", 0.1, 3, "true full load over the nominal one", default=1.0)
    full_load: Curve = curve(("speed", "rad/s", 0, 1500), ("torque", "N*m", 0, 5000), "torque at full load")
    drag_constant: float = quantity("N*m", 0, 500, "drag torque at standstill, throttle closed", default=10.0)
    drag_slope: float = quantity("N*m*s/rad", 0, 1, "rise of the drag torque with speed", default=0.04)
    filling_gain: float = quantity("1", 0.1, 50, "gain of the filling over throttle", default=4.5)
    filling_throttle_exponent: float = quantity("1", 0.1, 5, "exponent of the throttle", default=1.2)
    filling_speed: float = quantity("rad/s", 1, 1500, "speed at which the filling gain holds", default=200.0)
    filling_speed_exponent: float = quantity("1", 0, 5, "exponent of the speed", default=0.8)
    filling_speed_floor: float = quantity("rad/s", 1, 500, "speed below which filling stays the same", default=30.0)
    idle_speed: float = quantity("rad/s", 20, 300, "lowest speed of normal running")
    speed_limit: float = quantity("rad/s", 100, 1500, "highest speed of normal running")


STARTING_SPEED = 5.0
"""Speed below which the drag fades to 0, so that a stalled engine comes to rest, rad/s (chosen)."""


@kernel
def engine_drag(e: Engine, speed: float) -> float:
    """Return the drag torque at `speed` (rad/s), N m: it opposes the rotation, in either direction."""
    return (e.drag_constant + e.drag_slope * abs(speed)) * clamp(speed / STARTING_SPEED, -1.0, 1.0)


@kernel
def throttle_effect(e: Engine, throttle: float) -> float:
    """Return a throttle^b for a throttle limited to 0..1: the part of the filling that no speed enters."""
    return e.filling_gain * math.pow(clamp(throttle, 0.0, 1.0), e.filling_throttle_exponent)


@kernel
def full_load_torque(e: Engine, speed: float) -> float:
    """Return the torque at full load and `speed` (rad/s), N m."""
    return e.torque_gain * lookup(e.full_load, speed)


@kernel
def lagged_effect(e: Engine, before: float, target: float, speed: float, dt: float) -> float:
    """Return the throttle effect after dt (s) whose filling has come from that of `before` towards that of `target`."""
    effect = target
    if e.lag > 0.0:
        ratio = math.pow(e.filling_speed / max(speed, e.filling_speed_floor), e.filling_speed_exponent)
        now = math.exp(-before * ratio)
        later = math.exp(-target * ratio)
        empty = later + (now - later) * math.exp(-dt / e.lag)
        effect = -math.log(max(empty, EPSILON)) / ratio
    return effect


LIMITER_SPAN = 10.0
"""Range above the speed limit in which the fuel is cut, rad/s (chosen)."""


@kernel
def engine_torque(e: Engine, effect: float, speed: float) -> float:
    """Return the steady torque, N m, at the throttle effect (see `throttle_effect`) and `speed` (rad/s).

    Above the speed limit the fuel is cut: what is left is drag.
    """
    drag = engine_drag(e, speed)
    ratio = e.filling_speed / max(speed, e.filling_speed_floor)
    filling = 1.0 - math.exp(-effect * math.pow(ratio, e.filling_speed_exponent))
    if speed > e.speed_limit:
        filling = filling * clamp(1.0 - (speed - e.speed_limit) / LIMITER_SPAN, 0.0, 1.0)
    return (full_load_torque(e, speed) + drag) * filling - drag


@kernel
def throttle_for(e: Engine, torque: float, speed: float) -> float:
    """Return the throttle, 0..1, at which the engine gives `torque` (N m) at `speed`; 0 or 1 where it cannot."""
    drag = engine_drag(e, speed)
    filling = clamp((torque + drag) / max(full_load_torque(e, speed) + drag, 1e-9), 0.0, 1.0 - EPSILON)
    ratio = e.filling_speed / max(speed, e.filling_speed_floor)
    effect = -math.log(1.0 - filling) / (e.filling_gain * math.pow(ratio, e.filling_speed_exponent))
    return clamp(math.pow(effect, 1.0 / e.filling_throttle_exponent), 0.0, 1.0)
