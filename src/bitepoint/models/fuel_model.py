"""A fuel model as it is identified and kept: fuel over speed and acceleration, with or without a vehicle behind it.

    plain       fuel = max(0, correction(v, a))                           the steady part is nothing
    steady      fuel = max(0, map(engine speed, torque) + correction(v, a))

Engine speed and torque of the second follow from the vehicle in the highest gear that the rule allows: engine not below
`lowest_speed`, torque not above `highest_load` of full load. A standing vehicle is held by its brakes.

A model file is JSON: what the model is, and where it comes from.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np

from bitepoint.errors import InputError, brief
from bitepoint.files import read_json, save_json
from bitepoint.kernels import kernel
from bitepoint.models.fuel import TransientCorrection, transient_correction
from bitepoint.models.longitudinal import (
    LongitudinalModel,
    driving_force,
    engine_speed_for,
    engine_torque_for,
    fuel_for,
    geared_speed,
)
from bitepoint.numerics.tables import lookup
from bitepoint.parts.amt import LEAST_RATIO, gear_ratio
from bitepoint.parts.body import Road
from bitepoint.recording import Floats
from bitepoint.records import Map, Record, RecordArray, quantity

STANDSTILL = 0.1
"""Speed below which a vehicle stands, m/s."""

_MEND = "expected a fuel model that `bitepoint identify --model fuel` wrote"


class GearRule(Record):
    """Which gear a vehicle is in where nobody logged it: the highest that is allowed."""

    lowest_speed: float = quantity("rad/s", 20, 1000, "lowest speed of the engine in any gear but the first")
    highest_load: float = quantity("1", 0.05, 2, "highest torque over full load in any gear but the first")


@kernel
def held_force(m: LongitudinalModel, road: Road, speed: float, acceleration: float) -> float:
    """Return the force at the wheels, N, that moves the vehicle; none while its brakes hold it."""
    return driving_force(m, road, speed, acceleration) if speed > STANDSTILL else 0.0


@kernel
def ruled_gear(m: LongitudinalModel, rule: GearRule, force: float, speed: float, acceleration: float) -> int:
    """Return the highest gear that the rule allows, 1..8."""
    chosen = 1
    for gear in range(2, 9):
        turning = geared_speed(m, gear, speed)
        if gear_ratio(m.gearbox, gear) > LEAST_RATIO and turning >= rule.lowest_speed:
            torque = engine_torque_for(m, gear, force, speed, acceleration)
            if torque <= rule.highest_load * lookup(m.engine.full_load, turning):
                chosen = gear
    return chosen


def backward(
    vehicle: RecordArray, rule: RecordArray, speed: Floats, acceleration: Floats, grade: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return gear, engine speed (rad/s) and engine torque (N m), shape (n,) each, that a motion takes.

    Args:
        vehicle: a `LongitudinalModel`, shape (1,); rule: a `GearRule`, likewise.
        speed, acceleration, grade: m/s, m/s^2 and rise over run, shape (n,).
    """
    road = np.repeat(Road.parse({}, "road"), len(speed))
    road["grade"] = grade
    force = held_force.run(vehicle, road, speed, acceleration)
    gear = ruled_gear.run(vehicle, rule, force, speed, acceleration)
    turning = engine_speed_for.run(vehicle, gear, speed)
    return gear, turning, engine_torque_for.run(vehicle, gear, force, speed, acceleration)


@dataclass(frozen=True)
class FuelModel:
    """Fuel over speed and acceleration.

    Attributes:
        correction: a `TransientCorrection`, shape (1,).
        vehicle: a `LongitudinalModel`, shape (1,), whose engine has the steady fuel; None: a plain model.
        rule: a `GearRule`, shape (1,); None for a plain model.
        about: where it comes from; what JSON can hold.
    """

    correction: RecordArray
    vehicle: RecordArray | None = None
    rule: RecordArray | None = None
    about: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @property
    def kind(self) -> str:
        """What the model is called: "plain" or "steady"."""
        return "plain" if self.vehicle is None else "steady"

    def flow(
        self, speed: Floats, acceleration: Floats, grade: Floats | None = None,
        engine: tuple[Floats, Floats] | None = None,
    ) -> Floats:  # fmt: skip
        """Return the fuel, kg/s, shape (n,).

        Args:
            speed, acceleration: m/s and m/s^2, shape (n,).
            grade: rise over run, likewise; None: flat. A plain model knows none.
            engine: speed (rad/s) and torque (N m) of the engine where they are known; None: by backward simulation.
        """
        v, a = (np.ascontiguousarray(values, np.float64) for values in (speed, acceleration))
        if self.vehicle is None or self.rule is None:
            return np.maximum(transient_correction.run(self.correction, v, a), 0.0)
        if engine is None:
            _, *engine_found = backward(self.vehicle, self.rule, v, a, np.zeros(len(v)) if grade is None else grade)
            engine = (engine_found[0], engine_found[1])
        model = self.applied(self.vehicle)
        return fuel_for.run(model, engine[0], engine[1], v, a)

    def applied(self, vehicle: RecordArray) -> RecordArray:
        """Return a `LongitudinalModel` that takes this fuel: its own steady map and correction are replaced.

        A plain model leaves no steady map: its fuel does not depend on the gear.
        """
        model = vehicle.copy()
        model["correction"] = self.correction[0]
        if self.vehicle is None:
            speeds, torques = [1.0, 1500.0], [0.0, 5000.0]
            model["engine"]["fuel"] = Map.through(speeds, torques, [[0.0, 0.0], [0.0, 0.0]])[0]
            return model
        for name in ("fuel", "drag_constant", "drag_slope", "firing_speed"):
            model["engine"][name] = self.vehicle["engine"][name][0]
        return model

    def to_json(self) -> dict[str, Any]:
        """Return what a model file holds."""
        return {
            "model": "fuel",
            "kind": self.kind,
            "correction": TransientCorrection.to_mapping(self.correction[0]),
            "vehicle": None if self.vehicle is None else _vehicle_mapping(self.vehicle[0]),
            "gear_rule": None if self.rule is None else GearRule.to_mapping(self.rule[0]),
            "about": dict(self.about),
        }

    def save(self, path: str | Path) -> None:
        """Write a model file.

        Raises:
            InputError: the file cannot be written.
        """
        save_json(path, self.to_json())

    @staticmethod
    def load(path: str | Path) -> FuelModel:
        """Read a model file.

        Raises:
            InputError: no such file, or no fuel model in it.
        """
        where = str(path)
        found: object = read_json(Path(path), _MEND)
        data = cast("dict[str, Any]", found) if isinstance(found, dict) else {}
        if data.get("model") != "fuel":
            raise InputError(where, f"model: got {brief(data.get('model'))}", _MEND)
        correction = TransientCorrection.parse(data.get("correction"), where, "correction")
        about = dict(data.get("about") or {})
        if data.get("kind") == "plain":
            return FuelModel(correction, about=about)
        if not isinstance(data.get("vehicle"), dict):
            raise InputError(where, "vehicle: missing", _MEND)
        block: dict[str, Any] = {**data["vehicle"], "correction": data["correction"]}
        vehicle = LongitudinalModel.parse(block, where, "vehicle")
        return FuelModel(correction, vehicle, GearRule.parse(data.get("gear_rule"), where, "gear_rule"), about)


def _vehicle_mapping(record: Any) -> dict[str, Any]:
    """Return the vehicle without the correction, which the file holds by itself."""
    return {key: value for key, value in LongitudinalModel.to_mapping(record).items() if key != "correction"}
