"""Supervisor of a parallel hybrid: a driver who follows a speed, with powertrain, brake and gears.

    F = m a* + road load(v*) + m / T (v* - v) + integral,      v*: speed to follow, a*: its rate

The powertrain gives F within its limits and recuperates down to a torque that fades near standstill; the brake takes
what the motor, which recuperates, leaves. a* is the filtered difference of v*, without looking ahead. The road load is
that of a level road and of the mass in the vehicle file; what is not so, the integral finds. It rests while a limit is
met, at a standstill and while shifting.

Gears follow the speed of the gearbox input, with hysteresis; with a schedule, a shift map over the torque request, as a
share of the highest, and the speed of the vehicle. To shift, the driver takes the torque away, waits until
the driveline has unwound, commands the gear, and gives torque again when it is engaged; meanwhile the brake does the
braking. At a standstill the brake holds, and 1st gear is engaged.
"""

from __future__ import annotations

import numpy as np

from bitepoint.controllers.controller import Controller, only_defaults
from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.models.shift_map import ShiftMap, mapped_gear, shift_map
from bitepoint.parts.amt import GEARS
from bitepoint.records import Record, RecordArray, count, nested, quantity
from bitepoint.units import STANDARD_GRAVITY

DRIVING, RELEASING, SHIFTING = range(3)
PHASES = ("driving", "releasing", "shifting")

TARGET_FILTER = 0.1
"""Time constant of the rate of the speed to follow, s (chosen: a tenth of what a driver sees)."""

RECUPERATION_SPEED = 1.0
"""Speed up to which the brake brakes alone, m/s; over the same span beyond, recuperation comes in (chosen)."""

STANDING_TARGET = 0.05
"""Speed to follow below which the driver wants to stand, m/s."""

RELEASED = 1.0
"""Torque at the input below which it counts as taken away, N m."""


class SpeedDriverCalibration(Record):
    """What can be set."""

    response_time: float = quantity("s", 0.1, 20, "in which an error of the speed would fall to 1/e", default=1.0)
    integral_time: float = quantity("s", 0.5, 1000, "of the integral part", default=5.0)
    recuperation_torque: float = quantity(
        "N*m", 0, 1000, "most that is recuperated, at the input of the gearbox", default=150.0
    )
    torque_rate: float = quantity("N*m/s", 1, 1e5, "fastest change of the torque request", default=400.0)
    brake_rate: float = quantity("N*m/s", 1, 1e6, "fastest change of the brake's torque", default=10_000.0)
    hold_torque: float = quantity("N*m", 0, 1e5, "of the brake at a standstill", default=1000.0)
    standstill_speed: float = quantity("m/s", 0, 3, "below which the vehicle may be held", default=0.3)
    shift_up_speed: float = quantity("rad/s", 50, 1500, "of the gearbox input, to shift up", default=220.0)
    shift_down_speed: float = quantity("rad/s", 20, 1000, "of the gearbox input, to shift down", default=115.0)
    schedule: int = count(0, 1, "1: gears follow the shift map; 0: the speed of the gearbox input", default=0)
    shift_pause: float = quantity("s", 0, 10, "shortest time in a gear", default=1.0)
    unwinding_time: float = quantity("s", 0, 2, "from no torque requested until the gear is left", default=0.3)


class SpeedDriverParameters(Record):
    """What the step reads."""

    calibration: SpeedDriverCalibration = nested(SpeedDriverCalibration, "what can be set")
    mass: float = quantity("kg", 1, 60_000, "of the vehicle")
    wheel_mass: float = quantity("kg", 0, 60_000, "that stands for the inertia of the wheels")
    input_inertia: float = quantity("kg*m^2", 0, 20, "of the gearbox input with the motor")
    wheel_radius: float = quantity("m", 0.1, 1.5, "of the wheels")
    rolling_force: float = quantity("N", 0, 1e6, "rolling resistance on a level road")
    air_coefficient: float = quantity("N*s^2/m^2", 0, 1000, "air resistance over speed squared")
    torque_limit: float = quantity("N*m", 0, 5000, "highest torque request")
    brake_limit: float = quantity("N*m", 0, 1e5, "highest torque of the brake")
    shift_map: ShiftMap = nested(ShiftMap, "the shift map")
    gears: int = count(1, GEARS, "number of gears", default=1)


class SpeedDriverState(Record):
    """Memory between two steps."""

    phase: int = count(0, 2, "what the driver does", names=PHASES)
    gear: int = count(0, GEARS, "commanded gear")
    next_gear: int = count(0, GEARS, "gear that comes next")
    elapsed: float = quantity("s", 0, 1e6, "time in the gear, or since the torque was taken away")
    target: float = quantity("m/s", 0, 100, "last speed to follow")
    rate: float = quantity("m/s^2", -1000, 1000, "its rate, filtered")
    integral: float = quantity("N", -1e6, 1e6, "integral part of the force")
    torque: float = quantity("N*m", -5000, 5000, "last torque request")
    brake: float = quantity("N*m", 0, 1e5, "last torque of the brake")


