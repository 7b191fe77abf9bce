"""Vehicle with a dual-clutch transmission, moving off on clutch 1 with clutch 2 open.

Four degrees of freedom: engine e, driven plate 1, axle 6 (half-shaft inboard end), wheel v (vehicle).
While the clutch slips [1, eq. 9]:

    (Ie + lambda) dwe/dt = T' - ce we - Tc            I1 dw1/dt = Tc - Td,  Td = k1 (th1 - th3) + c1 (w1 - w3)
    J6 dw6/dt = i Td - loss - To                      Iv dwv/dt = To - Tv,  To = ko (th6 - thv) + co (w6 - wv)

with w3 = i w6. Locked, engine and plate turn as one until the torque between them exceeds the capacity [1, eq. 10].
The vehicle is held at standstill until To exceeds grade plus rolling resistance; later it sticks only by its rolling
resistance. Lock, unlock, release and stop are located within the step. Where the actuator is active, the clutch torque
comes from a pressure that follows the command by way of the nominal friction. There is no term m dv/dt in Tv, as
eq. 11 of [1] has: Iv holds all of the inertia.

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014
"""

from __future__ import annotations

import math

import numpy as np

from bitepoint.errors import InputError
from bitepoint.kernels import clamp, is_finite, kernel, sign, to_index
from bitepoint.numerics.integration import clearer, copier, runge_kutta_4
from bitepoint.numerics.tables import highest
from bitepoint.parts.body import air_coefficient, grade_torque, rolling_torque
from bitepoint.parts.clutch import clutch_capacity
from bitepoint.parts.clutch_actuator import (
    clutch_friction,
    clutch_temperature,
    fill_rate,
    friction_steepness,
    pressure_for_torque,
    torque_from_pressure,
)
from bitepoint.parts.engine import engine_drag, engine_torque, lagged_effect, throttle_effect, throttle_for
from bitepoint.parts.gears import LOSS_FADE_SPEED, axle_side_inertia, gear_loss_torque, overall_ratio
from bitepoint.parts.shaft import shaft_energy, shaft_loss, shaft_torque
from bitepoint.plants.dct_records import DctInputs, DctMode, DctMotion, DctOutputs, DctParameters, DctState, DctWork
from bitepoint.plants.plant import Plant
from bitepoint.records import RecordArray

LEAST_INERTIA = 1e-3
"""Sum of the inertias in a gearbox, kg m^2, below which no substep would be short enough."""

STABILITY = 2.7
"""Longest step times fastest rate; the Runge-Kutta rule of order 4 is stable up to 2.78 on the negative real axis."""


@kernel
def capacity(p: DctParameters, m: DctMode, x: DctMotion) -> float:
    """Return the torque, N m, that clutch 1 can carry now."""
    torque = m.capacity
    if p.actuator.active == 1:
        temperature = clutch_temperature(p.actuator, x.friction_work)
        friction = clutch_friction(p.actuator, temperature, x.engine_speed - x.plate_speed)
        torque = p.clutch.friction_gain * torque_from_pressure(p.actuator, friction, x.clutch_pressure)
    return torque


