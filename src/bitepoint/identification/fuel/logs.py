"""Logs of a drive: fuel flow and speed, one row a second.

A log that is finer than the raster is averaged on the way, the mean filter of the paper: see `resampling`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.datasets import Dataset, Request, log_files, read_dataset
from bitepoint.identification.readers import FileError, open_log
from bitepoint.recording import Channel, Recording

FUEL, SPEED = Channel("fuel_flow", "kg/s"), Channel("vehicle_speed", "m/s")
GRADE = Channel("grade", "1")
ENGINE = (Channel("engine_speed", "rad/s"), Channel("engine_torque", "N*m"))

ALIASES: Mapping[str, tuple[str, ...]] = {"fuel_flow": ("fuel", "fuel_rate"), "vehicle_speed": ("speed", "velocity")}
"""Other names that are understood."""

LIMITS: Mapping[str, float] = {
    "fuel_flow": 0.1, "vehicle_speed": 100.0, "grade": 0.5, "engine_speed": 1500.0, "engine_torque": 5000.0,
}  # fmt: skip
"""Magnitudes, SI, that no road vehicle reaches (chosen)."""

PERIOD = 1.0
"""Raster, s."""

DENSITY = 743.0
"""Density of petrol where none is given, kg/m^3: that of the fuel of the dynamometer's files."""

LEAST_ROWS = 120
"""Rows of training that a model takes at least: two minutes."""

NEGATIVE = 0.01
"""Share of the highest flow, or of the highest speed, below zero that is taken for noise, and as zero."""


@dataclass(frozen=True)
class LogOptions:
    """How logs of a drive are read.

    Attributes:
        columns, delays, databases, period: see `datasets.Request`; period None: one second.
        density: of the fuel, kg/m^3, for flows of volume; None: `DENSITY` for logs, which a warning tells; an
            engine map of volumes is refused.
    """

    columns: Mapping[str, str] = field(default_factory=dict[str, str])
    delays: Mapping[str, float] = field(default_factory=dict[str, float])
    databases: tuple[Path, ...] = ()
    period: float | None = None
    density: float | None = None

    def __post_init__(self) -> None:
        """Hold that a density is one of a fuel.

        Raises:
            InputError: it is none.
        """
        if self.density is not None and not 400.0 <= self.density <= 1200.0:
            raise InputError("--density", f"got {self.density:g} kg/m^3", "expected a liquid fuel of 400..1200 kg/m^3")

    def request(self, channels: tuple[Channel, ...], columns: Mapping[str, str]) -> Request:
        """Return what is wanted of the logs."""
        period = PERIOD if self.period is None else self.period
        density = DENSITY if self.density is None else self.density
        limits, held = {name: LIMITS[name] for name in LIMITS}, frozenset[str]()
        return Request(
            channels, columns, self.delays, self.databases, period, held, limits, ALIASES, {FUEL.name: density}
        )


def read_drives(
    train: Sequence[str | Path], validate: Sequence[str | Path], options: LogOptions
) -> tuple[Dataset, Dataset | None]:
    """Return training and validation runs with fuel flow, speed and whatever else all of them hold.

    Raises:
        InputError: no usable logs, too few rows, fuel or speed below zero, or a vehicle that never moves.
    """
    paths = [*log_files(train, "identify"), *(log_files(validate, "--validate") if validate else [])]
    _known(options)
    channels, columns = _channels(paths, options)
    request = options.request(channels, columns)
    data = _clean(read_dataset(train, request))
    if data.rows < LEAST_ROWS:
        mend = f"expected {LEAST_ROWS} at least; a time in ms is named by --column time='NAME ms'"
        raise InputError("identify", f"{data.rows} rows of {data.period:g} s to train on", mend)
    if max(float(run[SPEED.name].max()) for run in data.runs) < 1.0:
        raise InputError("identify", "the vehicle never moves", "expected logs of a drive")
    checked = _clean(read_dataset(validate, request, "--validate")) if validate else None
    for option, each in (("identify", data), ("--validate", checked)):
        if each is not None and sum(float(run[FUEL.name].sum()) for run in each.runs) <= 0.0:
            raise InputError(option, "fuel_flow is zero throughout", "expected a measured fuel flow")
    if FUEL.name in data.volumes and options.density is None:
        told = f"fuel_flow is a volume, and no --density is given: taken as {DENSITY * 1e-3:g} g/mL, that of petrol"
        data = replace(data, warnings=(told, *data.warnings))
    return data, checked


def _known(options: LogOptions) -> None:
    """Hold that columns and delays name channels that there are, wherever they stand."""
    every = (FUEL, SPEED, GRADE, *ENGINE)
    Request(every, options.columns, options.delays)


def _channels(paths: Sequence[Path], options: LogOptions) -> tuple[tuple[Channel, ...], Mapping[str, str]]:
    """Return the channels that are read: fuel and speed, grade and engine where asked for or in all logs."""
    found: list[Channel] = [FUEL, SPEED]
    for group in ((GRADE,), ENGINE):
        asked = [each.name in options.columns or each.name in options.delays for each in group]
        if any(asked) or _all_hold(paths, group, options):
            found += group
    return tuple(found), options.columns


def _all_hold(paths: Sequence[Path], group: tuple[Channel, ...], options: LogOptions) -> bool:
    request = Request(group, aliases=ALIASES)
    for path in paths:
        try:
            log = open_log(path, options.databases, options.columns.get("time"))
            for channel in group:
                request.find(log, channel)
        except FileError:
            return False
    return True


def _clean(data: Dataset) -> Dataset:
    """Return the runs with fuel and speed of zero at the least.

    Raises:
        InputError: they are below zero by more than noise.
    """
    runs: list[Recording] = []
    for run in data.runs:
        values = run.data.copy()
        for row, channel in enumerate(run.channels):
            if channel not in (FUEL, SPEED):
                continue
            lowest, highest = float(values[row].min()), float(np.abs(values[row]).max())
            if lowest < -NEGATIVE * highest:
                at = float(run.time[int(np.argmin(values[row]))])
                where = f"{run.about['file']}: {channel.name}"
                raise InputError(where, f"{lowest:.3g} {channel.unit} at {at:g} s", "expected none below zero")
            values[row] = np.maximum(values[row], 0.0)
        runs.append(Recording(run.time, run.channels, values, run.about))
    return replace(data, runs=tuple(runs))
