"""Predictive damping of a parallel hybrid's driveline by its motor.

The motor's torque U over the coming moves is what the driver's shaped torque needs beyond what the engine gives, plus a
correction z that minimises, over the prediction horizon,

    sum of  q (y - yref)^2 + r (U(k) - U(k-1))^2 + rho z^2,      |U| <= limit,  |U(k) - U(k-1)| <= rate limit

y is the torsional speed of the half-shafts, yref the one at which they would take up the shaped torque without
swinging. The state comes from a Kalman observer of three speeds; a dead time of the motor is observed too, and the
programme is stated for the moment at which its command will act. Where the tyres slip too much, motor and engine give
less. With the clutch open, the motor alone gives the shaped torque less a share of the torsional speed.

Without shaping (shaping_time = 0) and with rho = 0 it is the controller of the source, page 2 of the specification; its
cost leaves a torque of the motor, which rho takes away.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from bitepoint.controllers.controller import Controller
from bitepoint.controllers.damping_mpc_design import PERIOD, design
from bitepoint.controllers.damping_mpc_records import (
    ASKED,
    MOVES,
    PAST,
    SOLVER,
    TORQUE_SCALE,
    DampingGear,
    DampingMpcCalibration,
    DampingMpcCommand,
    DampingMpcMeasurement,
    DampingMpcParameters,
    DampingMpcState,
    DampingMpcWork,
)
from bitepoint.controllers.torque_shaping import shaping_reset, shaping_step
from bitepoint.estimation.driveline import driveline_correct, driveline_predict
from bitepoint.estimation.motor_delay import motor_delay_command, motor_delay_measure, motor_delay_reset
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.numerics.qp_records import SOLVED
from bitepoint.numerics.unrolling import unrolled
from bitepoint.parts.amt import GEARS

SLOWEST = 1.0
"""Vehicle speed that the slip is related to at least, m/s."""

solve = SOLVER.solve


@kernel
def observe(
    p: DampingMpcParameters, g: DampingGear, s: DampingMpcState, m: DampingMpcMeasurement, w: DampingMpcWork
) -> None:
    """Bring the observed driveline up to now; begin anew in another gear."""
    gear = to_index(m.gear, 0, GEARS)
    if s.gear == gear:
        driveline_predict(g.observer, s.driveline, w.next, s.engine_request, s.motor.command[s.motor.delay])
    else:
        s.gear = gear
        s.driveline.x[0] = m.engine_speed
        s.driveline.x[1] = g.clutch_twist * s.engine_request
        s.driveline.x[2] = m.motor_speed
        s.driveline.x[3] = g.halfshaft_twist * (s.engine_request + s.motor_command)
        s.driveline.x[4] = m.wheel_speed
        s.driveline.x[5] = s.engine_request
        s.driveline.x[7] = p.rolling_torque
    driveline_correct(g.observer, s.driveline, m.engine_speed, m.motor_speed, m.wheel_speed)
    s.driveline.x[6] = s.motor.torque[s.motor.delay]


@kernel
def look_ahead(g: DampingGear, s: DampingMpcState, m: DampingMpcMeasurement, w: DampingMpcWork) -> None:
    """Write what the future follows from: the driveline when the command will act, requests, and memory."""
    for n in range(8):
        w.ahead.x[n] = s.driveline.x[n]
    for n in range(5):
        if n < s.motor.delay:
            driveline_predict(g.observer, w.ahead, w.next, w.engine, s.motor.command[max(s.motor.delay - 1 - n, 0)])
    for n in range(8):
        w.past[n] = w.ahead.x[n]
    w.past[8] = s.shaped.first
    w.past[9] = s.shaped.second
    w.past[10] = w.engine + clamp(m.motor_torque_base, -5000.0, 5000.0)
    w.past[11] = s.engine_shaped.first
    w.past[12] = s.engine_shaped.second
    w.past[13] = w.engine
    w.past[14] = s.motor_command


@kernel
def _state_programme(p: DampingMpcParameters, g: DampingGear, s: DampingMpcState, w: DampingMpcWork, dt: float) -> None:
    """Write the programme of this step.

    A torque beyond the limit, which has just fallen, comes back at the rate limit.
    """
    change = p.rate_limit * dt
    before = s.motor_command
    for j in range(MOVES):
        if j < p.moves:
            gradient = 0.0
            for n in range(PAST):
                gradient += g.gradient[j, n] * w.past[n]
            needed = 0.0
            for n in range(ASKED):
                needed += g.feed_forward[j, n] * w.past[n + 5]
            w.feed_forward[j] = needed
            w.data.gradient[j] = gradient
            steps = j + 1
            reach = float(steps) * change
            w.data.low[j] = (min(-w.limit, s.motor_command + reach) - needed) / TORQUE_SCALE
            w.data.high[j] = (max(w.limit, s.motor_command - reach) - needed) / TORQUE_SCALE
            row = min(p.moves + j, 2 * MOVES - 1)
            w.data.low[row] = (-change + before - needed) / TORQUE_SCALE
            w.data.high[row] = (change + before - needed) / TORQUE_SCALE
            before = needed


state_programme = unrolled(_state_programme, "state_programme", {}, {"PAST": PAST, "ASKED": ASKED})


@kernel
def predicted_torque(
    p: DampingMpcParameters,
    g: DampingGear,
    s: DampingMpcState,
    m: DampingMpcMeasurement,
    c: DampingMpcCommand,
    w: DampingMpcWork,
    dt: float,
) -> float:
    """Return the torque of the motor with the clutch closed, N m."""
    observe(p, g, s, m, w)
    look_ahead(g, s, m, w)
    state_programme(p, g, s, w, dt)
    status = solve(g.matrices, w.data, w.work, w.solution)
    c.solver_status = float(status)
    c.torsional_speed_estimate = s.driveline.x[2] / g.ratio - s.driveline.x[4]
    c.road_torque_estimate = clamp(s.driveline.x[7], -1e6, 1e6)
    # never: else, with a solver that always has an answer
    return w.feed_forward[0] + TORQUE_SCALE * w.solution.x[0] if status == SOLVED else w.feed_forward[0]


@kernel
def open_torque(
    p: DampingMpcParameters, g: DampingGear, s: DampingMpcState, m: DampingMpcMeasurement, c: DampingMpcCommand
) -> float:
    """Return the torque of the motor with the clutch open, N m."""
    wanted = 0.0
    if p.shaping_time > 0.0:
        wanted = g.open_twist_speed * (s.shaped.first - s.shaped.second) / p.shaping_time
    c.torsional_speed_estimate = m.motor_speed / g.ratio - m.wheel_speed
    return s.shaped.second - p.calibration.rate_damping * (c.torsional_speed_estimate - wanted)


@kernel
def excess_slip(p: DampingMpcParameters, m: DampingMpcMeasurement) -> float:
    """Return by how much the slip of the tyres, driving, is beyond its limit."""
    slip = (p.wheel_radius * m.wheel_speed - m.vehicle_speed) / max(abs(m.vehicle_speed), SLOWEST)
    return max(slip - p.calibration.slip_limit, 0.0)


@kernel
def init(
    p: DampingMpcParameters, s: DampingMpcState, m: DampingMpcMeasurement, c: DampingMpcCommand, w: DampingMpcWork
) -> None:
    """Take over a driveline that has long been driven by what is asked for now."""
    engine = clamp(m.engine_torque_base, -5000.0, 5000.0)
    motor = clamp(m.motor_torque_base, -p.torque_limit, p.torque_limit)
    s.gear = 0
    s.taken_away = 0.0
    s.engine_request = engine
    s.motor_command = motor
    for n in range(8):
        s.driveline.x[n] = 0.0
    shaping_reset(s.shaped, engine + motor)
    shaping_reset(s.engine_shaped, engine)
    motor_delay_reset(s.motor, motor, p.motor_delay)
    c.engine_torque_request = engine
    c.motor_torque_command = motor
    c.correction_torque = 0.0
    c.shaped_torque = engine + motor
    c.torsional_speed_estimate = 0.0
    c.road_torque_estimate = 0.0
    c.motor_delay_estimate = 0.0
    c.solver_status = 0.0


@kernel
def step(
    p: DampingMpcParameters,
    s: DampingMpcState,
    m: DampingMpcMeasurement,
    c: DampingMpcCommand,
    w: DampingMpcWork,
    dt: float,
) -> int:
    """Command engine and motor for the next dt (s); return 0, or 1 where a measurement is no number.

    A measurement that is no number leaves the commands as they are.
    """
    status = 1
    asked = m.engine_torque_base + m.motor_torque_base + m.clutch_torque_command + m.gear
    speeds = m.engine_speed + m.motor_speed + m.wheel_speed + m.vehicle_speed
    if is_finite(asked) and is_finite(speeds) and is_finite(m.motor_torque + m.motor_torque_limit):
        status = 0
        slipping = excess_slip(p, m)
        asked_engine = clamp(m.engine_torque_base, -5000.0, 5000.0)
        released = p.calibration.slip_release * dt if slipping == 0.0 else 0.0
        taken = s.taken_away + p.calibration.slip_rate * slipping * dt - released
        s.taken_away = clamp(taken, 0.0, max(asked_engine, 0.0))
        w.engine = asked_engine - s.taken_away
        motor = clamp(m.motor_torque_base, -5000.0, 5000.0)
        w.limit = clamp(m.motor_torque_limit, 0.0, p.torque_limit)
        place = to_index(m.gear - 1.0, 0, GEARS - 1)
        engaged = m.gear > 0.5 and p.gear[place].matrices.usable == 1
        motor_delay_measure(s.motor, p.motor_share, m.motor_torque)
        c.solver_status = 0.0
        torque = motor
        if engaged and m.clutch_torque_command > 0.0:
            torque = predicted_torque(p, p.gear[place], s, m, c, w, dt)
        else:
            s.gear = 0
            if engaged:
                torque = open_torque(p, p.gear[place], s, m, c)
        geared = w.engine if m.clutch_torque_command > 0.0 else 0.0
        shaping_step(s.shaped, geared + motor, p.shaping_share)
        shaping_step(s.engine_shaped, w.engine, p.shaping_share)
        change = p.rate_limit * dt
        torque = clamp(torque - p.calibration.slip_gain * slipping, -w.limit, w.limit)
        s.motor_command = clamp(torque, s.motor_command - change, s.motor_command + change)
        motor_delay_command(s.motor, s.motor_command)
        s.engine_request = s.engine_shaped.second if p.calibration.shape_engine == 1 else w.engine
        c.engine_torque_request = s.engine_request
        c.motor_torque_command = s.motor_command
        c.correction_torque = s.motor_command - motor
        c.shaped_torque = s.shaped.second
        c.motor_delay_estimate = float(s.motor.delay) * dt
    return status


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    return library_yaml("controllers", "damping_mpc.yaml")


CONTROLLER = Controller(
    name="damping_mpc",
    meaning="driveline damped by the motor under predictive control, with a shaped torque to aim at",
    plants=("p2_hybrid",),
    calibration=DampingMpcCalibration,
    calibrations=calibrations,
    default_calibration="tuned",
    parameters=DampingMpcParameters,
    state=DampingMpcState,
    measurement=DampingMpcMeasurement,
    command=DampingMpcCommand,
    design=design,
    init=init,
    step=step,
    period=PERIOD,
    work=DampingMpcWork,
)
