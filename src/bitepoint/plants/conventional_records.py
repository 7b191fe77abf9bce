"""Records of the conventional vehicle; what is done with them stands in `conventional`."""

from __future__ import annotations

from bitepoint.numerics.dead_time import DeadTime
from bitepoint.parts.amt import AutomatedGearbox
from bitepoint.parts.body import Body, Wheels
from bitepoint.parts.brake import Brake
from bitepoint.parts.launch_clutch import LaunchClutch
from bitepoint.parts.road_profile import ProfiledRoad
from bitepoint.parts.shaft import Shaft
from bitepoint.parts.torque_engine import TorqueEngine
from bitepoint.plants.solver import Solver
from bitepoint.records import Record, count, nested, quantity


class RollingStart(Record):
    """How the run starts: rolling in gear; or at a standstill, the clutch open."""

    speed: float = quantity("m/s", 0, 100, "speed of the vehicle; above 0 it rolls in gear", default=0.0)
    engine_torque: float = quantity("N*m", -500, 5000, "that the clutch carries when rolling", default=0.0)
    engine_running: int = count(0, 1, "at a standstill: 1 the engine idles, 0 it stands", default=1)


class ConventionalParameters(Record):
    """A vehicle with engine, clutch and automated gearbox, the road that it is on, and how it starts."""

    vehicle: Body = nested(Body, "the body")
    engine: TorqueEngine = nested(TorqueEngine, "the engine")
    clutch: LaunchClutch = nested(LaunchClutch, "the clutch, with the damper of its plate")
    gearbox: AutomatedGearbox = nested(AutomatedGearbox, "gearbox and final drive")
    halfshaft: Shaft = nested(Shaft, "both half-shafts, at the speed of the wheels")
    wheels: Wheels = nested(Wheels, "the wheels, which roll without slip")
    brake: Brake = nested(Brake, "the service brake")
    road: ProfiledRoad = nested(ProfiledRoad, "the road")
    start: RollingStart = nested(RollingStart, "how the run starts")
    solver: Solver = nested(Solver, "the integration")


class ConventionalMotion(Record):
    """What is integrated. Work and losses count from the start; every loss only grows."""

    engine_speed: float = quantity("rad/s", -2000, 2000, "engine")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "plate of the clutch and gearbox input")
    wheel_speed: float = quantity("rad/s", -500, 500, "wheels, and with them the vehicle")
    clutch_twist: float = quantity("rad", -10, 10, "damper of the clutch")
    halfshaft_twist: float = quantity("rad", -10, 10, "gearbox output against wheel")
    brake_twist: float = quantity("rad", -10, 10, "wheel against body, in the mounting of the brake")
    engine_torque: float = quantity("N*m", -500, 5000, "engine")
    brake_torque: float = quantity("N*m", 0, 1e5, "what the brake can hold")
    distance: float = quantity("m", -1e6, 1e6, "way of the vehicle")
    elevation: float = quantity("m", -1e5, 1e5, "height gained")
    fuel_used: float = quantity("kg", 0, 1e6, "fuel")
    engine_work: float = quantity("J", -1e9, 1e9, "work of the engine")
    clutch_heat: float = quantity("J", 0, 1e9, "heat of the slipping clutch")
    synchroniser_heat: float = quantity("J", 0, 1e9, "heat of the synchroniser")
    brake_heat: float = quantity("J", 0, 1e9, "heat of the sliding brake")
    damper_loss: float = quantity("J", 0, 1e9, "heat in the dampers of clutch and brake")
    gear_loss: float = quantity("J", 0, 1e9, "heat in the gears")
    halfshaft_loss: float = quantity("J", 0, 1e9, "heat in the half-shafts")
    road_loss: float = quantity("J", 0, 1e9, "work against rolling and air resistance")


