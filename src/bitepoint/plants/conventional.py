"""Conventional vehicle: engine, launch clutch, gearbox, half-shafts, wheels that roll without slip, and the road.

    J1 dw1/dt = T1 - Tc                          Tc = k1 th + c1 (w1 - w2), at most what the clutch can carry
    J2 dw2/dt = Tc - (Ts + loss) / i             Ts = k2 phi + c2 y,  y = dphi/dt = w2 / i - w3
    (m r^2 + Jw) dw3/dt = Ts - Tb - r (weight along the road + f m g cos) - c w3^2

The engine follows its request with dead time and lag. Clutch and brake are Coulomb sliders in series with a spring
(`parts.slider`), so that neither needs an event. Shifting, the gearbox is in neutral: the half-shafts carry nothing,
and a synchroniser brings the input to the speed of the next gear. The grade follows the road over distance.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.models.longitudinal import LongitudinalModel
from bitepoint.numerics.dead_time import delayed, start_dead_time
from bitepoint.numerics.integration import clearer, runge_kutta_4
from bitepoint.parts.amt import ENGAGING_BAND, meshing_loss_torque, synchroniser_torque
from bitepoint.parts.brake import brake_rate
from bitepoint.parts.launch_clutch import launch_capacity
from bitepoint.parts.road_profile import grade_at
from bitepoint.parts.shaft import shaft_energy, shaft_loss, shaft_torque
from bitepoint.parts.slider import slider_torque, twist_rate
from bitepoint.parts.torque_engine import fuel_flow, idle_torque, torque_rate
from bitepoint.parts.tyre import weight_across, weight_along
from bitepoint.plants.checks import check_engine, check_gearbox
from bitepoint.plants.conventional_modes import follow_gear, longest_substep, prepare
from bitepoint.plants.conventional_records import (
    ConventionalInputs,
    ConventionalMode,
    ConventionalMotion,
    ConventionalOutputs,
    ConventionalParameters,
    ConventionalState,
    ConventionalWork,
)
from bitepoint.plants.plant import Plant
from bitepoint.plants.stiffness import NEUTRAL_RELAXATION, ROLLING_FADE_SPEED
from bitepoint.records import RecordArray
from bitepoint.units import STANDARD_GRAVITY


@kernel
def engine_rates(p: ConventionalParameters, m: ConventionalMode, x: ConventionalMotion, d: ConventionalMotion) -> None:
    """Write the rates of the engine's torque, work and fuel, and of the brake's torque, into `d`."""
    governed = idle_torque(p.engine, x.engine_speed)
    wanted = governed if m.idling == 1 else max(m.engine_request, governed)
    d.engine_torque = torque_rate(p.engine, wanted, x.engine_speed, x.engine_torque)
    d.brake_torque = brake_rate(p.brake, m.brake_command, x.brake_torque)
    d.engine_work = x.engine_torque * x.engine_speed
    d.fuel_used = fuel_flow(p.engine, x.engine_speed, x.engine_torque)


@kernel
def clutch_rates(p: ConventionalParameters, m: ConventionalMode, x: ConventionalMotion, d: ConventionalMotion) -> float:
    """Write twist rate and heat of the clutch into `d`, its damper's loss first; return its torque, N m."""
    slip = x.engine_speed - x.clutch_speed
    torque = slider_torque(p.clutch.stiffness, p.clutch.damping, m.capacity, x.clutch_twist, slip)
    d.clutch_twist = twist_rate(p.clutch.stiffness, p.clutch.damping, torque, x.clutch_twist)
    d.clutch_heat = torque * (slip - d.clutch_twist)
    d.damper_loss = p.clutch.damping * d.clutch_twist**2
    return torque


