"""Identification from end to end: logs in; a model, its errors, and what is to be said of them out."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.armax import fit_armax
from bitepoint.identification.arx import METHODS, Fit, fit_arx
from bitepoint.identification.datasets import Dataset, Request, log_files, read_dataset
from bitepoint.identification.delays import DelayHint, estimate_delay
from bitepoint.identification.diagnostics import identifiability
from bitepoint.identification.orders import Candidate, best_orders, try_orders
from bitepoint.identification.regression import Orders, Roles, Run
from bitepoint.identification.validation import ChannelErrors, errors_of
from bitepoint.models.arx import ArxModel
from bitepoint.models.launch import DISTURBANCES, INPUTS, OUTPUTS
from bitepoint.recording import Channel, Recording
from bitepoint.version import __version__

MODELS = ("arx", "armax")
"""Kinds of models."""

HIGHEST_ORDER = 20
HIGHEST_RATIO = 100.0

LAUNCH = Roles(OUTPUTS, INPUTS, DISTURBANCES)
"""The signals of a launch."""

UNITS: Mapping[str, str] = {
    "engine_speed": "rad/s", "slip": "rad/s", "wheel_speed": "rad/s",
    "clutch_torque": "N*m", "engine_torque": "N*m", "load_torque": "N*m",
}  # fmt: skip
"""Their units."""

LIMITS: Mapping[str, float] = {
    "engine_speed": 1e3, "slip": 1e3, "wheel_speed": 1e3,
    "clutch_torque": 1e4, "engine_torque": 1e4, "load_torque": 1e5,
}  # fmt: skip
"""Magnitudes, SI, that no road vehicle reaches as it moves off: another unit, or a mark for "no value" (chosen)."""

LONGEST_PERIOD = 0.2
"""Longest raster, s: a launch lasts about a second."""

HELD_OUT = 5
"""Without validation logs every one of so many training runs is held out for validation."""


@dataclass(frozen=True)
class Options:
    """What is to be identified.

    Attributes:
        model: "arx" or "armax"; method: of ARX, see `arx.METHODS`.
        orders: n_a, n_b, n_g, for armax n_c may follow (n_a without it); None: searched by AIC.
        columns, delays, databases, period: see `datasets.Request`.
        ratio: overall ratio of the gear, where the logs hold the wheel speed instead of the slip; None: the slip.
    """

    model: str = "arx"
    orders: tuple[int, ...] | None = (2, 1, 1)
    method: str = "auto"
    columns: Mapping[str, str] | None = None
    delays: Mapping[str, float] | None = None
    databases: tuple[Path, ...] = ()
    period: float | None = None
    ratio: float | None = None

    def __post_init__(self) -> None:
        """Hold that they can be carried out.

        Raises:
            InputError: they cannot.
        """
        for option, value, known in (("--model", self.model, MODELS), ("--method", self.method, METHODS)):
            if value not in known:
                raise InputError(option, f"got {value}", f"expected one of {', '.join(known)}")
        if self.ratio is not None and not 0.1 <= self.ratio <= HIGHEST_RATIO:
            raise InputError("--ratio", f"got {self.ratio:g}", f"expected a ratio of 0.1..{HIGHEST_RATIO:g}")
        if self.orders is None:
            return
        lengths = (3,) if self.model == "arx" else (3, 4)
        if len(self.orders) not in lengths or not all(1 <= order <= HIGHEST_ORDER for order in self.orders):
            shape = "n_a,n_b,n_g" + ("" if self.model == "arx" else ",n_c")
            got = ",".join(map(str, self.orders))
            raise InputError("--orders", f"got {got}", f"expected auto or {shape}, each 1..{HIGHEST_ORDER}")

    def request(self, period: float | None) -> Request:
        """Return what is wanted of the logs."""
        names = [name if self.ratio is None or name != "slip" else "wheel_speed" for name in LAUNCH.names]
        channels = tuple(Channel(name, UNITS[name]) for name in names)
        held = frozenset((*LAUNCH.inputs, *LAUNCH.disturbances))
        return Request(channels, self.columns or {}, self.delays or {}, self.databases, period, held, LIMITS)


@dataclass(frozen=True)
class Identified:
    """A model with all that is known of it.

    Attributes:
        errors: "train" and "validation" -> errors by output; no "validation" where there was nothing to validate on.
        candidates: of the order search, best AIC first, always made; warnings: sentences.
        training, validation: the runs.
    """

    model: ArxModel
    fit: Fit
    errors: Mapping[str, Mapping[str, ChannelErrors]]
    candidates: Sequence[Candidate]
    warnings: Sequence[str]
    delay: DelayHint | None
    training: Sequence[Recording]
    validation: Sequence[Recording]

    def to_json(self) -> dict[str, Any]:
        """Return what `bitepoint identify --json` prints: rms one step ahead, largest in free run; null: not finite."""
        told: dict[str, Any] = {
            part: {
                "one_step": {name: _finite(found[name].one_step_rms) for name in found},
                "free_run": {name: _finite(found[name].free_run_max) for name in found},
            }
            for part, found in self.errors.items()
        }
        return {
            "model": self.model.kind,
            "orders": _orders(self.model),
            "errors": {"validation": None, **told},
            "warnings": list(self.warnings),
        }


def identify_launch(
    paths: Sequence[str | Path], validate: Sequence[str | Path] = (), options: Options | None = None
) -> Identified:
    """Return the model of a launch, identified from logs.

    Args:
        paths: logs to train on, files or folders.
        validate: logs to validate on; none: some of the training runs are held out.

    Raises:
        InputError: no usable logs, or options that cannot be carried out.
    """
    options = Options() if options is None else options
    data = _read(paths, options, options.period)
    if data.period > LONGEST_PERIOD:
        mend = f"expected at most {LONGEST_PERIOD:g} s; a time in ms is named by --column time='NAME ms'"
        raise InputError("identify", f"rows are {data.period:g} s apart, a launch lasts about a second", mend)
    warnings = list(data.warnings)
    if validate:
        checked = _read(validate, options, data.period, "--validate")
        warnings += [f"validation: {warning}" for warning in checked.warnings]
        both = set(map(Path.resolve, log_files(paths, ""))) & set(map(Path.resolve, log_files(validate, "")))
        if both:
            warnings.append(f"{len(both)} logs are in training and in validation: their errors say little")
    else:
        data, checked, said = _held_out(data)
        warnings.append(said)
    result = identify_runs(data.runs, () if checked is None else checked.runs, options, data.period)
    nothing: Mapping[str, str] = {}
    files = {"train": data.files, "validation": nothing if checked is None else checked.files}
    told = {
        part: [{"name": Path(file).name, "sha256": digest} for file, digest in named.items()]
        for part, named in files.items()
    }
    about = {**result.model.about, "files": told}
    return replace(result, model=replace(result.model, about=about), warnings=[*warnings, *result.warnings])


def _read(paths: Sequence[str | Path], options: Options, period: float | None, option: str = "identify") -> Dataset:
    """Return the runs with the channels of a launch, the slip formed where the logs do not hold it."""
    data, ratio = read_dataset(paths, options.request(period), option), options.ratio
    if ratio is None:
        return data
    slip = Channel("slip", UNITS["slip"])
    runs: list[Recording] = []
    for run in data.runs:
        channels = tuple(slip if channel.name == "wheel_speed" else channel for channel in run.channels)
        values = run.data.copy()
        values[channels.index(slip)] = run["engine_speed"] - ratio * run["wheel_speed"]
        runs.append(Recording(run.time, channels, values, run.about))
    return replace(data, runs=tuple(runs))


def _held_out(data: Dataset) -> tuple[Dataset, Dataset | None, str]:
    """Return training and validation runs, and a sentence on how they were parted."""
    if len(data.runs) < 3:
        return data, None, "no validation logs, and too few runs to hold some out: the errors are those of training"
    held = [run for n, run in enumerate(data.runs) if n % HELD_OUT == 2]
    kept = [run for n, run in enumerate(data.runs) if n % HELD_OUT != 2]
    said = f"no validation logs: {len(held)} of {len(data.runs)} runs are held out for validation"
    return replace(data, runs=tuple(kept)), replace(data, runs=tuple(held), files={}), said


def identify_runs(
    training: Sequence[Recording], validation: Sequence[Recording], options: Options, period: float
) -> Identified:
    """Return the model of runs on a raster of `period` (s) that have the channels of a launch.

    Raises:
        InputError: too few rows for the orders.
    """
    runs = [Run.of(recording, LAUNCH) for recording in training]
    checked = [Run.of(recording, LAUNCH) for recording in validation]
    candidates = try_orders(runs, LAUNCH, period) if _enough(runs, (4, 3, 3)) else []
    orders, moving_average = _chosen(options, candidates)
    longest = max(*orders, moving_average)
    runs = [run for run in runs if len(run) > longest]
    checked = [run for run in checked if len(run) > longest]
    if not _enough(runs, orders) or (validation and not checked):
        rows = sum(map(len, runs))
        raise InputError("identify", f"{rows} rows for orders {','.join(map(str, orders))}", "expected more rows")
    if options.model == "armax":
        fit = fit_armax(runs, LAUNCH, orders, moving_average, period)
    else:
        fit = fit_arx(runs, LAUNCH, orders, period, options.method)
    errors = {"train": errors_of(fit.model, runs)}
    if checked:
        errors["validation"] = errors_of(fit.model, checked)
    hint = estimate_delay(runs, LAUNCH.inputs[0], LAUNCH.outputs[0], period)
    warnings = identifiability(fit, runs, LAUNCH) + _remarks(errors, hint, period)
    model = replace(fit.model, about=_about(fit, errors, options, training, validation))
    return Identified(model, fit, errors, candidates, warnings, hint, training, validation)


def _enough(runs: Sequence[Run], orders: Orders) -> bool:
    """Return whether there are more than twice as many rows as columns."""
    return sum(max(len(run) - max(orders), 0) for run in runs) > 2 * len(LAUNCH.columns(orders))


def _chosen(options: Options, candidates: Sequence[Candidate]) -> tuple[Orders, int]:
    """Return n_a, n_b, n_g and n_c."""
    if options.orders is None:
        if not candidates:
            raise InputError("--orders", "auto, with too few rows for a search", "expected more rows, or give orders")
        orders = best_orders(candidates)
        return orders, orders[0] if options.model == "armax" else 0
    n_a, n_b, n_g, *rest = options.orders
    return (n_a, n_b, n_g), (rest[0] if rest else n_a) if options.model == "armax" else 0


def _remarks(errors: Mapping[str, Mapping[str, ChannelErrors]], hint: DelayHint | None, period: float) -> list[str]:
    """Return sentences on errors that do not fit together, and on a delay."""
    said: list[str] = []
    for part, found in errors.items():
        for name, error in found.items():
            if not error.free_run_rms <= FREE_RUN_RATIO * error.one_step_rms:
                said.append(
                    f"{part}: {name} is off by up to {error.free_run_max:.3g} rad/s in free run, against "
                    f"{error.one_step_rms:.2g} rad/s rms one step ahead: do not judge it by the second"
                )
    if hint is not None and abs(hint.delay) > 0.5 * period:
        said.append(
            f"{hint.signal} seems to be {abs(hint.delay) * 1e3:.0f} ms too {'late' if hint.delay > 0 else 'early'} "
            f"(correlation {hint.correlation:.2f}): try --delay {hint.signal}='{hint.delay * 1e3:.0f} ms'"
        )
    return said


FREE_RUN_RATIO = 10.0
"""Free-run error over one-step error, both rms, from which on it is remarked (chosen)."""


def _orders(model: ArxModel) -> list[int]:
    return [order for n, order in enumerate(model.orders) if n < 3 or order]


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _about(
    fit: Fit, errors: Mapping[str, Mapping[str, ChannelErrors]], options: Options, training: Sequence[Recording],
    validation: Sequence[Recording],
) -> dict[str, Any]:  # fmt: skip
    """Return where the model comes from, as JSON can hold it."""
    told = {
        part: {name: {key: _finite(value) for key, value in asdict(found[name]).items()} for name in found}
        for part, found in errors.items()
    }
    return {
        "source": "identified from logs",
        "method": fit.method,
        "errors": told,
        "runs": {"train": len(training), "validation": len(validation)},
        "rows": {
            part: sum(len(run.time) for run in runs) for part, runs in (("train", training), ("validation", validation))
        },
        "aic": fit.aic,
        "bic": fit.bic,
        "condition": fit.condition,
        "standard_errors": fit.standard_errors.tolist(),
        "columns": dict(options.columns or {}),
        "delays": dict(options.delays or {}),
        "ratio": options.ratio,
        "versions": {"bitepoint": __version__, "numpy": np.__version__, "python": platform.python_version()},
    }
