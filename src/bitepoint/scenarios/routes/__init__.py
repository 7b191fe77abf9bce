"""Roads: from a table, from GPX, or made of waves; each becomes a `Route`."""

from __future__ import annotations

from pathlib import Path

from bitepoint.errors import InputError, brief
from bitepoint.files import library_folder, library_names, read_yaml
from bitepoint.models.route import Route

__all__ = ["SUFFIXES", "load_route", "route_names"]

SUFFIXES = (".csv", ".txt", ".parquet", ".gpx", ".yaml", ".yml")
"""What is read, by the end of the file's name."""

_LIBRARY = "scenarios/routes"


def route_names() -> list[str]:
    """Return the names of the roads in the library."""
    return library_names(_LIBRARY)


def load_route(name: str, smoothing: float | None = None) -> Route:
    """Return the library road `name`, or the one in the file at that path; the end of its name says what it is.

    Args:
        smoothing: base of the triangle that smooths elevation, m; 0: none. None: 200 m for measured elevation, none
            where the file gives the grade. Made roads are not smoothed.

    Raises:
        InputError: no such road, an optional library that is missing, or a file that holds no road.
    """
    path = library_folder(_LIBRARY) / f"{name}.yaml" if name in route_names() else Path(name)
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        mend = f"expected a file ({', '.join(SUFFIXES)}) or one of {', '.join(route_names())}"
        raise InputError(brief(name).strip("'"), "no such road", mend)
    if kind in (".yaml", ".yml"):
        from bitepoint.scenarios.routes.rolling import rolling_road

        return rolling_road(read_yaml(path), str(path))
    from bitepoint.scenarios.routes.terrain import road

    if kind == ".gpx":
        from bitepoint.scenarios.routes.gpx import read_gpx_points

        return road(read_gpx_points(path), smoothing)
    from bitepoint.scenarios.routes.table import read_table_points

    return road(read_table_points(path), smoothing)
