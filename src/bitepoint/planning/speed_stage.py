"""One stage of a plan of speed and gear: from one speed to the next over a distance, at constant acceleration.

    q = v^2,    a = (q1 - q0) / (2 ds),    dt = 2 ds / (v0 + v1)        exact for constant acceleration
    force from the mean of v^2 over the distance, engine speed from the mean of v over the time

so that the work of every force over the stage is exact, and so is the time. Three things can happen in a stage: the
engine drives or holds back through the gear, with brakes below its drag; the clutch is open and the engine idles, where
the vehicle is braked below the launch speed; or a shift is on, and the vehicle rolls in neutral.
"""

from __future__ import annotations

import math

from bitepoint.kernels import clamp, kernel
from bitepoint.models.longitudinal import (
    LongitudinalModel,
    driving_force,
    engine_speed_for,
    engine_torque_for,
    fuel_for,
    geared_speed,
)
from bitepoint.parts.amt import LEAST_RATIO, gear_ratio
from bitepoint.parts.body import Road
from bitepoint.parts.torque_engine import fuel_cut_torque, fuel_flow, highest_torque
from bitepoint.records import Record, count, nested, quantity

LEAST_SPEED = 1e-3
"""Mean speed below which a stage takes forever, m/s."""

NEVER = 1e9
"""Cost of what cannot be driven, kg."""

SLACK = 1e-9
"""Share by which limits may be passed: a speed that lies on one is inside."""


class SpeedTask(Record):
    """What a plan of speed and gear is for: the vehicle, its limits, and what time and shifts cost."""

    model: LongitudinalModel = nested(LongitudinalModel, "the vehicle")
    road: Road = nested(Road, "the road of the stage at hand")
    time_price: float = quantity("kg/s", 0, 10, "fuel that a second is worth", default=0.0)
    acceleration_limit: float = quantity("m/s^2", 0, 100, "highest acceleration", default=10.0)
    shift_time: float = quantity("s", 0, 10, "time without traction of a shift")
    shift_price: float = quantity("kg", 0, 1, "fuel that a shift is worth, beyond what it takes", default=0.0)
    gears: int = count(1, 8, "forward gears", default=1)


class Stage(Record):
    """What a stage takes; fuel NEVER: it cannot be driven."""

    fuel: float = quantity("kg", 0, 1e9, "fuel")
    time: float = quantity("s", 0, 1e9, "time")
    engine_torque: float = quantity("N*m", -1e6, 1e6, "engine torque")
    engine_speed: float = quantity("rad/s", 0, 1e4, "engine speed")
    brake_force: float = quantity("N", 0, 1e9, "force of the brakes at the wheels")
    force: float = quantity("N", -1e9, 1e9, "force at the wheels, brakes included")


@kernel
def engine_force(m: LongitudinalModel, gear: int, torque: float, acceleration: float) -> float:
    """Return the force at the wheels, N, of an engine that gives `torque` (N m) while the clutch is locked."""
    ratio = gear_ratio(m.gearbox, gear)
    r = m.vehicle.wheel_radius
    input_torque = torque - m.engine.inertia * ratio * acceleration / r
    efficiency = m.gearbox.efficiency if input_torque > 0.0 else 1.0 / m.gearbox.efficiency
    return input_torque * ratio * efficiency / r


@kernel
def launch_square(t: SpeedTask, gear: int) -> float:
    """Return v^2, m^2/s^2, below which the clutch cannot be locked in a gear."""
    ratio = max(gear_ratio(t.model.gearbox, gear), LEAST_RATIO)
    return (t.model.launch_speed * t.model.vehicle.wheel_radius / ratio) ** 2


