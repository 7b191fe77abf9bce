"""Supervisor of a parallel hybrid: it splits the driver's torque by mode, and opens the clutch to drive electrically.

electric: all by the motor, the clutch open; engine: all by the engine; hybrid: a share by the motor; generating: the
engine also gives what the motor takes to charge the battery.

automatic: electric when slow, braking, and where the engine would turn below idle; else by the engine, which idles
meanwhile. To take it in, its speed is brought to that of the motor, the clutch closes, and the torque is handed over;
to let it go, the other way round. While the gearbox shifts the clutch is open.
"""

from __future__ import annotations

from bitepoint.controllers.controller import Controller, only_defaults
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.records import Record, RecordArray, count, nested, quantity

MODES = ("electric", "engine", "hybrid", "generating", "automatic")
ELECTRIC, ENGINE, HYBRID, GENERATING, AUTOMATIC = range(len(MODES))

LEAVING_TORQUE = -10.0
"""Request below which the engine is let go in the mode automatic, N m; above its opposite it may be taken in."""

LEAVING_SPEED = 1.1
"""Speed of the motor over the engine's idle speed below which the clutch has to be open."""

ENTERING_SPEED = 1.3
"""The same, above which the engine may be taken in."""

MATCHING_TIME = 0.1
"""Time constant with which the engine comes to the speed of the motor, s (chosen: two lags of an engine)."""


class TorqueSplitCalibration(Record):
    """What can be set."""

    mode: int = count(0, 4, "who drives", default=1, names=MODES)
    motor_share: float = quantity("1", 0, 1, "share of the torque that the motor gives in the mode hybrid", default=0.3)
    charging_torque: float = quantity("N*m", 0, 1000, "of the motor in the mode generating", default=40.0)
    engine_speed_above: float = quantity("m/s", 0, 100, "vehicle speed from which the engine drives", default=10.0)
    engine_speed_below: float = quantity("m/s", 0, 100, "vehicle speed below which it does not", default=8.0)
    engine_torque_above: float = quantity("N*m", 0, 5000, "request from which it drives at any speed", default=180.0)
    closing_slip: float = quantity("rad/s", 0.1, 100, "difference of speeds at which the clutch closes", default=5.0)
    handover_time: float = quantity("s", 0.01, 10, "in which the torque goes from one to the other", default=0.4)


class TorqueSplitParameters(Record):
    """What the step reads."""

    calibration: TorqueSplitCalibration = nested(TorqueSplitCalibration, "what can be set")
    clutch_torque: float = quantity("N*m", 0, 10_000, "capacity that closes the clutch")
    idle_speed: float = quantity("rad/s", 20, 300, "of the engine", default=80.0)
    matching_gain: float = quantity("N*m*s/rad", 0, 1000, "torque of the engine per difference of speeds")


class TorqueSplitState(Record):
    """Memory between two steps, of the mode automatic."""

    engine_wanted: int = count(0, 1, "1: the engine is to drive")
    clutch_closed: int = count(0, 1, "1: the clutch is closed")
    engine_share: float = quantity("1", 0, 1, "share of a driving torque that the engine has")


class TorqueSplitMeasurement(Record):
    """What it sees."""

    torque_request: float = quantity("N*m", -5000, 5000, "torque at the input of the gearbox that the driver asks for")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    motor_speed: float = quantity("rad/s", -2000, 2000, "speed of the motor")
    gear: float = quantity("1", 0, 8, "engaged gear; 0 while shifting")


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
def choose_source(p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement) -> None:
    """Say whether the engine is to drive; between the limits it stays as it is."""
    slow = m.vehicle_speed < p.calibration.engine_speed_below
    fast = m.vehicle_speed > p.calibration.engine_speed_above
    much = m.torque_request > p.calibration.engine_torque_above
    little = m.torque_request < 0.5 * p.calibration.engine_torque_above
    if m.torque_request < LEAVING_TORQUE or (slow and little):
        s.engine_wanted = 0
    elif (fast or much) and m.torque_request > -LEAVING_TORQUE and m.motor_speed > ENTERING_SPEED * p.idle_speed:
        s.engine_wanted = 1


@kernel
def move_clutch(p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement, dt: float) -> None:
    """Close the clutch at equal speeds and hand the torque over, or take it back and open."""
    change = dt / p.calibration.handover_time
    if m.gear < 0.5 or m.motor_speed < LEAVING_SPEED * p.idle_speed:
        s.engine_share = 0.0
        s.clutch_closed = 0
    elif s.engine_wanted == 1:
        if abs(m.engine_speed - m.motor_speed) < p.calibration.closing_slip:
            s.clutch_closed = 1
        if s.clutch_closed == 1:
            s.engine_share = min(s.engine_share + change, 1.0)
    else:
        s.engine_share = max(s.engine_share - change, 0.0)
        if s.engine_share == 0.0:
            s.clutch_closed = 0


@kernel
def split_automatically(
    p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement, c: TorqueSplitCommand
) -> None:
    """Write the shares and the clutch; with the clutch open an engine that is wanted comes to the motor's speed."""
    asked = clamp(m.torque_request, -5000.0, 5000.0)
    engine = s.engine_share * max(asked, 0.0)
    c.motor_torque_base = asked - engine
    if s.clutch_closed == 0 and s.engine_wanted == 1:
        engine = p.matching_gain * (m.motor_speed - m.engine_speed)
    c.engine_torque_base = clamp(engine, -5000.0, 5000.0)
    c.clutch_torque_command = p.clutch_torque if s.clutch_closed == 1 else 0.0


@kernel
def init(p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement, c: TorqueSplitCommand) -> None:
    """Split what is asked for now; automatic begins with the clutch open."""
    s.engine_wanted = 0
    s.clutch_closed = 0
    s.engine_share = 0.0
    if p.calibration.mode == AUTOMATIC:
        split_automatically(p, s, m, c)
    else:
        split(p, m.torque_request, c)


@kernel
def step(
    p: TorqueSplitParameters, s: TorqueSplitState, m: TorqueSplitMeasurement, c: TorqueSplitCommand, dt: float
) -> int:
    """Split what is asked for now; return 0, or 1 where a measurement is no number, and leave the commands."""
    status = 1
    speeds = m.vehicle_speed + m.engine_speed + m.motor_speed
    if is_finite(m.torque_request + m.gear) and is_finite(speeds):
        status = 0
        if p.calibration.mode == AUTOMATIC:
            choose_source(p, s, m)
            move_clutch(p, s, m, dt)
            split_automatically(p, s, m, c)
        else:
            split(p, m.torque_request, c)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (blocks clutch and engine), one record per calibration."""
    parameters = TorqueSplitParameters.zeros(len(calibration))
    parameters["calibration"] = calibration
    parameters["clutch_torque"] = vehicle["clutch"]["torque_limit"]
    parameters["idle_speed"] = vehicle["engine"]["idle_speed"]
    parameters["matching_gain"] = vehicle["engine"]["inertia"] / MATCHING_TIME
    return parameters


CONTROLLER = Controller(
    name="torque_split",
    meaning="splits the driver's torque between engine and motor by mode",
    plants=("p2_hybrid",),
    calibration=TorqueSplitCalibration,
    calibrations=only_defaults,
    default_calibration="default",
    parameters=TorqueSplitParameters,
    state=TorqueSplitState,
    measurement=TorqueSplitMeasurement,
    command=TorqueSplitCommand,
    design=design,
    init=init,
    step=step,
)
