"""Launch by data-driven predictive control of the clutch torque [1, sec. 2.2]: four moves, an exact programme.

The engine is held at a target speed by a PID on the throttle rate, as in `launch_pid`. The clutch torque is what a
linear difference model, identified from logs or derived from the vehicle, says will let the slip decay:

    minimise  sum_i (slip(k+i) - beta^i slip(k))^2 + rho sum_j du(k+j)^2,   i = 1..4,  j = 0..3,   beta = 1 - D1

subject to limits of the clutch torque, of its rate, and of the engine speed. D1 follows from the launch intention.
Where no moves keep the engine speed within its limits, the limit gives way to what opening the clutch at its fastest
reaches, so that this is always an answer, and the programme always has one. Over four steps that is little: a heavier
vehicle on a hill still pulls the engine down. `limit_horizon` looks further ahead for this limit alone, at four times
in as many rows; the clutch torque then stays after its four moves.

The model sees the slip of the wheels, engine speed - ratio * wheel speed: that of the driven plate carries the
oscillation of the shafts, which no model of this order holds.

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014; eqs. 5 to 7 with their signs mended.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

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
from bitepoint.controllers.prediction import predict
from bitepoint.errors import InputError
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.models.arx import ArxModel
from bitepoint.models.launch import DISTURBANCES, INPUTS, OUTPUTS, LaunchModel
from bitepoint.numerics.qp import qp_solver
from bitepoint.numerics.qp_records import SOLVED
from bitepoint.numerics.tables import lookup
from bitepoint.parts.engine import Engine, engine_torque, throttle_effect
from bitepoint.recording import Floats
from bitepoint.records import Curve, FloatArray, Record, RecordArray, count, curve, nested, quantity

MOVES = 4
"""Prediction and control horizon, steps [1]."""

MOST_STEPS = 100
"""Longest horizon of the limits of the engine speed."""

DEPTH = 3
"""Rows of the past that a prediction takes: the highest order of a model."""

PAST = DEPTH * 2 + (DEPTH - 1) + DEPTH * 2

SOLVER = qp_solver(MOVES, 3 * MOVES)
solve = SOLVER.solve
if TYPE_CHECKING:
    from bitepoint.numerics.qp_records import QpData as Qp4x12Data
    from bitepoint.numerics.qp_records import QpMatrices as Qp4x12Matrices
    from bitepoint.numerics.qp_records import QpSolution as Qp4x12Solution
    from bitepoint.numerics.qp_records import QpWork as Qp4x12Work
else:
    Qp4x12Matrices, Qp4x12Data, Qp4x12Work, Qp4x12Solution = SOLVER.matrices, SOLVER.data, SOLVER.work, SOLVER.solution

_PEDAL = ("pedal", "1", 0.0, 1.0)


class DdpcCalibration(Record):
    """What an engineer tunes; curves are over the pedal."""

    engine_target: Curve = curve(_PEDAL, ("speed", "rad/s", 20, 1000), "engine speed to hold")
    target_rise_time: float = quantity("s", 0.01, 10, "time in which the target rises from idle speed")
    slip_decay: Curve = curve(
        _PEDAL, ("decay", "1", 0, 0.99), "D1, share of the slip to be removed in a step, where no block gives it"
    )
    move_weight: float = quantity("rad^2/s^2/N^2/m^2", 1e-6, 1e6, "rho, weight of a move against an error of the slip")
    limit_horizon: int = count(
        0, MOST_STEPS, "steps over which the limits of the engine speed are foreseen; 0: there are none", default=MOVES
    )
    touch_delay: float = quantity("s", 0, 5, "time from pedal onset until the clutch touches")
    closing_slip: float = quantity("rad/s", 0.01, 100, "slip below which the clutch closes")
    closing_rate: float = quantity("N*m/s", 1, 1e5, "how fast it closes")
    handover_rate: float = quantity("1/s", 0.01, 100, "how fast the throttle then goes to the pedal")
    pedal_threshold: float = quantity("1", 0.001, 0.2, "pedal above which the driver wants to move off", default=0.01)
    engine_speed: EngineSpeedCalibration = nested(EngineSpeedCalibration, "PID on the throttle rate")


class DdpcParameters(Record):
    """What the step reads."""

    calibration: DdpcCalibration = nested(DdpcCalibration, "what an engineer tunes")
    engine: Engine = nested(Engine, "the engine, whose torque is a measured disturbance")
    ratio: float = quantity("1", 0.1, 2500, "engine side speed over wheel speed")
    idle_throttle: float = quantity("1", 0, 1, "throttle that holds the idle speed, clutch open")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest clutch torque")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the clutch torque")
    gradient: FloatArray = quantity(
        "1", -1e12, 1e12, "gradient of the programme per slip that is to go after each step", shape=(MOVES, MOVES)
    )
    free_slip: FloatArray = quantity(
        "1", -1e12, 1e12, "slip after each step per number of the past", shape=(MOVES, PAST)
    )
    free_engine: FloatArray = quantity(
        "1", -1e12, 1e12, "engine speed where it is limited, per number of the past", shape=(MOVES, PAST)
    )
    matrices: Qp4x12Matrices = nested(Qp4x12Matrices, "rows: moves, clutch torques, engine speeds; factorised")


class DdpcState(Record):
    """Memory between two steps."""

    phase: int = count(0, 3, "phase of the launch", names=PHASES)
    known: int = count(0, 1, "1 once there is a past")
    time: float = quantity("s", 0, 1e9, "time since pedal onset")
    clutch_torque: float = quantity("N*m", 0, 10_000, "commanded clutch torque")
    engine_speed_before: float = quantity("rad/s", -2000, 2000, "engine speed of the last step")
    slip_before: float = quantity("rad/s", -4000, 4000, "slip of the last step")
    engine_torque_before: float = quantity("N*m", -10_000, 10_000, "engine torque of the last step")
    past: FloatArray = quantity(
        "1", -1e6, 1e6, "changes: engine speed and slip, clutch torque, engine torque and load", shape=(PAST,)
    )
    engine_speed: EngineSpeedState = nested(EngineSpeedState, "engine-speed control")


class DdpcMeasurement(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "speed of the driven plate of clutch 1")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    slip_decay: float = quantity("1", 0, 0.99, "D1 by the block of the launch intention; 0 for none: by the pedal")


class DdpcCommand(Record):
    """What it commands, and what it thinks."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of clutch 1")
    engine_speed_target: float = quantity("rad/s", 0, 2000, "engine speed to hold")
    launch_phase: float = quantity("1", 0, 3, "phase of the launch", names=PHASES)
    solver_status: float = quantity("1", 0, 4, "of the quadratic programme: 0 solved; else the clutch torque stays")


