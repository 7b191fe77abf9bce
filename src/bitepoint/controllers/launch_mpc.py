"""Launch by predictive control of clutch and engine torque together, over 0.2 s, free of offset.

The clutch torque rises at the rate that the wanted jerk allows to what the wanted acceleration needs on this road; the
engine holds a target speed, and when the vehicle comes near, takes up its acceleration, so that both meet with equal
speed and equal acceleration: the torque then passes from the slipping to the locked clutch without a step. A quadratic
programme over the rates of both torques, each constant over three segments,

    minimise  sum_n (slip_n - aim_n)^2 + q sum_n (Tc_n - plan_n)^2 + sum_m r_c rate_cm^2 + r_e rate_em^2

subject to limits of rates and torques, and engine speed >= stall speed. Where no rates could keep that speed, the limit
gives way to what the safest rates reach (clutch opened and engine raised as fast as can be), so that these are always
an answer and the programme always has one.

- Load: an observer tells the road torque; before the vehicle moves, its prior comes from an accelerometer.
- Engine: observers with several lags tell its torque, its error and its lag. The programme plans the torque that the
  engine is to have; the command leads it by lag * rate.
- Target speed: the lowest of its range at which the engine could give what will be needed at sync.
- Until it moves, a vehicle on a hill is not jerked by a clutch torque, which therefore rises at its fastest up to a
  share of what holds the vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from bitepoint.controllers.controller import Controller
from bitepoint.controllers.launch_mpc_design import PERIOD, design, design_on
from bitepoint.controllers.launch_mpc_records import (
    MOVES,
    SEGMENTS,
    STEP,
    STEPS,
    LaunchMpcCalibration,
    LaunchMpcCommand,
    LaunchMpcMeasurement,
    LaunchMpcParameters,
    LaunchMpcState,
    LaunchMpcWork,
    solve,
)
from bitepoint.controllers.launch_phase import DRIVING, SLIPPING, WAITING, phase_after
from bitepoint.estimation.engine_torque import engine_observer_reset, engine_observer_step
from bitepoint.estimation.road_torque import observer_reset, observer_step
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.numerics.qp_records import SOLVED
from bitepoint.numerics.tables import lookup
from bitepoint.parts.engine import engine_drag, engine_torque, full_load_torque, throttle_effect, throttle_for

SPEEDS = 16
"""Target speeds that are tried."""

STEEP = 20.0
"""Clutch torque that holds the vehicle above which the road counts as a hill, N m (chosen: 5 % for a car)."""

THROUGH = -0.5
"""Slip that the end of a landing aims at, rad/s: through zero, gently (chosen)."""

CLOSED = 0.1
"""Slip below which engine and clutch turn as one, rad/s (chosen)."""

LEAST_LAG = 1e-3
"""Lag below which the engine counts as without, s."""


@kernel
def hold_torque(p: LaunchMpcParameters, s: LaunchMpcState) -> float:
    """Return the clutch torque, N m, that balances the road."""
    return s.road.road_torque / (p.road.ratio * p.road.efficiency)


@kernel
def observe(p: LaunchMpcParameters, s: LaunchMpcState, m: LaunchMpcMeasurement) -> None:
    """Bring the estimates up to date with measurements that are finite."""
    engine_observer_step(p.torque, s.torque, s.engine_torque, s.clutch_torque, m.engine_speed)
    if s.road.moving == 0:
        gravity = clamp(m.longitudinal_acceleration, -10.0, 10.0)
        s.road.road_torque = p.rolling_torque + p.weight_radius * gravity
        s.hold = hold_torque(p, s)
    wheel = clamp(m.wheel_speed, -500.0, 500.0)
    engine = s.torque.mean_torque + s.torque.mean_error
    road = observer_step(p.road, s.road, m.engine_speed, wheel, s.clutch_torque, engine)
    if s.phase < DRIVING:
        s.road.road_torque = max(road, 0.0)


@kernel
def choose_target(p: LaunchMpcParameters, s: LaunchMpcState, pedal: float, need: float, dt: float) -> float:
    """Return the engine speed, rad/s, to launch at: the lowest that offers `need` (N m); the state follows slowly."""
    low = lookup(p.calibration.engine_target, pedal)
    high = max(lookup(p.calibration.engine_ceiling, pedal), low)
    chosen = high
    for n in range(SPEEDS):
        speed = low + (high - low) * (float(n) / (SPEEDS - 1.0))
        if full_load_torque(p.engine, speed) >= need:
            chosen = speed
            break
    change = p.calibration.target_rate * dt
    s.target = clamp(clamp(chosen, s.target - change, s.target + change), 0.0, 2000.0)
    return chosen


@kernel
def limit_rates(p: LaunchMpcParameters, s: LaunchMpcState, w: LaunchMpcWork) -> None:
    """Write the limits of rates and torques, and the safest rates within them."""
    speed = max(s.torque.mean_speed, p.engine.idle_speed)
    torque = s.torque.mean_torque
    highest = max(full_load_torque(p.engine, speed), torque)
    lowest = min(-engine_drag(p.engine, speed), torque)
    lag = max(s.torque.mean_lag, LEAST_LAG)
    clutch = s.clutch_torque
    for k in range(SEGMENTS):
        w.high[k] = p.calibration.engine_rate_limit
        w.low[k] = -p.calibration.engine_rate_limit
        if k == 0:
            w.high[k] = min(w.high[k], (highest - s.torque.mean_torque) / lag)
            w.low[k] = max(w.low[k], (lowest - s.torque.mean_torque) / lag)
        w.safest[k] = -min(w.rate, clutch / p.lengths[k])
        clutch = max(clutch + w.safest[k] * p.lengths[k], 0.0)
        w.safest[SEGMENTS + k] = max(min(w.high[k], (highest - torque) / p.lengths[k]), 0.0)
        torque = torque + w.safest[SEGMENTS + k] * p.lengths[k]
        w.data.low[k] = -w.rate
        w.data.high[k] = w.rate
        w.data.low[SEGMENTS + k] = w.low[k]
        w.data.high[SEGMENTS + k] = w.high[k]
        w.data.low[2 * SEGMENTS + k] = -s.clutch_torque
        w.data.high[2 * SEGMENTS + k] = max(p.torque_limit - s.clutch_torque, 0.0)
        w.data.low[3 * SEGMENTS + k] = lowest - s.torque.mean_torque
        w.data.high[3 * SEGMENTS + k] = highest - s.torque.mean_torque


@kernel
def limit_speeds(p: LaunchMpcParameters, s: LaunchMpcState, w: LaunchMpcWork, acceleration: float) -> None:
    """Write the limits of the engine speed; `acceleration` is the engine's with torques as they are, rad/s^2."""
    time = 0.0
    for k in range(SEGMENTS):
        time = time + p.lengths[k]
        free = s.torque.mean_speed + acceleration * time
        reached = 0.0
        for j in range(MOVES):
            reached += p.speed[k, j] * w.safest[j]
        w.data.low[4 * SEGMENTS + k] = min(p.calibration.stall_speed - free, reached)
        w.data.high[4 * SEGMENTS + k] = max(p.engine.speed_limit - free, reached)


