"""The steady fuel of an engine, from points of speed and torque, whether measured, logged or reconstructed.

    fuel = c0 + c1 w + c2 w^2 + k T w + q max(T, 0)^2 w        all coefficients >= 0, k >= 1/(0.46 Hu), and fuel >= 0

a Willans line: idling and friction, work over a marginal efficiency, and a share of it that is lost more and more with
load. Where the line ends, on overrun, fuel is cut. Points that are measured can bend it, see `engine_map`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.fuel.regression import clipped_least_squares
from bitepoint.models.longitudinal import LongitudinalModel
from bitepoint.parts.amt import AutomatedGearbox
from bitepoint.parts.body import Body, Wheels
from bitepoint.parts.launch_clutch import LaunchClutch
from bitepoint.parts.torque_engine import TorqueEngine
from bitepoint.recording import Floats
from bitepoint.records import Map, Record, RecordArray
from bitepoint.vehicles import load_vehicle

GRID = 16
"""Points of the map along speed and along torque."""

BEYOND = 1.1
"""The map reaches to so many times full load."""

HEATING_VALUE = 42.67e6
"""Lower heating value of petrol, J/kg; that of diesel fuel differs by less than 1 %."""

BEST_MARGINAL = 0.46
"""Marginal efficiency that no engine of a car exceeds (chosen above the 0.40 of page 5 of the specification).

Noise in the acceleration would feign a better one, paid for by a friction that is too high.
"""

LEAST_RUNNING = 0.6
"""The map begins at this share of the launch speed."""

_BLOCKS: Mapping[str, type[Record]] = {
    "vehicle": Body, "engine": TorqueEngine, "gearbox": AutomatedGearbox, "wheels": Wheels, "clutch": LaunchClutch,
}  # fmt: skip

_NO_FUEL = {"speed": [1.0, 1500.0], "torque": [0.0, 5000.0], "flow": [[0.0, 0.0], [0.0, 0.0]]}


def vehicle_for(name: str) -> RecordArray:
    """Return the `LongitudinalModel`, shape (1,), of a vehicle of the library or of a file.

    Its blocks are vehicle, engine, gearbox, wheels and clutch, any others are passed over; the engine needs no `fuel`,
    which is what will be identified.

    Raises:
        InputError: no such vehicle, or a block is missing or not as it should be.
    """
    vehicle = load_vehicle(name)
    if vehicle.plant != "conventional":
        raise InputError(vehicle.where, f"plant: {vehicle.plant}", "expected a vehicle of the plant conventional")
    found: dict[str, RecordArray] = {}
    for key, record in _BLOCKS.items():
        block = vehicle.blocks.get(key)
        if not isinstance(block, Mapping):
            raise InputError(vehicle.where, f"{key}: missing", f"expected the blocks {', '.join(_BLOCKS)}")
        numbers: dict[str, Any] = dict(cast("Mapping[str, Any]", block))
        if key == "engine":
            numbers.setdefault("fuel", _NO_FUEL)
        found[key] = record.parse(numbers, vehicle.where, key)
    return LongitudinalModel.of(found)


def willans_columns(speed: Floats, torque: Floats) -> Floats:
    """Return what c0, c1, c2, k and q multiply, shape (n, 5), at engine speed (rad/s) and torque (N m)."""
    return np.stack(
        [np.ones_like(speed), speed, speed**2, torque * speed, np.maximum(torque, 0.0) ** 2 * speed], axis=1
    )


def fit_willans(speed: Floats, torque: Floats, fuel: Floats, weight: Floats | None = None) -> Floats:
    """Return c0, c1, c2, k and q, SI, shape (5,), of points, shape (n,) each; weight: of their errors, None: equal."""
    least = np.array([0.0, 0.0, 0.0, 1.0 / (BEST_MARGINAL * HEATING_VALUE), 0.0])
    weight = np.ones_like(fuel) if weight is None else weight
    return clipped_least_squares(willans_columns(speed, torque) * weight[:, np.newaxis], fuel * weight, least)


def map_nodes(vehicle: RecordArray) -> tuple[Floats, Floats]:
    """Return the speeds (rad/s) and torques (N m) of the nodes of an engine's map, evenly spaced."""
    engine = vehicle["engine"]
    peak = float(engine["full_load"]["y"].max())
    speeds = np.linspace(LEAST_RUNNING * float(vehicle["launch_speed"][0]), float(engine["speed_limit"][0]), GRID)
    return speeds, np.linspace(0.0, BEYOND * peak, GRID)


def line_map(vehicle: RecordArray, coefficients: Floats) -> Floats:
    """Return the fuel of the Willans line at the nodes, kg/s, shape (16, 16)."""
    speed, torque = (each.ravel() for each in np.meshgrid(*map_nodes(vehicle), indexing="ij"))
    return (willans_columns(speed, torque) @ coefficients).reshape(GRID, GRID)


def with_steady(vehicle: RecordArray, coefficients: Floats, fuel: Floats | None = None) -> RecordArray:
    """Return the vehicle with the Willans line for the fuel of its engine: map, and drag at which it is cut.

    Args:
        fuel: a map at the nodes in the place of the line, kg/s, shape (16, 16); the drag stays that of the line.
    """
    model = vehicle.copy()
    engine = model["engine"]
    speeds, torques = map_nodes(vehicle)
    flow = line_map(vehicle, coefficients)
    engine["fuel"] = Map.through(speeds.tolist(), torques.tolist(), (flow if fuel is None else fuel).tolist())[0]
    line: Floats = flow[:, 0] / (coefficients[3] * speeds)  # torque at which the Willans line ends
    across = speeds - speeds.mean()
    slope = min(max(float(across @ line) / float(across @ across), 0.0), 1.0)
    engine["drag_slope"] = slope
    engine["drag_constant"] = min(max(float(line.mean() - slope * speeds.mean()), 1.0), 500.0)
    engine["firing_speed"] = min(float(engine["firing_speed"][0]), 0.5 * float(model["launch_speed"][0]))
    return model
