"""Combustion engine behind its own control unit: it follows a request for torque.

    tau dT/dt = limited(request) - T        limited to what drag and full load leave at this speed

A governor keeps the engine running: it asks for gain (idle speed - speed), at the least, which is nothing at idle
speed; with the clutch open and no torque requested, that is all it does, so that the engine also falls back to idle.
The fuel is cut below the speed at which the engine fires, and above its speed limit; what is left is drag. The map
tells the fuel from no torque to full load; below, it falls on a line to nothing at the drag torque.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.numerics.tables import lookup, lookup_map
from bitepoint.parts.engine import LIMITER_SPAN, STARTING_SPEED
from bitepoint.records import Curve, Map, Record, characteristic_map, curve, quantity


class TorqueEngine(Record):
    """A combustion engine that follows a request for torque."""

    inertia: float = quantity("kg*m^2", 0.01, 20, "crankshaft, flywheel and driving side of the clutch")
    lag: float = quantity("s", 0.001, 5, "time constant with which the torque follows", default=0.05)
    delay: float = quantity("s", 0, 0.25, "dead time of the request, a multiple of the step of the plant", default=0.0)
    full_load: Curve = curve(("speed", "rad/s", 0, 1500), ("torque", "N*m", 0, 5000), "torque at full load")
    fuel: Map = characteristic_map(
        ("speed", "rad/s", 0, 1500),
        ("torque", "N*m", 0, 5000),
        ("flow", "kg/s", 0, 1),
        "fuel flow over speed and torque",
    )
    drag_constant: float = quantity("N*m", 0, 500, "drag torque at standstill, fuel cut", default=10.0)
    drag_slope: float = quantity("N*m*s/rad", 0, 1, "rise of the drag torque with speed", default=0.04)
    firing_speed: float = quantity("rad/s", 1, 300, "speed below which the engine does not fire", default=30.0)
    idle_speed: float = quantity("rad/s", 20, 300, "lowest speed of normal running")
    idle_gain: float = quantity("N*m*s/rad", 0, 100, "torque of the governor per speed below idle", default=2.5)
    speed_limit: float = quantity("rad/s", 100, 1500, "highest speed of normal running")


@kernel
def fuel_cut_torque(e: TorqueEngine, speed: float) -> float:
    """Return the torque without fuel at `speed` (rad/s), N m: drag, against the rotation in either direction."""
    return -(e.drag_constant + e.drag_slope * abs(speed)) * clamp(speed / STARTING_SPEED, -1.0, 1.0)


@kernel
def firing_share(e: TorqueEngine, speed: float) -> float:
    """Return the share of the cylinders that fire at `speed` (rad/s), 0..1; the limiter left out."""
    return clamp((speed - e.firing_speed) / LIMITER_SPAN, 0.0, 1.0)


@kernel
def highest_torque(e: TorqueEngine, speed: float) -> float:
    """Return the highest torque at `speed` (rad/s), N m: full load where the engine fires, else drag."""
    drag = fuel_cut_torque(e, speed)
    limiter = clamp(1.0 - (speed - e.speed_limit) / LIMITER_SPAN, 0.0, 1.0)
    return drag + (lookup(e.full_load, speed) - drag) * firing_share(e, speed) * limiter


@kernel
def idle_torque(e: TorqueEngine, speed: float) -> float:
    """Return what the governor asks for at `speed` (rad/s), N m."""
    return e.idle_gain * (e.idle_speed - speed)


@kernel
def torque_rate(e: TorqueEngine, wanted: float, speed: float, torque: float) -> float:
    """Return dT/dt, N m/s, of an engine that gives `torque` (N m) at `speed` (rad/s) and is wanted to give `wanted`."""
    return (clamp(wanted, fuel_cut_torque(e, speed), highest_torque(e, speed)) - torque) / e.lag


LEAST_DRAG = 1.0
"""Drag torque, N m, over which the fuel falls to nothing at least: an engine at standstill has none."""


@kernel
def fuel_flow(e: TorqueEngine, speed: float, torque: float) -> float:
    """Return the fuel, kg/s, that makes `torque` (N m) at `speed` (rad/s)."""
    share = clamp(1.0 + torque / max(-fuel_cut_torque(e, speed), LEAST_DRAG), 0.0, 1.0)
    return lookup_map(e.fuel, speed, torque) * share * firing_share(e, speed)