class ConventionalMode(Record):
    """What is constant over a substep: the gear, the commands, and all that follows from the parameters alone."""

    gear: int = count(0, 8, "engaged gear; 0 neutral")
    next_gear: int = count(0, 8, "gear that is being engaged, or is engaged")
    idling: int = count(0, 1, "1 while nothing but idle speed is asked of the engine")
    neutral_time: float = quantity("s", 0, 10, "time that the gearbox has to stay in neutral")
    capacity: float = quantity("N*m", 0, 10_000, "torque that the clutch can carry")
    engine_request: float = quantity("N*m", -1e6, 1e6, "torque request, its dead time over")
    brake_command: float = quantity("N*m", -1e6, 1e6, "torque that the brake is commanded to hold")
    ratio: float = quantity("1", 0, 2500, "clutch speed over wheel speed in the next gear")
    inverse_ratio: float = quantity("1", 0, 1e9, "one over that")
    engine_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the engine's inertia")
    input_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the inertia of plate and gearbox input")
    wheel_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the inertia of wheels and vehicle, at the wheels")
    air_coefficient: float = quantity("N*m*s^2/rad^2", 0, 1e5, "torque of the air over wheel speed squared")
    rate: float = quantity("1/s", 0, 1e12, "bound of the fastest rate in gear")
    neutral_rate: float = quantity("1/s", 0, 1e12, "the same in neutral")
    fade_rate: float = quantity("1/s", 0, 1e12, "what is added near standstill, where friction turns its sign")


class ConventionalState(Record):
    """State of the plant."""

    motion: ConventionalMotion = nested(ConventionalMotion, "what is integrated")
    mode: ConventionalMode = nested(ConventionalMode, "what is constant over a substep")
    engine_delay: DeadTime = nested(DeadTime, "past requests for engine torque, N m")


class ConventionalWork(Record):
    """Scratch of the integrator."""

    stage: ConventionalMotion = nested(ConventionalMotion, "motion at a stage")
    slope: ConventionalMotion = nested(ConventionalMotion, "rates at a stage")
    sum: ConventionalMotion = nested(ConventionalMotion, "weighted sum of the rates")


class ConventionalInputs(Record):
    """What the actuators are asked for."""

    engine_torque_request: float = quantity("N*m", -500, 5000, "torque that the engine is asked for")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of the clutch; 0 opens it")
    brake_torque_command: float = quantity("N*m", 0, 1e5, "torque of the brake, all wheels together")
    gear_command: float = quantity("1", 0, 8, "gear to be engaged; 0 keeps the one there is")


class ConventionalOutputs(Record):
    """What can be seen of the vehicle."""

    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "speed of the driven plate of the clutch")
    slip_speed: float = quantity("rad/s", -2000, 2000, "engine speed minus clutch speed")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle; positive forwards")
    vehicle_acceleration: float = quantity("m/s^2", -100, 100, "acceleration of the vehicle")
    longitudinal_acceleration: float = quantity(
        "m/s^2", -100, 100, "what an accelerometer shows along the road: acceleration, and gravity on a grade"
    )
    distance: float = quantity("m", -1e6, 1e6, "way since the start")
    elevation: float = quantity("m", -1e5, 1e5, "height gained since the start")
    road_grade: float = quantity("1", -1, 1, "grade of the road here; positive uphill")
    engine_torque: float = quantity("N*m", -500, 5000, "engine torque at the crankshaft, any transient loss taken off")
    clutch_torque: float = quantity("N*m", -10_000, 10_000, "torque that the clutch carries")
    clutch_twist: float = quantity("rad", -10, 10, "twist of the damper of the clutch")
    brake_torque: float = quantity("N*m", -1e5, 1e5, "torque of the brake; positive slows forward motion")
    halfshaft_torque: float = quantity("N*m", -1e6, 1e6, "torque of both half-shafts")
    halfshaft_twist: float = quantity("rad", -10, 10, "twist of the half-shafts")
    torsional_speed: float = quantity(
        "rad/s", -2000, 2000, "rate of the half-shafts' twist, at the speed of the wheels"
    )
    gear: float = quantity("1", 0, 8, "engaged gear; 0 while shifting")
    gear_ratio: float = quantity(
        "1", 0, 2500, "input speed over wheel speed in the gear; while shifting, in the next one"
    )
    fuel_flow: float = quantity("kg/s", 0, 1, "fuel that the engine takes")
    fuel_used: float = quantity("kg", 0, 1e6, "fuel since the start")
    engine_work: float = quantity("J", -1e9, 1e9, "work of the engine since the start")
    friction_heat: float = quantity(
        "J", 0, 1e9, "heat in clutches, synchroniser, brakes and slipping tyres since the start"
    )
    losses: float = quantity("J", 0, 1e9, "all other heat and resistance since the start")
    stored_energy: float = quantity("J", -1e9, 1e9, "kinetic, elastic and potential energy")
