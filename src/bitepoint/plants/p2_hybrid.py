"""P2 hybrid: engine, separating clutch, motor at the gearbox input, gearbox, half-shafts, wheels, tyres, vehicle.

    J1 dw1/dt = T1 - Tc                      Tc = k1 th + c1 (w1 - w2), at most what the clutch can carry
    J2 dw2/dt = Tc + T2 - Ts / i - loss      Ts = k2 phi + c2 y,  y = dphi/dt = w2 / i - w3
    Jw dw3/dt = Ts - Tb - r (F + f m g)      F: Magic Formula of the slip
     m dv/dt  = F - grade - 1/2 rho cd A v^2

Engine and motor follow their commands with dead time and lag. Clutch and brake are Coulomb sliders in series with a
spring (`parts.slider`), so that neither needs an event. Shifting, the gearbox is in neutral: the half-shafts carry
nothing, and a synchroniser brings the input to the speed of the next gear.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.models.longitudinal import LongitudinalModel
from bitepoint.numerics.dead_time import delayed, start_dead_time
from bitepoint.numerics.integration import clearer, runge_kutta_4
from bitepoint.parts.amt import ENGAGING_BAND, meshing_loss_torque, synchroniser_torque
from bitepoint.parts.brake import brake_rate
from bitepoint.parts.motor import electric_power, rate_limited, torque_bound, warming
from bitepoint.parts.separating_clutch import separating_capacity
from bitepoint.parts.shaft import shaft_energy, shaft_loss, shaft_torque
from bitepoint.parts.slider import slider_torque, twist_rate
from bitepoint.parts.torque_engine import fuel_flow, idle_torque, torque_rate
from bitepoint.parts.tyre import tyre_force, tyre_slip
from bitepoint.plants.checks import check_engine, check_gearbox
from bitepoint.plants.p2_hybrid_modes import follow_gear, limit_motor, longest_substep, prepare
from bitepoint.plants.p2_hybrid_records import (
    P2Inputs,
    P2Mode,
    P2Motion,
    P2Outputs,
    P2Parameters,
    P2State,
    P2Work,
)
from bitepoint.plants.plant import Plant
from bitepoint.plants.stiffness import NEUTRAL_RELAXATION, ROLLING_FADE_SPEED
from bitepoint.records import RecordArray

LEAST_OVER_IDLE = 1.2
"""Lowest speed at which the engine drives, over that of its idling (chosen)."""


@kernel
def drive_rates(p: P2Parameters, m: P2Mode, x: P2Motion, d: P2Motion) -> None:
    """Write the rates of the torques of engine, motor and brake into `d`, and what the first two do and take."""
    governed = idle_torque(p.engine, x.engine_speed)
    wanted = governed if m.idling == 1 else max(m.engine_request, governed)
    d.engine_torque = torque_rate(p.engine, wanted, x.engine_speed, x.engine_torque)
    bound = torque_bound(m.motor_peak, m.motor_power, x.motor_speed)
    d.motor_torque = (clamp(m.motor_command, -bound, bound) - x.motor_torque) / p.motor.lag
    d.brake_torque = brake_rate(p.brake, m.brake_command, x.brake_torque)
    d.engine_work = x.engine_torque * x.engine_speed
    d.motor_work = x.motor_torque * x.motor_speed
    d.fuel_used = fuel_flow(p.engine, x.engine_speed, x.engine_torque)
    d.electric_energy = electric_power(p.motor, x.motor_torque, x.motor_speed)
    d.motor_temperature = warming(p.motor, d.electric_energy - d.motor_work, x.motor_temperature)


@kernel
def clutch_rates(p: P2Parameters, m: P2Mode, x: P2Motion, d: P2Motion) -> float:
    """Write twist rate and heat of the clutch into `d`, its damper's loss first; return its torque, N m."""
    slip = x.engine_speed - x.motor_speed
    torque = slider_torque(p.clutch.stiffness, p.clutch.damping, m.capacity, x.clutch_twist, slip)
    d.clutch_twist = twist_rate(p.clutch.stiffness, p.clutch.damping, torque, x.clutch_twist)
    d.clutch_heat = torque * (slip - d.clutch_twist)
    d.damper_loss = p.clutch.damping * d.clutch_twist**2
    return torque


