"""The fuel model: fitted on two dynamometer cycles, tested on a third; and the reach of the paper's filter."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bitepoint.api import FuelIdentification, identify_fuel
from bitepoint.identification.fuel.drives import SIGMAS
from bitepoint.studies.reproduction import Row

FOLDER = "fuel_dyno"
TRAIN = ("camry2018_61811012_udds.csv", "camry2018_61811013_hwfet_x2.csv")
UNSEEN = "camry2018_61811014_us06_run1.csv"
SPIKE = 311.0
"""Time of the meter's spike in the first of them, s."""

ABSENT = "no measured data"

NORMAL_SHARE = 0.0026
"""Share of rows beyond three standard deviations, as the paper reckons."""


def data_folder() -> Path | None:
    """Return the folder of measured data, $BITEPOINT_DATA or ../shared/data; None where these cycles are not in it."""
    named = os.environ.get("BITEPOINT_DATA")
    folder = (Path(named) if named else Path("..") / "shared" / "data") / FOLDER
    return folder if all((folder / name).is_file() for name in (*TRAIN, UNSEEN)) else None


def fitted() -> FuelIdentification | None:
    """Return the fuel model of the cycles; None where there are none."""
    folder = data_folder()
    if folder is None:
        return None
    return identify_fuel([folder / name for name in TRAIN], validate=folder / UNSEEN, density="0.743 g/mL")


def fuel_rows(found: FuelIdentification | None) -> Iterator[Row]:
    """Yield the errors on the unseen cycle, and what the filter dropped."""
    reason = ABSENT if found is None else ""
    total = score = spike = dropped = None
    if found is not None:
        errors = found.errors["validation"]
        total, score = errors.total_percent, errors.r2
        spike = float(any(row["file"] == TRAIN[0] and row["time"] == SPIKE for row in found.dropped()))
        dropped = float(np.mean(found.outliers))
    case = "fuel model, US06 unseen"
    yield Row(case, "total_percent", 2.0, total, "%", 0.0, "magnitude", reason)
    yield Row(case, "r2", 0.83, score, "1", 0.0, "least", reason)
    case = "VSP and three sigma, UDDS and HWFET"
    yield Row(case, "spike at 311 s is dropped", 1.0, spike, "1", 0.0, "about", reason)
    yield Row(case, "share of rows dropped", NORMAL_SHARE, dropped, "1", None, "about", reason)


def filter_rows() -> Iterator[Row]:
    """Yield how far off a row can be at most, in standard deviations of a bin that it is part of."""
    for rows in (10, 11, 30):
        fuel = np.zeros(rows)
        fuel[-1] = 1.0
        farthest = float(np.max(np.abs(fuel - fuel.mean())) / fuel.std(ddof=1))
        yield Row(f"VSP and three sigma, a bin of {rows} rows", "standard deviations at most", SIGMAS, farthest, "1")