@kernel
def rates(p: DctParameters, m: DctMode, x: DctMotion, d: DctMotion) -> None:
    """Write dx/dt into `d`."""
    engine = engine_torque(p.engine, m.throttle_effect, x.engine_speed)
    friction = p.engine.friction * x.engine_speed
    damper_slip = x.plate_speed - m.ratio * x.axle_speed
    damper = shaft_torque(p.damper, x.damper_twist, damper_slip)
    halfshaft_slip = x.axle_speed - x.wheel_speed
    halfshaft = shaft_torque(p.halfshaft, x.halfshaft_twist, halfshaft_slip)
    gear_loss = gear_loss_torque(p.gearbox, m.ratio * damper, x.axle_speed)
    drag = m.air_coefficient * x.wheel_speed * abs(x.wheel_speed) + m.rolling_direction * m.rolling_torque
    if m.locked == 1:
        d.engine_speed = (engine - friction - damper) * m.joint_mobility
        d.plate_speed = d.engine_speed
        d.friction_work = 0.0
    else:
        clutch = m.slip_direction * capacity(p, m, x)
        d.engine_speed = (engine - friction - clutch) * m.engine_mobility
        d.plate_speed = (clutch - damper) * m.plate_mobility
        d.friction_work = clutch * (x.engine_speed - x.plate_speed)
    d.axle_speed = (m.ratio * damper - gear_loss - halfshaft) * m.axle_mobility
    if m.rolling_direction == 0.0:
        d.wheel_speed = 0.0
    else:
        d.wheel_speed = (halfshaft - m.grade_torque - drag) * m.vehicle_mobility
    d.damper_twist = damper_slip
    d.halfshaft_twist = halfshaft_slip
    d.clutch_pressure = 0.0
    if p.actuator.active == 1:
        d.clutch_pressure = fill_rate(p.actuator, m.pressure, x.clutch_pressure)
    d.distance = p.vehicle.wheel_radius * x.wheel_speed
    d.engine_work = engine * x.engine_speed
    d.engine_loss = friction * x.engine_speed
    d.damper_loss = shaft_loss(p.damper, damper_slip)
    d.gear_loss = gear_loss * x.axle_speed
    d.halfshaft_loss = shaft_loss(p.halfshaft, halfshaft_slip)
    d.road_loss = drag * x.wheel_speed


integrate = runge_kutta_4("integrate_dct", rates, DctMotion, DctWork)
keep = copier("keep_dct", DctMotion)
clear = clearer("clear_dct", DctMotion)


@kernel
def locked_torque(p: DctParameters, m: DctMode, x: DctMotion) -> float:
    """Return the torque, N m, that the clutch would have to carry to keep engine and plate together."""
    engine = engine_torque(p.engine, m.throttle_effect, x.engine_speed) - p.engine.friction * x.engine_speed
    damper = shaft_torque(p.damper, x.damper_twist, x.plate_speed - m.ratio * x.axle_speed)
    return damper + p.clutch.plate_inertia * m.joint_mobility * (engine - damper)


@kernel
def surely_locked(p: DctParameters, m: DctMode, x: DctMotion) -> bool:
    """Return whether the clutch holds whatever the engine gives: true spares the look into the engine map."""
    damper = abs(shaft_torque(p.damper, x.damper_twist, x.plate_speed - m.ratio * x.axle_speed))
    engine = m.full_load_peak + engine_drag(p.engine, x.engine_speed) + p.engine.friction * abs(x.engine_speed)
    share = p.clutch.plate_inertia * m.joint_mobility
    return damper + share * (abs(engine) + damper) < capacity(p, m, x)


@kernel
def wheel_pull(p: DctParameters, m: DctMode, x: DctMotion) -> float:
    """Return half-shaft torque minus grade torque, N m: what pulls a standing vehicle forwards."""
    return shaft_torque(p.halfshaft, x.halfshaft_twist, x.axle_speed - x.wheel_speed) - m.grade_torque


@kernel
def crossed(p: DctParameters, m: DctMode, x: DctMotion) -> bool:
    """Return whether the modes no longer fit the motion."""
    if m.locked == 1:
        clutch = not surely_locked(p, m, x) and abs(locked_torque(p, m, x)) > capacity(p, m, x)
    else:
        clutch = (x.engine_speed - x.plate_speed) * m.slip_direction < 0.0
    if m.rolling_direction == 0.0:
        pull = wheel_pull(p, m, x)
        wheel = pull > m.rolling_torque or (m.hill_hold == 0 and pull < -m.rolling_torque)
    else:
        wheel = x.wheel_speed * m.rolling_direction < 0.0
    return clutch or wheel


