"""Tables: CSV with a header, and Parquet. One column holds the time."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.identification.readers.log import FileError, Log, said_by
from bitepoint.identification.units import header_unit
from bitepoint.recording import Floats
from bitepoint.units import UnitError, parse

TIME_NAMES = ("time", "timestamp", "timestamps", "t")
"""Names that the column of the time may have; a unit may follow, as in time_ms or t [s]; without one it is seconds."""


def open_table(path: Path, time: str | None = None) -> Log:
    """Return a CSV or Parquet file as a log.

    A CSV may be separated by commas, semicolons or tabs; with semicolons or tabs the decimal sign may be a comma.

    Args:
        time: name of the column of the time, a unit may follow after a blank; None: the first of `TIME_NAMES`.

    Raises:
        FileError: it cannot be read, two columns have one name, or there is no column of time.
    """
    where = str(path)
    table = read_table(path)
    names: list[str] = table.column_names
    units = {name: metadata_unit(table, name) for name in names}
    name, unit = _time_column(names, time, where)
    try:
        scale = parse(1.0, "s", unit or units[name] or header_unit(name, TIME_NAMES) or "s")
    except UnitError as error:
        raise FileError(where, f"{name}: {error}", "expected a unit of time") from None
    seconds = _seconds(table, name, where) * scale
    del units[name]
    return Log(where, units, lambda column: (seconds, column_floats(table, column, where)))


def read_table(path: Path) -> Any:
    """Return a CSV or Parquet file as a table of pyarrow, its names without blanks around them.

    Raises:
        FileError: it cannot be read, has no rows, or two columns of one name.
    """
    where = str(path)
    table = _read(path)
    names: list[str] = [name.strip() for name in table.column_names]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise FileError(where, f"two columns are named {twice}", "rename one of them")
    if not table.num_rows:
        raise FileError(where, "no rows", "expected a header and rows of numbers")
    return table.rename_columns(names)


def _time_column(names: list[str], wish: str | None, where: str) -> tuple[str, str | None]:
    """Return name and wished unit of the column of the time."""
    if wish is not None:
        name, unit = next(((each, wish.removeprefix(each).strip()) for each in names if _is_wish(wish, each)), ("", ""))
        if not name:
            raise FileError(where, f"no column {wish} for time", f"it has {', '.join(names[:8])}")
        return name, unit or None
    found = [name for name in names if header_unit(name, TIME_NAMES) is not None]
    if not found:
        mend = f"expected one named {' or '.join(TIME_NAMES)}, or --column time=NAME"
        raise FileError(where, "no column of time", mend)
    return found[0], None


def _is_wish(wish: str, name: str) -> bool:
    return wish == name or wish.startswith(f"{name} ")


def _read(path: Path) -> Any:
    pa, csv, parquet = _arrow()
    where = str(path)
    try:
        if path.suffix.lower() == ".parquet":
            return parquet.ParquetFile(path).read()
        delimiter, decimal = _dialect(path)
        return csv.read_csv(
            path,
            parse_options=csv.ParseOptions(delimiter=delimiter),
            convert_options=csv.ConvertOptions(decimal_point=decimal),
        )
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        raise FileError(where, f"cannot be read ({said_by(error)})", "expected CSV with a header, or Parquet") from None


def _arrow() -> tuple[Any, Any, Any]:
    import pyarrow as pa
    from pyarrow import csv, parquet

    return pa, csv, parquet


def _dialect(path: Path) -> tuple[str, str]:
    """Return separator and decimal sign of a CSV file, from its first two lines."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        header, row = file.readline(), file.readline()
    delimiter = max(",;\t", key=header.count)
    decimal = "," if delimiter != "," and re.search(r"\d,\d", row) else "."
    return delimiter, decimal


def metadata_unit(table: Any, name: str) -> str | None:
    """Return the unit of a column that the file itself states, as Parquet may."""
    metadata: dict[bytes, bytes] = table.schema.field(name).metadata or {}
    unit = metadata.get(b"unit")
    return None if unit is None else unit.decode(errors="replace")


def _seconds(table: Any, name: str, where: str) -> Floats:
    """Return the column of time as numbers; dates become seconds since the first row, durations seconds."""
    pa, _, _ = _arrow()
    column = table[name]
    if pa.types.is_duration(column.type):
        return (
            column_floats(table.set_column(0, name, column.cast(pa.duration("ns")).cast(pa.int64())), name, where)
            * 1e-9
        )
    if pa.types.is_timestamp(column.type):
        ticks = column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy(zero_copy_only=False)
        return (ticks - ticks[0]) * 1e-9
    return column_floats(table, name, where)


def column_floats(table: Any, name: str, where: str) -> Floats:
    """Return a column as floats, NaN where a cell is empty.

    Raises:
        FileError: not numbers only.
    """
    pa, _, _ = _arrow()
    try:
        return np.asarray(table[name].cast(pa.float64()).to_numpy(zero_copy_only=False), float)
    except pa.ArrowException:
        raise FileError(where, f"{name}: not numbers only", "expected numbers or empty cells") from None