class SpeedDriverMeasurement(Record):
    """What it sees."""

    speed_target: float = quantity("m/s", 0, 100, "speed to follow")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle")
    gear: float = quantity("1", 0, 8, "engaged gear; 0 while shifting")
    gear_ratio: float = quantity("1", 0, 2500, "input speed over wheel speed in the gear, or in the next one")
    motor_torque: float = quantity("N*m", -5000, 5000, "torque of the motor")


class SpeedDriverCommand(Record):
    """What it commands."""

    torque_request: float = quantity("N*m", -5000, 5000, "torque at the input of the gearbox that the driver asks for")
    brake_torque_command: float = quantity("N*m", 0, 1e5, "torque of the brake, all wheels together")
    gear_command: float = quantity("1", 0, 8, "gear to be engaged")


@kernel
def wanted_gear(p: SpeedDriverParameters, gear: int, input_speed: float) -> int:
    """Return the gear, 1.., that suits the speed of the input, rad/s: the one there is or its neighbour."""
    now = max(min(gear, p.gears), 1)
    wanted = now
    if input_speed > p.calibration.shift_up_speed:
        wanted = min(now + 1, p.gears)
    elif input_speed < p.calibration.shift_down_speed:
        wanted = max(now - 1, 1)
    return wanted


@kernel
def choose_gear(
    p: SpeedDriverParameters, s: SpeedDriverState, gear: int, speed: float, ratio: float, dt: float
) -> None:
    """Advance the phase; in neutral `gear` is 0. `speed`: of the vehicle, m/s; `ratio`: of the input to the wheels."""
    s.elapsed = min(s.elapsed + dt, 1e6)
    if s.phase == DRIVING:
        if gear > 0 and s.elapsed >= p.calibration.shift_pause:
            share = clamp(s.torque / p.torque_limit, 0.0, 1.0)
            mapped = min(mapped_gear(p.shift_map, gear, share, max(speed, 0.0)), p.gears)
            lined = wanted_gear(p, gear, ratio * speed / p.wheel_radius)
            s.next_gear = mapped if p.calibration.schedule == 1 else lined
            if s.next_gear != gear:
                s.phase = RELEASING
                s.elapsed = 0.0
    elif s.phase == RELEASING:
        if abs(s.torque) > RELEASED:
            s.elapsed = 0.0
        elif s.elapsed >= p.calibration.unwinding_time:
            s.gear = s.next_gear
            s.phase = SHIFTING
    elif gear == s.gear:
        s.phase = DRIVING
        s.elapsed = 0.0


@kernel
def road_load(p: SpeedDriverParameters, speed: float) -> float:
    """Return what rolling and air take at a speed >= 0 (m/s) on a level road, N."""
    rolling = p.rolling_force if speed > STANDING_TARGET else 0.0
    return rolling + p.air_coefficient * speed * speed


@kernel
def follow(p: SpeedDriverParameters, s: SpeedDriverState, speed: float, ratio: float, given: float, dt: float) -> None:
    """Write torque and brake that follow the target from `speed` (m/s), with `ratio` to the wheels.

    The brake brakes what the torque `given` at the input (N m) leaves, which lags behind the request.
    """
    lever = ratio / p.wheel_radius
    inertia = p.mass + p.wheel_mass + p.input_inertia * lever * lever
    error = s.target - speed
    gain = p.mass / p.calibration.response_time
    force = inertia * s.rate + road_load(p, s.target) + gain * error + s.integral
    faded = clamp(speed / RECUPERATION_SPEED - 1.0, 0.0, 1.0)
    low = -p.calibration.recuperation_torque * faded
    wanted = clamp(force / lever, low, p.torque_limit) if s.phase == DRIVING else 0.0
    change = p.calibration.torque_rate * dt
    s.torque = clamp(wanted, s.torque - change, s.torque + change)
    friction = max(given * lever - force, 0.0) * p.wheel_radius if force < 0.0 else 0.0
    step = p.calibration.brake_rate * dt
    s.brake = clamp(clamp(friction, s.brake - step, s.brake + step), 0.0, p.brake_limit)
    limited = (force > lever * p.torque_limit and error > 0.0) or (friction > p.brake_limit and error < 0.0)
    if s.phase == DRIVING and not limited:
        s.integral = clamp(s.integral + gain / p.calibration.integral_time * error * dt, -1e6, 1e6)