@kernel
def halfshaft_rates(p: P2Parameters, m: P2Mode, x: P2Motion, d: P2Motion) -> float:
    """Write twist rate and loss of the half-shafts into `d`; return their torque, N m. In neutral they relax."""
    torque = 0.0
    if m.gear == 0:
        d.halfshaft_twist = -x.halfshaft_twist / NEUTRAL_RELAXATION
        d.halfshaft_loss = -p.halfshaft.stiffness * x.halfshaft_twist * d.halfshaft_twist
    else:
        d.halfshaft_twist = x.motor_speed * m.inverse_ratio - x.wheel_speed
        d.halfshaft_loss = shaft_loss(p.halfshaft, d.halfshaft_twist)
        torque = shaft_torque(p.halfshaft, x.halfshaft_twist, d.halfshaft_twist)
    return torque


@kernel
def brake_rates(p: P2Parameters, x: P2Motion, d: P2Motion) -> float:
    """Write twist rate and heat of the brake into `d`, add its damper's loss; return its torque on the wheels, N m."""
    torque = slider_torque(p.brake.stiffness, p.brake.damping, x.brake_torque, x.brake_twist, x.wheel_speed)
    d.brake_twist = twist_rate(p.brake.stiffness, p.brake.damping, torque, x.brake_twist)
    d.brake_heat = torque * (x.wheel_speed - d.brake_twist)
    d.damper_loss = d.damper_loss + p.brake.damping * d.brake_twist**2
    return torque


@kernel
def road_rates(p: P2Parameters, m: P2Mode, x: P2Motion, d: P2Motion) -> float:
    """Write the rates of the vehicle on the road into `d`; return the torque that the wheels lose to the road, N m."""
    slip = tyre_slip(x.wheel_speed, p.vehicle.wheel_radius, x.speed)
    force = tyre_force(p.tyre, p.road.friction, m.load, slip)
    air = m.air_coefficient * x.speed * abs(x.speed)
    rolling = m.rolling_torque * clamp(x.wheel_speed / ROLLING_FADE_SPEED, -1.0, 1.0)
    d.speed = (force - air - m.grade_force) / p.vehicle.mass
    d.distance = x.speed
    d.tyre_heat = force * (p.vehicle.wheel_radius * x.wheel_speed - x.speed)
    d.road_loss = air * x.speed + rolling * x.wheel_speed
    return p.vehicle.wheel_radius * force + rolling


@kernel
def rates(p: P2Parameters, m: P2Mode, x: P2Motion, d: P2Motion) -> None:
    """Write dx/dt into `d`."""
    drive_rates(p, m, x, d)
    clutch = clutch_rates(p, m, x, d)
    halfshaft = halfshaft_rates(p, m, x, d)
    brake = brake_rates(p, x, d)
    road = road_rates(p, m, x, d)
    loss = 0.0
    synchroniser = 0.0
    if m.gear == 0:
        synchroniser = synchroniser_torque(p.gearbox, m.ratio * x.wheel_speed - x.motor_speed)
    else:
        loss = meshing_loss_torque(p.gearbox, halfshaft, x.motor_speed * m.inverse_ratio)
    d.motor_speed = clutch + x.motor_torque + synchroniser - (halfshaft + loss) * m.inverse_ratio
    d.motor_speed = d.motor_speed * m.motor_mobility
    d.wheel_speed = (halfshaft - m.ratio * synchroniser - brake - road) * m.wheel_mobility
    d.engine_speed = (x.engine_torque - clutch) * m.engine_mobility
    d.gear_loss = loss * x.motor_speed * m.inverse_ratio
    d.synchroniser_heat = synchroniser * (m.ratio * x.wheel_speed - x.motor_speed)


integrate = runge_kutta_4("integrate_p2", rates, P2Motion, P2Work)
clear = clearer("clear_p2", P2Motion)


