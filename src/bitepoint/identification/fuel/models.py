"""The models that are tried: each a name and a way from rows to a `FuelModel`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bitepoint.identification.fuel.drives import Drive
from bitepoint.identification.fuel.engine_map import EnginePoints, read_points, smooth_map, within
from bitepoint.identification.fuel.measured import with_points
from bitepoint.identification.fuel.polynomials import (
    CORRECTIONS,
    PLAIN,
    Family,
    fit_correction,
    fit_plain,
    no_correction,
)
from bitepoint.identification.fuel.steady import fit_willans, line_map, map_nodes, with_steady
from bitepoint.models.fuel_model import FuelModel, GearRule, backward
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

LOWEST_SPEEDS = (900.0, 1000.0, 1100.0, 1200.0, 1300.0, 1500.0)
"""Lowest engine speeds of a gear rule that are tried, r/min."""

HIGHEST_LOADS = (0.5, 0.65, 0.8, 0.9)
"""Highest loads of a gear rule that are tried."""


@dataclass(frozen=True)
class Candidate:
    """A model that is tried.

    Attributes:
        kind: "plain", "steady", or "steady and correction".
        fit: from rows to the model; prepared: rows with what is the same for any fit, so that it is made once.
    """

    kind: str
    name: str
    fit: Callable[[Drive], FuelModel]
    prepared: Callable[[Drive], Drive] = lambda drive: drive


@dataclass(frozen=True)
class Source:
    """Where the steady map of an engine comes from.

    Attributes:
        steady: from a vehicle, and from engine speed (rad/s), torque (N m) and fuel (kg/s) of rows, to the vehicle
            with the map.
        warnings: what is to be said of it.
    """

    name: str
    steady: Callable[[RecordArray, Floats, Floats, Floats], RecordArray]
    warnings: tuple[str, ...] = ()


def _line(vehicle: RecordArray, speed: Floats, torque: Floats, fuel: Floats) -> RecordArray:
    return with_steady(vehicle, fit_willans(speed, torque, fuel))


def _bent(vehicle: RecordArray, speed: Floats, torque: Floats, fuel: Floats) -> RecordArray:
    nodes, coefficients = map_nodes(vehicle), fit_willans(speed, torque, fuel)
    points = within(EnginePoints(speed, torque, fuel), *nodes, "identify")
    return with_steady(vehicle, coefficients, smooth_map(points, *nodes, line_map(vehicle, coefficients))[0])


WILLANS = Source("Willans line", _line)
LOGGED_MAP = Source("map through logged points", _bent)


def measured_map(vehicle: RecordArray, path: str, density: float | None = None) -> Source:
    """Return the map through the measured points of a file, whatever the rows are; density: see `read_points`.

    Raises:
        InputError: the file holds no such points.
    """
    found = with_points(vehicle, read_points(path, density), path)

    def steady(vehicle: RecordArray, speed: Floats, torque: Floats, fuel: Floats) -> RecordArray:
        del vehicle, speed, torque, fuel
        return found.vehicle

    return Source("measured map", steady, found.warnings)


def modelled(model: FuelModel, drive: Drive) -> Floats:
    """Return the fuel of a model over rows, kg/s, shape (n,); the engine as it is logged, where it is."""
    return model.flow(drive.speed, drive.acceleration, drive.grade, drive.engine)


def plain_candidates() -> list[Candidate]:
    """Return the plain models."""

    def fit(family: Family) -> Callable[[Drive], FuelModel]:
        return lambda drive: FuelModel(fit_plain(family, drive))

    return [Candidate("plain", family.name, fit(family)) for family in PLAIN]


def gear_rules(logged: bool) -> list[RecordArray]:
    """Return the gear rules that are tried; one where the engine is logged, since it decides nothing then."""
    speeds, loads = ((1200.0,), (0.8,)) if logged else (LOWEST_SPEEDS, HIGHEST_LOADS)
    return [
        GearRule.parse({"lowest_speed": f"{speed} rpm", "highest_load": load}, "gear rule")
        for speed in speeds
        for load in loads
    ]


def steady_candidate(vehicle: RecordArray, rule: RecordArray, source: Source) -> Candidate:
    """Return the steady model with a gear rule."""
    speed, load = float(rule["lowest_speed"][0]) * 30.0 / np.pi, float(rule["highest_load"][0])
    name = f"{source.name}, from {speed:.0f} r/min, to {load:.0%} load"
    return Candidate(
        "steady", name, lambda drive: _steady(vehicle, rule, source, drive),
        lambda drive: _reconstructed(vehicle, rule, drive),
    )  # fmt: skip


def corrected_candidates(vehicle: RecordArray, rule: RecordArray, source: Source) -> list[Candidate]:
    """Return the steady model with corrections of each degree."""

    def fit(family: Family) -> Callable[[Drive], FuelModel]:
        def corrected(drive: Drive) -> FuelModel:
            steady = _steady(vehicle, rule, source, drive)
            correction = fit_correction(family, drive, modelled(steady, drive))
            return FuelModel(correction, steady.vehicle, rule)

        return corrected

    def prepared(drive: Drive) -> Drive:
        return _reconstructed(vehicle, rule, drive)

    return [Candidate("steady and correction", family.name, fit(family), prepared) for family in CORRECTIONS]


def _reconstructed(vehicle: RecordArray, rule: RecordArray, drive: Drive) -> Drive:
    """Return the rows with the engine, logged or by backward simulation."""
    if drive.engine is not None:
        return drive
    _, speed, torque = backward(vehicle, rule, drive.speed, drive.acceleration, drive.grade)
    return replace(drive, engine=(speed, torque))


def _steady(vehicle: RecordArray, rule: RecordArray, source: Source, drive: Drive) -> FuelModel:
    engine = _reconstructed(vehicle, rule, drive).engine
    assert engine is not None
    return FuelModel(no_correction(drive), source.steady(vehicle, *engine, drive.fuel), rule)


def scored(candidates: Sequence[Candidate], score: Callable[[Candidate], float]) -> tuple[Candidate, float]:
    """Return the candidate with the highest score, and that."""
    scores = [score(candidate) for candidate in candidates]
    best = int(np.argmax(scores))
    return candidates[best], scores[best]
