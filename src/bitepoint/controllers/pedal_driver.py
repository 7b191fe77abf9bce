"""Driver with an accelerator and a brake, who follows a speed or a plan, and chooses the gear.

    u = gain (v* - v) + integral        throttle = u within 0..limit,  brake = -(u + rest) beyond a rest position
    torque = drag + throttle (full load - drag)       at the present speed of the engine

target: v* is the speed to follow, and gears follow a line: up where the engine turns faster than a line over the
throttle, and the next gear not slower than the launch speed; down where the gear below would not be left at once. With
a schedule they follow a shift map over throttle and speed.

speeds: the same with v* from a plan over distance.

plan: v*, gear and torques come from a plan over distance. They are fed forward, ahead by the lag of the engine, and u
corrects them, likewise its gear, ahead by half a shift.

The integral rests while the throttle is at a limit that the error asks to pass, and while the gearbox shifts. At a
standstill that is wanted the brake holds.

Stop lines are kept in the modes speeds and plan: where v^2 / 2 over the way to the line reaches the deceleration that
is told for it, the driver brakes with what that takes on the slope there, corrected by the error of the speed; stands;
and leaves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from bitepoint.controllers.controller import Controller
from bitepoint.controllers.pedal_driver_records import (
    PLAN,
    TARGET,
    PedalDriverCalibration,
    PedalDriverCommand,
    PedalDriverMeasurement,
    PedalDriverParameters,
    PedalDriverState,
)
from bitepoint.controllers.plan_table import PlanTable, planned_brake, planned_gear, planned_speed, planned_torque
from bitepoint.controllers.stop_lines import (
    REACH,
    STOP_LINES,
    StopLines,
    braking_ahead,
    lined_square,
    slowing_ahead,
    slowing_to_line,
    way_off_line,
    way_to_line,
)
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.models.shift_map import mapped_gear, shift_map
from bitepoint.parts.amt import GEARS, gear_ratio
from bitepoint.parts.torque_engine import fuel_cut_torque, highest_torque
from bitepoint.records import RecordArray

STANDING = 0.01
"""Speed of a vehicle that stands, m/s."""

STANDING_SPEED = 0.05
"""Speed to follow below which the driver wants to stand, m/s."""

BITE = 0.9
"""Speed of the engine, over that at which the clutch is launched, from which the brake at a standstill is released."""

ONSET = 0.95
"""Share of the deceleration told for a stop line at which the driver begins to brake for it."""

SLOWING_GAIN, SLOWING_INTEGRAL = 2.0, 1.0
"""Deceleration towards a line per error of the speed, 1/s, and its rate, 1/s^2: what slows down beside the brake is met
in a second, without an overshoot."""

SOFT_RATE, SOFT_GAIN = 0.3, 2.0
"""Highest deceleration at a line, m/s^2, and how it grows with the speed, 1/s: a stop without a jolt. What a slope
takes, which the integral finds, comes on top."""

STEEP = 3.0
"""Most that a slope adds to the deceleration that the brake gives, or takes from it, m/s^2: that of 30 %."""

STOPPED = 0.1
"""Speed below which a vehicle that stops at a line is held, m/s."""

LEAST_SPAN = 1.0
"""Least torque from drag to full load, N m: an engine that stands has none."""


@kernel
def shift_up_speed(k: PedalDriverCalibration, throttle: float) -> float:
    """Return the engine speed, rad/s, to shift up at, at a throttle of 0..1."""
    return k.shift_up_low + (k.shift_up_high - k.shift_up_low) * throttle


@kernel
def lined_gear(p: PedalDriverParameters, gear: int, engine_speed: float, throttle: float) -> int:
    """Return the gear, 1.., that suits the engine speed (rad/s) in the gear there is: that one or its neighbour."""
    now = max(min(gear, p.gears), 1)
    up = min(now + 1, p.gears)
    down = max(now - 1, 1)
    ratio = max(gear_ratio(p.gearbox, now), 0.1)
    line = shift_up_speed(p.calibration, throttle)
    after = engine_speed * gear_ratio(p.gearbox, up) / ratio
    before = engine_speed * gear_ratio(p.gearbox, down) / ratio
    wanted = now
    if engine_speed > line and after >= p.launch_speed:
        wanted = up
    elif before < p.calibration.shift_down_share * line:
        wanted = down
    return wanted


@kernel
def choose_gear(p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, dt: float) -> None:
    """Choose the gear by the plan, or by line or map; these wait for the last choice and for the pause."""
    s.elapsed = min(s.elapsed + dt, 1e6)
    gear = to_index(m.gear + 0.5, 0, GEARS)
    if p.calibration.mode == PLAN:
        ahead = way_off_line(p.stop_lines, s.passed, m.distance) + p.calibration.gear_preview * m.vehicle_speed
        planned = to_index(planned_gear(p.plan, ahead) + 0.5, 0, GEARS)
        s.gear = min(planned, p.gears) if planned > 0 and s.stopping == 0 else s.gear
    elif gear != s.gear:
        s.elapsed = 0.0
    elif gear > 0 and s.elapsed >= p.calibration.shift_pause:
        lined = lined_gear(p, gear, clamp(m.engine_speed, 0.0, 2000.0), s.throttle)
        mapped = min(mapped_gear(p.shift_map, gear, s.throttle, clamp(m.vehicle_speed, 0.0, 150.0)), p.gears)
        s.gear = mapped if p.calibration.schedule == 1 else lined


@kernel
def speed_to_follow(p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement) -> float:
    """Return the speed to follow, m/s: the target's, or the plan's here within what stop lines allow."""
    speed = clamp(m.speed_target, 0.0, 100.0)
    if p.calibration.mode != TARGET:
        planned = planned_speed(p.plan, way_off_line(p.stop_lines, s.passed, m.distance))
        speed = min(planned, math.sqrt(lined_square(p.stop_lines, s.passed, m.distance)))
    return speed


@kernel
def share_ahead(
    p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, drag: float, span: float
) -> float:
    """Return the throttle of the plan, as far ahead as the engine lags; below 0 where the plan brakes."""
    ahead = way_off_line(p.stop_lines, s.passed, m.distance) + p.engine.lag * m.vehicle_speed
    return clamp((planned_torque(p.plan, ahead) - drag) / span, -1.0, 1.0)


@kernel
def follow(
    p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, c: PedalDriverCommand, dt: float
) -> None:
    """Write throttle, torque and brake that follow the speed."""
    engine_speed = clamp(m.engine_speed, 0.0, 2000.0)
    drag = fuel_cut_torque(p.engine, engine_speed)
    span = max(highest_torque(p.engine, engine_speed) - drag, LEAST_SPAN)
    error = clamp(c.speed_wanted - m.vehicle_speed, -150.0, 150.0)
    limit = p.calibration.throttle_limit
    ahead = 0.0
    brake = 0.0
    if p.calibration.mode == PLAN and p.calibration.feed_forward == 1:
        ahead = share_ahead(p, s, m, drag, span)
        brake = planned_brake(p.plan, way_off_line(p.stop_lines, s.passed, m.distance))
        limit = 1.0
    rest = 0.0 if brake > 0.0 else p.calibration.brake_rest
    wish = ahead + p.calibration.throttle_gain * error + s.integral
    full = wish >= limit and error > 0.0
    none = wish <= -rest and error < 0.0
    if m.gear > 0.5 and not full and not none:
        s.integral = clamp(s.integral + p.calibration.integral_gain * error * dt, -1.0, 1.0)
    brake = max(brake - p.slowing_torque * p.calibration.brake_gain * (wish + rest), 0.0)
    s.throttle = clamp(wish, 0.0, limit) if brake == 0.0 else 0.0
    c.throttle = s.throttle
    c.engine_torque_wanted = clamp(drag + s.throttle * span, -500.0, 5000.0)
    if m.vehicle_speed >= p.calibration.standstill_speed or engine_speed >= BITE * p.launch_speed:
        s.holding = max(s.holding - p.hold_torque / p.calibration.release_time * dt, 0.0)
    c.brake_torque_command = min(max(brake, s.holding), p.brake_limit)


@kernel
def hold(
    p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, c: PedalDriverCommand, dt: float
) -> None:
    """Write the commands that hold the vehicle: at once where it stands, else in time."""
    s.throttle = 0.0
    s.integral = 0.0
    s.gear = 1
    c.throttle = 0.0
    c.engine_torque_wanted = 0.0
    more = p.hold_torque / p.calibration.hold_time * dt if m.vehicle_speed > STANDING else p.hold_torque
    s.holding = min(s.holding + more, p.hold_torque)
    c.brake_torque_command = s.holding


@kernel
def watch_line(p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, dt: float) -> None:
    """Decide whether to brake for the next stop line; leave it behind where the vehicle has stood there long enough."""
    standing = m.vehicle_speed < STOPPED
    slowing = slowing_ahead(p.stop_lines, s.passed)
    if s.stopping == 0:
        s.slowing_more = clamp(braking_ahead(p.stop_lines, s.passed) - slowing, -STEEP, STEEP)
    if standing and way_to_line(p.stop_lines, s.passed, m.distance) > REACH:
        s.stopping = 0
    elif standing or slowing_to_line(p.stop_lines, s.passed, m.distance, m.vehicle_speed) >= ONSET * slowing:
        s.stopping = 1
    if s.stopping == 1 and standing:
        s.stood = min(s.stood + dt, 1e6)
        if s.stood >= p.stop_lines.dwell:
            s.passed = min(s.passed + 1, STOP_LINES)
            s.stopping = 0
            s.stood = 0.0


@kernel
def stop_at_line(
    p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, c: PedalDriverCommand, dt: float
) -> None:
    """Write the commands that bring the vehicle to a stand at the next line; leave it where no brake is needed.

    The engine is dragged along without fuel, as far as the transmission control keeps it above idling.
    """
    s.throttle = 0.0
    s.integral = 0.0
    c.throttle = 0.0
    c.engine_torque_wanted = clamp(fuel_cut_torque(p.engine, clamp(m.engine_speed, 0.0, 2000.0)), -500.0, 0.0)
    error = clamp(m.vehicle_speed - math.sqrt(lined_square(p.stop_lines, s.passed, m.distance)), -150.0, 150.0)
    slowing = slowing_ahead(p.stop_lines, s.passed)
    s.slowing_more = clamp(s.slowing_more + SLOWING_INTEGRAL * error * dt, -STEEP, STEEP)
    soft = SOFT_RATE + SOFT_GAIN * clamp(m.vehicle_speed, 0.0, 150.0) + max(s.slowing_more, 0.0)
    rate = clamp(slowing + s.slowing_more + SLOWING_GAIN * error, 0.0, soft)
    c.brake_torque_command = min(p.slowing_torque * rate, p.brake_limit)
    s.holding = c.brake_torque_command
    if rate == 0.0:
        s.stopping = 0


@kernel
def drive(
    p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, c: PedalDriverCommand, dt: float
) -> None:
    """Write the commands: drive, stop at a line, or hold the vehicle where it is to stand."""
    if p.calibration.mode != TARGET and slowing_ahead(p.stop_lines, s.passed) > 0.0:
        watch_line(p, s, m, dt)
    c.speed_wanted = speed_to_follow(p, s, m)
    stands = m.vehicle_speed < p.calibration.standstill_speed and c.speed_wanted < STANDING_SPEED
    if (s.stopping == 1 and m.vehicle_speed < STOPPED) or (s.stopping == 0 and stands):
        hold(p, s, m, c, dt)
    elif s.stopping == 1:
        stop_at_line(p, s, m, c, dt)
    else:
        follow(p, s, m, c, dt)
    c.gear_wanted = float(s.gear)


@kernel
def init(p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, c: PedalDriverCommand) -> None:
    """Take over in the gear there is."""
    s.gear = to_index(m.gear + 0.5, 0, GEARS)
    s.elapsed = 0.0
    s.integral = 0.0
    s.throttle = 0.0
    s.passed = 0
    s.stopping = 0
    s.slowing_more = 0.0
    s.stood = 0.0
    s.holding = 0.0
    drive(p, s, m, c, 0.0)


@kernel
def step(
    p: PedalDriverParameters, s: PedalDriverState, m: PedalDriverMeasurement, c: PedalDriverCommand, dt: float
) -> int:
    """Follow the speed; return 0, or 1 where a measurement is no number, and leave the commands as they are."""
    status = 1
    if is_finite(m.speed_target + m.vehicle_speed) and is_finite(m.engine_speed + m.distance + m.gear):
        status = 0
        choose_gear(p, s, m, dt)
        drive(p, s, m, c, dt)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (blocks engine, gearbox, clutch, brake, vehicle), one record per calibration.

    Plan and stop lines are empty, and the shift map has the lines of the calibration: `with_plan` and
    `models.shift_map.with_shift_map` give others.
    """
    parameters = PedalDriverParameters.zeros(len(calibration))
    parameters["calibration"] = calibration
    for block in ("engine", "gearbox"):
        parameters[block] = vehicle[block]
    parameters["plan"]["spacing"] = PlanTable.fields["spacing"].default
    parameters["launch_speed"] = vehicle["clutch"]["launch_speed"]
    parameters["brake_limit"] = vehicle["brake"]["torque_limit"]
    body = vehicle["vehicle"]
    parameters["slowing_torque"] = body["mass"] * body["wheel_radius"]
    hold_torque = calibration["hold_rate"] * parameters["slowing_torque"]
    parameters["hold_torque"] = np.minimum(hold_torque, parameters["brake_limit"])
    gears = parameters["gears"] = int(np.argmin(np.append(vehicle["gearbox"]["ratios"][0], 0.0) > 0.0))
    if gears > 1:
        ratios = vehicle["gearbox"]["ratios"][0, :gears] * vehicle["gearbox"]["final_drive"][0]
        per_input = body["wheel_radius"][0] / ratios[:, np.newaxis]
        for lane, k in enumerate(calibration):
            line = np.array([k["shift_up_low"], k["shift_up_high"]])
            up, down = line * per_input[:-1], k["shift_down_share"] * line * per_input[:-1]
            parameters["shift_map"][lane] = shift_map(np.array([0.0, 1.0]), up, down)[0]
    return parameters


def with_plan(
    parameters: RecordArray, plan: RecordArray, mode: int = PLAN, lines: RecordArray | None = None
) -> RecordArray:
    """Return the parameters of a driver who follows a plan, made by `plan_parameters`; SPEEDS: its speeds alone.

    Args:
        lines: where to stop, made by `stop_lines`; None: nowhere.
    """
    changed = parameters.copy()
    changed["plan"] = plan
    changed["stop_lines"] = StopLines.zeros() if lines is None else lines
    changed["calibration"]["mode"] = mode
    return changed


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    return library_yaml("controllers", "pedal_driver.yaml")


CONTROLLER = Controller(
    name="pedal_driver",
    meaning="driver with throttle, brake and gear lever, who follows a speed or a plan",
    plants=("conventional",),
    calibration=PedalDriverCalibration,
    calibrations=calibrations,
    default_calibration="typical",
    parameters=PedalDriverParameters,
    state=PedalDriverState,
    measurement=PedalDriverMeasurement,
    command=PedalDriverCommand,
    design=design,
    init=init,
    step=step,
)
