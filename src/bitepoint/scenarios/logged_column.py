"""One column of a measured log, over time."""

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
class LoggedColumn:
    """Which part of which log.

    Attributes:
        file: CSV with a header, or Parquet.
        column: its name.
        key: what the settings of it begin with, for what is said of an error.
        start, end: part of the log, s in its own time; None: from its first or to its last row.
    """

    file: Path
    column: str
    key: str
    start: float | None = None
    end: float | None = None


def read_logged_column(log: LoggedColumn) -> tuple[Floats, Floats]:
    """Return time (s, in the log's own time) and value (as it stands there), each shape (n,), n >= 2.

    Raises:
        InputError: no such file or column, times that do not increase, or missing values.
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
    return _cut(log, _floats(table, time_name, where), _floats(table, log.column, where), where)


def _cut(log: LoggedColumn, time: Floats, value: Floats, where: str) -> tuple[Floats, Floats]:
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
        mend = f"choose {log.key}.start and {log.key}.end where it has values"
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
