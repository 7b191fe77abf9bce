"""A launch model with what surrounds it: the load of the road, and the range of the engine's torque."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bitepoint.models.launch import LaunchModel
from bitepoint.parts.body import air_coefficient, grade_torque, rolling_torque
from bitepoint.parts.engine import LIMITER_SPAN, engine_torque, throttle_effect
from bitepoint.records import RecordArray

SPEED_RASTER = 40.0
"""Distance of the engine speeds at which the torque range is looked up, beside the points of the full load, rad/s."""


@dataclass(frozen=True)
class LaunchVehicle:
    """A vehicle that moves off on a road, with all that limits it.

    Attributes:
        model: two inertias; its torque limits are those of the true clutch, friction gain included.
        grade_torque: N m at the wheels, positive uphill; rolling_torque: N m at the wheels, >= 0.
        air_coefficient: torque at the wheels over the wheel speed squared, N m s^2/rad^2.
        idle_speed, speed_limit: of the engine in normal running, rad/s.
        engine_speeds: rad/s, rising; lowest_torque, highest_torque: steady engine torque there with closed and with
            open throttle, N m, linear in between. The viscous friction is not taken off.
    """

    model: LaunchModel
    grade_torque: float
    rolling_torque: float
    air_coefficient: float
    idle_speed: float
    speed_limit: float
    engine_speeds: tuple[float, ...]
    lowest_torque: tuple[float, ...]
    highest_torque: tuple[float, ...]

    @staticmethod
    def of(parameters: RecordArray) -> LaunchVehicle:
        """Return that of a plant: one record with the blocks vehicle, engine, clutch, gearbox and road."""
        body, road, engine = (parameters[block].copy() for block in ("vehicle", "road", "engine"))
        model, gain = LaunchModel.of(parameters), float(parameters["clutch"]["friction_gain"][0])
        limits = {"torque_limit": gain * model.torque_limit, "torque_rate_limit": gain * model.torque_rate_limit}
        speeds, lowest, highest = _torque_range(engine)
        return LaunchVehicle(
            model=replace(model, **limits),
            grade_torque=float(grade_torque.run(body, road, life="interpreted")[0]),
            rolling_torque=float(rolling_torque.run(body, road, life="interpreted")[0]),
            air_coefficient=float(air_coefficient.run(body, road, life="interpreted")[0]),
            idle_speed=float(engine["idle_speed"][0]),
            speed_limit=float(engine["speed_limit"][0]),
            engine_speeds=speeds,
            lowest_torque=lowest,
            highest_torque=highest,
        )

    @property
    def release_torque(self) -> float:
        """Clutch torque at which the vehicle, held at standstill, starts to move, N m, >= 0."""
        load = self.grade_torque + self.rolling_torque
        return max(load, 0.0) / (self.model.efficiency * self.model.ratio)

    @property
    def rolls_off(self) -> bool:
        """Whether the grade alone moves the vehicle: nothing holds it then."""
        return self.grade_torque + self.rolling_torque < 0.0


def _torque_range(engine: RecordArray) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Return speeds, and the engine torque there with closed and with open throttle."""
    limit = float(engine["speed_limit"][0])
    points = int(engine["full_load"]["points"][0])
    raster = np.arange(0.0, limit, SPEED_RASTER)
    known = np.concatenate((raster, engine["full_load"]["x"][0][:points], [limit, limit + LIMITER_SPAN]))
    speeds = np.unique(known[known <= limit + LIMITER_SPAN].round(3))
    torques: list[tuple[float, ...]] = []
    for throttle in (0.0, 1.0):
        effect = throttle_effect.run(engine, throttle, life="interpreted")
        torques.append(tuple(engine_torque.run(engine, effect, speeds, life="interpreted").tolist()))
    return tuple(speeds.tolist()), torques[0], torques[1]
