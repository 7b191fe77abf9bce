"""Records of `damping_mpc`; what it does stands there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bitepoint.controllers.torque_shaping import ShapedTorque
from bitepoint.estimation.driveline import DrivelineEstimate, DrivelineObserver
from bitepoint.estimation.motor_delay import MotorDelayState
from bitepoint.numerics.qp import qp_solver
from bitepoint.parts.amt import GEARS
from bitepoint.records import FloatArray, Record, RecordElements, count, nested, quantity

MOVES = 10
"""Most moves."""

ROWS = 2 * MOVES
"""Limits of the torque, and of its changes."""

PAST = 15
"""Numbers that the future follows from, see `damping_mpc_design`."""

ASKED = 9
"""Of these, the ones from the engine's torque to its request: what is asked for follows from them alone."""

TORQUE_SCALE = 100.0
"""Unit of the moves in the programme, N m."""

WEIGHT_SCALE = 3.0
"""Torque that the weights of changes and corrections count as 1, N m: r = 1 and q = 1 then give about the 17 N m of
correction that the source shows for both (its units are lost)."""

DISCRETISATIONS = ("zero_order_hold", "euler", "euler_unchecked")
SOLVER = qp_solver(MOVES, ROWS)
if TYPE_CHECKING:
    from bitepoint.numerics.qp_records import QpData as Qp10x20Data
    from bitepoint.numerics.qp_records import QpMatrices as Qp10x20Matrices
    from bitepoint.numerics.qp_records import QpSolution as Qp10x20Solution
    from bitepoint.numerics.qp_records import QpWork as Qp10x20Work
else:
    Qp10x20Matrices, Qp10x20Data = SOLVER.matrices, SOLVER.data
    Qp10x20Work, Qp10x20Solution = SOLVER.work, SOLVER.solution


class DampingMpcCalibration(Record):
    """What an engineer tunes."""

    prediction_horizon: int = count(2, 100, "steps of 10 ms that are foreseen", default=30)
    control_horizon: int = count(1, MOVES, "moves; the last one is held", default=5)
    q: float = quantity("1", 0, 1e6, "weight of the torsional speed's error, per 1 rad/s squared", default=1.0)
    r: float = quantity("1", 0, 1e6, "weight of a change of the torque, per 3 N m squared", default=0.001)
    rho: float = quantity("1", 0, 1e6, "weight of the correction itself, per 3 N m squared", default=0.003)
    shaping_time: float = quantity(
        "s", 0, 2, "time constant of both filters that shape the request for the motor; 0 for none", default=0.13
    )
    shape_engine: int = count(0, 1, "1: the engine is asked for the shaped torque too", default=0)
    engine_shaping_time: float = quantity("s", 0.001, 2, "time constant of both filters then", default=0.18)
    rate_damping: float = quantity(
        "N*m*s/rad", 0, 1000, "motor torque per torsional speed, with the clutch open", default=10.0
    )
    discretisation: int = count(0, 2, "of the model", default=0, names=DISCRETISATIONS)
    engine_speed_noise: float = quantity("rad/s", 1e-6, 100, "standard deviation that is reckoned with", default=0.1)
    motor_speed_noise: float = quantity("rad/s", 1e-6, 100, "standard deviation that is reckoned with", default=0.1)
    wheel_speed_noise: float = quantity("rad/s", 1e-6, 100, "standard deviation that is reckoned with", default=0.02)
    slip_limit: float = quantity("1", 0.01, 10, "slip of the tyres above which torque is taken away", default=0.08)
    slip_gain: float = quantity("N*m", 0, 1e5, "of the motor, per slip beyond the limit", default=2000.0)
    slip_rate: float = quantity("N*m/s", 0, 1e6, "of the engine, per slip beyond the limit", default=20_000.0)
    slip_release: float = quantity("N*m/s", 0, 1e5, "at which the engine gets it back", default=200.0)


class DampingGear(Record):
    """What the step needs of one gear."""

    observer: DrivelineObserver = nested(DrivelineObserver, "observer of the driveline")
    gradient: FloatArray = quantity(
        "1", -1e12, 1e12, "gradient of the programme per number of the past", shape=(MOVES, PAST)
    )
    feed_forward: FloatArray = quantity(
        "1", -1e12, 1e12, "torque of the motor that the shaped request needs, per number of the past from the 6th on",
        shape=(MOVES, ASKED),
    )  # fmt: skip
    ratio: float = quantity("1", 0, 2500, "motor speed over wheel speed")
    clutch_twist: float = quantity("rad/(N*m)", 0, 1e3, "twist of the clutch per torque of the engine")
    halfshaft_twist: float = quantity("rad/(N*m)", 0, 1e3, "twist of the half-shafts per torque at the gearbox")
    open_twist_speed: float = quantity(
        "rad/(N*m)", 0, 1e3, "torsional speed per change rate of the motor's torque, the clutch open"
    )
    matrices: Qp10x20Matrices = nested(Qp10x20Matrices, "rows: torques, changes; factorised")


