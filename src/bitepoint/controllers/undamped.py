"""No damping of a parallel hybrid: engine and motor are asked for their shares.

A limit of the engine's rate, the simplest remedy, can be set.
"""

from __future__ import annotations

from bitepoint.controllers.controller import Controller, only_defaults
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.records import Record, RecordArray, nested, quantity


class UndampedCalibration(Record):
    """What can be set."""

    request_rate: float = quantity(
        "N*m/s", 1, 1e6, "fastest change of what the engine is asked for; the default is no limit", default=1e6
    )


class UndampedParameters(Record):
    """What the step reads."""

    calibration: UndampedCalibration = nested(UndampedCalibration, "what can be set")


class UndampedState(Record):
    """Memory between two steps."""

    engine_request: float = quantity("N*m", -5000, 5000, "torque asked of the engine")


class UndampedMeasurement(Record):
    """What it sees."""

    engine_torque_base: float = quantity("N*m", -5000, 5000, "the engine's share of what the driver asks for")
    motor_torque_base: float = quantity("N*m", -5000, 5000, "the motor's share")


class UndampedCommand(Record):
    """What it commands."""

    engine_torque_request: float = quantity("N*m", -5000, 5000, "torque asked of the engine")
    motor_torque_command: float = quantity("N*m", -5000, 5000, "torque commanded to the motor")
    correction_torque: float = quantity("N*m", -10_000, 10_000, "what of it is not the motor's share: none")


@kernel
def init(p: UndampedParameters, s: UndampedState, m: UndampedMeasurement, c: UndampedCommand) -> None:
    """Ask for the shares of now."""
    s.engine_request = clamp(m.engine_torque_base, -5000.0, 5000.0)
    c.engine_torque_request = s.engine_request
    c.motor_torque_command = clamp(m.motor_torque_base, -5000.0, 5000.0)
    c.correction_torque = 0.0


@kernel
def step(p: UndampedParameters, s: UndampedState, m: UndampedMeasurement, c: UndampedCommand, dt: float) -> int:
    """Ask for the shares; return 0, or 1 where one is no number, and leave the commands as they are."""
    status = 1
    if is_finite(m.engine_torque_base) and is_finite(m.motor_torque_base):
        status = 0
        change = p.calibration.request_rate * dt
        engine = clamp(m.engine_torque_base, -5000.0, 5000.0)
        s.engine_request = clamp(engine, s.engine_request - change, s.engine_request + change)
        c.engine_torque_request = s.engine_request
        c.motor_torque_command = clamp(m.motor_torque_base, -5000.0, 5000.0)
        c.correction_torque = 0.0
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters: the calibrations; nothing is asked of the vehicle."""
    parameters = UndampedParameters.zeros(len(calibration))
    parameters["calibration"] = calibration
    return parameters


CONTROLLER = Controller(
    name="none",
    meaning="no damping: engine and motor give their shares",
    plants=("p2_hybrid",),
    calibration=UndampedCalibration,
    calibrations=only_defaults,
    default_calibration="default",
    parameters=UndampedParameters,
    state=UndampedState,
    measurement=UndampedMeasurement,
    command=UndampedCommand,
    design=design,
    init=init,
    step=step,
)
