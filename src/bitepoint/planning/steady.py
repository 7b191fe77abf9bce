"""Steady driving: what a constant speed takes in each gear, and what follows from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.longitudinal import (
    driving_force,
    engine_speed_for,
    engine_torque_for,
    fuel_for,
    geared_speed,
)
from bitepoint.models.plan import Floats
from bitepoint.parts.amt import LEAST_RATIO
from bitepoint.parts.body import Road
from bitepoint.parts.torque_engine import highest_torque
from bitepoint.records import RecordArray

SPEED_STEP = 0.1 / 3.6
"""Raster of the search for the economical speed, m/s."""


@dataclass(frozen=True)
class EconomySpeed:
    """The steady speed that takes the least fuel per metre.

    Attributes:
        speed: m/s; gear: from 1; fuel_per_metre: kg/m; engine_speed: rad/s; engine_torque: N m.
    """

    speed: float
    gear: int
    fuel_per_metre: float
    engine_speed: float
    engine_torque: float


def gear_count(model: RecordArray) -> int:
    """Return the number of forward gears."""
    return int(np.count_nonzero(model["gearbox"]["ratios"][0] * model["gearbox"]["final_drive"][0] >= LEAST_RATIO))


class FuelByGear(NamedTuple):
    """What a motion takes in each gear, arrays of shape (gears, n): it may be more than the engine can.

    Attributes:
        flow: kg/s; turning: gearbox input, rad/s; torque, full_load: of the engine, N m.
    """

    flow: Floats
    turning: Floats
    torque: Floats
    full_load: Floats


def fuel_by_gear(model: RecordArray, force: Floats, speed: Floats, acceleration: Floats | float) -> FuelByGear:
    """Return what `force` (N at the wheels) takes in each gear at a speed (m/s) and an acceleration (m/s^2)."""
    rows: list[tuple[Floats, ...]] = []
    for gear in range(1, gear_count(model) + 1):
        engine = engine_speed_for.run(model, gear, speed)
        torque = engine_torque_for.run(model, gear, force, speed, acceleration)
        flow = fuel_for.run(model, engine, torque, speed, acceleration)
        turning = geared_speed.run(model, gear, speed)
        rows.append((flow, turning, torque, highest_torque.run(model["engine"], engine)))
    return FuelByGear(*(np.array(each) for each in zip(*rows, strict=True)))


def steady_fuel(
    model: RecordArray, speed: Floats, *, grade: float = 0.0, extra_force: float = 0.0, air_density: float = 1.206
) -> Floats:
    """Return the fuel flow at constant speeds in each gear, kg/s, shape (gears, speeds).

    Infinite where the gear cannot hold the speed: too little torque, or engine below launch speed or above its limit.

    Args:
        speed: m/s, above 0; extra_force: N at the wheels, on top of what the speed takes.
    """
    road = Road.parse({"grade": grade, "air_density": air_density}, "steady")
    force = driving_force.run(model, road, speed, 0.0) + extra_force
    found = fuel_by_gear(model, force, speed, 0.0)
    low, high = model["launch_speed"][0] * (1.0 - 1e-9), model["engine"]["speed_limit"][0]
    unable = (found.turning < low) | (found.turning > high) | (found.torque > found.full_load)
    return np.where(unable, np.inf, found.flow)


def economy_speed(model: RecordArray, *, grade: float = 0.0, fastest: float = 60.0) -> EconomySpeed:
    """Return the steady speed and the gear with the least fuel per metre, on a raster of 0.1 km/h.

    Args:
        fastest: m/s, the end of the search.

    Raises:
        InputError: no speed can be held in any gear.
    """
    speed = np.arange(1.0, fastest, SPEED_STEP)
    speed = np.round(speed * 36.0) / 36.0
    per_metre = steady_fuel(model, speed, grade=grade) / speed
    gear, k = np.unravel_index(int(np.argmin(per_metre)), per_metre.shape)
    if not np.isfinite(per_metre[gear, k]):
        raise InputError("economy_speed", f"no gear holds any speed up to {fastest:g} m/s", "expected a road it climbs")
    road = Road.parse({"grade": grade, "air_density": 1.206}, "steady")
    at = speed[k : k + 1]
    engine, torque = _operating_point(model, int(gear) + 1, driving_force.run(model, road, at, 0.0), at)
    return EconomySpeed(float(at[0]), int(gear) + 1, float(per_metre[gear, k]), float(engine[0]), float(torque[0]))


def set_speed_price(model: RecordArray, speed: float) -> float:
    """Return the price of time, kg/s, at which `speed` (m/s) is the cheapest steady speed on a flat road.

    With fuel per metre g(v) in the best gear, least g + price / v: price = v^2 dg/dv; 0 at and below the economy speed.
    """
    step = 0.02 * speed
    around = np.array([speed - step, speed, speed + step])
    flow = steady_fuel(model, around)
    gear = int(np.argmin(flow.max(axis=1)))
    _need(flow[gear, 1], speed)
    return max(float(speed**2 * (flow[gear, 2] / around[2] - flow[gear, 0] / around[0]) / (2.0 * step)), 0.0)


def energy_value(model: RecordArray, speed: float) -> float:
    """Return what a joule more of kinetic energy is worth at a steady `speed` (m/s), kg: the fuel of one at the wheels.

    It is the cost to go's derivative by kinetic energy where the rest of the road is driven steadily.
    """
    at, force = np.array([speed]), 100.0
    more, less = (steady_fuel(model, at, extra_force=x)[:, 0] for x in (force, -force))
    gear = int(np.argmin(more))
    _need(more[gear], speed)
    return float((more[gear] - less[gear]) / (2.0 * force * speed))


def _need(flow: float, speed: float) -> None:
    if not np.isfinite(flow):
        raise InputError(
            "cruise", f"no gear holds {speed:g} m/s on a flat road", "expected a speed that the engine holds"
        )


def _operating_point(model: RecordArray, gear: int, force: Floats, speed: Floats) -> tuple[Floats, Floats]:
    """Return engine speed (rad/s) and torque (N m) that hold a speed."""
    engine = engine_speed_for.run(model, gear, speed)
    return engine, engine_torque_for.run(model, gear, force, speed, 0.0)
