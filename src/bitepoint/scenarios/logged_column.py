"""One column of a measured log, over time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.readers.table import TIME_NAMES, column_floats, read_table
from bitepoint.identification.units import header_unit
from bitepoint.recording import Floats
from bitepoint.units import UnitError, parse

TIME_COLUMNS = (*TIME_NAMES, "cycsecs")
"""Names that the time column may have; a unit may follow, as in time_ms or t [s]. The last one is that of FASTSim."""


@dataclass(frozen=True)
class LoggedColumn:
    """Which part of which log.

    Attributes:
        file: CSV with a header, separated by commas, semicolons or tabs, or Parquet.
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
    if not log.file.is_file():
        raise InputError(where, "no such file", "check the path")
    table = read_table(log.file)
    names: list[str] = table.column_names
    times = next((name for name in names if header_unit(name, TIME_COLUMNS) is not None), None)
    if times is None:
        raise InputError(where, "no time column", f"expected a column named one of {', '.join(TIME_COLUMNS)}")
    if log.column not in names:
        mend = f"expected one of {', '.join(name for name in names if name != times)}"
        raise InputError(where, f"no column {log.column}", mend)
    try:
        second = parse(1.0, "s", header_unit(times, TIME_COLUMNS) or "s")
    except UnitError as error:
        raise InputError(where, f"{times}: {error}", "expected a unit of time") from None
    return _cut(log, column_floats(table, times, where) * second, column_floats(table, log.column, where), where)


def _cut(log: LoggedColumn, time: Floats, value: Floats, where: str) -> tuple[Floats, Floats]:
    rising = np.isfinite(time)
    rising[1:] &= time[1:] > time[:-1]
    if not rising.all():
        bad = int(np.flatnonzero(~rising)[0])
        raise InputError(where, f"time does not increase in row {bad + 1}", "sort the rows and remove repeated ones")
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