@kernel
def hold(p: SpeedDriverParameters, s: SpeedDriverState, dt: float) -> None:
    """Write torque and brake that hold the vehicle."""
    change = p.calibration.torque_rate * dt
    s.torque = clamp(0.0, s.torque - change, s.torque + change)
    step = p.calibration.brake_rate * dt
    s.brake = clamp(min(p.calibration.hold_torque, p.brake_limit), s.brake - step, s.brake + step)
    s.integral = 0.0


@kernel
def command(s: SpeedDriverState, c: SpeedDriverCommand) -> None:
    """Write the commands."""
    c.torque_request = s.torque
    c.brake_torque_command = s.brake
    c.gear_command = float(s.gear)


@kernel
def init(p: SpeedDriverParameters, s: SpeedDriverState, m: SpeedDriverMeasurement, c: SpeedDriverCommand) -> None:
    """Take over in the gear there is, without torque."""
    s.phase = DRIVING
    s.gear = to_index(m.gear + 0.5, 0, GEARS)
    s.next_gear = s.gear
    s.elapsed = 0.0
    s.target = clamp(m.speed_target, 0.0, 100.0)
    s.rate = 0.0
    s.integral = 0.0
    s.torque = 0.0
    s.brake = 0.0
    command(s, c)


@kernel
def step(
    p: SpeedDriverParameters, s: SpeedDriverState, m: SpeedDriverMeasurement, c: SpeedDriverCommand, dt: float
) -> int:
    """Follow the speed; return 0, or 1 where a measurement is no number, and leave the commands as they are."""
    status = 1
    if is_finite(m.speed_target + m.vehicle_speed) and is_finite(m.gear + m.gear_ratio + m.motor_torque):
        status = 0
        target = clamp(m.speed_target, 0.0, 100.0)
        speed = clamp(m.vehicle_speed, -150.0, 150.0)
        ratio = clamp(m.gear_ratio, 0.1, 2500.0)
        rate = (target - s.target) / dt
        s.rate = clamp(s.rate + dt / (TARGET_FILTER + dt) * (rate - s.rate), -1000.0, 1000.0)
        s.target = target
        choose_gear(p, s, to_index(m.gear + 0.5, 0, GEARS), speed, ratio, dt)
        if target < STANDING_TARGET and speed < p.calibration.standstill_speed:
            hold(p, s, dt)
        else:
            given = clamp(m.motor_torque, -5000.0, 5000.0) if m.gear > 0.5 else 0.0
            follow(p, s, speed, ratio, given, dt)
        command(s, c)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (blocks vehicle, tyre, motor, engine, gearbox, brake, road) and calibrations.

    The shift map has the speeds of the calibration; `models.shift_map.with_shift_map` gives another.
    The road is taken as level. The torque is limited to the most that the engine can give.
    """
    parameters = SpeedDriverParameters.zeros(len(calibration))
    body, curve = vehicle["vehicle"], vehicle["engine"]["full_load"][0]
    parameters["calibration"] = calibration
    parameters["mass"] = body["mass"]
    parameters["wheel_radius"] = body["wheel_radius"]
    parameters["wheel_mass"] = vehicle["tyre"]["wheel_inertia"] / body["wheel_radius"] ** 2
    parameters["input_inertia"] = vehicle["motor"]["inertia"]
    parameters["rolling_force"] = body["rolling_resistance"] * body["mass"] * STANDARD_GRAVITY
    parameters["air_coefficient"] = (
        0.5 * vehicle["road"]["air_density"] * body["drag_coefficient"] * body["frontal_area"]
    )
    parameters["torque_limit"] = curve["y"][: curve["points"]].max()
    parameters["brake_limit"] = vehicle["brake"]["torque_limit"]
    gears = parameters["gears"] = int(np.argmin(np.append(vehicle["gearbox"]["ratios"][0], 0.0) > 0.0))
    if gears > 1:
        ratios = vehicle["gearbox"]["ratios"][0, :gears] * vehicle["gearbox"]["final_drive"][0]
        per_input = np.repeat(body["wheel_radius"][0] / ratios[:, np.newaxis], 2, axis=1)
        for lane, k in enumerate(calibration):
            up, down = k["shift_up_speed"] * per_input[:-1], k["shift_down_speed"] * per_input[1:]
            parameters["shift_map"][lane] = shift_map(np.array([0.0, 1.0]), up, down)[0]
    return parameters


CONTROLLER = Controller(
    name="speed_driver",
    meaning="follows a speed with torque, brake and gears",
    plants=("p2_hybrid",),
    calibration=SpeedDriverCalibration,
    calibrations=only_defaults,
    default_calibration="default",
    parameters=SpeedDriverParameters,
    state=SpeedDriverState,
    measurement=SpeedDriverMeasurement,
    command=SpeedDriverCommand,
    design=design,
    init=init,
    step=step,
)