class DdpcWork(Record):
    """The programme of a step."""

    safest: FloatArray = quantity("N*m", -1e6, 0, "moves that open the clutch as fast as it can", shape=(MOVES,))
    data: Qp4x12Data = nested(Qp4x12Data, "the programme of this step")
    work: Qp4x12Work = nested(Qp4x12Work, "scratch")
    solution: Qp4x12Solution = nested(Qp4x12Solution, "the result")


@kernel
def remember(s: DdpcState, engine_speed: float, slip: float, torque: float) -> None:
    """Take new measurements into the past: speeds in rad/s, engine torque in N m."""
    for n in range(DEPTH - 1, 0, -1):
        for m in range(2):
            s.past[2 * n + m] = s.past[2 * n + m - 2]
            s.past[3 * DEPTH - 1 + 2 * n + m] = s.past[3 * DEPTH - 3 + 2 * n + m]
    if s.known == 1:
        s.past[0] = engine_speed - s.engine_speed_before
        s.past[1] = slip - s.slip_before
        s.past[3 * DEPTH - 1] = torque - s.engine_torque_before
    s.engine_speed_before = engine_speed
    s.slip_before = slip
    s.engine_torque_before = torque
    s.known = 1


@kernel
def remember_move(s: DdpcState, torque: float) -> None:
    """Command a clutch torque, N m, and take its change into the past."""
    for n in range(DEPTH - 2, 0, -1):
        s.past[2 * DEPTH + n] = s.past[2 * DEPTH + n - 1]
    s.past[2 * DEPTH] = torque - s.clutch_torque
    s.clutch_torque = torque


@kernel
def forget(s: DdpcState) -> None:
    """Begin without a past."""
    s.known = 0
    for n in range(PAST):
        s.past[n] = 0.0