@kernel
def substep(p: P2Parameters, s: P2State, w: P2Work, h: float) -> None:
    """Advance by h; a gear engages before it, where its time has come and the speeds have met."""
    if s.mode.gear == 0 and s.mode.neutral_time <= 0.0:
        difference = s.mode.ratio * s.motion.wheel_speed - s.motion.motor_speed
        if abs(difference) < ENGAGING_BAND:
            s.mode.gear = s.mode.next_gear
    s.mode.motor_command = rate_limited(s.mode.motor_command, s.mode.motor_target, p.motor.torque_rate_limit * h)
    integrate(p, s.mode, s.motion, w, h)
    s.mode.neutral_time = max(0.0, s.mode.neutral_time - h)


@kernel
def follow_inputs(p: P2Parameters, s: P2State, u: P2Inputs, dt: float) -> None:
    """Write into the mode what follows from the inputs, and the limits of the motor as hot as it is."""
    request = delayed(s.engine_delay, u.engine_torque_request, p.engine.delay, dt)
    command = delayed(s.motor_delay, u.motor_torque_command, p.motor.delay, dt)
    s.mode.capacity = separating_capacity(p.clutch, u.clutch_torque_command)
    s.mode.engine_request = request
    s.mode.idling = 1 if s.mode.capacity <= 0.0 and request <= 0.0 else 0
    limit_motor(p, s)
    s.mode.motor_target = clamp(command, -s.mode.motor_peak, s.mode.motor_peak)
    s.mode.brake_command = u.brake_torque_command
    follow_gear(p, s.mode, u.gear_command)


@kernel
def stored_energy(p: P2Parameters, m: P2Mode, x: P2Motion) -> float:
    """Return kinetic, elastic and potential energy, J."""
    turning = p.engine.inertia * x.engine_speed**2 + p.motor.inertia * x.motor_speed**2
    rolling = p.tyre.wheel_inertia * x.wheel_speed**2 + p.vehicle.mass * x.speed**2
    wound = p.clutch.stiffness * x.clutch_twist**2 + p.brake.stiffness * x.brake_twist**2
    return 0.5 * (turning + rolling + wound) + shaft_energy(p.halfshaft, x.halfshaft_twist) + m.grade_force * x.distance


@kernel
def observe_driveline(p: P2Parameters, s: P2State, y: P2Outputs, w: P2Work) -> None:
    """Write the outputs of the driveline; the rates are in `w.slope`."""
    y.engine_speed = s.motion.engine_speed
    y.motor_speed = s.motion.motor_speed
    y.wheel_speed = s.motion.wheel_speed
    y.engine_torque = s.motion.engine_torque
    y.motor_torque = s.motion.motor_torque
    y.motor_torque_limit = torque_bound(s.mode.motor_peak, s.mode.motor_power, s.motion.motor_speed)
    y.clutch_torque = clutch_rates(p, s.mode, s.motion, w.slope)
    y.clutch_twist = s.motion.clutch_twist
    y.halfshaft_torque = halfshaft_rates(p, s.mode, s.motion, w.slope)
    y.halfshaft_twist = s.motion.halfshaft_twist
    y.torsional_speed = w.slope.halfshaft_twist
    y.gear = float(s.mode.gear)
    y.gear_ratio = s.mode.ratio


@kernel
def observe_vehicle(p: P2Parameters, s: P2State, y: P2Outputs, w: P2Work) -> None:
    """Write the outputs of the vehicle on its road; the rates are in `w.slope`."""
    y.vehicle_speed = s.motion.speed
    y.vehicle_acceleration = w.slope.speed
    y.longitudinal_acceleration = w.slope.speed + s.mode.grade_force / p.vehicle.mass
    y.distance = s.motion.distance
    y.tyre_slip = tyre_slip(s.motion.wheel_speed, p.vehicle.wheel_radius, s.motion.speed)
    y.tyre_force = tyre_force(p.tyre, p.road.friction, s.mode.load, y.tyre_slip)
    y.brake_torque = brake_rates(p, s.motion, w.slope)


