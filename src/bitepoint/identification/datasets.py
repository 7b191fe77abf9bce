"""Logs to runs: channels found and converted, times aligned, gaps cut, one raster for all.

Nothing is repaired: a gap in time ends a run and begins the next one, and a file that is broken is left out and named
in a warning. What is asked for and cannot be done is refused.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.columns import Column, find_column
from bitepoint.identification.readers import SUFFIXES, FileError, Log, open_log
from bitepoint.identification.resampling import LEAST_ROWS, Signal, is_finer, pieces
from bitepoint.recording import Channel, Floats, Recording

COARSER = 1.5
"""A channel with a step of time longer than this many of the raster is remarked."""


@dataclass(frozen=True)
class Request:
    """What is wanted of the logs.

    Attributes:
        channels: wanted signals with their units; all are resampled to one raster.
        columns: channel, or time -> how it is called in the logs: a name, a unit may follow ("EngSpd rpm").
        delays: channel -> how much it is late in the logs, s.
        databases: DBC files for CAN frames.
        period: raster, s; None: that of the first usable file.
        held: channels whose values act from their row on, torques; the others are sampled at it.
        limits: channel -> magnitude, SI, above which it cannot be what it says.
        aliases: channel -> other names that it may have in the logs.
        densities: channel, a flow of mass -> kg/m^3, by which it is read where it is logged as a flow of volume.
    """

    channels: tuple[Channel, ...]
    columns: Mapping[str, str] = field(default_factory=dict[str, str])
    delays: Mapping[str, float] = field(default_factory=dict[str, float])
    databases: tuple[Path, ...] = ()
    period: float | None = None
    held: frozenset[str] = frozenset()
    limits: Mapping[str, float] = field(default_factory=dict[str, float])
    aliases: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    densities: Mapping[str, float] = field(default_factory=dict[str, float])

    def find(self, log: Log, channel: Channel) -> Column:
        """Return the signal of a log that is the channel.

        Raises:
            FileError: no such signal, several, or a unit of another dimension.
        """
        name = channel.name
        return find_column(log, channel, self.columns.get(name), self.aliases.get(name, ()), self.densities.get(name))

    def __post_init__(self) -> None:
        """Hold that columns and delays name wanted channels.

        Raises:
            InputError: one does not, or a delay or the period is no such time.
        """
        names = [channel.name for channel in self.channels]
        for option, keys in (("--column", self.columns), ("--delay", self.delays)):
            for name in keys:
                if name not in names and (option, name) != ("--column", "time"):
                    raise InputError(option, f"{name}: unknown channel", f"expected one of {', '.join(names)}")
        for name, delay in self.delays.items():
            if not abs(delay) <= 10.0:
                raise InputError("--delay", f"{name}: got {delay:g} s", "expected at most 10 s, either way")
        if self.period is not None and not 1e-4 <= self.period <= 10.0:
            raise InputError("--period", f"got {self.period:g} s", "expected a time of 0.0001..10 s")


@dataclass(frozen=True)
class Dataset:
    """Runs on one raster.

    Attributes:
        runs: each with the wanted channels, SI; `about["file"]` names the file, gaps make several of one.
        period: s.
        warnings: what was left out, and why.
        files: SHA-256 by file, of those that are used.
        volumes: channels that a log holds as a flow of volume.
    """

    runs: tuple[Recording, ...]
    period: float
    warnings: tuple[str, ...]
    files: Mapping[str, str]
    volumes: frozenset[str] = frozenset()

    @property
    def rows(self) -> int:
        """Rows of all runs."""
        return sum(len(run.time) for run in self.runs)


def log_files(paths: Sequence[str | Path], option: str) -> list[Path]:
    """Return the files that are meant: folders stand for all logs in them, by name.

    Raises:
        InputError: none, no such file or folder, or a folder without logs.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        inside = sorted(file for file in path.iterdir() if file.suffix.lower() in SUFFIXES) if path.is_dir() else [path]
        if not inside:
            raise InputError(str(path), "no logs in it", f"expected files that end in {', '.join(SUFFIXES)}")
        if not inside[0].exists():
            raise InputError(str(path), "no such file", "check the path")
        found += inside
    if not found:
        raise InputError(option, "no files", "name at least one log")
    return list(dict.fromkeys(found))