@kernel
def state_programme(p: DdpcParameters, s: DdpcState, w: DdpcWork, decay: float, dt: float) -> None:
    """Write the programme of this step: the slip is to decay by the share `decay` per step."""
    left = s.slip_before
    torque = s.clutch_torque
    for j in range(MOVES):
        w.data.gradient[j] = 0.0
        w.safest[j] = -min(p.rate_limit * dt, torque)
        torque = max(torque + w.safest[j], 0.0)
    for i in range(MOVES):
        slip = s.slip_before
        speed = s.engine_speed_before
        for n in range(PAST):
            slip += p.free_slip[i, n] * s.past[n]
            speed += p.free_engine[i, n] * s.past[n]
        left = left * (1.0 - decay)
        for j in range(MOVES):
            w.data.gradient[j] += p.gradient[j, i] * (left - slip)
        w.data.low[i] = -p.rate_limit * dt
        w.data.high[i] = p.rate_limit * dt
        w.data.low[MOVES + i] = -s.clutch_torque
        w.data.high[MOVES + i] = p.torque_limit - s.clutch_torque
        reached = 0.0
        for j in range(MOVES):
            reached += p.matrices.constraints[2 * MOVES + i, j] * w.safest[j]
        w.data.low[2 * MOVES + i] = min(p.engine.idle_speed - speed, reached)
        w.data.high[2 * MOVES + i] = max(p.engine.speed_limit - speed, reached)


@kernel
def first_move(p: DdpcParameters, s: DdpcState, w: DdpcWork) -> int:
    """Solve the programme; the first of its moves, N m, is `w.solution.x[0]`. Return the status."""
    return solve(p.matrices, w.data, w.work, w.solution)


@kernel
def slipping_torque(
    p: DdpcParameters, s: DdpcState, c: DdpcCommand, w: DdpcWork, pedal: float, decay: float, dt: float
) -> float:
    """Return the clutch torque while slipping, N m."""
    torque = 0.0
    if s.time >= p.calibration.touch_delay:
        share = decay if decay > 0.0 else lookup(p.calibration.slip_decay, pedal)
        state_programme(p, s, w, clamp(share, 0.0, 0.99), dt)
        status = first_move(p, s, w)
        c.solver_status = float(status)
        # never: else, with a solver that always has an answer
        torque = s.clutch_torque + w.solution.x[0] if status == SOLVED else s.clutch_torque
    return torque


@kernel
def init(p: DdpcParameters, s: DdpcState, m: DdpcMeasurement, c: DdpcCommand, w: DdpcWork) -> None:
    """Wait with the clutch open and the engine idling."""
    s.phase = WAITING
    s.time = 0.0
    s.clutch_torque = 0.0
    s.engine_speed_before = 0.0
    s.slip_before = 0.0
    s.engine_torque_before = 0.0
    forget(s)
    engine_speed_reset(s.engine_speed, p.idle_throttle)
    c.throttle = p.idle_throttle
    c.clutch_torque_command = 0.0
    c.engine_speed_target = p.engine.idle_speed
    c.launch_phase = 0.0
    c.solver_status = 0.0