@kernel
def observe_energy(p: P2Parameters, s: P2State, y: P2Outputs, w: P2Work) -> None:
    """Write the outputs of fuel, electricity, and what the audit is made of; the rates are in `w.slope`."""
    y.motor_voltage = p.motor.voltage
    y.motor_current = w.slope.electric_energy / p.motor.voltage
    y.motor_temperature = s.motion.motor_temperature
    y.fuel_flow = w.slope.fuel_used
    y.fuel_used = s.motion.fuel_used
    y.electric_energy = s.motion.electric_energy
    y.engine_work = s.motion.engine_work
    y.motor_work = s.motion.motor_work
    y.friction_heat = s.motion.clutch_heat + s.motion.synchroniser_heat
    y.friction_heat = y.friction_heat + s.motion.brake_heat + s.motion.tyre_heat
    y.losses = s.motion.damper_loss + s.motion.gear_loss + s.motion.halfshaft_loss + s.motion.road_loss
    y.stored_energy = stored_energy(p, s.mode, s.motion)


@kernel
def observe(p: P2Parameters, s: P2State, y: P2Outputs, w: P2Work) -> None:
    """Write the outputs."""
    rates(p, s.mode, s.motion, w.slope)
    observe_driveline(p, s, y, w)
    observe_vehicle(p, s, y, w)
    observe_energy(p, s, y, w)


@kernel
def init(p: P2Parameters, s: P2State, u: P2Inputs, y: P2Outputs, w: P2Work) -> None:
    """Roll steadily in gear, without slip, wound up by the engine; or stand, the clutch open, the engine at idle."""
    clear(s.motion)
    u.engine_torque_request = 0.0
    u.motor_torque_command = 0.0
    u.clutch_torque_command = 0.0
    u.brake_torque_command = 0.0
    u.gear_command = 0.0
    prepare(p, s.mode)
    s.motion.motor_temperature = p.motor.temperature
    s.motion.speed = p.start.speed
    s.motion.wheel_speed = p.start.speed / p.vehicle.wheel_radius
    s.motion.motor_speed = s.mode.ratio * s.motion.wheel_speed
    if p.start.speed > 0.0:
        u.engine_torque_request = p.start.engine_torque
        u.clutch_torque_command = p.clutch.torque_limit
        s.motion.engine_speed = s.motion.motor_speed
        s.motion.engine_torque = p.start.engine_torque
        s.motion.clutch_twist = p.start.engine_torque / p.clutch.stiffness
        s.motion.halfshaft_twist = p.start.engine_torque * s.mode.ratio / p.halfshaft.stiffness
    elif p.start.engine_running == 1:
        s.motion.engine_speed = p.engine.idle_speed
    start_dead_time(s.engine_delay, u.engine_torque_request)
    start_dead_time(s.motor_delay, 0.0)
    s.mode.capacity = u.clutch_torque_command
    limit_motor(p, s)
    observe(p, s, y, w)


@kernel
def step(p: P2Parameters, s: P2State, u: P2Inputs, y: P2Outputs, w: P2Work, dt: float) -> int:
    """Advance by dt; return 0, or 1 where a number is no longer finite."""
    follow_inputs(p, s, u, dt)
    substeps = to_index(dt / longest_substep(p, s, dt) + 0.999, 1, 100_000)
    h = dt / substeps
    for _i in range(substeps):
        substep(p, s, w, h)
    observe(p, s, y, w)
    asked = u.engine_torque_request + u.motor_torque_command + u.clutch_torque_command + u.brake_torque_command
    # never: the energy not finite where the inputs are, since the substeps are stable and every command is limited
    return 0 if is_finite(asked) and is_finite(y.stored_energy) else 1


def check(parameters: RecordArray, where: str) -> None:
    """Raise InputError where parameters, each in its range, contradict each other; see `Plant`."""
    check_gearbox(parameters["gearbox"], where)
    check_engine(parameters["engine"], where)


def longitudinal(parameters: RecordArray) -> RecordArray:
    """Return the vehicle as its engine drives it, a `LongitudinalModel`; the motor turns with the gearbox input."""
    model = LongitudinalModel.zeros(len(parameters))
    for block in ("vehicle", "engine", "gearbox"):
        model[block] = parameters[block]
    model["engine"]["inertia"] += parameters["motor"]["inertia"]
    model["wheel_inertia"] = parameters["tyre"]["wheel_inertia"]
    model["launch_speed"] = LEAST_OVER_IDLE * parameters["engine"]["idle_speed"]
    return model


PLANT = Plant(
    "p2_hybrid", P2Parameters, P2State, P2Inputs, P2Outputs, P2Work, init, step, check, longitudinal=longitudinal
)