@kernel
def landing(w: LaunchMpcWork, gap: float, lead: float) -> float:
    """Return the slip to aim at, rad/s, from target speed minus vehicle speed: a parabola leads into zero slip."""
    slip = 0.0
    if gap >= w.half:
        slip = gap
    elif gap > -w.half:
        slip = (gap + w.half) ** 2 / (4.0 * w.half)
    return min(slip, THROUGH) if gap <= lead - w.half else slip


@kernel
def state_aims(
    p: LaunchMpcParameters, s: LaunchMpcState, w: LaunchMpcWork, chosen: float, plate: float, acceleration: float
) -> None:
    """Write the gradient: of errors that torques as they are would leave.

    Args:
        chosen: engine speed to launch at in the end, plate: clutch speed, rad/s.
        acceleration: of the engine with torques as they are, rad/s^2.
    """
    for j in range(MOVES):
        w.data.gradient[j] = 0.0
    road = s.road.road_torque / p.road.ratio
    vehicle = (p.road.efficiency * s.clutch_torque - road) / p.inertia if s.road.moving == 1 else 0.0
    planned = s.clutch_torque
    speed = plate
    for n in range(STEPS):
        time = STEP * (float(n) + 1.0)
        before = planned
        planned = s.clutch_torque + clamp(w.goal - s.clutch_torque, -w.rate * time, w.rate * time)
        gain = (p.road.efficiency * 0.5 * (before + planned) - road) / p.inertia
        speed = speed + STEP * (gain if s.road.moving == 1 else max(gain, 0.0))
        target = s.target + clamp(chosen - s.target, 0.0, p.calibration.target_rate * time)
        free = s.torque.mean_speed - plate + (acceleration - vehicle) * time
        error = free - landing(w, target - speed, p.calibration.landing_slip)
        lack = p.calibration.torque_weight * (s.clutch_torque - planned)
        for j in range(MOVES):
            w.data.gradient[j] += p.slip[n, j] * error
        for j in range(SEGMENTS):
            w.data.gradient[j] += p.risen[n, j] * lack


