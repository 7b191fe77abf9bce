"""Launch at constant engine speed: the field's classical controller, and the baseline of every other one.

The engine is held at a target speed that follows the pedal, by a PID on the throttle rate. The clutch torque rises,
after a touch delay, at a rate that the wanted jerk allows, to the torque that the engine gives at that pedal and
speed [1, sec. 2.3.2]; a correction by the engine-speed error may be added, so that the clutch takes what the engine
has to give and gives way before it stalls. Near synchronous speed the clutch closes; then the throttle is handed
back to the pedal.

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014; gains and targets are chosen or fitted, see the calibrations.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from bitepoint.controllers.controller import Controller
from bitepoint.controllers.engine_speed import (
    EngineSpeedCalibration,
    EngineSpeedState,
    engine_speed_hand_over,
    engine_speed_reset,
    engine_speed_step,
    idle_throttle,
)
from bitepoint.controllers.launch_phase import DRIVING, PHASES, SLIPPING, WAITING, phase_after
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.numerics.tables import lookup
from bitepoint.records import Curve, Record, RecordArray, count, curve, nested, quantity

_PEDAL = ("pedal", "1", 0.0, 1.0)


class LaunchPidCalibration(Record):
    """What an engineer tunes; curves are over the pedal."""

    engine_target: Curve = curve(_PEDAL, ("speed", "rad/s", 20, 1000), "engine speed to hold")
    target_rise_time: float = quantity("s", 0.01, 10, "time in which the target rises from idle speed")
    clutch_torque: Curve = curve(_PEDAL, ("torque", "N*m", 0, 10_000), "clutch torque to rise to")
    clutch_rate: Curve = curve(_PEDAL, ("rate", "N*m/s", 1, 1e5), "how fast it rises: the wanted jerk")
    touch_delay: float = quantity("s", 0, 5, "time from pedal onset until the clutch touches")
    clutch_kp: float = quantity("N*m*s/rad", 0, 100, "clutch torque per engine-speed error", default=0.0)
    clutch_deadband: float = quantity(
        "rad/s", 0, 200, "speed error that the clutch leaves to the throttle", default=0.0
    )
    clutch_ki: float = quantity("N*m/rad", 0, 1000, "clutch torque rate per engine-speed error", default=0.0)
    closing_slip: float = quantity("rad/s", 0.01, 100, "slip below which the clutch closes")
    closing_rate: float = quantity("N*m/s", 1, 1e5, "how fast it closes")
    handover_rate: float = quantity("1/s", 0.01, 100, "how fast the throttle then goes to the pedal")
    pedal_threshold: float = quantity("1", 0.001, 0.2, "pedal above which the driver wants to move off", default=0.01)
    engine_speed: EngineSpeedCalibration = nested(EngineSpeedCalibration, "PID on the throttle rate")


class LaunchPidParameters(Record):
    """What the step reads."""

    calibration: LaunchPidCalibration = nested(LaunchPidCalibration, "what an engineer tunes")
    idle_speed: float = quantity("rad/s", 20, 300, "idle speed of the engine")
    idle_throttle: float = quantity("1", 0, 1, "throttle that holds the idle speed, clutch open")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest clutch torque")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the clutch torque")


class LaunchPidState(Record):
    """Memory between two steps."""

    phase: int = count(0, 3, "phase of the launch", names=PHASES)
    time: float = quantity("s", 0, 1e9, "time since pedal onset")
    feed_forward: float = quantity("N*m", 0, 10_000, "risen part of the clutch torque")
    integral: float = quantity("N*m", -10_000, 10_000, "integral part of the clutch torque")
    clutch_torque: float = quantity("N*m", 0, 10_000, "commanded clutch torque")
    engine_speed: EngineSpeedState = nested(EngineSpeedState, "engine-speed control")


class LaunchPidMeasurement(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "speed of the driven plate of clutch 1")


class LaunchPidCommand(Record):
    """What it commands, and what it thinks."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of clutch 1")
    engine_speed_target: float = quantity("rad/s", 0, 2000, "engine speed to hold")
    launch_phase: float = quantity("1", 0, 3, "phase of the launch", names=PHASES)


