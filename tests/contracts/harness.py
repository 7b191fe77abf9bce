"""Driving one plant or one controller by hand, for the contracts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from bitepoint.assembly import CONTROLLERS, PLANTS, SUPERVISORS
from bitepoint.controllers.controller import Controller
from bitepoint.kernels import Life
from bitepoint.plants.plant import Plant
from bitepoint.records import Record, RecordArray
from bitepoint.vehicles import load_vehicle, vehicle_names

SWITCHED_ON = " with "
"""What stands between the name of a vehicle and that of a block that is made active."""


def plants_with_vehicles() -> Iterator[tuple[Plant, str]]:
    """Every plant with every library vehicle that it is made for, the first one also with each optional block."""
    seen: set[str] = set()
    for name in vehicle_names():
        plant = PLANTS[load_vehicle(name).plant]
        yield plant, name
        if plant.name not in seen:
            for block, field in plant.parameters.fields.items():
                if field.record is not None and "active" in field.record.fields:
                    yield plant, f"{name}{SWITCHED_ON}{block}"
        seen.add(plant.name)


def controllers_with_calibrations() -> Iterator[tuple[Controller, str]]:
    """Every controller and supervisor with every calibration that ships."""
    for controller in (*CONTROLLERS.values(), *SUPERVISORS.values()):
        for calibration in controller.calibrations():
            yield controller, calibration


def nominal(plant: Plant, vehicle: str) -> RecordArray:
    """The parameters of a library vehicle on a level road; "NAME with BLOCK" has that block active."""
    name, _, block = vehicle.partition(SWITCHED_ON)
    switched = {block: {"active": 1}} if block else {}
    return plant.parameters.parse({**load_vehicle(name).blocks, **switched, "road": {}}, vehicle)


VEHICLES = {"dct": "dct-t240", "p2_hybrid": "p2-suv", "conventional": "hatchback-2l"}
"""The library vehicle of each plant that its controllers are tried with."""


def designed(controller: Controller, calibration: str, vehicle: str = "") -> RecordArray:
    """The parameters of a controller designed for a library vehicle."""
    vehicle = vehicle or VEHICLES[controller.plants[0]]
    values = {key: value for key, value in controller.calibrations()[calibration].items() if key != "source"}
    parsed = controller.calibration.parse(values, calibration)
    return controller.design(nominal(PLANTS[load_vehicle(vehicle).plant], vehicle), parsed)


class PlantBench:
    """A plant with its memory."""

    def __init__(self, plant: Plant, parameters: RecordArray, life: Life = "compiled") -> None:
        lanes = len(parameters)
        self.plant, self.p, self.life = plant, parameters, life
        self.x, self.u, self.y, self.w = (
            record.zeros(lanes) for record in (plant.state, plant.inputs, plant.outputs, plant.work)
        )
        for array in (self.x, self.u, self.y, self.w):  # init must not rely on what was there
            array.view(np.float64)[...] = 3.0
        plant.init.run(self.p, self.x, self.u, self.y, self.w, life=life)

    def step(self, dt: float = 0.002, **inputs: Any) -> np.ndarray:
        """Set inputs, step, and return the status of every lane."""
        for name, value in inputs.items():
            self.u[name] = value
        return self.plant.step.run(self.p, self.x, self.u, self.y, self.w, dt, life=self.life)


class ControllerBench:
    """A controller with its memory."""

    def __init__(self, controller: Controller, parameters: RecordArray, life: Life = "compiled") -> None:
        lanes = len(parameters)
        self.controller, self.p, self.life = controller, parameters, life
        self.s, self.m, self.c = (
            record.zeros(lanes) for record in (controller.state, controller.measurement, controller.command)
        )
        self.memory = [self.p, self.s, self.m, self.c]
        if controller.work is not None:
            self.memory.append(controller.work.zeros(lanes))
            self.memory[-1].view(np.int64)[...] = 7  # no step may rely on what was there
        self.init()

    def init(self) -> None:
        """Take over."""
        self.controller.init.run(*self.memory, life=self.life)

    def step(self, dt: float | None = None, **measurements: Any) -> np.ndarray:
        """Set measurements, step, and return the status of every lane."""
        for name, value in measurements.items():
            self.m[name] = value
        period = self.controller.period if dt is None else dt
        return self.controller.step.run(*self.memory, period, life=self.life)


def random_signals(record: type[Record], rng: np.random.Generator, shape: tuple[int, ...]) -> dict[str, np.ndarray]:
    """Values of every field of a record of signals, uniform over its declared range."""
    return {name: rng.uniform(field.low, field.high, shape) for name, field in record.fields.items()}


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays of records hold the same numbers, every NaN the same."""
    return np.array_equal(a.view(np.float64), b.view(np.float64), equal_nan=True)