@kernel
def clutch_rate(p: LaunchMpcParameters, s: LaunchMpcState, pedal: float) -> float:
    """Return the fastest change of the clutch torque, N m/s, that the wanted jerk allows."""
    rate = lookup(p.calibration.jerk, pedal) * p.inertia / (p.metres_per_radian * p.road.efficiency)
    rate = rate * (1.0 + p.calibration.jerk_on_load * max(s.hold - STEEP, 0.0))
    if s.road.moving == 0 and s.hold > STEEP and s.clutch_torque < p.calibration.held_share * s.hold:
        rate = p.rate_limit
    return min(rate, p.rate_limit)


@kernel
def slipping(
    p: LaunchMpcParameters,
    s: LaunchMpcState,
    c: LaunchMpcCommand,
    w: LaunchMpcWork,
    pedal: float,
    plate: float,
    dt: float,
) -> float:
    """Return the clutch torque while slipping, N m, and write the engine torque."""
    wanted = lookup(p.calibration.acceleration, pedal) / p.metres_per_radian
    w.goal = min(p.inertia * wanted / p.road.efficiency + hold_torque(p, s), p.torque_limit)
    friction = p.torque.friction * s.torque.mean_speed
    need = w.goal + p.torque.inertia * wanted + friction - s.torque.mean_error
    chosen = choose_target(p, s, pedal, need * p.calibration.reserve, dt)
    w.rate = clutch_rate(p, s, pedal)
    w.half = 0.5 * wanted * p.calibration.landing_time
    net = s.torque.mean_torque + s.torque.mean_error - friction - s.clutch_torque
    limit_rates(p, s, w)
    limit_speeds(p, s, w, net / p.torque.inertia)
    state_aims(p, s, w, chosen, plate, net / p.torque.inertia)
    status = solve(p.matrices, w.data, w.work, w.solution)
    c.solver_status = float(status)
    clutch = w.solution.x[0] if status == SOLVED else w.safest[0]
    engine = w.solution.x[SEGMENTS] if status == SOLVED else w.safest[SEGMENTS]
    s.engine_torque = clamp(s.torque.mean_torque + (dt + s.torque.mean_lag) * engine, -10_000.0, 10_000.0)
    return s.clutch_torque + dt * clutch


@kernel
def driving(p: LaunchMpcParameters, s: LaunchMpcState, pedal: float, speed: float, dt: float) -> float:
    """Return the clutch torque after sync, N m, and write the engine torque: it settles at that of the pedal."""
    goal = engine_torque(p.engine, throttle_effect(p.engine, pedal), speed)
    turning = p.inertia / p.road.efficiency + p.torque.inertia
    jerk = lookup(p.calibration.settling_share, pedal) * lookup(p.calibration.jerk, pedal)
    change = jerk / p.metres_per_radian * turning * dt
    s.engine_torque = clamp(goal, s.engine_torque - change, s.engine_torque + change)
    return s.clutch_torque + p.calibration.closing_rate * dt


