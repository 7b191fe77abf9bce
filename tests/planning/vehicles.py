"""Vehicles in balance for the tests of planners: the hatchback of the library, and a truck that is a straight line."""

from __future__ import annotations

from typing import Any

import numpy as np

from bitepoint.models.longitudinal import LongitudinalModel
from bitepoint.models.route import Route
from bitepoint.parts.amt import AutomatedGearbox
from bitepoint.parts.body import Body, Wheels
from bitepoint.parts.launch_clutch import LaunchClutch
from bitepoint.parts.torque_engine import TorqueEngine
from bitepoint.records import RecordArray
from bitepoint.vehicles import load_vehicle

BLOCKS = {
    "vehicle": Body,
    "engine": TorqueEngine,
    "gearbox": AutomatedGearbox,
    "wheels": Wheels,
    "clutch": LaunchClutch,
}

SHARE, HEAT, FRICTION = 0.42, 42.8e6, 40.0
"""Of the truck's engine: share of the heat of fuel, J/kg, that makes torque and friction, N m."""


def hatchback() -> RecordArray:
    """The car of page 5."""
    vehicle = load_vehicle("hatchback-2l")
    blocks = {name: record.parse(vehicle.blocks[name], vehicle.where, name) for name, record in BLOCKS.items()}
    return LongitudinalModel.of(blocks)


def truck(mass: float = 6000.0, **gearbox: Any) -> RecordArray:
    """6 t, 110 kW diesel, fuel = (torque + 40 N m) speed / (0.42 * 42.8 MJ/kg): its map is exact between its points."""
    speed, torque = np.linspace(60.0, 320.0, 14), np.linspace(0.0, 480.0, 13)
    flow = (torque + FRICTION) * speed[:, np.newaxis] / (SHARE * HEAT)
    shown: dict[str, Any] = {
        "vehicle": {
            "mass": mass,
            "wheel_radius": 0.38,
            "rolling_resistance": 0.008,
            "drag_coefficient": 0.55,
            "frontal_area": 5.6,
        },
        "engine": {
            "inertia": 0.6,
            "full_load": {"speed": [0, 60, 105, 147, 245, 273, 320], "torque": [200, 250, 400, 450, 450, 404, 300]},
            "fuel": {"speed": speed.tolist(), "torque": torque.tolist(), "flow": flow.tolist()},
            "drag_constant": 30.0,
            "drag_slope": 0.1,
            "idle_speed": "700 rpm",
            "speed_limit": "3000 rpm",
        },
        "gearbox": {
            "ratios": [5.37, 3.15, 2.03, 1.37, 1.0, 0.79],
            "final_drive": 4.1,
            "efficiency": 0.94,
            "shift_time": 0.5,
            **gearbox,
        },
        "wheels": {"inertia": 20.0},
        "clutch": {"torque_limit": 600.0, "launch_speed": "1000 rpm"},
    }
    return LongitudinalModel.of({name: record.parse(shown[name], "truck", name) for name, record in BLOCKS.items()})


def hills(deviation: float, length: float = 20_000.0, seed: int = 1) -> Route:
    """A road of 12 waves of equal height in grade, 0.9 to 4.5 km long, with this standard deviation of the grade."""
    s, random = np.arange(0.0, length + 25.0, 25.0), np.random.default_rng(seed)
    waves, phases = np.exp(random.uniform(np.log(900.0), np.log(4500.0), 12)), random.uniform(0.0, 2.0 * np.pi, 12)
    grade = np.cos(2.0 * np.pi * s[:, np.newaxis] / waves + phases).sum(axis=1)
    grade = grade - grade.mean()
    return Route.of_grade(s, deviation * grade / grade.std(), np.full(len(s), np.inf), np.empty(0))
