"""The models that are tried: each a name and a way from rows to a `FuelModel`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bitepoint.identification.fuel.drives import Drive
from bitepoint.identification.fuel.polynomials import (
    CORRECTIONS,
    PLAIN,
    Family,
    fit_correction,
    fit_plain,
    no_correction,
)
from bitepoint.identification.fuel.steady import fit_willans, with_steady
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


def steady_candidate(vehicle: RecordArray, rule: RecordArray) -> Candidate:
    """Return the steady model with a gear rule."""
    speed, load = float(rule["lowest_speed"][0]) * 30.0 / np.pi, float(rule["highest_load"][0])
    name = f"from {speed:.0f} r/min, to {load:.0%} load"
    return Candidate(
        "steady", name, lambda drive: _steady(vehicle, rule, drive), lambda drive: _reconstructed(vehicle, rule, drive)
    )


def corrected_candidates(vehicle: RecordArray, rule: RecordArray) -> list[Candidate]:
    """Return the steady model with corrections of each degree."""

    def fit(family: Family) -> Callable[[Drive], FuelModel]:
        def corrected(drive: Drive) -> FuelModel:
            steady = _steady(vehicle, rule, drive)
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


def _steady(vehicle: RecordArray, rule: RecordArray, drive: Drive) -> FuelModel:
    engine = _reconstructed(vehicle, rule, drive).engine
    assert engine is not None
    coefficients = fit_willans(engine[0], engine[1], drive.fuel)
    return FuelModel(no_correction(drive), with_steady(vehicle, coefficients), rule)


def scored(candidates: Sequence[Candidate], score: Callable[[Candidate], float]) -> tuple[Candidate, float]:
    """Return the candidate with the highest score, and that."""
    scores = [score(candidate) for candidate in candidates]
    best = int(np.argmax(scores))
    return candidates[best], scores[best]
