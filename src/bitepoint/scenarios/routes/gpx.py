"""A road from a GPX file: a recorded track or a planned route, by gpxpy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.readers.log import FileError, library, said_by
from bitepoint.scenarios.routes.table import track
from bitepoint.scenarios.routes.terrain import Points


def read_gpx_points(path: Path) -> Points:
    """Return what the one track of a GPX file, or its one route where it has no track, tells of a road.

    The segments of a track are joined. Points at the same place as the one before are left out: a receiver that stands.

    Raises:
        InputError: gpxpy is not installed; no such file, no GPX, none or several tracks, or points without elevation.
    """
    where = str(path)
    file = _opened(library("gpxpy", "route", where), path)
    points = _points(file, where)
    if len(points) < 2:
        raise InputError(where, f"{len(points)} points", "expected two or more, at different places")
    latitude, longitude = (np.array([getattr(each, name) for each in points]) for name in ("latitude", "longitude"))
    elevation = np.array([np.nan if each.elevation is None else each.elevation for each in points], float)
    distance, kept, told = track(latitude, longitude, where, "point")
    about = "; ".join(part for part in (path.name, told) if part)
    return Points(where, distance, elevation[kept], about=about, row="point")


def _opened(gpxpy: Any, path: Path) -> Any:
    where = str(path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            return gpxpy.parse(file)
    except FileNotFoundError:
        raise InputError(where, "no such file", "check the path") from None
    except (gpxpy.gpx.GPXException, OSError, ValueError, TypeError) as error:  # its conversions raise the last two
        raise FileError(where, f"cannot be read ({said_by(error)})", "expected a GPX file") from None


def _points(file: Any, where: str) -> list[Any]:
    noun, lines = ("tracks", file.tracks) if file.tracks else ("routes", file.routes)
    if len(lines) != 1:
        problem = f"{len(lines)} {noun}" if lines else "no track and no route"
        raise InputError(where, problem, "expected a GPX file with one track or one route")
    return [point for segment in getattr(lines[0], "segments", lines) for point in segment.points]
