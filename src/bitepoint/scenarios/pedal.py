"""A pedal trace cut from a measured log."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bitepoint.errors import InputError
from bitepoint.recording import Floats
from bitepoint.scenarios.logged_column import LoggedColumn, read_logged_column


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
    time, value = read_logged_column(LoggedColumn(log.file, log.column, "pedal", log.start, log.end))
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