@kernel
def halfshaft_rates(
    p: ConventionalParameters, m: ConventionalMode, x: ConventionalMotion, d: ConventionalMotion
) -> float:
    """Write twist rate and loss of the half-shafts into `d`; return their torque, N m. In neutral they relax."""
    torque = 0.0
    if m.gear == 0:
        d.halfshaft_twist = -x.halfshaft_twist / NEUTRAL_RELAXATION
        d.halfshaft_loss = -p.halfshaft.stiffness * x.halfshaft_twist * d.halfshaft_twist
    else:
        d.halfshaft_twist = x.clutch_speed * m.inverse_ratio - x.wheel_speed
        d.halfshaft_loss = shaft_loss(p.halfshaft, d.halfshaft_twist)
        torque = shaft_torque(p.halfshaft, x.halfshaft_twist, d.halfshaft_twist)
    return torque


@kernel
def brake_rates(p: ConventionalParameters, x: ConventionalMotion, d: ConventionalMotion) -> float:
    """Write twist rate and heat of the brake into `d`, add its damper's loss; return its torque on the wheels, N m."""
    torque = slider_torque(p.brake.stiffness, p.brake.damping, x.brake_torque, x.brake_twist, x.wheel_speed)
    d.brake_twist = twist_rate(p.brake.stiffness, p.brake.damping, torque, x.brake_twist)
    d.brake_heat = torque * (x.wheel_speed - d.brake_twist)
    d.damper_loss = d.damper_loss + p.brake.damping * d.brake_twist**2
    return torque


@kernel
def road_rates(p: ConventionalParameters, m: ConventionalMode, x: ConventionalMotion, d: ConventionalMotion) -> float:
    """Write way, height and road loss into `d`; return the torque that the road takes at the wheels, N m."""
    grade = grade_at(p.road, x.distance)
    weight = weight_along(p.vehicle.mass, grade)
    across = weight_across(p.vehicle.mass, grade)
    fade = clamp(x.wheel_speed / ROLLING_FADE_SPEED, -1.0, 1.0)
    rolling = p.vehicle.rolling_resistance * across * p.vehicle.wheel_radius * fade
    resistance = rolling + m.air_coefficient * x.wheel_speed * abs(x.wheel_speed)
    d.distance = p.vehicle.wheel_radius * x.wheel_speed
    d.elevation = d.distance * weight / (p.vehicle.mass * STANDARD_GRAVITY)
    d.road_loss = resistance * x.wheel_speed
    return weight * p.vehicle.wheel_radius + resistance


@kernel
def rates(p: ConventionalParameters, m: ConventionalMode, x: ConventionalMotion, d: ConventionalMotion) -> None:
    """Write dx/dt into `d`."""
    engine_rates(p, m, x, d)
    clutch = clutch_rates(p, m, x, d)
    halfshaft = halfshaft_rates(p, m, x, d)
    brake = brake_rates(p, x, d)
    road = road_rates(p, m, x, d)
    loss = 0.0
    synchroniser = 0.0
    if m.gear == 0:
        synchroniser = synchroniser_torque(p.gearbox, m.ratio * x.wheel_speed - x.clutch_speed)
    else:
        loss = meshing_loss_torque(p.gearbox, halfshaft, x.clutch_speed * m.inverse_ratio)
    d.engine_speed = (x.engine_torque - clutch) * m.engine_mobility
    d.clutch_speed = (clutch + synchroniser - (halfshaft + loss) * m.inverse_ratio) * m.input_mobility
    d.wheel_speed = (halfshaft - m.ratio * synchroniser - brake - road) * m.wheel_mobility
    d.gear_loss = loss * x.clutch_speed * m.inverse_ratio
    d.synchroniser_heat = synchroniser * (m.ratio * x.wheel_speed - x.clutch_speed)


integrate = runge_kutta_4("integrate_conventional", rates, ConventionalMotion, ConventionalWork)
clear = clearer("clear_conventional", ConventionalMotion)


