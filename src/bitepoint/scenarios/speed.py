"""A speed to follow, from a file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.units import header_unit, split_header
from bitepoint.recording import Floats
from bitepoint.scenarios.logged_column import LoggedColumn, read_logged_column
from bitepoint.units import UnitError, parse

FASTEST = 100.0
"""Highest speed, m/s, as of every trace of a speed."""

_HUMPS = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")

ZERO_ERROR = 0.1
"""How far below 0 a log of a standstill may be, m/s: it counts as 0."""


@dataclass(frozen=True)
class SpeedLog:
    """Which part of which file is the speed to follow.

    Attributes:
        file: CSV with a header, or Parquet.
        column: name of the column; unit: of its values, or None where the header tells (`speed_kmh`, `cycMps`).
        start, end: part of the file, s in its own time; None: from its first or to its last row.
    """

    file: Path
    column: str
    unit: str | None = None
    start: float | None = None
    end: float | None = None


def read_speed_log(log: SpeedLog) -> tuple[Floats, Floats]:
    """Return time (s, from 0) and speed (m/s, >= 0), each shape (n,).

    Raises:
        InputError: no such file or column, no unit, times that do not increase, or missing or impossible values.
    """
    where = str(log.file)
    unit = log.unit or _stated_unit(log.column)
    if unit is None:
        raise InputError(where, f"{log.column}: unit unknown", "add --set speed.unit=km/h, or what it is")
    time, value = read_logged_column(LoggedColumn(log.file, log.column, "speed", log.start, log.end))
    try:
        speed: Floats = value * parse(1.0, "m/s", unit)
    except UnitError as error:
        raise InputError(where, f"{log.column}: {error}", "expected a unit of a speed, such as km/h") from None
    low, high = float(speed.min()), float(speed.max())
    if low < -ZERO_ERROR or high > FASTEST:
        mend = f"expected 0..{FASTEST:g} m/s; check speed.unit"
        raise InputError(where, f"{log.column}: speeds from {low:g} m/s to {high:g} m/s", mend)
    return time - time[0], np.maximum(speed, 0.0)


def _stated_unit(column: str) -> str | None:
    """Return the unit in a header, such as `speed_kmh`, `v [km/h]` or `cycMps`; None where it states none."""
    name, unit = split_header(column)
    words = _HUMPS.sub("_", name).lower().split("_")
    return unit or header_unit("_".join(words), ["_".join(words[:count]) for count in range(1, len(words))]) or None
