"""Logs to runs: channels found and converted, times aligned, gaps cut, one raster for all.

Nothing is repaired: a gap in time ends a run and begins the next one, and a file that is broken is left out and named
in a warning. What is asked for and cannot be done is refused.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.columns import find_column
from bitepoint.identification.readers import SUFFIXES, FileError, Log, open_log
from bitepoint.recording import Channel, Floats, Recording

GAP = 3.0
"""A step of time longer than this many usual ones is a gap."""

LEAST_ROWS = 10
"""A piece between gaps with fewer rows is left out."""

MOST_ROWS = 20_000_000
"""Most rows of one run."""


@dataclass(frozen=True)
class Request:
    """What is wanted of the logs.

    Attributes:
        channels: wanted signals with their units; all are resampled to one raster.
        columns: channel, or time -> how it is called in the logs: a name, a unit may follow ("EngSpd rpm").
        delays: channel -> how much it is late in the logs, s.
        databases: DBC files for CAN frames.
        period: raster, s; None: that of the first usable file.
    """

    channels: tuple[Channel, ...]
    columns: Mapping[str, str] = field(default_factory=dict[str, str])
    delays: Mapping[str, float] = field(default_factory=dict[str, float])
    databases: tuple[Path, ...] = ()
    period: float | None = None

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
    """

    runs: tuple[Recording, ...]
    period: float
    warnings: tuple[str, ...]
    files: Mapping[str, str]

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
    period = request.period
    for path in log_files(paths, option):
        try:
            log = open_log(path, request.databases, request.columns.get("time"))
            signals = _signals(log, request, warnings)
            period = _usual_step(signals[0][0]) if period is None else period
            pieces = _pieces(signals, request.channels, period, str(path))
        except FileError as fault:
            faults.append(fault)
            warnings.append(f"{fault.where}: {fault.problem}; the file is left out")
            continue
        if not pieces:
            warnings.append(f"{path}: no piece of it has {LEAST_ROWS} rows between gaps; the file is left out")
            continue
        if len(pieces) > 1:
            warnings.append(f"{path}: {len(pieces) - 1} gaps, so it counts as {len(pieces)} runs")
        files[str(path)] = hashlib.sha256(path.read_bytes()).hexdigest()
        runs += pieces
    if not runs or period is None:
        if faults:
            raise InputError(faults[0].where, faults[0].problem, faults[0].mend)
        raise InputError(
            option, warnings[0] if warnings else "no usable log", "expected longer logs, or a shorter period"
        )
    return Dataset(tuple(runs), period, tuple(warnings), files)


def _signals(log: Log, request: Request, warnings: list[str]) -> list[tuple[Floats, Floats]]:
    """Return times and values of the wanted channels, in their units, delays taken out; add what is to be told."""
    result: list[tuple[Floats, Floats]] = []
    for channel in request.channels:
        column = find_column(log, channel, request.columns.get(channel.name))
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
        result.append((time - request.delays.get(channel.name, 0.0), values * column.scale + column.offset))
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


def _usual_step(time: Floats) -> float:
    """Return the median step of time, rounded to a microsecond."""
    return max(round(float(np.median(np.diff(time))), 6), 1e-6)


def _pieces(
    signals: Sequence[tuple[Floats, Floats]], channels: tuple[Channel, ...], period: float, where: str
) -> list[Recording]:
    """Return what lies between gaps, on the raster."""
    start, end = max(time[0] for time, _ in signals), min(time[-1] for time, _ in signals)
    if end <= start:
        raise FileError(where, "its channels have no time in common", "expected channels that overlap")
    if (end - start) / period > MOST_ROWS:
        raise FileError(where, f"{end - start:g} s of log", f"expected at most {MOST_ROWS} rows")
    cuts = [(start, end)]
    for time, _ in signals:
        step = np.diff(time)
        gaps = np.flatnonzero(step > GAP * max(float(np.median(step)), period))
        cuts = [piece for cut in cuts for piece in _without(cut, time[gaps], time[gaps + 1])]
    pieces: list[Recording] = []
    for first, last in cuts:
        raster = _raster(signals[0][0], first, last, period)
        if len(raster) < LEAST_ROWS:
            continue
        data = np.array([np.interp(raster, time, values) for time, values in signals])
        pieces.append(Recording(raster, channels, data, {"file": where}))
    return pieces


def _without(cut: tuple[float, float], begins: Floats, ends: Floats) -> list[tuple[float, float]]:
    """Return what is left of a span of time without the gaps."""
    left: list[tuple[float, float]] = []
    first, last = cut
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        if begin < last and end > first:
            left.append((first, min(begin, last)))
            first = end
    left.append((first, last))
    return [(a, b) for a, b in left if b > a]


def _raster(time: Floats, first: float, last: float, period: float) -> Floats:
    """Return the raster of a piece; it begins at a row of the first channel, so that rows on the raster stay rows."""
    inside = time[(time >= first - 1e-9) & (time <= last + 1e-9)]
    start = max(float(inside[0]), first) if inside.size else first
    rows = int(np.floor((last - start) / period + 1e-6)) + 1
    return start + period * np.arange(max(rows, 0), dtype=np.float64)