@kernel
def switch_clutch(p: DctParameters, m: DctMode, x: DctMotion) -> None:
    """Lock or unlock the clutch where its mode no longer fits."""
    if m.locked == 1:
        torque = locked_torque(p, m, x)
        if abs(torque) > capacity(p, m, x):
            m.locked = 0
            m.slip_direction = sign(torque)
    elif (x.engine_speed - x.plate_speed) * m.slip_direction <= 0.0:
        momentum = m.engine_inertia * x.engine_speed + p.clutch.plate_inertia * x.plate_speed
        x.engine_speed = momentum / (m.engine_inertia + p.clutch.plate_inertia)
        x.plate_speed = x.engine_speed
        torque = locked_torque(p, m, x)
        if abs(torque) <= capacity(p, m, x):
            m.locked = 1
        else:
            m.slip_direction = sign(torque)


@kernel
def switch_wheel(p: DctParameters, m: DctMode, x: DctMotion) -> None:
    """Stop the vehicle at zero speed, or release it, where its mode no longer fits."""
    if x.wheel_speed * m.rolling_direction < 0.0:
        x.wheel_speed = 0.0
        m.rolling_direction = 0.0
    if m.rolling_direction == 0.0:
        pull = wheel_pull(p, m, x)
        if pull > m.rolling_torque:
            m.rolling_direction = 1.0
            m.hill_hold = 0
        elif m.hill_hold == 0 and pull < -m.rolling_torque:
            m.rolling_direction = -1.0


@kernel
def switch_modes(p: DctParameters, s: DctState) -> None:
    """Bring the modes in line with the motion; the time since the lock starts again with each lock and unlock."""
    locked = s.mode.locked
    switch_clutch(p, s.mode, s.motion)
    switch_wheel(p, s.mode, s.motion)
    if s.mode.locked != locked:
        s.locked_time = 0.0


@kernel
def advance(p: DctParameters, s: DctState, w: DctWork, h: float) -> float:
    """Integrate over h, or to the first event before it; return the time that went by, s."""
    keep(w.start, s.motion)
    integrate(p, s.mode, s.motion, w, h)
    passed = h
    if crossed(p, s.mode, s.motion):
        before = 0.0
        for _bisection in range(40):
            middle = 0.5 * (before + passed)
            keep(s.motion, w.start)
            integrate(p, s.mode, s.motion, w, middle)
            if crossed(p, s.mode, s.motion):
                passed = middle
            else:
                before = middle
        keep(s.motion, w.start)
        integrate(p, s.mode, s.motion, w, passed)
    return passed


@kernel
def substep(p: DctParameters, s: DctState, w: DctWork, h: float) -> None:
    """Advance by h through up to 8 events; more than those are left to the next substep."""
    left = h
    for _event in range(8):
        if left > 0.0:
            switch_modes(p, s)
            passed = advance(p, s, w, left)
            if s.mode.locked == 1:
                s.locked_time = s.locked_time + passed
            left = left - passed
    # never: with fewer than 8 events in a substep
    if left > 0.0:
        integrate(p, s.mode, s.motion, w, left)


@kernel
def prepare(p: DctParameters, m: DctMode) -> None:
    """Write into the mode what follows from the parameters: these are constant from init on."""
    m.substep = min(p.solver.substep, stable_step(p))
    m.full_load_peak = p.engine.torque_gain * highest(p.engine.full_load)
    m.ratio = overall_ratio(p.gearbox)
    m.engine_inertia = p.engine.inertia + p.engine.transient_loss
    m.axle_inertia = axle_side_inertia(p.gearbox)
    m.vehicle_inertia = p.vehicle.mass * p.vehicle.wheel_radius**2
    m.engine_mobility = 1.0 / m.engine_inertia
    m.plate_mobility = 1.0 / p.clutch.plate_inertia
    m.joint_mobility = 1.0 / (m.engine_inertia + p.clutch.plate_inertia)
    m.axle_mobility = 1.0 / m.axle_inertia
    m.vehicle_mobility = 1.0 / m.vehicle_inertia
    m.grade_torque = grade_torque(p.vehicle, p.road)
    m.rolling_torque = rolling_torque(p.vehicle, p.road)
    m.air_coefficient = air_coefficient(p.vehicle, p.road)