@kernel
def drive_part(t: SpeedTask, gear: int, before: float, after: float, length: float, s: Stage) -> float:
    """Fill `s` as `drive_stage` does, for a stage on one side of the launch speed; return NEVER or its fuel, kg."""
    v = max(0.5 * (math.sqrt(before) + math.sqrt(after)), LEAST_SPEED)
    a = 0.5 * (after - before) / length
    locked = before + after >= 2.0 * launch_square(t, gear) * (1.0 - SLACK)
    s.time = length / v
    s.force = driving_force(t.model, t.road, math.sqrt(0.5 * (before + after)), a)
    s.brake_force = 0.0
    if s.force <= 0.0 and not locked:
        s.engine_speed = t.model.engine.idle_speed
        s.engine_torque = 0.0
        s.brake_force = -s.force
    else:
        s.engine_speed = max(geared_speed(t.model, gear, v), t.model.launch_speed)
        s.engine_torque = engine_torque_for(t.model, gear, s.force, v, a)
        drag = fuel_cut_torque(t.model.engine, s.engine_speed)
        if s.engine_torque < drag:
            s.engine_torque = drag
            s.brake_force = max(engine_force(t.model, gear, drag, a) - s.force, 0.0)
    slips = gear > 1 and s.force > 0.0 and not locked
    if slips or s.engine_torque > highest_torque(t.model.engine, s.engine_speed) + SLACK:
        s.fuel = NEVER
    else:
        s.fuel = fuel_for(t.model, s.engine_speed, s.engine_torque, v, a) * s.time
    return s.fuel


@kernel
def drive_stage(t: SpeedTask, gear: int, before: float, after: float, length: float, s: Stage) -> float:
    """Fill `s` and return its fuel, kg: from v^2 `before` to `after` (m^2/s^2) over `length` (m) in a gear.

    Where the launch speed is passed on the way, the parts before and after it count each for themselves; torque, engine
    speed and forces are then means over time.
    """
    launch = launch_square(t, gear)
    fastest = launch * (t.model.engine.speed_limit / t.model.launch_speed) ** 2
    none = gear_ratio(t.model.gearbox, gear) < LEAST_RATIO
    if none or before + after < LEAST_SPEED**2 or max(before, after) > fastest * (1.0 + SLACK):
        s.fuel = NEVER
    elif min(before, after) < launch * (1.0 - SLACK) and max(before, after) > launch * (1.0 + SLACK):
        share = (launch - before) / (after - before)
        fuel = drive_part(t, gear, before, launch, share * length, s)
        time = s.time
        torque = s.engine_torque * time
        speed = s.engine_speed * time
        brake = s.brake_force * time
        force = s.force * time
        rest = drive_part(t, gear, launch, after, (1.0 - share) * length, s)
        s.fuel = min(fuel + rest, NEVER)
        force = force + s.force * s.time
        brake = brake + s.brake_force * s.time
        speed = speed + s.engine_speed * s.time
        torque = torque + s.engine_torque * s.time
        s.time = time + s.time
        s.engine_torque = torque / s.time
        s.engine_speed = speed / s.time
        s.brake_force = brake / s.time
        s.force = force / s.time
    else:
        s.fuel = drive_part(t, gear, before, after, length, s)
    return s.fuel


@kernel
def coast_deceleration(t: SpeedTask, speed: float) -> float:
    """Return how fast the vehicle slows down in neutral at `speed` (m/s), m/s^2; below 0 where it gains speed."""
    without = driving_force(t.model, t.road, speed, 0.0)
    return without / (driving_force(t.model, t.road, speed, 1.0) - without)


@kernel
def coast_end(t: SpeedTask, speed: float) -> float:
    """Return the speed, m/s, after a shift that begins at `speed`; below 0 where the vehicle stops before its end."""
    middle = speed - 0.5 * t.shift_time * coast_deceleration(t, speed)
    return speed - t.shift_time * coast_deceleration(t, max(middle, 0.0))


@kernel
def coast_length(t: SpeedTask, before: float) -> float:
    """Return how far the vehicle rolls in neutral during a shift from v^2 `before` (m^2/s^2) on, m; -1: it stops."""
    v = math.sqrt(before)
    end = coast_end(t, v)
    return 0.5 * (v + end) * t.shift_time if end > 0.0 else -1.0


@kernel
def shift_fuel(t: SpeedTask, old: int, new: int, speed: float) -> float:
    """Return the fuel of a shift at `speed` (m/s), kg: the engine goes in neutral from the one speed to the other.

    It takes the constant torque that turns it there within the shift time, between drag and full load.
    """
    before = engine_speed_for(t.model, old, speed)
    after = engine_speed_for(t.model, new, speed)
    mean = 0.5 * (before + after)
    wanted = t.model.engine.inertia * (after - before) / max(t.shift_time, 1e-3)
    torque = clamp(wanted, fuel_cut_torque(t.model.engine, mean), highest_torque(t.model.engine, mean))
    return fuel_flow(t.model.engine, mean, torque) * t.shift_time
