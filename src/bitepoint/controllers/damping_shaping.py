"""Damping of a parallel hybrid's driveline by a law instead of a programme: shaping and rate damping.

    U = f2 - T1 - Kd (y - yref),      yref = twist speed (f1 - f2) / tf

f1 and f2 are the driver's torque after one and two filters of time constant tf; T1 is the engine's torque by its lag,
and y the torsional speed, of the measured speeds of motor and wheels. The motor fills in what the shaped torque has
beyond the engine's, less a share of what swings. With `shape_engine` the engine is asked for its share of the shaped
torque, and the motor keeps to its own and damps.

Source: page 2 of the specification.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from bitepoint.controllers.controller import Controller
from bitepoint.controllers.torque_shaping import ShapedTorque, shaping_reset, shaping_step
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.models.driveline import DrivelineModel
from bitepoint.parts.amt import GEARS
from bitepoint.records import FloatArray, Record, RecordArray, count, nested, quantity

PERIOD = 0.01


class DampingShapingCalibration(Record):
    """What an engineer tunes."""

    shaping_time: float = quantity("s", 0.001, 2, "time constant of each of both filters", default=0.15)
    rate_damping: float = quantity("N*m*s/rad", 0, 1000, "motor torque per torsional speed", default=30.0)
    shape_engine: int = count(0, 1, "1: the engine is asked for the shaped torque too", default=0)


class DampingShapingParameters(Record):
    """What the step reads."""

    calibration: DampingShapingCalibration = nested(DampingShapingCalibration, "what an engineer tunes")
    shaping_share: float = quantity("1", 0, 1, "of a step that each filter answers per step")
    engine_share: float = quantity("1", 0, 1, "of a step that the engine answers per step")
    torque_limit: float = quantity("N*m", 0, 5000, "highest torque of the motor")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the motor's command")
    ratio: FloatArray = quantity("1", 0, 2500, "motor speed over wheel speed by gear; 0 for no gear", shape=(GEARS,))
    twist_speed: FloatArray = quantity(
        "rad/(N*m)", 0, 1e3, "torsional speed per change rate of the torque by gear", shape=(GEARS,)
    )
    open_twist_speed: FloatArray = quantity("rad/(N*m)", 0, 1e3, "the same, the clutch open", shape=(GEARS,))


class DampingShapingState(Record):
    """Memory between two steps."""

    motor_command: float = quantity("N*m", -5000, 5000, "commanded torque of the motor")
    engine_torque: float = quantity("N*m", -5000, 5000, "torque of the engine, by its lag")
    engine_request: float = quantity("N*m", -5000, 5000, "torque that it was asked for")
    shaped: ShapedTorque = nested(ShapedTorque, "the driver's torque, shaped")
    engine_shaped: ShapedTorque = nested(ShapedTorque, "the engine's share, shaped")


class DampingShapingMeasurement(Record):
    """What it sees."""

    engine_torque_base: float = quantity("N*m", -5000, 5000, "the engine's share of what the driver asks for")
    motor_torque_base: float = quantity("N*m", -5000, 5000, "the motor's share")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of the clutch; 0: open")
    motor_speed: float = quantity("rad/s", -2000, 2000, "motor speed")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    motor_torque_limit: float = quantity("N*m", 0, 5000, "torque that the motor can give now, either way")
    gear: float = quantity("1", 0, GEARS, "gear; 0 while shifting")


class DampingShapingCommand(Record):
    """What it commands, and what it thinks."""

    engine_torque_request: float = quantity("N*m", -5000, 5000, "torque asked of the engine")
    motor_torque_command: float = quantity("N*m", -5000, 5000, "torque commanded to the motor")
    correction_torque: float = quantity("N*m", -10_000, 10_000, "what of it is not the motor's share: it damps")
    shaped_torque: float = quantity("N*m", -10_000, 10_000, "torque at the gearbox that is aimed at")


@kernel
def engine_follows(p: DampingShapingParameters, s: DampingShapingState, engine: float) -> None:
    """Ask the engine for its share, N m, shaped or not, after its torque has followed the last request."""
    s.engine_torque += p.engine_share * (s.engine_request - s.engine_torque)
    shaping_step(s.engine_shaped, engine, p.shaping_share)
    s.engine_request = s.engine_shaped.second if p.calibration.shape_engine == 1 else engine


@kernel
def damping_torque(p: DampingShapingParameters, s: DampingShapingState, m: DampingShapingMeasurement) -> float:
    """Return the torque, N m, that takes away what the half-shafts swing beyond what the shaped torque wants."""
    place = to_index(m.gear - 1.0, 0, GEARS - 1)
    torque = 0.0
    if m.gear > 0.5 and p.ratio[place] > 0.0:
        rate = (s.shaped.first - s.shaped.second) / p.calibration.shaping_time
        per_rate = p.twist_speed[place] if m.clutch_torque_command > 0.0 else p.open_twist_speed[place]
        torsional = m.motor_speed / p.ratio[place] - m.wheel_speed
        torque = -p.calibration.rate_damping * (torsional - per_rate * rate)
    return torque


@kernel
def init(
    p: DampingShapingParameters, s: DampingShapingState, m: DampingShapingMeasurement, c: DampingShapingCommand
) -> None:
    """Take over a driveline that has long been driven by what is asked for now."""
    engine = clamp(m.engine_torque_base, -5000.0, 5000.0)
    motor = clamp(m.motor_torque_base, -p.torque_limit, p.torque_limit)
    s.motor_command = motor
    s.engine_torque = engine
    s.engine_request = engine
    shaping_reset(s.shaped, engine + motor)
    shaping_reset(s.engine_shaped, engine)
    c.engine_torque_request = engine
    c.motor_torque_command = motor
    c.correction_torque = 0.0
    c.shaped_torque = engine + motor


@kernel
def step(
    p: DampingShapingParameters,
    s: DampingShapingState,
    m: DampingShapingMeasurement,
    c: DampingShapingCommand,
    dt: float,
) -> int:
    """Command engine and motor for the next dt (s); return 0, or 1 where a measurement is no number.

    A measurement that is no number leaves the commands as they are.
    """
    status = 1
    asked = m.engine_torque_base + m.motor_torque_base + m.clutch_torque_command + m.gear
    if is_finite(asked) and is_finite(m.motor_speed + m.wheel_speed + m.motor_torque_limit):
        status = 0
        engine = clamp(m.engine_torque_base, -5000.0, 5000.0)
        motor = clamp(m.motor_torque_base, -5000.0, 5000.0)
        limit = clamp(m.motor_torque_limit, 0.0, p.torque_limit)
        geared = engine if m.clutch_torque_command > 0.0 else 0.0
        shaping_step(s.shaped, geared + motor, p.shaping_share)
        engine_follows(p, s, engine)
        given = s.engine_shaped.second if p.calibration.shape_engine == 1 else s.engine_torque
        if m.clutch_torque_command <= 0.0:
            given = 0.0
        change = p.rate_limit * dt
        torque = clamp(s.shaped.second - given + damping_torque(p, s, m), -limit, limit)
        s.motor_command = clamp(torque, s.motor_command - change, s.motor_command + change)
        c.engine_torque_request = s.engine_request
        c.motor_torque_command = s.motor_command
        c.correction_torque = s.motor_command - motor
        c.shaped_torque = s.shaped.second
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle with the blocks of a `p2_hybrid`, one record per calibration."""
    parameters = DampingShapingParameters.zeros(len(calibration))
    motor = vehicle["motor"]
    parameters["calibration"] = calibration
    parameters["shaping_share"] = 1.0 - np.exp(-PERIOD / calibration["shaping_time"])
    parameters["engine_share"] = 1.0 - np.exp(-PERIOD / vehicle["engine"]["lag"])
    parameters["torque_limit"], parameters["rate_limit"] = motor["torque_limit"], motor["torque_rate_limit"]
    for n in range(GEARS):
        if vehicle["gearbox"]["ratios"][0, n] > 0.0:
            model = DrivelineModel.of(vehicle, n + 1)
            parameters["ratio"][:, n] = model.ratio
            parameters["twist_speed"][:, n] = model.twist_speed
            parameters["open_twist_speed"][:, n] = model.opened().twist_speed
    return parameters


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    return library_yaml("controllers", "damping_shaping.yaml")


CONTROLLER = Controller(
    name="damping_shaping",
    meaning="driveline damped by the motor: shaped torque and rate damping",
    plants=("p2_hybrid",),
    calibration=DampingShapingCalibration,
    calibrations=calibrations,
    default_calibration="tuned",
    parameters=DampingShapingParameters,
    state=DampingShapingState,
    measurement=DampingShapingMeasurement,
    command=DampingShapingCommand,
    design=design,
    init=init,
    step=step,
    period=PERIOD,
)