@kernel
def waiting(p: LaunchMpcParameters, s: LaunchMpcState, speed: float) -> float:
    """Return the clutch torque of an open clutch, N m, and write the engine torque that holds the idle speed."""
    s.target = p.engine.idle_speed
    error = p.engine.idle_speed - speed
    s.engine_torque = max(p.engine.friction * p.engine.idle_speed + p.calibration.idle_gain * error, -10_000.0)
    return 0.0


@kernel
def init(
    p: LaunchMpcParameters, s: LaunchMpcState, m: LaunchMpcMeasurement, c: LaunchMpcCommand, w: LaunchMpcWork
) -> None:
    """Wait with the clutch open and the engine idling."""
    s.phase = WAITING
    s.hold = 0.0
    s.clutch_torque = 0.0
    s.target = p.engine.idle_speed
    s.engine_torque = p.engine.friction * p.engine.idle_speed
    observer_reset(s.road, p.rolling_torque)
    engine_observer_reset(s.torque, s.engine_torque, p.engine.idle_speed)
    c.throttle = throttle_for(p.engine, s.engine_torque, p.engine.idle_speed)
    c.clutch_torque_command = 0.0
    c.engine_speed_target = p.engine.idle_speed
    c.launch_phase = 0.0
    c.road_torque_estimate = s.road.road_torque
    c.engine_lag_estimate = 0.0
    c.solver_status = 0.0


@kernel
def step(
    p: LaunchMpcParameters,
    s: LaunchMpcState,
    m: LaunchMpcMeasurement,
    c: LaunchMpcCommand,
    w: LaunchMpcWork,
    dt: float,
) -> int:
    """Command throttle and clutch for the next dt (s); return 0, or 1 where a measurement is no number.

    A measurement that is no number leaves the commands as they are.
    """
    status = 1
    speeds = m.engine_speed + m.clutch_speed + m.wheel_speed
    if is_finite(m.pedal) and is_finite(speeds) and is_finite(m.longitudinal_acceleration):
        status = 0
        pedal = clamp(m.pedal, 0.0, 1.0)
        speed = clamp(m.engine_speed, -2000.0, 2000.0)
        plate = clamp(m.clutch_speed, -2000.0, 2000.0)
        observe(p, s, m)
        demand = pedal - p.calibration.pedal_threshold
        s.phase = phase_after(s.phase, demand, float(s.road.moving), speed - plate, CLOSED)
        c.solver_status = 0.0
        if s.phase == WAITING:
            torque = waiting(p, s, speed)
        elif s.phase == SLIPPING:
            torque = slipping(p, s, c, w, pedal, plate, dt)
        else:
            torque = driving(p, s, pedal, speed, dt)
        change = p.rate_limit * dt
        torque = clamp(torque, s.clutch_torque - change, s.clutch_torque + change)
        s.clutch_torque = clamp(torque, 0.0, p.torque_limit)
        most = full_load_torque(p.engine, max(speed, p.engine.idle_speed))
        s.engine_torque = clamp(s.engine_torque, -engine_drag(p.engine, max(speed, 0.0)), most)
        c.throttle = throttle_for(p.engine, s.engine_torque, speed)
        c.clutch_torque_command = s.clutch_torque
        c.engine_speed_target = s.target
        c.launch_phase = float(s.phase)
        c.road_torque_estimate = s.road.road_torque
        c.engine_lag_estimate = s.torque.mean_lag
    return status


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    return library_yaml("controllers", "launch_mpc.yaml")


CONTROLLER = Controller(
    name="launch_mpc",
    meaning="predictive control of clutch and engine torque together, with a landing at equal speed and acceleration",
    plants=("dct",),
    calibration=LaunchMpcCalibration,
    calibrations=calibrations,
    default_calibration="tuned",
    parameters=LaunchMpcParameters,
    state=LaunchMpcState,
    measurement=LaunchMpcMeasurement,
    command=LaunchMpcCommand,
    design=design,
    init=init,
    step=step,
    work=LaunchMpcWork,
    design_on=design_on,
    period=PERIOD,
)
