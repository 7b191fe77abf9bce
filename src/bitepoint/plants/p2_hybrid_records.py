"""Records of the P2 hybrid; what is done with them stands in `p2_hybrid`."""

from __future__ import annotations

from bitepoint.numerics.dead_time import DeadTime
from bitepoint.parts.amt import AutomatedGearbox
from bitepoint.parts.body import Body
from bitepoint.parts.brake import Brake
from bitepoint.parts.motor import Motor
from bitepoint.parts.separating_clutch import SeparatingClutch
from bitepoint.parts.shaft import Shaft
from bitepoint.parts.torque_engine import TorqueEngine
from bitepoint.parts.tyre import Tyre, TyreRoad
from bitepoint.plants.solver import Solver
from bitepoint.records import Record, count, nested, quantity


class Start(Record):
    """How the run starts: rolling in gear without slip, the clutch closed; or at a standstill, the clutch open."""

    speed: float = quantity("m/s", 0, 100, "speed of the vehicle; above 0 the clutch is closed", default=0.0)
    engine_torque: float = quantity("N*m", -500, 5000, "that clutch and half-shafts are wound up by", default=0.0)
    engine_running: int = count(0, 1, "at a standstill: 1 the engine idles, 0 it stands", default=1)


class P2Parameters(Record):
    """A P2 hybrid, the road that it is on, and how it starts."""

    vehicle: Body = nested(Body, "the body")
    engine: TorqueEngine = nested(TorqueEngine, "the engine")
    clutch: SeparatingClutch = nested(SeparatingClutch, "the clutch between engine and motor, with its damper")
    motor: Motor = nested(Motor, "the motor, on the gearbox input")
    gearbox: AutomatedGearbox = nested(AutomatedGearbox, "gearbox and final drive")
    halfshaft: Shaft = nested(Shaft, "both half-shafts, at the speed of the wheels")
    tyre: Tyre = nested(Tyre, "tyres and wheels")
    brake: Brake = nested(Brake, "the service brake")
    road: TyreRoad = nested(TyreRoad, "the road")
    start: Start = nested(Start, "how the run starts")
    solver: Solver = nested(Solver, "the integration")


class P2Motion(Record):
    """What is integrated. Work and losses count from the start; every loss only grows."""

    engine_speed: float = quantity("rad/s", -2000, 2000, "engine")
    motor_speed: float = quantity("rad/s", -2000, 2000, "motor and gearbox input")
    wheel_speed: float = quantity("rad/s", -500, 500, "driven wheels")
    speed: float = quantity("m/s", -150, 150, "vehicle")
    clutch_twist: float = quantity("rad", -10, 10, "damper of the clutch")
    halfshaft_twist: float = quantity("rad", -10, 10, "gearbox output against wheel")
    brake_twist: float = quantity("rad", -10, 10, "wheel against body, in the mounting of the brake")
    engine_torque: float = quantity("N*m", -500, 5000, "engine")
    motor_torque: float = quantity("N*m", -5000, 5000, "motor")
    brake_torque: float = quantity("N*m", 0, 1e5, "what the brake can hold")
    motor_temperature: float = quantity("K", 0, 2000, "winding of the motor")
    distance: float = quantity("m", -1e6, 1e6, "way of the vehicle")
    fuel_used: float = quantity("kg", 0, 1e6, "fuel")
    electric_energy: float = quantity("J", -1e9, 1e9, "drawn from the bus")
    engine_work: float = quantity("J", -1e9, 1e9, "work of the engine")
    motor_work: float = quantity("J", -1e9, 1e9, "work of the motor at its shaft")
    clutch_heat: float = quantity("J", 0, 1e9, "heat of the slipping clutch")
    synchroniser_heat: float = quantity("J", 0, 1e9, "heat of the synchroniser")
    brake_heat: float = quantity("J", 0, 1e9, "heat of the sliding brake")
    tyre_heat: float = quantity("J", 0, 1e9, "heat of the slipping tyres")
    damper_loss: float = quantity("J", 0, 1e9, "heat in the dampers of clutch and brake")
    gear_loss: float = quantity("J", 0, 1e9, "heat in the gears")
    halfshaft_loss: float = quantity("J", 0, 1e9, "heat in the half-shafts")
    road_loss: float = quantity("J", 0, 1e9, "work against rolling and air resistance")