class DampingMpcParameters(Record):
    """What the step reads."""

    calibration: DampingMpcCalibration = nested(DampingMpcCalibration, "what an engineer tunes")
    moves: int = count(1, MOVES, "moves in use")
    shaping_share: float = quantity("1", 0, 1, "of a step that each filter answers per step")
    shaping_time: float = quantity("s", 0, 2, "time constant of each filter; 0 for none")
    motor_share: float = quantity("1", 0, 1, "of a step that the motor answers per step")
    motor_delay: int = count(0, 5, "dead time of the motor that it begins with, steps")
    torque_limit: float = quantity("N*m", 0, 5000, "highest torque of the motor")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the motor's command")
    wheel_radius: float = quantity("m", 0.1, 1.5, "of the driven wheels")
    engine_torque_limit: float = quantity("N*m", 0, 5000, "highest torque of the engine")
    rolling_torque: float = quantity("N*m", 0, 1e5, "resistance that the observer begins with")
    gear: RecordElements[DampingGear] = nested(DampingGear, "the gears, 1st first", shape=(GEARS,))


class DampingMpcState(Record):
    """Memory between two steps."""

    gear: int = count(0, GEARS, "gear of the estimate; 0 for none")
    motor_command: float = quantity("N*m", -5000, 5000, "commanded torque of the motor")
    engine_request: float = quantity("N*m", -5000, 5000, "torque that the engine was asked for")
    taken_away: float = quantity("N*m", 0, 10_000, "torque of the engine that the slip has cost")
    shaped: ShapedTorque = nested(ShapedTorque, "the driver's torque, shaped")
    engine_shaped: ShapedTorque = nested(ShapedTorque, "the engine's share, shaped")
    motor: MotorDelayState = nested(MotorDelayState, "dead time of the motor")
    driveline: DrivelineEstimate = nested(DrivelineEstimate, "observed driveline")


class DampingMpcMeasurement(Record):
    """What it sees."""

    engine_torque_base: float = quantity("N*m", -5000, 5000, "the engine's share of what the driver asks for")
    motor_torque_base: float = quantity("N*m", -5000, 5000, "the motor's share")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of the clutch; 0: open")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    motor_speed: float = quantity("rad/s", -2000, 2000, "motor speed")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle; positive forwards")
    motor_torque: float = quantity("N*m", -5000, 5000, "torque of the motor, as its inverter tells it")
    motor_torque_limit: float = quantity("N*m", 0, 5000, "torque that the motor can give now, either way")
    gear: float = quantity("1", 0, GEARS, "gear; 0 while shifting")


class DampingMpcCommand(Record):
    """What it commands, and what it thinks."""

    engine_torque_request: float = quantity("N*m", -5000, 5000, "torque asked of the engine")
    motor_torque_command: float = quantity("N*m", -5000, 5000, "torque commanded to the motor")
    correction_torque: float = quantity("N*m", -10_000, 10_000, "what of it is not the motor's share: it damps")
    shaped_torque: float = quantity("N*m", -10_000, 10_000, "torque at the gearbox that is aimed at")
    torsional_speed_estimate: float = quantity("rad/s", -1e5, 1e5, "observed torsional speed")
    road_torque_estimate: float = quantity("N*m", -1e6, 1e6, "observed resistance at the wheels")
    motor_delay_estimate: float = quantity("s", 0, 1, "observed dead time of the motor")
    solver_status: float = quantity("1", 0, 4, "of the quadratic programme: 0 solved; else no damping")


class DampingMpcWork(Record):
    """Scratch: what the future follows from, and the programme of a step."""

    engine: float = quantity("N*m", -5000, 5000, "what the engine is to be asked for, the slip reckoned with")
    limit: float = quantity("N*m", 0, 5000, "torque that the motor can give now")
    past: FloatArray = quantity("1", -1e12, 1e12, "numbers that the future follows from", shape=(PAST,))
    ahead: DrivelineEstimate = nested(DrivelineEstimate, "driveline when the command will act")
    next: DrivelineEstimate = nested(DrivelineEstimate, "scratch of the prediction")
    feed_forward: FloatArray = quantity("N*m", -1e12, 1e12, "torque that the shaped request needs", shape=(MOVES,))
    data: Qp10x20Data = nested(Qp10x20Data, "the programme of this step")
    work: Qp10x20Work = nested(Qp10x20Work, "scratch")
    solution: Qp10x20Solution = nested(Qp10x20Solution, "the result")