@kernel
def follow_inputs(p: DctParameters, m: DctMode, u: DctInputs) -> None:
    """Write into the mode what follows from the inputs at once: all but the throttle, which the engine may lag."""
    m.capacity = clutch_capacity(p.clutch, u.clutch_torque_command)
    m.pressure = 0.0
    if p.actuator.active == 1:
        command = clamp(u.clutch_torque_command, 0.0, p.clutch.torque_limit)
        m.pressure = pressure_for_torque(p.actuator, p.actuator.sliding_friction, command)


@kernel
def stored_energy(p: DctParameters, m: DctMode, x: DctMotion) -> float:
    """Return kinetic, elastic and potential energy, J."""
    turning = m.engine_inertia * x.engine_speed**2 + p.clutch.plate_inertia * x.plate_speed**2
    driving = m.axle_inertia * x.axle_speed**2 + m.vehicle_inertia * x.wheel_speed**2
    elastic = shaft_energy(p.damper, x.damper_twist) + shaft_energy(p.halfshaft, x.halfshaft_twist)
    return 0.5 * (turning + driving) + elastic + m.grade_torque * x.distance / p.vehicle.wheel_radius


@kernel
def observe(p: DctParameters, s: DctState, y: DctOutputs, w: DctWork) -> None:
    """Write the outputs."""
    rates(p, s.mode, s.motion, w.slope)
    engine = engine_torque(p.engine, s.mode.throttle_effect, s.motion.engine_speed)
    damper_slip = s.motion.plate_speed - s.mode.ratio * s.motion.axle_speed
    y.engine_speed = s.motion.engine_speed
    y.clutch_speed = s.motion.plate_speed
    y.slip_speed = s.motion.engine_speed - s.motion.plate_speed
    y.input_shaft_speed = s.mode.ratio * s.motion.axle_speed
    y.wheel_speed = s.motion.wheel_speed
    y.vehicle_speed = p.vehicle.wheel_radius * s.motion.wheel_speed
    y.vehicle_acceleration = p.vehicle.wheel_radius * w.slope.wheel_speed
    y.longitudinal_acceleration = y.vehicle_acceleration + s.mode.grade_torque / (
        p.vehicle.mass * p.vehicle.wheel_radius
    )
    y.distance = s.motion.distance
    y.engine_torque = engine - p.engine.transient_loss * w.slope.engine_speed
    if s.mode.locked == 1:
        y.clutch_torque = locked_torque(p, s.mode, s.motion)
    else:
        y.clutch_torque = s.mode.slip_direction * capacity(p, s.mode, s.motion)
    y.clutch_pressure = s.motion.clutch_pressure
    y.clutch_temperature = clutch_temperature(p.actuator, s.motion.friction_work)
    y.damper_torque = shaft_torque(p.damper, s.motion.damper_twist, damper_slip)
    y.halfshaft_torque = wheel_pull(p, s.mode, s.motion) + s.mode.grade_torque
    y.road_torque = y.halfshaft_torque - s.mode.vehicle_inertia * w.slope.wheel_speed
    y.clutch_locked = 1.0 if s.mode.locked == 1 else 0.0
    y.clutch_locked_time = s.locked_time
    y.vehicle_held = 1.0 if s.mode.rolling_direction == 0.0 else 0.0
    y.engine_work = s.motion.engine_work
    y.friction_heat = s.motion.friction_work
    y.losses = s.motion.engine_loss + s.motion.damper_loss + s.motion.gear_loss
    y.losses = y.losses + s.motion.halfshaft_loss + s.motion.road_loss
    y.stored_energy = stored_energy(p, s.mode, s.motion)


@kernel
def init(p: DctParameters, s: DctState, u: DctInputs, y: DctOutputs, w: DctWork) -> None:
    """Stand still, held, with clutch 1 open and the engine at idle, at the throttle that balances its friction.

    With an actuator, the clutch is filled to its kiss-point.
    """
    clear(s.motion)
    s.locked_time = 0.0
    s.motion.engine_speed = p.engine.idle_speed
    s.mode.locked = 0
    s.mode.hill_hold = 1
    s.mode.slip_direction = 1.0
    s.mode.rolling_direction = 0.0
    u.throttle = throttle_for(p.engine, p.engine.friction * p.engine.idle_speed, p.engine.idle_speed)
    u.clutch_torque_command = 0.0
    prepare(p, s.mode)
    s.mode.throttle_effect = throttle_effect(p.engine, u.throttle)
    follow_inputs(p, s.mode, u)
    s.motion.clutch_pressure = s.mode.pressure
    observe(p, s, y, w)


