"""A road from a table: CSV with a header, or Parquet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.readers.table import column_floats, metadata_unit, read_table
from bitepoint.identification.units import conversion, header_unit
from bitepoint.recording import Floats
from bitepoint.scenarios.routes.terrain import Points, distinct, track_distance
from bitepoint.units import UnitError

COLUMNS: Mapping[str, str] = {
    "distance": "m", "latitude": "deg", "longitude": "deg", "elevation": "m", "grade": "1", "speed_limit": "m/s",
    "stop": "1",
}  # fmt: skip
"""What is read, and its unit where neither header nor file states one."""

HIGHEST_LIMIT = 45.0
"""Highest speed limit, m/s: 160 km/h is the highest that is posted anywhere; 50 and more are km/h or mph, mistaken."""


def read_table_points(path: Path) -> Points:
    """Return what a table tells of a road.

    Columns are `distance`, or `latitude` and `longitude`; `elevation` or `grade` or both; perhaps `speed_limit`, whose
    empty cells mean none, and `stop`, 1 where a stop line is. Units stand in the headers, as `distance_km`; others are
    left alone.

    Raises:
        InputError: it cannot be read, a column is missing or twice there, a unit does not fit, or values cannot be.
    """
    where = str(path)
    columns = _columns(read_table(path), where)
    if "elevation" not in columns and "grade" not in columns:
        raise InputError(where, "no column elevation or grade", f"it has {_some(columns)}")
    if "distance" in columns:
        distance, kept, told = columns["distance"], np.arange(columns["distance"].size), ""
    elif "latitude" in columns and "longitude" in columns:
        distance, kept, told = track(columns["latitude"], columns["longitude"], where, "row")
    else:
        raise InputError(where, "no column distance", f"it has {_some(columns)}; latitude and longitude also do")
    stops = np.unique(distance[np.searchsorted(kept, _stops(columns, where), "right") - 1])
    rows = {name: values[kept] for name, values in columns.items()}
    limit = _limits(rows["speed_limit"], where) if "speed_limit" in rows else None
    about = "; ".join(part for part in (path.name, told) if part)
    return Points(where, distance, rows.get("elevation"), rows.get("grade"), limit, stops, about)


def track(latitude: Floats, longitude: Floats, where: str, row: str) -> tuple[Floats, Any, str]:
    """Return distances (m) of the points of a track that are kept, their places, and what is to be said of the others.

    Raises:
        InputError: a position that is missing or not on Earth.
    """
    fine = (np.abs(latitude) <= 90.0) & (np.abs(longitude) <= 360.0)
    if not fine.all():
        bad = int(np.flatnonzero(~fine)[0]) + 1
        raise InputError(where, f"no position on Earth in {row} {bad}", "expected latitude and longitude in degrees")
    kept = distinct(track_distance(latitude, longitude))
    left = latitude.size - kept.size
    told = f"{left} points left out where the track stands" if left else ""
    return track_distance(latitude[kept], longitude[kept]), kept, told


def _columns(table: Any, where: str) -> dict[str, Floats]:
    """Return the columns that are known, in SI (angles in degrees), NaN where a cell is empty."""
    found: dict[str, Floats] = {}
    for header in table.column_names:
        name, stated = _named(header, where)
        if name is None:
            continue
        if name in found:
            raise InputError(where, f"two columns are {name}, one of them {header}", "leave one of them out")
        unit = metadata_unit(table, header) or stated or COLUMNS[name]
        try:
            scale, offset = conversion(unit, COLUMNS[name])
        except UnitError as error:
            raise InputError(where, f"{header}: {error}", f"expected a unit such as {COLUMNS[name]}") from None
        found[name] = column_floats(table, header, where) * scale + offset
    return found


def _named(header: str, where: str) -> tuple[str | None, str]:
    """Return which column a header names, None where it is of no use here, and the unit in it."""
    for name in COLUMNS:
        unit = header_unit(header, (name,))
        if unit is not None:
            return name, unit
        if header.lower().startswith(f"{name}_") and name != "stop":  # passed over, what it tells would be lost
            raise InputError(where, f"{header}: unit unknown", f"expected a header such as {name} [{COLUMNS[name]}]")
    return None, ""


def _stops(columns: Mapping[str, Floats], where: str) -> Any:
    stop = np.nan_to_num(columns.get("stop", np.zeros(0)))
    if not np.isin(stop, (0.0, 1.0)).all():
        raise InputError(where, f"stop: got {stop[~np.isin(stop, (0.0, 1.0))][0]:g}", "expected 1, 0 or empty cells")
    return np.flatnonzero(stop)


def _limits(limit: Floats, where: str) -> Floats:
    given = np.where(np.isnan(limit), np.inf, limit)
    wrong = given[(given <= 0.0) | ((given > HIGHEST_LIMIT) & np.isfinite(given))]
    if wrong.size:
        mend = f"expected up to {HIGHEST_LIMIT:g} m/s; a unit may stand in the header, as speed_limit_kmh"
        raise InputError(where, f"speed_limit: {wrong[0]:g} m/s", mend)
    return given


def _some(columns: Mapping[str, Floats]) -> str:
    return ", ".join(columns) if columns else f"none of {', '.join(COLUMNS)}"