@kernel
def slipping_torque(c: LaunchPidCalibration, s: LaunchPidState, pedal: float, speed_error: float, dt: float) -> float:
    """Return the clutch torque while slipping, N m: risen feed-forward plus correction by the speed error.

    The correction may lower the torque at will, but raise it only to what the pedal asks for.
    """
    goal = lookup(c.clutch_torque, pedal)
    error = speed_error - clamp(speed_error, -c.clutch_deadband, c.clutch_deadband)
    rise = lookup(c.clutch_rate, pedal) * dt
    touching = s.time >= c.touch_delay
    if touching:
        s.feed_forward = clamp(goal, s.feed_forward - rise, s.feed_forward + rise)
        s.integral = clamp(s.integral - c.clutch_ki * dt * error, -s.feed_forward, 10_000.0)
    correction = s.integral - c.clutch_kp * error
    torque = s.feed_forward + correction
    if correction > 0.0:  # a driver who lifts the pedal lowers the target: that is no reason to grip harder
        torque = min(torque, max(goal, s.feed_forward))
    return torque if touching else 0.0


@kernel
def init(p: LaunchPidParameters, s: LaunchPidState, m: LaunchPidMeasurement, c: LaunchPidCommand) -> None:
    """Wait with the clutch open and the engine idling."""
    s.phase = WAITING
    s.time = 0.0
    s.feed_forward = 0.0
    s.integral = 0.0
    s.clutch_torque = 0.0
    engine_speed_reset(s.engine_speed, p.idle_throttle)
    c.throttle = p.idle_throttle
    c.clutch_torque_command = 0.0
    c.engine_speed_target = p.idle_speed
    c.launch_phase = 0.0


@kernel
def step(p: LaunchPidParameters, s: LaunchPidState, m: LaunchPidMeasurement, c: LaunchPidCommand, dt: float) -> int:
    """Command throttle and clutch for the next dt (s); return 0, or 1 where a measurement is no number.

    A measurement that is no number leaves the commands as they are.
    """
    status = 1
    if is_finite(m.pedal) and is_finite(m.engine_speed) and is_finite(m.clutch_speed):
        status = 0
        pedal = clamp(m.pedal, 0.0, 1.0)
        demand = pedal - p.calibration.pedal_threshold
        contact = s.time - p.calibration.touch_delay
        s.phase = phase_after(s.phase, demand, contact, m.engine_speed - m.clutch_speed, p.calibration.closing_slip)
        risen = clamp(s.time / p.calibration.target_rise_time, 0.0, 1.0)
        target = p.idle_speed + risen * (lookup(p.calibration.engine_target, pedal) - p.idle_speed)
        torque = 0.0
        if s.phase == WAITING:
            s.time = 0.0
            s.feed_forward = 0.0
            s.integral = 0.0
            target = p.idle_speed
        elif s.phase == SLIPPING:
            torque = slipping_torque(p.calibration, s, pedal, target - m.engine_speed, dt)
            s.time = s.time + dt
        else:
            torque = s.clutch_torque + p.calibration.closing_rate * dt
        change = p.rate_limit * dt
        torque = clamp(torque, s.clutch_torque - change, s.clutch_torque + change)
        s.clutch_torque = clamp(torque, 0.0, p.torque_limit)
        if s.phase == DRIVING:
            c.throttle = engine_speed_hand_over(s.engine_speed, pedal, p.calibration.handover_rate * dt)
        else:
            c.throttle = engine_speed_step(p.calibration.engine_speed, s.engine_speed, target, m.engine_speed, dt)
        c.clutch_torque_command = s.clutch_torque
        c.engine_speed_target = target
        c.launch_phase = float(s.phase)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (blocks engine and clutch), one record per calibration."""
    parameters = LaunchPidParameters.zeros(len(calibration))
    engine = vehicle["engine"]
    parameters["calibration"] = calibration
    parameters["idle_speed"] = engine["idle_speed"]
    parameters["idle_throttle"] = idle_throttle(engine)
    parameters["torque_limit"] = vehicle["clutch"]["torque_limit"]
    parameters["rate_limit"] = vehicle["clutch"]["torque_rate_limit"]
    return parameters


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    return library_yaml("controllers", "launch_pid.yaml")


CONTROLLER = Controller(
    name="launch_pid",
    meaning="constant engine speed by PID, clutch torque by feed-forward and speed error",
    plants=("dct",),
    calibration=LaunchPidCalibration,
    calibrations=calibrations,
    default_calibration="tuned",
    parameters=LaunchPidParameters,
    state=LaunchPidState,
    measurement=LaunchPidMeasurement,
    command=LaunchPidCommand,
    design=design,
    init=init,
    step=step,
)