def read_dataset(paths: Sequence[str | Path], request: Request, option: str = "identify") -> Dataset:
    """Return the runs of logs; a broken file is left out with a warning.

    Args:
        paths: files and folders.
        option: what an error names where there are none.

    Raises:
        InputError: the request cannot be carried out, or no file is usable; then the first fault is told.
    """
    runs: list[Recording] = []
    warnings: list[str] = []
    faults: list[FileError] = []
    files: dict[str, str] = {}
    volumes: set[str] = set()
    period, remarks = request.period, _Remarks()
    for path in log_files(paths, option):
        try:
            signals = _signals(
                open_log(path, request.databases, request.columns.get("time")), request, warnings, volumes
            )
            step = max(round(signals[0].step, 6), 1e-6) if period is None else period
            found = pieces(signals, step, str(path))
        except FileError as fault:
            faults.append(fault)
            warnings.append(f"{fault.where}: {fault.problem}; the file is left out")
            continue
        if not found:
            warnings.append(f"{path}: no piece of it has {LEAST_ROWS} rows between gaps; the file is left out")
            continue
        if len(found) > 1:
            warnings.append(f"{path}: {len(found) - 1} gaps, so it counts as {len(found)} runs")
        period = step
        remarks.see(signals, request.channels, period)
        files[str(path)] = hashlib.sha256(path.read_bytes()).hexdigest()
        runs += [Recording(raster, request.channels, data, {"file": str(path)}) for raster, data in found]
    if not runs or period is None:
        _refuse(faults, warnings, option)
    return Dataset(tuple(runs), period, (*warnings, *remarks.told(period)), files, frozenset(volumes))


def _refuse(faults: Sequence[FileError], warnings: Sequence[str], option: str) -> NoReturn:
    if faults:
        raise InputError(faults[0].where, faults[0].problem, faults[0].mend)
    raise InputError(option, warnings[0] if warnings else "no usable log", "expected longer logs, or a shorter period")


@dataclass
class _Remarks:
    """What resampling has done to all logs together."""

    averaged: int = 0
    coarse: dict[str, float] = field(default_factory=dict[str, float])

    def see(self, signals: Sequence[Signal], channels: Sequence[Channel], period: float) -> None:
        self.averaged += is_finer(signals, period)
        for channel, signal in zip(channels, signals, strict=True):
            if signal.step > COARSER * period:
                self.coarse[channel.name] = max(signal.step, self.coarse.get(channel.name, 0.0))

    def told(self, period: float) -> Iterator[str]:
        if self.averaged:
            yield f"finer than the raster: {self.averaged} logs, all channels of them are means over {period:g} s"
        if self.coarse:
            names, step = ", ".join(self.coarse), max(self.coarse.values())
            yield f"coarser than the raster, up to {step:.3g} s: {names}; the rows in between are interpolated"


def _signals(log: Log, request: Request, warnings: list[str], volumes: set[str]) -> list[Signal]:
    """Return the wanted channels in their units, delays taken out; add what is to be told, and which are volumes."""
    result: list[Signal] = []
    for channel in request.channels:
        column = request.find(log, channel)
        volumes |= {channel.name} if column.volume else set()
        time, values = log.read(column.name)
        where = f"{log.where}: {column.name}"
        rows = len(time)
        time, values = _present(time, values, where)
        if len(time) < rows:
            warnings.append(f"{where} has values from {time[0]:g} s to {time[-1]:g} s only: the rest is not used")
        rising = np.diff(time) > 0.0
        if not rising.all():
            row = int(np.argmin(rising)) + 1
            raise FileError(where, f"time does not increase at {time[row]:g} s", "sort the rows, remove repeated ones")
        values = values * column.scale + column.offset
        _hold_plausible(channel, values, request.limits.get(channel.name, np.inf), where)
        result.append(Signal(time - request.delays.get(channel.name, 0.0), values, channel.name in request.held))
    return result


def _present(time: Floats, values: Floats, where: str) -> tuple[Floats, Floats]:
    """Return a signal from its first value to its last: what stands empty before and after was not logged."""
    if not np.isfinite(time).all():
        raise FileError(where, "a time is no number", "remove the row")
    there = np.flatnonzero(np.isfinite(values))
    if there.size < 2:
        raise FileError(where, "no values", "expected a logged channel")
    span = slice(int(there[0]), int(there[-1]) + 1)
    inside = np.isfinite(values[span])
    if not inside.all():
        first = time[span][int(np.argmin(inside))]
        raise FileError(where, f"{int((~inside).sum())} values missing, from {first:g} s", "cut the log there")
    return time[span], values[span]


def _hold_plausible(channel: Channel, values: Floats, limit: float, where: str) -> None:
    worst = float(np.abs(values).max())
    if worst > limit:
        unit = f"at most {limit:g} {channel.unit}; its unit is named by --column {channel.name}='NAME UNIT'"
        raise FileError(where, f"reaches {worst:g} {channel.unit}", f"expected {unit}")
