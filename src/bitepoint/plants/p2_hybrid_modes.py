"""What is constant over a substep of the P2 hybrid: the gear, limits, what follows from parameters, and its length."""

from __future__ import annotations

import math

from bitepoint.kernels import kernel, to_index
from bitepoint.parts.amt import FRICTION_FADE_SPEED, LEAST_RATIO, SYNCHRONISER_BAND, gear_ratio
from bitepoint.parts.motor import hot_share, power_now
from bitepoint.parts.tyre import SLIP_SPEED, slip_stiffness, weight_across, weight_along
from bitepoint.plants.p2_hybrid_records import P2Mode, P2Parameters, P2State
from bitepoint.plants.stiffness import NEUTRAL_RELAXATION, ROLLING_FADE_SPEED, STABILITY, spring_rate

BRAKING = 15.0
"""Deceleration that the length of a substep allows for within a step, m/s^2: what slows, stiffens the tyres."""


@kernel
def prepare(p: P2Parameters, m: P2Mode) -> None:
    """Write into the mode what follows from the parameters, and the gear of the start."""
    m.gear = p.gearbox.gear
    m.idling = 0
    m.neutral_time = 0.0
    m.engine_request = 0.0
    m.motor_target = 0.0
    m.motor_command = 0.0
    m.brake_command = 0.0
    m.engine_mobility = 1.0 / p.engine.inertia
    m.motor_mobility = 1.0 / p.motor.inertia
    m.wheel_mobility = 1.0 / p.tyre.wheel_inertia
    m.load = weight_across(p.vehicle.mass, p.road.grade)
    m.grade_force = weight_along(p.vehicle.mass, p.road.grade)
    m.rolling_torque = p.vehicle.rolling_resistance * m.load * p.vehicle.wheel_radius
    m.air_coefficient = 0.5 * p.road.air_density * p.vehicle.drag_coefficient * p.vehicle.frontal_area
    choose_gear(p, m, p.gearbox.gear)


@kernel
def choose_gear(p: P2Parameters, m: P2Mode, gear: int) -> None:
    """Make a gear, 1..8, the next one."""
    m.next_gear = max(min(gear, 8), 1)
    m.ratio = max(gear_ratio(p.gearbox, m.next_gear), LEAST_RATIO)
    m.inverse_ratio = 1.0 / m.ratio
    bound_rates(p, m)


@kernel
def follow_gear(p: P2Parameters, m: P2Mode, command: float) -> None:
    """Go to neutral where another gear is commanded; one that there is not is as good as none."""
    wanted = to_index(command + 0.5, 0, 8)
    if wanted != 0 and wanted != m.next_gear and gear_ratio(p.gearbox, wanted) >= LEAST_RATIO:
        m.gear = 0
        m.neutral_time = p.gearbox.shift_time
        choose_gear(p, m, wanted)


@kernel
def limit_motor(p: P2Parameters, s: P2State) -> None:
    """Write into the mode what the motor can give, as hot as it is."""
    s.mode.motor_peak = p.motor.torque_limit * hot_share(p.motor, s.motion.motor_temperature)
    s.mode.motor_power = power_now(p.motor, s.motion.motor_temperature)


@kernel
def bound_rates(p: P2Parameters, m: P2Mode) -> None:
    """Write the bound of the fastest rates in the gear: those of each part, added up."""
    geared = m.inverse_ratio**2 * m.motor_mobility
    clutch = spring_rate(p.clutch.stiffness, p.clutch.damping, m.engine_mobility + m.motor_mobility)
    clutch = clutch + p.clutch.stiffness / p.clutch.damping
    shaft = (
        spring_rate(p.halfshaft.stiffness, p.halfshaft.damping, geared + m.wheel_mobility) + 1.0 / NEUTRAL_RELAXATION
    )
    brake = spring_rate(p.brake.stiffness, p.brake.damping, m.wheel_mobility) + p.brake.stiffness / p.brake.damping
    lags = 1.0 / p.engine.lag + 1.0 / p.motor.lag + 1.0 / p.brake.lag
    governor = math.sqrt(p.engine.idle_gain * m.engine_mobility / p.engine.lag)
    steepness = p.gearbox.synchroniser_torque / SYNCHRONISER_BAND
    synchroniser = steepness * (m.motor_mobility + m.ratio**2 * m.wheel_mobility)
    passed = 2.0 * m.ratio * (p.clutch.torque_limit + p.motor.torque_limit)  # a step rings up to twice its torque
    meshing = (1.0 / p.gearbox.efficiency - 1.0) * passed / FRICTION_FADE_SPEED * geared
    rolling = m.rolling_torque / ROLLING_FADE_SPEED * m.wheel_mobility
    m.rate = clutch + shaft + brake + lags + governor + synchroniser + meshing + rolling
    slope = slip_stiffness(p.tyre, p.road.friction, m.load)
    m.tyre_rate = slope * (p.vehicle.wheel_radius**2 * m.wheel_mobility + 1.0 / p.vehicle.mass)


@kernel
def longest_substep(p: P2Parameters, s: P2State, dt: float) -> float:
    """Return the longest substep, s, that is stable over the next dt (s): the slower, the stiffer the tyres."""
    speed = max(abs(s.motion.speed) - BRAKING * dt, SLIP_SPEED)
    return min(p.solver.substep, STABILITY / (s.mode.rate + s.mode.tyre_rate / speed))
