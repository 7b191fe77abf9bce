"""Supervisor of a parallel hybrid: it splits the driver's torque by mode, and opens the clutch to drive electrically.

electric: all by the motor, the clutch open; engine: all by the engine; hybrid: a share by the motor; generating: the
engine also gives what the motor takes to charge the battery.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bitepoint.controllers.controller import Controller
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.records import Record, RecordArray, count, nested, quantity

MODES = ("electric", "engine", "hybrid", "generating")
ELECTRIC, ENGINE, HYBRID, GENERATING = range(len(MODES))


class TorqueSplitCalibration(Record):
    """What can be set."""

    mode: int = count(0, 3, "who drives", default=1, names=MODES)
    motor_share: float = quantity("1", 0, 1, "share of the torque that the motor gives in the mode hybrid", default=0.3)
    charging_torque: float = quantity("N*m", 0, 1000, "of the motor in the mode generating", default=40.0)


class TorqueSplitParameters(Record):
    """What the step reads."""

    calibration: TorqueSplitCalibration = nested(TorqueSplitCalibration, "what can be set")
    clutch_torque: float = quantity("N*m", 0, 10_000, "capacity that closes the clutch")


class TorqueSplitState(Record):
    """Memory between two steps: none."""

    unused: float = quantity("1", 0, 0, "nothing")


class TorqueSplitMeasurement(Record):
    """What it sees."""

    torque_request: float = quantity("N*m", -5000, 5000, "torque at the input of the gearbox that the driver asks for")


class TorqueSplitCommand(Record):
    """What it commands."""

    engine_torque_base: float = quantity("N*m", -5000, 5000, "the engine's share of what the driver asks for")
    motor_torque_base: float = quantity("N*m", -5000, 5000, "the motor's share")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of the clutch; 0: open")


@kernel
def split(p: TorqueSplitParameters, request: float, c: TorqueSplitCommand) -> None:
    """Write the shares of a torque, N m, and the clutch."""
    mode = p.calibration.mode
    asked = clamp(request, -5000.0, 5000.0)
    motor = 0.0
    if mode == ELECTRIC:
        motor = asked
    elif mode == HYBRID:
        motor = p.calibration.motor_share * asked
    elif mode == GENERATING:
        motor = -p.calibration.charging_torque
    c.motor_torque_base = motor
    c.engine_torque_base = clamp(asked - motor, -5000.0, 5000.0)
    c.clutch_torque_command = 0.0 if mode == ELECTRIC else p.clutch_torque


@kernel
def init(p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement, c: TorqueSplitCommand) -> None:
    """Split what is asked for now."""
    s.unused = 0.0
    split(p, m.torque_request, c)


@kernel
def step(
    p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement, c: TorqueSplitCommand, dt: float
) -> int:
    """Split what is asked for; return 0, or 1 where it is no number, and leave the commands as they are."""
    status = 1
    if is_finite(m.torque_request):
        status = 0
        split(p, m.torque_request, c)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (block clutch), one record per calibration."""
    parameters = TorqueSplitParameters.zeros(len(calibration))
    parameters["calibration"] = calibration
    parameters["clutch_torque"] = vehicle["clutch"]["torque_limit"]
    return parameters


def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the one calibration, all defaults."""
    return {"default": {}}


CONTROLLER = Controller(
    name="torque_split",
    meaning="splits the driver's torque between engine and motor by mode",
    plants=("p2_hybrid",),
    calibration=TorqueSplitCalibration,
    calibrations=calibrations,
    default_calibration="default",
    parameters=TorqueSplitParameters,
    state=TorqueSplitState,
    measurement=TorqueSplitMeasurement,
    command=TorqueSplitCommand,
    design=design,
    init=init,
    step=step,
)