@kernel
def step(p: DdpcParameters, s: DdpcState, m: DdpcMeasurement, c: DdpcCommand, w: DdpcWork, dt: float) -> int:
    """Command throttle and clutch for the next dt (s); return 0, or 1 where a measurement is no number.

    A measurement that is no number leaves the commands as they are.
    """
    status = 1
    speeds = m.engine_speed + m.clutch_speed + m.wheel_speed
    if is_finite(m.pedal) and is_finite(speeds) and is_finite(m.slip_decay):
        status = 0
        pedal = clamp(m.pedal, 0.0, 1.0)
        speed = clamp(m.engine_speed, -2000.0, 2000.0)
        plate = clamp(m.clutch_speed, -2000.0, 2000.0)
        effect = throttle_effect(p.engine, s.engine_speed.throttle)
        wheel = clamp(p.ratio * m.wheel_speed, -2000.0, 2000.0)
        remember(s, speed, speed - wheel, engine_torque(p.engine, effect, speed))
        contact = s.time - p.calibration.touch_delay
        gap = speed - plate if s.phase != SLIPPING else s.slip_before
        s.phase = phase_after(s.phase, pedal - p.calibration.pedal_threshold, contact, gap, p.calibration.closing_slip)
        risen = clamp(s.time / p.calibration.target_rise_time, 0.0, 1.0)
        target = p.engine.idle_speed + risen * (lookup(p.calibration.engine_target, pedal) - p.engine.idle_speed)
        c.solver_status = 0.0
        torque = 0.0
        if s.phase == WAITING:
            s.time = 0.0
            target = p.engine.idle_speed
        elif s.phase == SLIPPING:
            torque = slipping_torque(p, s, c, w, pedal, m.slip_decay, dt)
            s.time = s.time + dt
        else:
            torque = s.clutch_torque + p.calibration.closing_rate * dt
        change = p.rate_limit * dt
        torque = clamp(torque, s.clutch_torque - change, s.clutch_torque + change)
        remember_move(s, clamp(torque, 0.0, p.torque_limit))
        if s.phase == DRIVING:
            c.throttle = engine_speed_hand_over(s.engine_speed, pedal, p.calibration.handover_rate * dt)
        else:
            c.throttle = engine_speed_step(p.calibration.engine_speed, s.engine_speed, target, speed, dt)
        c.clutch_torque_command = s.clutch_torque
        c.engine_speed_target = target
        c.launch_phase = float(s.phase)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle on its reduced launch model, one record per calibration."""
    return design_on(vehicle, calibration, LaunchModel.of(vehicle).arx(CONTROLLER.period))


def design_on(vehicle: RecordArray, calibration: RecordArray, model: ArxModel) -> RecordArray:
    """Return the parameters on a given model of the launch, one record per calibration.

    Raises:
        InputError: another period, other signals, or a higher order than the controller takes.
    """
    _check(model)
    parameters = DdpcParameters.zeros(len(calibration))
    engine, clutch, launch = vehicle["engine"], vehicle["clutch"], LaunchModel.of(vehicle)
    parameters["calibration"], parameters["engine"] = calibration, engine
    parameters["ratio"] = launch.ratio
    parameters["idle_throttle"] = idle_throttle(engine)
    parameters["torque_limit"], parameters["rate_limit"] = clutch["torque_limit"], clutch["torque_rate_limit"]
    (_, slip_response), (_, parameters["free_slip"]) = predict(model, MOVES, DEPTH)
    parameters["gradient"] = -slip_response.T
    engine_response, parameters["free_engine"] = _engine_rows(model, calibration["limit_horizon"])
    matrices = SOLVER.matrices.zeros(len(calibration))
    matrices["variables"], matrices["rows"] = MOVES, 3 * MOVES
    weights = calibration["move_weight"][:, np.newaxis, np.newaxis] * np.eye(MOVES)
    matrices["hessian"] = slip_response.T @ slip_response + weights
    matrices["constraints"][:, : 2 * MOVES] = np.vstack([np.eye(MOVES), np.tril(np.ones((MOVES, MOVES)))])
    matrices["constraints"][:, 2 * MOVES :] = engine_response
    if SOLVER.factorise.run(matrices, life="interpreted").any():
        raise InputError("model", "its predictions overflow", "identify it anew, or raise controller.move_weight")
    parameters["matrices"] = matrices
    return parameters


def _engine_rows(model: ArxModel, horizons: npt.NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return how the engine speed at four times follows from moves and past, (n, MOVES, MOVES) and (n, MOVES, PAST)."""
    response, free = predict(model, max(int(horizons.max()), MOVES), DEPTH)
    steps = np.ceil(horizons[:, np.newaxis] * np.arange(1, MOVES + 1) / MOVES).astype(int)
    there = (steps > 0)[:, :, np.newaxis]
    return response[0][steps - 1][:, :, :MOVES] * there, free[0][steps - 1] * there


def _check(model: ArxModel) -> None:
    for what, found, expected in (
        ("outputs", model.outputs, OUTPUTS), ("inputs", model.inputs, INPUTS),
        ("disturbances", model.disturbances, DISTURBANCES),
    ):  # fmt: skip
        if found != expected:
            raise InputError("model", f"{what}: {', '.join(found)}", f"expected {', '.join(expected)}")
    if abs(model.period - CONTROLLER.period) > 1e-9:
        mend = f"expected {CONTROLLER.period} s, the period of the controller"
        raise InputError("model", f"has a period of {model.period:g} s", mend)
    orders = dict(zip(("n_a", "n_b", "n_g"), model.orders, strict=False))
    for name, order in orders.items():
        most = DEPTH - 1 if name == "n_b" else DEPTH
        if order > most:
            raise InputError("model", f"has order {name} = {order}", f"expected at most {most}, see identify --orders")


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    return library_yaml("controllers", "ddpc.yaml")


CONTROLLER = Controller(
    name="ddpc",
    meaning="constant engine speed by PID, clutch torque by predictive control on an identified or a physical model",
    plants=("dct",),
    calibration=DdpcCalibration,
    calibrations=calibrations,
    default_calibration="paper",
    parameters=DdpcParameters,
    state=DdpcState,
    measurement=DdpcMeasurement,
    command=DdpcCommand,
    design=design,
    init=init,
    step=step,
    work=DdpcWork,
    design_on=design_on,
)