@kernel
def substep(p: ConventionalParameters, s: ConventionalState, w: ConventionalWork, h: float) -> None:
    """Advance by h; a gear engages before it, where its time has come and the speeds have met."""
    if s.mode.gear == 0 and s.mode.neutral_time <= 0.0:
        difference = s.mode.ratio * s.motion.wheel_speed - s.motion.clutch_speed
        if abs(difference) < ENGAGING_BAND:
            s.mode.gear = s.mode.next_gear
    integrate(p, s.mode, s.motion, w, h)
    s.mode.neutral_time = max(0.0, s.mode.neutral_time - h)


@kernel
def follow_inputs(p: ConventionalParameters, s: ConventionalState, u: ConventionalInputs, dt: float) -> None:
    """Write into the mode what follows from the inputs."""
    request = delayed(s.engine_delay, u.engine_torque_request, p.engine.delay, dt)
    s.mode.capacity = launch_capacity(p.clutch, u.clutch_torque_command)
    s.mode.engine_request = request
    s.mode.idling = 1 if s.mode.capacity <= 0.0 and request <= 0.0 else 0
    s.mode.brake_command = u.brake_torque_command
    follow_gear(p, s.mode, u.gear_command)


@kernel
def stored_energy(p: ConventionalParameters, m: ConventionalMode, x: ConventionalMotion) -> float:
    """Return kinetic, elastic and potential energy, J."""
    turning = p.engine.inertia * x.engine_speed**2 + p.clutch.plate_inertia * x.clutch_speed**2
    rolling = x.wheel_speed**2 / m.wheel_mobility
    wound = p.clutch.stiffness * x.clutch_twist**2 + p.brake.stiffness * x.brake_twist**2
    raised = p.vehicle.mass * STANDARD_GRAVITY * x.elevation
    return 0.5 * (turning + rolling + wound) + shaft_energy(p.halfshaft, x.halfshaft_twist) + raised


@kernel
def observe_driveline(
    p: ConventionalParameters, s: ConventionalState, y: ConventionalOutputs, w: ConventionalWork
) -> None:
    """Write the outputs of the driveline; the rates are in `w.slope`."""
    y.engine_speed = s.motion.engine_speed
    y.clutch_speed = s.motion.clutch_speed
    y.slip_speed = s.motion.engine_speed - s.motion.clutch_speed
    y.wheel_speed = s.motion.wheel_speed
    y.engine_torque = s.motion.engine_torque
    y.clutch_torque = clutch_rates(p, s.mode, s.motion, w.slope)
    y.clutch_twist = s.motion.clutch_twist
    y.halfshaft_torque = halfshaft_rates(p, s.mode, s.motion, w.slope)
    y.halfshaft_twist = s.motion.halfshaft_twist
    y.torsional_speed = w.slope.halfshaft_twist
    y.gear = float(s.mode.gear)
    y.gear_ratio = s.mode.ratio


@kernel
def observe_vehicle(
    p: ConventionalParameters, s: ConventionalState, y: ConventionalOutputs, w: ConventionalWork
) -> None:
    """Write the outputs of the vehicle on its road; the rates are in `w.slope`."""
    grade = grade_at(p.road, s.motion.distance)
    y.vehicle_speed = p.vehicle.wheel_radius * s.motion.wheel_speed
    y.vehicle_acceleration = p.vehicle.wheel_radius * w.slope.wheel_speed
    y.longitudinal_acceleration = y.vehicle_acceleration + weight_along(p.vehicle.mass, grade) / p.vehicle.mass
    y.distance = s.motion.distance
    y.elevation = s.motion.elevation
    y.road_grade = grade
    y.brake_torque = brake_rates(p, s.motion, w.slope)


