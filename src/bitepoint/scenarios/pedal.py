"""A pedal trace cut from a measured log."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.recording import Floats

TIME_COLUMNS = ("time", "time_s", "t", "timestamp")
"""Names that the time column may have; times are in seconds."""


@dataclass(frozen=True)
class PedalLog:
    """Which part of which log is the pedal.

    Attributes:
        file: CSV with a header, or Parquet.
        column: name of the pedal column, in percent, or from 0 to 1 where `ratio` is True.
        rest: its value with the pedal released, percent: subtracted.
        full: its value with the pedal fully pressed, percent; None: 100 percentage points above rest.
        start, end: part of the log, s in its own time; None: from its first or to its last row.
    """

    file: Path
    column: str
    rest: float = 0.0
    full: float | None = None
    start: float | None = None
    end: float | None = None
    ratio: bool | None = None


def read_pedal_log(log: PedalLog) -> tuple[Floats, Floats]:
    """Return time (s, from 0) and pedal (0..1), each shape (n,).

    The pedal is (value - rest) / (full - rest), limited to 0..1.

    Raises:
        InputError: no such file or column, times that do not increase, or missing or impossible values.
    """
    where = str(log.file)
    table = _read_table(log.file)
    twice = [name for name in table.column_names if table.column_names.count(name) > 1]
    if twice:
        raise InputError(where, f"two columns are named {twice[0]}", "rename one of them")
    time_name = next((name for name in TIME_COLUMNS if name in table.column_names), None)
    if time_name is None:
        raise InputError(where, "no time column", f"expected a column named one of {', '.join(TIME_COLUMNS)}")
    if log.column not in table.column_names:
        mend = f"expected one of {', '.join(name for name in table.column_names if name != time_name)}"
        raise InputError(where, f"no column {log.column}", mend)
    time, value = _floats(table, time_name, where), _floats(table, log.column, where)
    time, value = _cut(log, time, value, where)
    if not 0.0 <= log.rest <= 100.0:
        raise InputError("pedal.rest", f"got {log.rest:g} %", "expected percent, 0 to 100")
    if log.ratio:
        value = 100.0 * value
    span = 100.0 if log.full is None else log.full - log.rest
    if span <= 0.0:
        raise InputError("pedal.full", f"got {log.full:g} %", f"expected more than pedal.rest, {log.rest:g} %")
    low, high = float(value.min()), float(value.max())
    if low < -1.0 or high > 101.0:
        raise InputError(where, f"{log.column}: values from {low:g} to {high:g}", "expected percent, 0 to 100")
    if 0.0 < high <= 1.0 and log.ratio is None:  # nobody said which of the two it is
        mend = "expected percent; add --set pedal.unit=ratio where 1 is fully pressed"
        raise InputError(where, f"{log.column}: values up to {high:g}", mend)
    return time - time[0], np.clip((value - log.rest) / span, 0.0, 1.0)


def _cut(log: PedalLog, time: Floats, value: Floats, where: str) -> tuple[Floats, Floats]:
    rising = np.isfinite(time)
    rising[1:] &= time[1:] > time[:-1]
    if not rising.all():
        bad = int(np.flatnonzero(~rising)[0])
        raise InputError(where, f"time does not increase in row {bad + 1}", "sort the rows and remove repeated ones")
    if not time.size:
        raise InputError(where, "fewer than two rows", "expected a header and rows of numbers")
    start = time[0] if log.start is None else log.start
    end = time[-1] if log.end is None else log.end
    inside = (time >= start) & (time <= end)
    if inside.sum() < 2:
        mend = f"expected part of {time[0]:g}..{time[-1]:g} s"
        raise InputError(where, f"fewer than two rows from {start:g} s to {end:g} s", mend)
    if not np.isfinite(value[inside]).all():
        first = float(time[inside][~np.isfinite(value[inside])][0])
        mend = "choose pedal.start and pedal.end where it has values"
        raise InputError(where, f"{log.column} has no value at {first:g} s", mend)
    return time[inside], value[inside]


def _read_table(path: Path) -> Any:
    pa, csv, parquet = _arrow()
    try:
        return parquet.read_table(path) if path.suffix == ".parquet" else csv.read_csv(path)
    except FileNotFoundError:
        raise InputError(str(path), "no such file", "check the path") from None
    except (pa.ArrowException, OSError) as error:
        text = str(error).splitlines()[0][:80]
        raise InputError(str(path), f"cannot be read ({text})", "expected CSV with a header, or Parquet") from None


def _arrow() -> tuple[Any, Any, Any]:
    import pyarrow as pa
    from pyarrow import csv, parquet

    return pa, csv, parquet


def _floats(table: Any, name: str, where: str) -> Floats:
    pa, _, _ = _arrow()
    try:
        return table[name].cast(pa.float64()).to_numpy(zero_copy_only=False).astype(float)
    except pa.ArrowException:
        raise InputError(where, f"{name}: not numbers only", "expected numbers or empty cells") from None
