"""The engine of a vehicle with the map of its measured points, and what is to be said of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bitepoint.identification.fuel.engine_map import (
    SMOOTHINGS,
    EnginePoints,
    distances,
    relative_weight,
    smooth_map,
    within,
)
from bitepoint.identification.fuel.steady import fit_willans, line_map, map_nodes, with_steady
from bitepoint.numerics.tables import lookup_map
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

ABOVE = 1.1
"""Points at more than this times full load are none that the engine runs at: tables go on above it."""

FAR = 2.0
"""Nodes from the nearest point to idle, above which a warning tells: there the map is on its way to the line."""


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
    fuel, smoothing = smooth_map(kept, *nodes, line_map(vehicle, coefficients))
    found = with_steady(vehicle, coefficients, fuel)
    said = [*_on_dropped(points, kept, most, nodes[0]), *_on_smoothing(smoothing), *_on_idle(found, kept)]
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


def _on_smoothing(smoothing: float) -> list[str]:
    """Return what is to be said where the smoothing is the least or the most that is tried."""
    if smoothing == SMOOTHINGS[0]:
        return [f"the least smoothing that is tried was chosen, {smoothing:g}: noise of the points may be in the map"]
    if smoothing == SMOOTHINGS[-1]:
        return [f"the most smoothing that is tried was chosen, {smoothing:g}: the map is hardly bent by its points"]
    return []


def _on_idle(vehicle: RecordArray, points: EnginePoints) -> list[str]:
    """Return what is to be said where the points are far from idle speed at no torque."""
    idle, none = vehicle["engine"]["idle_speed"], np.zeros(1)
    away = float(distances(points, *map_nodes(vehicle), idle, none)[0])
    if away <= FAR:
        return []
    fuel = 1e3 * float(lookup_map.run(vehicle["engine"]["fuel"], idle, none)[0])
    turning, least = float(idle[0]) * 30.0 / np.pi, float(points.torque.min())
    return [
        f"idle, {turning:.0f} r/min and 0 N m, is {away:.1f} nodes off the nearest point, the least torque of any is "
        f"{least:.0f} N m: fuel there, {fuel:.2f} g/s, is a guess; a measured point at idle would tell"
    ]
