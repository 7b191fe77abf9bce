"""The paper's programme as it is written: forward Euler steps in speed, on a grid that is uniform in speed.

    v1 = v0 + a ds / v0       the paper's, which makes kinetic energy: v1^2 - v0^2 = 2 a ds + (a ds / v0)^2
    v1^2 = v0^2 + 2 a ds      what the vehicle does

Gears are free and shifts cost nothing, as there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.models.longitudinal import (
    driving_force,
    engine_speed_for,
    engine_torque_for,
    fuel_for,
    geared_speed,
)
from bitepoint.parts.body import Road
from bitepoint.parts.torque_engine import highest_torque
from bitepoint.planning.steady import gear_count
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

EULER, EXACT = "euler", "exact"

AIR_DENSITY = 1.206


@dataclass(frozen=True)
class GridPlan:
    """What such a programme finds.

    Attributes:
        speed: m/s, shape (stages + 1,); fuel: kg; time: s; both as the programme reckons them.
        work: of the wheels as it reckons them, J.
        gain: kinetic energy beyond what that work and the road make, J.
    """

    speed: Floats
    fuel: float
    time: float
    work: float
    gain: float


def euler_error(acceleration: float, start: float, length: float, step: float) -> float:
    """Return by how much, m/s, Euler steps in speed are too fast after a way at constant acceleration (SI units)."""
    speed = start
    for _ in range(round(length / step)):
        speed += acceleration * step / speed
    return speed - float(np.sqrt(start**2 + 2.0 * acceleration * length))


def grid_plan(
    model: RecordArray, start: float, end: float, length: float, stages: int, speed: Floats, steps: str
) -> GridPlan | None:
    """Return the cheapest way from a speed to another over a flat road; None: there is none on this grid.

    Args:
        start, end: m/s, nodes of `speed`; length: m.
        speed: nodes, m/s, rising; steps: EULER or EXACT.
    """
    ds = length / stages
    fuel, time, force = _stage(model, speed, ds, steps)
    cost = np.full(len(speed), np.inf)
    cost[int(np.argmin(np.abs(speed - end)))] = 0.0
    choices = np.empty((stages, len(speed)), np.int64)
    for k in range(stages - 1, -1, -1):
        total = fuel + cost
        choices[k] = total.argmin(axis=1)
        cost = total.min(axis=1)
    node = int(np.argmin(np.abs(speed - start)))
    if not np.isfinite(cost[node]):
        return None
    way = [node]
    for row in choices:
        way.append(int(row[way[-1]]))
    before, after = np.array(way[:-1]), np.array(way[1:])
    pushed = force[before, after]
    road = driving_force.run(model, _road(), speed[before], 0.0)
    work = float(np.sum(pushed) * ds)
    energy = 0.5 * _mass(model) * (speed[way[-1]] ** 2 - speed[way[0]] ** 2)
    gain = energy - (work - float(np.sum(road) * ds))
    return GridPlan(speed[way], float(cost[node]), float(time[before, after].sum()), work, gain)


def _mass(model: RecordArray) -> float:
    return float(driving_force.run(model, _road(), 1.0, 1.0)[0] - driving_force.run(model, _road(), 1.0, 0.0)[0])


def _road() -> RecordArray:
    return Road.parse({"grade": 0.0, "air_density": AIR_DENSITY}, "launch")


def _stage(model: RecordArray, speed: Floats, ds: float, steps: str) -> tuple[Floats, Floats, Floats]:
    """Return fuel (kg, infinite where the engine cannot), time (s) and force (N), shape (from, to)."""
    before, after = (each.ravel() for each in np.meshgrid(speed, speed, indexing="ij"))
    if steps == EULER:
        acceleration, at = (after - before) * before / ds, before
    else:
        acceleration, at = (after**2 - before**2) / (2.0 * ds), 0.5 * (before + after)
    force = driving_force.run(model, _road(), at, acceleration)
    best = np.full(len(at), np.inf)
    for gear in range(1, gear_count(model) + 1):
        turning = geared_speed.run(model, gear, at)
        engine = engine_speed_for.run(model, gear, at)
        torque = engine_torque_for.run(model, gear, force, at, acceleration)
        flow = fuel_for.run(model, engine, torque, at, acceleration)
        slow = (turning < model["launch_speed"][0]) & (gear > 1)
        weak = torque > highest_torque.run(model["engine"], engine)
        fast = turning > model["engine"]["speed_limit"][0]
        best = np.minimum(best, np.where(slow | weak | fast | (acceleration < 0.0), np.inf, flow))
    shape = (len(speed), len(speed))
    return (best * ds / at).reshape(shape), (ds / at).reshape(shape), force.reshape(shape)
