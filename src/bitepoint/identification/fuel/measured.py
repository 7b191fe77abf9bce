"""The engine of a vehicle with the map of its measured points, and what is to be said of it."""

from __future__ import annotations

from dataclasses import dataclass

from bitepoint.identification.fuel.engine_map import EnginePoints, relative_weight, smooth_map, within
from bitepoint.identification.fuel.steady import fit_willans, line_map, map_nodes, with_steady
from bitepoint.records import RecordArray


@dataclass(frozen=True)
class MeasuredMap:
    """A vehicle, shape (1,), whose engine has the map; warnings: sentences."""

    vehicle: RecordArray
    warnings: tuple[str, ...] = ()


def with_points(vehicle: RecordArray, points: EnginePoints, where: str) -> MeasuredMap:
    """Return the vehicle with the map through measured points for the fuel of its engine.

    Raises:
        InputError: too few points within the map.
    """
    nodes = map_nodes(vehicle)
    kept = within(points, *nodes, where)
    coefficients = fit_willans(kept.speed, kept.torque, kept.fuel, relative_weight(kept.fuel))
    fuel, _ = smooth_map(kept, *nodes, line_map(vehicle, coefficients))
    return MeasuredMap(with_steady(vehicle, coefficients, fuel))
