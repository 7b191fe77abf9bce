"""What is constant over a substep of the conventional vehicle: gear, commands, what follows from parameters, length."""

from __future__ import annotations

import math

from bitepoint.kernels import kernel, to_index
from bitepoint.parts.amt import FRICTION_FADE_SPEED, LEAST_RATIO, SYNCHRONISER_BAND, gear_ratio
from bitepoint.plants.conventional_records import ConventionalMode, ConventionalParameters, ConventionalState
from bitepoint.plants.stiffness import NEUTRAL_RELAXATION, ROLLING_FADE_SPEED, STABILITY, spring_rate
from bitepoint.units import STANDARD_GRAVITY

BRAKING = 15.0
"""Deceleration that the length of a substep allows for within a step, m/s^2: friction fades at standstill."""

SWING = 5.0
"""How far the gearbox output may swing about the speed of the wheels, rad/s (chosen: a rough shift in 1st gear)."""


@kernel
def prepare(p: ConventionalParameters, m: ConventionalMode) -> None:
    """Write into the mode what follows from the parameters, and the gear of the start."""
    r = p.vehicle.wheel_radius
    m.gear = p.gearbox.gear
    m.idling = 0
    m.neutral_time = 0.0
    m.engine_request = 0.0
    m.brake_command = 0.0
    m.engine_mobility = 1.0 / p.engine.inertia
    m.input_mobility = 1.0 / p.clutch.plate_inertia
    m.wheel_mobility = 1.0 / (p.vehicle.mass * r**2 + p.wheels.inertia)
    m.air_coefficient = 0.5 * p.road.air_density * p.vehicle.drag_coefficient * p.vehicle.frontal_area * r * r**2
    choose_gear(p, m, p.gearbox.gear)


@kernel
def choose_gear(p: ConventionalParameters, m: ConventionalMode, gear: int) -> None:
    """Make a gear, 1..8, the next one."""
    m.next_gear = max(min(gear, 8), 1)
    m.ratio = max(gear_ratio(p.gearbox, m.next_gear), LEAST_RATIO)
    m.inverse_ratio = 1.0 / m.ratio
    bound_rates(p, m)


@kernel
def follow_gear(p: ConventionalParameters, m: ConventionalMode, command: float) -> None:
    """Go to neutral where another gear is commanded; one that there is not is as good as none."""
    wanted = to_index(command + 0.5, 0, 8)
    if wanted != 0 and wanted != m.next_gear and gear_ratio(p.gearbox, wanted) >= LEAST_RATIO:
        m.gear = 0
        m.neutral_time = p.gearbox.shift_time
        choose_gear(p, m, wanted)


@kernel
def bound_rates(p: ConventionalParameters, m: ConventionalMode) -> None:
    """Write the bounds of the fastest rates in the gear and in neutral: those of each part, added up."""
    geared = m.inverse_ratio**2 * m.input_mobility
    clutch = spring_rate(p.clutch.stiffness, p.clutch.damping, m.engine_mobility + m.input_mobility)
    clutch = clutch + p.clutch.stiffness / p.clutch.damping
    brake = spring_rate(p.brake.stiffness, p.brake.damping, m.wheel_mobility) + p.brake.stiffness / p.brake.damping
    lags = 1.0 / p.engine.lag + 1.0 / p.brake.lag
    governor = math.sqrt(p.engine.idle_gain * m.engine_mobility / p.engine.lag)
    m.rate = clutch + brake + lags + governor
    m.rate = m.rate + spring_rate(p.halfshaft.stiffness, p.halfshaft.damping, geared + m.wheel_mobility)
    steepness = p.gearbox.synchroniser_torque / SYNCHRONISER_BAND
    synchroniser = steepness * (m.input_mobility + m.ratio**2 * m.wheel_mobility)
    m.neutral_rate = clutch + brake + lags + governor + synchroniser + 1.0 / NEUTRAL_RELAXATION
    passed = 2.0 * m.ratio * p.clutch.torque_limit  # a step rings up to twice its torque
    meshing = (1.0 / p.gearbox.efficiency - 1.0) * passed / FRICTION_FADE_SPEED * geared
    rolling = p.vehicle.rolling_resistance * p.vehicle.mass * STANDARD_GRAVITY * p.vehicle.wheel_radius
    m.fade_rate = meshing + rolling / ROLLING_FADE_SPEED * m.wheel_mobility


@kernel
def longest_substep(p: ConventionalParameters, s: ConventionalState, dt: float) -> float:
    """Return the longest substep, s, that is stable over the next dt (s): shorter near standstill."""
    rate = s.mode.rate
    if s.mode.gear == 0:
        rate = max(rate, s.mode.neutral_rate)
    slowing = BRAKING * dt / p.vehicle.wheel_radius + SWING
    if abs(s.motion.wheel_speed) < FRICTION_FADE_SPEED + slowing:
        rate = rate + s.mode.fade_rate
    return min(p.solver.substep, STABILITY / rate)