@kernel
def observe_energy(
    p: ConventionalParameters, s: ConventionalState, y: ConventionalOutputs, w: ConventionalWork
) -> None:
    """Write the outputs of fuel, and what the audit is made of; the rates are in `w.slope`."""
    y.fuel_flow = w.slope.fuel_used
    y.fuel_used = s.motion.fuel_used
    y.engine_work = s.motion.engine_work
    y.friction_heat = s.motion.clutch_heat + s.motion.synchroniser_heat + s.motion.brake_heat
    y.losses = s.motion.damper_loss + s.motion.gear_loss + s.motion.halfshaft_loss + s.motion.road_loss
    y.stored_energy = stored_energy(p, s.mode, s.motion)


@kernel
def observe(p: ConventionalParameters, s: ConventionalState, y: ConventionalOutputs, w: ConventionalWork) -> None:
    """Write the outputs."""
    rates(p, s.mode, s.motion, w.slope)
    observe_driveline(p, s, y, w)
    observe_vehicle(p, s, y, w)
    observe_energy(p, s, y, w)


@kernel
def roll(p: ConventionalParameters, s: ConventionalState, u: ConventionalInputs) -> None:
    """Roll steadily, wound up by the engine; below the launch speed the engine turns at it, and the clutch slips."""
    s.motion.engine_speed = max(s.motion.clutch_speed, p.clutch.launch_speed)
    slips = s.motion.engine_speed > s.motion.clutch_speed
    u.engine_torque_request = p.start.engine_torque
    u.clutch_torque_command = abs(p.start.engine_torque) if slips else p.clutch.torque_limit
    s.motion.engine_torque = p.start.engine_torque
    s.motion.clutch_twist = p.start.engine_torque / p.clutch.stiffness
    s.motion.halfshaft_twist = p.start.engine_torque * s.mode.ratio / p.halfshaft.stiffness


@kernel
def init(
    p: ConventionalParameters,
    s: ConventionalState,
    u: ConventionalInputs,
    y: ConventionalOutputs,
    w: ConventionalWork,
) -> None:
    """Roll in gear; or stand, the clutch open, the engine at idle or at rest."""
    clear(s.motion)
    u.engine_torque_request = 0.0
    u.clutch_torque_command = 0.0
    u.brake_torque_command = 0.0
    u.gear_command = 0.0
    prepare(p, s.mode)
    s.motion.wheel_speed = p.start.speed / p.vehicle.wheel_radius
    s.motion.clutch_speed = s.mode.ratio * s.motion.wheel_speed
    if p.start.speed > 0.0:
        roll(p, s, u)
    elif p.start.engine_running == 1:
        s.motion.engine_speed = p.engine.idle_speed
    start_dead_time(s.engine_delay, u.engine_torque_request)
    s.mode.capacity = launch_capacity(p.clutch, u.clutch_torque_command)
    observe(p, s, y, w)


@kernel
def step(
    p: ConventionalParameters,
    s: ConventionalState,
    u: ConventionalInputs,
    y: ConventionalOutputs,
    w: ConventionalWork,
    dt: float,
) -> int:
    """Advance by dt; return 0, or 1 where a number is no longer finite."""
    follow_inputs(p, s, u, dt)
    substeps = to_index(dt / longest_substep(p, s, dt) + 0.999, 1, 100_000)
    h = dt / substeps
    for _i in range(substeps):
        substep(p, s, w, h)
    observe(p, s, y, w)
    asked = u.engine_torque_request + u.clutch_torque_command + u.brake_torque_command
    # never: the energy not finite where the inputs are, since the substeps are stable and every command is limited
    return 0 if is_finite(asked) and is_finite(y.stored_energy) else 1


def check(parameters: RecordArray, where: str) -> None:
    """Raise InputError where parameters, each in its range, contradict each other; see `Plant`."""
    check_gearbox(parameters["gearbox"], where)
    check_engine(parameters["engine"], where)


PLANT = Plant(
    "conventional",
    ConventionalParameters,
    ConventionalState,
    ConventionalInputs,
    ConventionalOutputs,
    ConventionalWork,
    init,
    step,
    check,
    LongitudinalModel.of,
)