class P2Mode(Record):
    """What is constant over a substep: the gear, the commands, and all that follows from the parameters alone."""

    gear: int = count(0, 8, "engaged gear; 0 neutral")
    next_gear: int = count(0, 8, "gear that is being engaged, or is engaged")
    idling: int = count(0, 1, "1 while nothing but idle speed is asked of the engine")
    neutral_time: float = quantity("s", 0, 10, "time that the gearbox has to stay in neutral")
    capacity: float = quantity("N*m", 0, 10_000, "torque that the clutch can carry")
    engine_request: float = quantity("N*m", -1e6, 1e6, "torque request, its dead time over")
    motor_target: float = quantity("N*m", -5000, 5000, "torque command, its dead time over, within the peak")
    motor_command: float = quantity("N*m", -5000, 5000, "the same, its rate limited")
    motor_peak: float = quantity("N*m", 0, 5000, "peak torque now")
    motor_power: float = quantity("W", 0, 1e9, "peak power now")
    brake_command: float = quantity("N*m", -1e6, 1e6, "torque that the brake is commanded to hold")
    ratio: float = quantity("1", 0, 2500, "motor speed over wheel speed in the next gear")
    inverse_ratio: float = quantity("1", 0, 1e9, "one over that")
    engine_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the engine's inertia")
    motor_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the motor's inertia")
    wheel_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the inertia of the wheels")
    load: float = quantity("N", 0, 1e6, "of the tyres")
    grade_force: float = quantity("N", -1e6, 1e6, "of the grade")
    rolling_torque: float = quantity("N*m", 0, 1e6, "of the rolling resistance, at the wheel")
    air_coefficient: float = quantity("N*s^2/m^2", 0, 1000, "air resistance over speed squared")
    rate: float = quantity("1/s", 0, 1e12, "bound of the fastest rate, the tyres' left out")
    tyre_rate: float = quantity("m/s^2", 0, 1e12, "rate of the tyres times speed")


class P2State(Record):
    """State of the plant."""

    motion: P2Motion = nested(P2Motion, "what is integrated")
    mode: P2Mode = nested(P2Mode, "what is constant over a substep")
    engine_delay: DeadTime = nested(DeadTime, "past requests for engine torque, N m")
    motor_delay: DeadTime = nested(DeadTime, "past commands of the motor torque, N m")


class P2Work(Record):
    """Scratch of the integrator."""

    stage: P2Motion = nested(P2Motion, "motion at a stage")
    slope: P2Motion = nested(P2Motion, "rates at a stage")
    sum: P2Motion = nested(P2Motion, "weighted sum of the rates")


class P2Inputs(Record):
    """What the actuators are asked for."""

    engine_torque_request: float = quantity("N*m", -500, 5000, "torque that the engine is asked for")
    motor_torque_command: float = quantity("N*m", -5000, 5000, "torque that the motor is asked for; below 0 generating")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of the clutch; 0 opens it")
    brake_torque_command: float = quantity("N*m", 0, 1e5, "torque of the brake, all wheels together")
    gear_command: float = quantity("1", 0, 8, "gear to be engaged; 0 keeps the one there is")


class P2Outputs(Record):
    """What can be seen of the vehicle."""

    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    motor_speed: float = quantity("rad/s", -2000, 2000, "speed of the motor and of the gearbox input")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle; positive forwards")
    vehicle_acceleration: float = quantity("m/s^2", -100, 100, "acceleration of the vehicle")
    longitudinal_acceleration: float = quantity(
        "m/s^2", -100, 100, "what an accelerometer shows along the road: acceleration, and gravity on a grade"
    )
    distance: float = quantity("m", -1e6, 1e6, "way since the start")
    tyre_slip: float = quantity("1", -500, 500, "slip of the tyres; positive when driving")
    tyre_force: float = quantity("N", -1e6, 1e6, "force of the tyres on the vehicle")
    engine_torque: float = quantity("N*m", -500, 5000, "engine torque at the crankshaft, any transient loss taken off")
    motor_torque: float = quantity("N*m", -5000, 5000, "torque of the motor")
    motor_torque_limit: float = quantity("N*m", 0, 5000, "highest torque that the motor could give now, either way")
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
    motor_current: float = quantity("A", -1e6, 1e6, "current from the bus; below 0 generating")
    motor_voltage: float = quantity("V", 0, 2000, "voltage of the bus")
    motor_temperature: float = quantity("K", 0, 2000, "temperature of the winding of the motor")
    fuel_flow: float = quantity("kg/s", 0, 1, "fuel that the engine takes")
    fuel_used: float = quantity("kg", 0, 1e6, "fuel since the start")
    electric_energy: float = quantity("J", -1e9, 1e9, "energy drawn from the bus since the start")
    engine_work: float = quantity("J", -1e9, 1e9, "work of the engine since the start")
    motor_work: float = quantity("J", -1e9, 1e9, "work of the motor at its shaft since the start")
    friction_heat: float = quantity(
        "J", 0, 1e9, "heat in clutches, synchroniser, brakes and slipping tyres since the start"
    )
    losses: float = quantity("J", 0, 1e9, "all other heat and resistance since the start")
    stored_energy: float = quantity("J", -1e9, 1e9, "kinetic, elastic and potential energy")
