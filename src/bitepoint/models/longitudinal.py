"""A vehicle with engine, gears and wheels in balance with the road: what a motion takes of the engine, and what fuel.

    F = (m + Jw / r^2) a + m g (f cos + sin) + c v^2,      T_in = F r / (i eta) driving, F r eta / i in overrun
    T_engine = T_in + J_e i a / r                          the engine turns with the wheels
    T_engine = max(T_in, 0), engine speed = launch speed   below: the clutch slips, and what it turns to heat is paid;
                                                           it drags nobody: the engine idles while the brakes work

Nothing swings here; torque and speed follow at once. i is the ratio of gear and final drive together.

Source: the vehicle of page 5 of the specification.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bitepoint.kernels import kernel
from bitepoint.models.fuel import TransientCorrection, transient_correction
from bitepoint.parts.amt import AutomatedGearbox, gear_ratio
from bitepoint.parts.body import Body, Road, air_coefficient, grade_torque, rolling_torque
from bitepoint.parts.torque_engine import TorqueEngine, fuel_flow
from bitepoint.records import Record, RecordArray, nested, quantity


class LongitudinalModel(Record):
    """A vehicle in balance."""

    vehicle: Body = nested(Body, "the body")
    engine: TorqueEngine = nested(TorqueEngine, "the engine with its steady fuel")
    gearbox: AutomatedGearbox = nested(AutomatedGearbox, "gearbox and final drive")
    correction: TransientCorrection = nested(TransientCorrection, "transient fuel, added to the steady one")
    wheel_inertia: float = quantity("kg*m^2", 0, 1000, "of all wheels and what turns with them")
    launch_speed: float = quantity("rad/s", 20, 500, "lowest speed of the engine in gear; below, the clutch slips")

    @staticmethod
    def of(parameters: RecordArray | Mapping[str, RecordArray], correction: RecordArray | None = None) -> RecordArray:
        """Return that of a vehicle.

        Args:
            parameters: the record of a plant with the blocks vehicle, engine, gearbox, wheels and clutch, one or one
                per lane; or these blocks by name.
            correction: transient fuel; None: none.
        """
        model = LongitudinalModel.zeros(len(parameters["vehicle"]))
        for block in ("vehicle", "engine", "gearbox"):
            model[block] = parameters[block]
        model["wheel_inertia"] = parameters["wheels"]["inertia"]
        model["launch_speed"] = parameters["clutch"]["launch_speed"]
        if correction is not None:
            model["correction"] = np.broadcast_to(correction, model.shape)
        return model


@kernel
def driving_force(m: LongitudinalModel, road: Road, speed: float, acceleration: float) -> float:
    """Return the force, N at the wheels, that moves the vehicle at `speed` (m/s) and `acceleration` (m/s^2)."""
    r = m.vehicle.wheel_radius
    inertia = m.vehicle.mass * r**2 + m.wheel_inertia
    resistance = grade_torque(m.vehicle, road) + rolling_torque(m.vehicle, road)
    return (inertia * acceleration / r + resistance + air_coefficient(m.vehicle, road) * (speed / r) ** 2) / r


@kernel
def geared_speed(m: LongitudinalModel, gear: int, speed: float) -> float:
    """Return the speed of the gearbox input, rad/s, in a gear (1 is the first) at `speed` (m/s)."""
    return gear_ratio(m.gearbox, gear) * speed / m.vehicle.wheel_radius


@kernel
def engine_speed_for(m: LongitudinalModel, gear: int, speed: float) -> float:
    """Return the speed of the engine, rad/s: that of the gearbox input, or the launch speed while the clutch slips."""
    return max(geared_speed(m, gear, speed), m.launch_speed)


@kernel
def engine_torque_for(m: LongitudinalModel, gear: int, force: float, speed: float, acceleration: float) -> float:
    """Return the engine torque, N m, that gives `force` (N) at the wheels; it may be more than the engine has."""
    ratio = max(gear_ratio(m.gearbox, gear), 1e-9)
    r = m.vehicle.wheel_radius
    torque = force * r / (ratio * m.gearbox.efficiency)
    if force < 0.0:
        torque = force * r * m.gearbox.efficiency / ratio
    if geared_speed(m, gear, speed) >= m.launch_speed:
        torque = torque + m.engine.inertia * ratio * acceleration / r
    else:
        torque = max(torque, 0.0)
    return torque


@kernel
def fuel_for(m: LongitudinalModel, engine_speed: float, torque: float, speed: float, acceleration: float) -> float:
    """Return the fuel, kg/s, >= 0, at engine speed (rad/s) and torque (N m), and vehicle speed and acceleration."""
    steady = fuel_flow(m.engine, engine_speed, torque)
    return max(steady + transient_correction(m.correction, speed, acceleration), 0.0)
