"""Records of the vehicle with a dual-clutch transmission; what is done with them stands in `dct`."""

from __future__ import annotations

from bitepoint.parts.body import Body, Road
from bitepoint.parts.clutch import Clutch
from bitepoint.parts.clutch_actuator import ClutchActuator
from bitepoint.parts.engine import Engine
from bitepoint.parts.gears import Gearbox
from bitepoint.parts.shaft import Shaft
from bitepoint.plants.solver import Solver
from bitepoint.records import Record, count, nested, quantity


class DctParameters(Record):
    """A vehicle with a dual-clutch transmission, and the road it stands on."""

    vehicle: Body = nested(Body, "the body")
    engine: Engine = nested(Engine, "the engine")
    clutch: Clutch = nested(Clutch, "clutch 1, which the vehicle moves off with")
    actuator: ClutchActuator = nested(ClutchActuator, "hydraulic actuator of clutch 1; off unless it is active")
    damper: Shaft = nested(Shaft, "torsional damper behind clutch 1, at the speed of the input shaft")
    gearbox: Gearbox = nested(Gearbox, "gearbox and final drive")
    halfshaft: Shaft = nested(Shaft, "both half-shafts and tyres, at the speed of the wheels")
    road: Road = nested(Road, "the road")
    solver: Solver = nested(Solver, "the integration")


class DctMotion(Record):
    """What is integrated. Work and losses count from the start; every loss only grows."""

    engine_speed: float = quantity("rad/s", -2000, 2000, "engine")
    plate_speed: float = quantity("rad/s", -2000, 2000, "driven plate of clutch 1")
    axle_speed: float = quantity("rad/s", -500, 500, "half-shafts, inboard end")
    wheel_speed: float = quantity("rad/s", -500, 500, "wheels; vehicle speed over wheel radius")
    damper_twist: float = quantity("rad", -10, 10, "driven plate against input shaft")
    halfshaft_twist: float = quantity("rad", -10, 10, "axle against wheel")
    clutch_pressure: float = quantity("Pa", 0, 1e9, "pressure of clutch 1; 0 without its actuator")
    distance: float = quantity("m", -1e6, 1e6, "way of the vehicle")
    engine_work: float = quantity("J", -1e9, 1e9, "work of the steady engine torque")
    friction_work: float = quantity("J", 0, 1e9, "heat in the clutch")
    engine_loss: float = quantity("J", 0, 1e9, "heat from the viscous friction of the engine")
    damper_loss: float = quantity("J", 0, 1e9, "heat in the torsional damper")
    gear_loss: float = quantity("J", 0, 1e9, "heat in the gears")
    halfshaft_loss: float = quantity("J", 0, 1e9, "heat in half-shafts and tyres")
    road_loss: float = quantity("J", 0, 1e9, "work against rolling and air resistance")


class DctMode(Record):
    """What is constant over a substep: the discrete modes, and all that follows from parameters and inputs alone."""

    locked: int = count(0, 1, "1 while clutch 1 does not slip")
    hill_hold: int = count(0, 1, "1 until the vehicle first moves: it cannot roll back")
    slip_direction: float = quantity("1", -1, 1, "sign of engine speed minus plate speed")
    rolling_direction: float = quantity("1", -1, 1, "sign of the vehicle's motion; 0 while it stands")
    substep: float = quantity("s", 0, 0.002, "longest substep")
    full_load_peak: float = quantity("N*m", 0, 5000, "highest torque of the engine")
    throttle_effect: float = quantity("1", 0, 50, "see parts.engine")
    capacity: float = quantity("N*m", 0, 30_000, "torque that clutch 1 can carry, without its actuator")
    pressure: float = quantity("Pa", 0, 1e9, "commanded pressure of clutch 1; 0 without its actuator")
    ratio: float = quantity("1", 0, 2500, "engine side speed over axle speed")
    engine_inertia: float = quantity("kg*m^2", 0, 25, "engine with its transient loss")
    axle_inertia: float = quantity("kg*m^2", 0, 1000, "all that turns with the axle, at the axle")
    vehicle_inertia: float = quantity("kg*m^2", 0, 200_000, "mass at the wheel")
    engine_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the engine's inertia")
    plate_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the plate's inertia")
    joint_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the inertia of both, locked")
    axle_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the axle's inertia")
    vehicle_mobility: float = quantity("1/(kg*m^2)", 0, 1e9, "one over the vehicle's inertia")
    grade_torque: float = quantity("N*m", -1e6, 1e6, "of the grade, at the wheel")
    rolling_torque: float = quantity("N*m", 0, 1e6, "of the rolling resistance, at the wheel")
    air_coefficient: float = quantity("N*m*s^2/rad^2", 0, 1000, "air resistance over wheel speed squared")


class DctState(Record):
    """State of the plant."""

    locked_time: float = quantity("s", 0, 1e9, "time since clutch 1 last locked; 0 while it slips")
    motion: DctMotion = nested(DctMotion, "what is integrated")
    mode: DctMode = nested(DctMode, "what is constant over a substep")


class DctWork(Record):
    """Scratch of the integrator."""

    start: DctMotion = nested(DctMotion, "motion at the start of the substep")
    stage: DctMotion = nested(DctMotion, "motion at a stage")
    slope: DctMotion = nested(DctMotion, "rates at a stage")
    sum: DctMotion = nested(DctMotion, "weighted sum of the rates")


class DctInputs(Record):
    """What the actuators do."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of clutch 1")


class DctOutputs(Record):
    """What can be seen of the vehicle."""

    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "speed of the driven plate of clutch 1")
    slip_speed: float = quantity("rad/s", -2000, 2000, "engine speed minus clutch speed")
    input_shaft_speed: float = quantity("rad/s", -2000, 2000, "gearbox input, behind the torsional damper")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle; positive forwards")
    vehicle_acceleration: float = quantity("m/s^2", -100, 100, "acceleration of the vehicle")
    longitudinal_acceleration: float = quantity(
        "m/s^2", -100, 100, "what an accelerometer shows along the road: acceleration, and gravity on a grade"
    )
    distance: float = quantity("m", -1e6, 1e6, "way since the start")
    engine_torque: float = quantity("N*m", -500, 5000, "engine torque with its transient loss")
    clutch_torque: float = quantity("N*m", -10_000, 10_000, "torque that clutch 1 carries")
    clutch_pressure: float = quantity("Pa", 0, 1e9, "pressure of clutch 1; 0 without its actuator")
    clutch_temperature: float = quantity("K", 0, 1e6, "temperature of the plates of clutch 1, all heat kept")
    damper_torque: float = quantity("N*m", -1e5, 1e5, "torque of the torsional damper")
    halfshaft_torque: float = quantity("N*m", -1e6, 1e6, "torque of both half-shafts")
    road_torque: float = quantity("N*m", -1e6, 1e6, "grade, rolling and air resistance at the wheels")
    clutch_locked: float = quantity("1", 0, 1, "1 while clutch 1 does not slip")
    clutch_locked_time: float = quantity("s", 0, 1e9, "time since clutch 1 last locked; 0 while it slips")
    vehicle_held: float = quantity("1", 0, 1, "1 while the vehicle is held at standstill")
    engine_work: float = quantity("J", -1e9, 1e9, "work of the steady engine torque since the start")
    friction_heat: float = quantity("J", 0, 1e9, "heat in the clutch since the start")
    losses: float = quantity("J", 0, 1e9, "all other heat and resistance since the start")
    stored_energy: float = quantity("J", -1e9, 1e9, "kinetic, elastic and potential energy")