@kernel
def stable_step(p: DctParameters) -> float:
    """Return the longest stable substep, s: STABILITY over a bound of the fastest rate of the driveline.

    The rates of the damper between plate and axle, of the half-shaft, of the fading gear loss, and of the actuator,
    added up.
    """
    ratio = overall_ratio(p.gearbox)
    axle = axle_side_inertia(p.gearbox)
    mobility = 1.0 / p.clutch.plate_inertia + ratio**2 / axle
    decay = 0.5 * p.damper.damping * mobility
    damper = decay + math.sqrt(abs(decay**2 - p.damper.stiffness * mobility))
    fade = (1.0 / p.gearbox.efficiency - 1.0) * ratio * p.clutch.torque_limit / (LOSS_FADE_SPEED * axle)
    swing = 1.0 / axle + 1.0 / (p.vehicle.mass * p.vehicle.wheel_radius**2)
    swing_decay = 0.5 * p.halfshaft.damping * swing
    halfshaft = swing_decay + math.sqrt(abs(swing_decay**2 - p.halfshaft.stiffness * swing))
    actuator = 0.0
    if p.actuator.active == 1:
        steepness = friction_steepness(p.actuator) * p.clutch.friction_gain * p.clutch.torque_limit
        actuator = 1.0 / p.actuator.fill_time + steepness / p.clutch.plate_inertia
    return STABILITY / (damper + fade + halfshaft + actuator)


@kernel
def step(p: DctParameters, s: DctState, u: DctInputs, y: DctOutputs, w: DctWork, dt: float) -> int:
    """Advance by dt; return 0, or 1 where a number is no longer finite."""
    follow_inputs(p, s.mode, u)
    effect = throttle_effect(p.engine, u.throttle)
    s.mode.throttle_effect = lagged_effect(p.engine, s.mode.throttle_effect, effect, s.motion.engine_speed, dt)
    substeps = to_index(dt / s.mode.substep + 0.999, 1, 100_000)
    h = dt / substeps
    for _i in range(substeps):
        substep(p, s, w, h)
    switch_modes(p, s)
    observe(p, s, y, w)
    # never: the energy finite and the work not, where the engine's torque is finite
    return 0 if is_finite(y.stored_energy) and is_finite(y.engine_work) else 1


def check(parameters: RecordArray, where: str) -> None:
    """Raise InputError where parameters, each in its range, contradict each other; see `Plant`."""
    gearbox, engine = parameters["gearbox"], parameters["engine"]
    if (gearbox["gear"] % 2 == 0).any():
        mend = "expected an odd gear: the even ones hang on clutch 2, which stays open here"
        raise InputError(where, "gearbox.gear: got an even gear", mend)
    inertias = ("odd_shaft_inertia", "even_shaft_inertia", "layshaft_inertia", "axle_inertia")
    if (np.sum([gearbox[name] for name in inertias], axis=0) < LEAST_INERTIA).any():
        raise InputError(where, "gearbox: its inertias are all but 0", f"expected {LEAST_INERTIA:g} kg m^2 in all")
    for number in sorted({1, 2, *np.unique(gearbox["gear"]).tolist()}):
        if (gearbox["ratios"][:, number - 1] <= 0.0).any():
            raise InputError(where, f"gearbox.ratios: gear {number} has no ratio", "expected a number above 0")
    if (engine["idle_speed"] >= engine["speed_limit"]).any():
        idle = float(engine["idle_speed"].max())
        raise InputError(where, f"engine.idle_speed: got {idle:g} rad/s", "expected it below engine.speed_limit")


PLANT = Plant("dct", DctParameters, DctState, DctInputs, DctOutputs, DctWork, init, step, check)
