"""No control: the throttle follows the pedal, the clutch rises to a fixed torque at a fixed rate.

What a launch is without feedback.
"""

from __future__ import annotations

from bitepoint.controllers.controller import Controller, only_defaults
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.records import Record, RecordArray, nested, quantity


class OpenLoopCalibration(Record):
    """What can be set."""

    clutch_torque: float = quantity("N*m", 0, 10_000, "clutch torque to rise to", default=100.0)
    clutch_rate: float = quantity("N*m/s", 0.1, 1e5, "how fast it rises", default=100.0)
    pedal_threshold: float = quantity("1", 0.001, 0.2, "pedal above which it rises", default=0.01)


class OpenLoopParameters(Record):
    """What the step reads."""

    calibration: OpenLoopCalibration = nested(OpenLoopCalibration, "what can be set")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest clutch torque")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the clutch torque")


class OpenLoopState(Record):
    """Memory between two steps."""

    clutch_torque: float = quantity("N*m", 0, 10_000, "commanded clutch torque")


class OpenLoopMeasurement(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")


class OpenLoopCommand(Record):
    """What it commands."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of clutch 1")


@kernel
def init(p: OpenLoopParameters, s: OpenLoopState, m: OpenLoopMeasurement, c: OpenLoopCommand) -> None:
    """Start with the clutch open."""
    s.clutch_torque = 0.0
    c.throttle = clamp(m.pedal, 0.0, 1.0)
    c.clutch_torque_command = 0.0


@kernel
def step(p: OpenLoopParameters, s: OpenLoopState, m: OpenLoopMeasurement, c: OpenLoopCommand, dt: float) -> int:
    """Pass the pedal on and raise the clutch torque; return 0, or 1 where the pedal is no number."""
    status = 1
    if is_finite(m.pedal):
        status = 0
        goal = p.calibration.clutch_torque if m.pedal > p.calibration.pedal_threshold else 0.0
        change = min(p.calibration.clutch_rate, p.rate_limit) * dt
        torque = clamp(goal, s.clutch_torque - change, s.clutch_torque + change)
        s.clutch_torque = clamp(torque, 0.0, p.torque_limit)
        c.throttle = clamp(m.pedal, 0.0, 1.0)
        c.clutch_torque_command = s.clutch_torque
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (block clutch), one record per calibration."""
    parameters = OpenLoopParameters.zeros(len(calibration))
    parameters["calibration"] = calibration
    parameters["torque_limit"] = vehicle["clutch"]["torque_limit"]
    parameters["rate_limit"] = vehicle["clutch"]["torque_rate_limit"]
    return parameters


CONTROLLER = Controller(
    name="none",
    meaning="open loop: throttle as the pedal, clutch torque on a ramp",
    plants=("dct",),
    calibration=OpenLoopCalibration,
    calibrations=only_defaults,
    default_calibration="default",
    parameters=OpenLoopParameters,
    state=OpenLoopState,
    measurement=OpenLoopMeasurement,
    command=OpenLoopCommand,
    design=design,
    init=init,
    step=step,
)
