"""Records of the controller `launch_mpc`; what is done with them stands there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bitepoint.controllers.launch_phase import PHASES
from bitepoint.estimation.engine_torque import EngineObserver, EngineObserverState
from bitepoint.estimation.road_torque import RoadObserver, RoadObserverState
from bitepoint.numerics.qp import qp_solver
from bitepoint.parts.engine import Engine
from bitepoint.records import Curve, FloatArray, Record, count, curve, nested, quantity

STEPS = 10
"""Steps of the prediction."""

STEP = 0.02
"""Length of one, s."""

SEGMENTS = 3
"""Segments over which each torque changes at a constant rate."""

ENDS = (1, 4, 10)
"""Steps at whose end the segments end."""

MOVES = 2 * SEGMENTS
ROWS = 5 * SEGMENTS

SOLVER = qp_solver(MOVES, ROWS)
solve = SOLVER.solve
if TYPE_CHECKING:
    from bitepoint.numerics.qp_records import QpData as Qp6x15Data
    from bitepoint.numerics.qp_records import QpMatrices as Qp6x15Matrices
    from bitepoint.numerics.qp_records import QpSolution as Qp6x15Solution
    from bitepoint.numerics.qp_records import QpWork as Qp6x15Work
else:
    Qp6x15Matrices, Qp6x15Data, Qp6x15Work, Qp6x15Solution = SOLVER.matrices, SOLVER.data, SOLVER.work, SOLVER.solution

_PEDAL = ("pedal", "1", 0.0, 1.0)
_ANY = 1e12


class LaunchMpcCalibration(Record):
    """What an engineer tunes; curves are over the pedal."""

    acceleration: Curve = curve(_PEDAL, ("acceleration", "m/s^2", 0.1, 10), "acceleration to launch with")
    jerk: Curve = curve(_PEDAL, ("jerk", "m/s^3", 0.1, 100), "jerk at which the clutch torque may change")
    jerk_on_load: float = quantity(
        "1/(N*m)",
        0,
        1,
        "share by which the jerk may be higher per clutch torque above 20 N m that holds the vehicle",
        default=0.0,
    )
    engine_target: Curve = curve(_PEDAL, ("speed", "rad/s", 20, 1000), "lowest engine speed to launch at")
    engine_ceiling: Curve = curve(_PEDAL, ("speed", "rad/s", 20, 1000), "highest engine speed to launch at")
    reserve: float = quantity(
        "1", 0, 2, "share of the torque needed at sync that the engine must be able to give at its target"
    )
    target_rate: float = quantity("rad/s^2", 1, 1e4, "how fast the target speed rises")
    stall_speed: float = quantity("rad/s", 0, 1000, "engine speed that the prediction keeps, if anything can")
    held_share: float = quantity(
        "1", 0, 0.95, "share of the torque that holds the vehicle up to which the clutch closes at its fastest"
    )
    landing_time: float = quantity("s", 0.001, 1, "time in which the engine takes up the vehicle's acceleration")
    landing_slip: float = quantity("rad/s", 0, 50, "how far before its end the landing aims through zero slip")
    torque_weight: float = quantity(
        "rad^2/s^2/N^2/m^2", 1e-6, 1e6, "weight of an error of the clutch torque against one of the slip"
    )
    clutch_rate_weight: float = quantity("rad^2/N^2/m^2", 1e-12, 1e3, "weight of the rate of the clutch torque")
    engine_rate_weight: float = quantity("rad^2/N^2/m^2", 1e-12, 1e3, "weight of the rate of the engine torque")
    engine_rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the engine torque")
    settling_share: Curve = curve(
        _PEDAL, ("share", "1", 0.01, 2), "share of the jerk at which the engine then goes to the pedal's torque"
    )
    closing_rate: float = quantity("N*m/s", 1, 1e5, "how fast the clutch closes after sync")
    idle_gain: float = quantity("N*m*s/rad", 0, 100, "engine torque per error of the idle speed", default=0.5)
    pedal_threshold: float = quantity("1", 0.001, 0.2, "pedal above which the driver wants to move off", default=0.01)


class LaunchMpcParameters(Record):
    """What the step reads."""

    calibration: LaunchMpcCalibration = nested(LaunchMpcCalibration, "what an engineer tunes")
    engine: Engine = nested(Engine, "the engine, whose map is inverted")
    road: RoadObserver = nested(RoadObserver, "observer of the road torque")
    torque: EngineObserver = nested(EngineObserver, "observer of the engine torque and its lag")
    inertia: float = quantity("kg*m^2", 1e-4, 1e4, "of all behind the clutch, at the clutch")
    metres_per_radian: float = quantity("m", 1e-5, 10, "vehicle speed over clutch speed")
    rolling_torque: float = quantity("N*m", 0, 1e6, "rolling resistance at the wheels")
    weight_radius: float = quantity("kg*m", 1, 1e5, "mass times wheel radius: road torque per gravity along the road")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest clutch torque")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the clutch torque")
    lengths: FloatArray = quantity("s", 1e-3, 10, "length of each segment", shape=(SEGMENTS,))
    risen: FloatArray = quantity("s", 0, 10, "torque after each step per rate", shape=(STEPS, SEGMENTS))
    slip: FloatArray = quantity("rad/N/m", -_ANY, _ANY, "slip after each step per rate", shape=(STEPS, MOVES))
    speed: FloatArray = quantity(
        "rad/N/m", -_ANY, _ANY, "engine speed at the end of each segment per rate", shape=(SEGMENTS, MOVES)
    )
    matrices: Qp6x15Matrices = nested(
        Qp6x15Matrices, "rows: rates of clutch and engine, torques of both, engine speeds; factorised"
    )


class LaunchMpcState(Record):
    """Memory between two steps."""

    phase: int = count(0, 3, "phase of the launch", names=PHASES)
    target: float = quantity("rad/s", 0, 2000, "engine speed to launch at")
    hold: float = quantity("N*m", -1e6, 1e6, "clutch torque that held the vehicle at standstill")
    clutch_torque: float = quantity("N*m", 0, 10_000, "commanded clutch torque")
    engine_torque: float = quantity("N*m", -10_000, 10_000, "commanded engine torque")
    road: RoadObserverState = nested(RoadObserverState, "observer of the road torque")
    torque: EngineObserverState = nested(EngineObserverState, "observer of the engine torque and its lag")


class LaunchMpcMeasurement(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "speed of the driven plate of clutch 1")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    longitudinal_acceleration: float = quantity(
        "m/s^2", -100, 100, "what an accelerometer shows along the road: acceleration, and gravity on a grade"
    )


class LaunchMpcCommand(Record):
    """What it commands, and what it thinks."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of clutch 1")
    engine_speed_target: float = quantity("rad/s", 0, 2000, "engine speed to launch at")
    launch_phase: float = quantity("1", 0, 3, "phase of the launch", names=PHASES)
    road_torque_estimate: float = quantity("N*m", -1e9, 1e9, "road torque that it estimates")
    engine_lag_estimate: float = quantity("s", 0, 5, "lag of the engine that it estimates")
    solver_status: float = quantity("1", 0, 4, "of the quadratic programme: 0 solved; else the safest rates are taken")


class LaunchMpcWork(Record):
    """The programme of a step, and what it is made from."""

    goal: float = quantity("N*m", -_ANY, _ANY, "clutch torque to rise to")
    rate: float = quantity("N*m/s", 0, _ANY, "fastest change of the clutch torque")
    half: float = quantity("rad/s", 0, _ANY, "half of the speed over which the landing goes")
    low: FloatArray = quantity("N*m/s", -_ANY, _ANY, "lowest rate of the engine torque by segment", shape=(SEGMENTS,))
    high: FloatArray = quantity("N*m/s", -_ANY, _ANY, "highest rate of the engine torque by segment", shape=(SEGMENTS,))
    safest: FloatArray = quantity(
        "N*m/s", -_ANY, _ANY, "rates that keep the engine from stalling as well as any", shape=(MOVES,)
    )
    data: Qp6x15Data = nested(Qp6x15Data, "the programme of this step")
    work: Qp6x15Work = nested(Qp6x15Work, "scratch")
    solution: Qp6x15Solution = nested(Qp6x15Solution, "the result")
