"""Fuel from end to end: logs of a drive in; a model, its errors, and what is to be said of it out."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.datasets import Dataset, log_files
from bitepoint.identification.fuel.drives import ASKED, Bin, Drive, Rows, joined, vsp_outliers
from bitepoint.identification.fuel.folds import fold_scores, folds_of
from bitepoint.identification.fuel.logs import DENSITY, ENGINE, FUEL, LogOptions, read_drives
from bitepoint.identification.fuel.models import (
    LOGGED_MAP,
    WILLANS,
    Candidate,
    Source,
    corrected_candidates,
    gear_rules,
    measured_map,
    modelled,
    plain_candidates,
    scored,
    steady_candidate,
)
from bitepoint.identification.fuel.polynomials import POWER
from bitepoint.identification.fuel.regression import r_squared
from bitepoint.identification.fuel.steady import vehicle_for
from bitepoint.models.fuel_model import FuelModel
from bitepoint.recording import Recording
from bitepoint.records import RecordArray
from bitepoint.version import __version__

DELAYS = (-0.5, -0.25, -0.125, 0.0, 0.125, 0.25, 0.375, 0.5, 0.75)
"""Leads of the fuel before the motion that are tried, s."""

ENOUGH_GAIN = 0.005
"""A model with more to it is taken where it scores better by this much (chosen)."""


@dataclass(frozen=True)
class FuelErrors:
    """Errors over rows: of the total, %; row by row, R2 (NaN: a constant fuel) and kg/s rms; and how many rows."""

    total_percent: float
    r2: float
    rms: float
    rows: int

    def to_json(self) -> dict[str, float | None]:
        """Return them as JSON can hold them: null for what is not finite."""
        return {name: value if np.isfinite(value) else None for name, value in asdict(self).items()}


@dataclass(frozen=True)
class Tried:
    """The best model of a kind: its score in cross-validation, fold by fold and mean, and its errors."""

    kind: str
    name: str
    score: float
    folds: tuple[float, ...]
    model: FuelModel
    errors: Mapping[str, FuelErrors]


@dataclass(frozen=True)
class FuelIdentified:
    """A fuel model with all that is known of it.

    Attributes:
        model: the one that is chosen; errors: "train" and "validation" -> its errors.
        tried: the best of each kind and of each plain family, all on the same rows.
        delay: s that the fuel precedes the motion by.
        drive: all rows of training; outliers: which of them are left out; bins: of their specific power.
        checked: the rows of validation, none left out; None: there are none.
        warnings: sentences.
    """

    model: FuelModel
    errors: Mapping[str, FuelErrors]
    tried: Sequence[Tried]
    delay: float
    drive: Drive
    outliers: Rows
    bins: Sequence[Bin]
    checked: Drive | None
    training: Sequence[Recording]
    validation: Sequence[Recording]
    warnings: Sequence[str]

    def to_json(self) -> dict[str, Any]:
        """Return what `bitepoint identify --model fuel --json` prints; rms in kg/s."""
        return {
            "model": "fuel",
            "kind": self.model.about["kind"],
            "errors": {"validation": None, **{part: found.to_json() for part, found in self.errors.items()}},
            "tried": [_told(each) for each in self.tried],
            "delay": self.delay,
            "outliers": self.dropped(),
            "warnings": list(self.warnings),
        }

    def dropped(self) -> list[dict[str, Any]]:
        """Return the rows that the filter left out: file, time (s) in it, fuel (kg/s)."""
        rows: list[int] = np.flatnonzero(self.outliers).tolist()
        return [
            {
                "file": Path(self.training[int(self.drive.run[row])].about["file"]).name,
                "time": float(self.drive.time[row]),
                "fuel_flow": float(self.drive.fuel[row]),
            }
            for row in rows
        ]


def identify_fuel(
    paths: Sequence[str | Path],
    validate: Sequence[str | Path] = (),
    options: LogOptions | None = None,
    vehicle: str | None = None,
    engine_map: str | None = None,
) -> FuelIdentified:
    """Return the fuel model of logs; whatever is chosen is chosen on the training logs alone.

    Args:
        paths, validate: logs, files or folders.
        vehicle: name or file of the vehicle, for a steady map with correction; None: plain models only.
        engine_map: file of measured points of the engine's steady fuel; None: its map is made of the logs.

    Raises:
        InputError: no usable logs, or options that cannot be carried out.
    """
    options = LogOptions() if options is None else options
    if engine_map is not None and vehicle is None:
        raise InputError("--engine-map", "no vehicle whose engine it is", "add --vehicle")
    model = None if vehicle is None else vehicle_for(vehicle)
    measured = None if model is None or engine_map is None else measured_map(model, engine_map, options.density)
    data, checked = read_drives(paths, validate, options)
    outliers, bins = vsp_outliers(joined(data.runs, 0.0))
    fixed = FUEL.name in options.delays
    delay = 0.0 if fixed else _delay(data.runs, ~outliers)
    drive = joined(data.runs, delay)
    tested = None if checked is None else joined(checked.runs, delay)
    tried = _tried(drive.rows(~outliers), tested, model, measured)
    chosen = _chosen(tried)
    warnings = [*data.warnings, *_on_outliers(drive, outliers, bins), *_on_logs(data, drive, model is not None)]
    warnings += [*_on_map(measured, engine_map, chosen, tried), *_on_validation(checked, paths, validate)]
    about = _about(data, checked, options, vehicle, chosen, delay, int(outliers.sum()))
    about["engine_map"] = None if engine_map is None or chosen.kind == "plain" else Path(engine_map).name
    validation = () if checked is None else checked.runs
    return FuelIdentified(
        replace(chosen.model, about=about), chosen.errors, tried, delay, drive, outliers, bins, tested, data.runs,
        validation, warnings,
    )  # fmt: skip


def _delay(runs: Sequence[Recording], kept: Rows) -> float:
    """Return the lead of the fuel with which the power model scores best."""
    power = next(each for each in plain_candidates() if each.name == POWER.name)
    scores: list[float] = []
    for delay in DELAYS:
        drive = joined(runs, delay).rows(kept)
        scores.append(_score(power, drive, folds_of(drive))[0])
    return DELAYS[int(np.argmax(scores))]


def _score(candidate: Candidate, drive: Drive, folds: Sequence[Rows]) -> tuple[float, tuple[float, ...]]:
    def fit(rows: Drive) -> Callable[[Drive], Any]:
        model = candidate.fit(rows)
        return lambda tested: modelled(model, tested)

    scores = fold_scores(fit, candidate.prepared(drive), folds)
    return float(scores.mean()), tuple(scores.tolist())


def _tried(drive: Drive, checked: Drive | None, vehicle: RecordArray | None, measured: Source | None) -> list[Tried]:
    """Return the models that are compared, plain ones first, then steady ones, then those with a correction.

    A steady map is that of the measured points, if there are any; else a Willans line or, where the engine is logged, a
    map through its points, whichever scores better.
    """
    folds = folds_of(drive)

    def finished(candidate: Candidate) -> Tried:
        score, each = _score(candidate, drive, folds)
        model = candidate.fit(drive)
        errors = {"train": errors_of(model, drive)}
        if checked is not None:
            errors["validation"] = errors_of(model, checked)
        return Tried(candidate.kind, candidate.name, score, each, model, errors)

    found = [finished(candidate) for candidate in plain_candidates()]
    if vehicle is None:
        return found
    rules = gear_rules(logged=drive.engine is not None)
    sources = [measured] if measured is not None else [WILLANS] + [LOGGED_MAP] * (drive.engine is not None)
    choices = [(rule, source) for source in sources for rule in rules]
    steady = [steady_candidate(vehicle, *choice) for choice in choices]
    best, _ = scored(steady, lambda candidate: _score(candidate, drive, folds)[0])
    choice = choices[steady.index(best)]
    return [*found, finished(best), *(finished(each) for each in corrected_candidates(vehicle, *choice))]


def _chosen(tried: Sequence[Tried]) -> Tried:
    """Return the best of the kinds, a kind with more to it only where that is worth it."""
    chosen = max((each for each in tried if each.kind == "plain"), key=lambda each: each.score)
    for kind in ("steady", "steady and correction"):
        best = max((each for each in tried if each.kind == kind), key=lambda each: each.score, default=None)
        if best is not None and best.score > chosen.score + ENOUGH_GAIN:
            chosen = best
    return chosen


def errors_of(model: FuelModel, drive: Drive) -> FuelErrors:
    """Return the errors of a model over rows."""
    found = modelled(model, drive)
    total = 100.0 * (float(found.sum()) / float(drive.fuel.sum()) - 1.0)
    rms = float(np.sqrt(np.mean((found - drive.fuel) ** 2)))
    return FuelErrors(total, r_squared(drive.fuel, found), rms, len(drive))


def _on_outliers(drive: Drive, outliers: Rows, bins: Sequence[Bin]) -> list[str]:
    """Return what is to be said of the filter."""
    said: list[str] = []
    if outliers.any():
        share = float(drive.fuel[outliers].sum()) / float(drive.fuel.sum())
        said.append(f"outliers: {int(outliers.sum())} rows are left out, which hold {share:.1%} of the fuel")
    few = [each for each in bins if each.rows < ASKED]
    if few:
        said.append(
            f"outliers: {len(few)} of {len(bins)} bins of specific power have fewer than {ASKED} rows, "
            f"{sum(each.rows for each in few)} together: one may pass there"
        )
    return said


def _on_logs(data: Dataset, drive: Drive, steady: bool) -> list[str]:
    """Return what is to be said of the training logs."""
    said: list[str] = []
    if len(data.runs) < 2:
        said.append("one run to train on: its quarters stand for other drives in the choice of the model")
    if drive.engine is not None and not steady:
        names = " and ".join(channel.name for channel in ENGINE)
        said.append(f"{names} are logged, and not used: a steady map needs --vehicle")
    return said


def _on_map(measured: Source | None, engine_map: str | None, chosen: Tried, tried: Sequence[Tried]) -> list[str]:
    """Return what is to be said of an engine map that was given."""
    if measured is None or engine_map is None:
        return []
    if chosen.kind != "plain":
        return [*measured.warnings]
    other = max(each.score for each in tried if each.kind != "plain")
    return [
        *measured.warnings,
        f"{Path(engine_map).name}: not used by the model, which is plain and scores {chosen.score:.3f}: one with the "
        f"map scores {other:.3f}, and would have to be better by {ENOUGH_GAIN:g}",
    ]


def _on_validation(checked: Dataset | None, paths: Sequence[str | Path], validate: Sequence[str | Path]) -> list[str]:
    """Return what is to be said of the validation logs."""
    if checked is None:
        return ["no validation logs: the errors are those of training"]
    said = [f"validation: {warning}" for warning in checked.warnings]
    both = set(map(Path.resolve, log_files(paths, ""))) & set(map(Path.resolve, log_files(validate, "")))
    if both:
        said.append(f"{len(both)} logs are in training and in validation: their errors say little")
    return said


def _about(
    data: Dataset, checked: Dataset | None, options: LogOptions, vehicle: str | None, chosen: Tried, delay: float,
    outliers: int,
) -> dict[str, Any]:  # fmt: skip
    """Return where the model comes from, as JSON can hold it."""
    nothing: Mapping[str, str] = {}
    files = {"train": data.files, "validation": nothing if checked is None else checked.files}
    volume = FUEL.name in data.volumes
    return {
        "source": "identified from logs",
        "kind": chosen.kind,
        "method": chosen.name,
        "errors": {part: found.to_json() for part, found in chosen.errors.items()},
        "score": {"mean": chosen.score, "folds": list(chosen.folds)},
        "delay": delay,
        "outliers": outliers,
        "period": data.period,
        "density": options.density or (DENSITY if volume else None),
        "vehicle": vehicle,
        "files": {
            part: [{"name": Path(file).name, "sha256": digest} for file, digest in named.items()]
            for part, named in files.items()
        },
        "columns": dict(options.columns),
        "delays": dict(options.delays),
        "versions": {"bitepoint": __version__, "numpy": np.__version__, "python": platform.python_version()},
    }


def _told(tried: Tried) -> dict[str, Any]:
    return {
        "kind": tried.kind,
        "name": tried.name,
        "score": tried.score,
        "errors": {part: found.to_json() for part, found in tried.errors.items()},
    }
