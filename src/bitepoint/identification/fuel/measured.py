"""The engine of a vehicle with the map of its measured points, and what is to be said of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bitepoint.identification.fuel.engine_map import EnginePoints, relative_weight, smooth_map, within
from bitepoint.identification.fuel.steady import fit_willans, line_map, map_nodes, with_steady
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

ABOVE = 1.1
"""Points at more than this times full load are none that the engine runs at: tables go on above it."""


@dataclass(frozen=True)
class MeasuredMap:
    """A vehicle, shape (1,), whose engine has the map; warnings: sentences."""

    vehicle: RecordArray
    warnings: tuple[str, ...] = ()


def with_points(vehicle: RecordArray, points: EnginePoints, where: str) -> MeasuredMap:
    """Return the vehicle with the map through measured points for the fuel of its engine.

    Raises:
        InputError: too few points within the map and full load, or none that takes fuel.
    """
    nodes, most = map_nodes(vehicle), ABOVE * _full_load(vehicle, points.speed)
    kept = within(points, *nodes, where, most)
    coefficients = fit_willans(kept.speed, kept.torque, kept.fuel, relative_weight(kept.fuel))
    fuel, _ = smooth_map(kept, *nodes, line_map(vehicle, coefficients))
    found = with_steady(vehicle, coefficients, fuel)
    said = _on_dropped(points, kept, most, nodes[0])
    return MeasuredMap(found, tuple(f"{Path(where).name}: {each}" for each in said))


def _full_load(vehicle: RecordArray, speed: Floats) -> Floats:
    """Return the torque of full load at engine speeds, rad/s, in N m, shape (n,)."""
    curve = vehicle["engine"]["full_load"][0]
    return np.asarray(np.interp(speed, curve["x"], curve["y"]), np.float64)


def _on_dropped(points: EnginePoints, kept: EnginePoints, most: Floats, speeds: Floats) -> list[str]:
    """Return how many points do not count, and why; most: torque that the engine has, N m; speeds: of the nodes."""
    dropped, low, high = points.speed.size - kept.speed.size, speeds[0], speeds[-1]
    if not dropped:
        return []
    above = int(np.count_nonzero((points.torque > most) & (points.speed >= low) & (points.speed <= high)))
    full = f"{above} at more than {ABOVE:g} times full load"
    beyond = f"{dropped - above} beyond {low:.0f}..{high:.0f} rad/s or below 0 N m"
    return [f"{dropped} of {points.speed.size} points are left out: {full}, {beyond}"]
