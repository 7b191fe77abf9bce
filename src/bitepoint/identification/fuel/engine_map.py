"""The steady map of an engine through measured points, wherever in speed and torque these lie.

    least  sum ((map(w, T) - fuel) / (fuel + mean fuel / 10))^2 + smoothing * sum (curvature of map - Willans line)^2
    with   map >= 0, and never falling over torque

The map is bilinear between nodes of even spacing, so what is bent between points is bent as the Willans line is, and
where there are no points the map goes on as it. The smoothing is chosen by leaving out points.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.fuel.regression import positive_least_squares
from bitepoint.identification.readers.table import column_floats, metadata_unit, read_table
from bitepoint.identification.units import conversion, header_unit
from bitepoint.recording import Channel, Floats
from bitepoint.units import UnitError

COLUMNS = {
    Channel("engine_speed", "rad/s"): ("engine_speed", "speed"),
    Channel("engine_torque", "N*m"): ("engine_torque", "torque"),
    Channel("fuel_flow", "kg/s"): ("fuel_flow", "fuel", "fuel_rate"),
}
"""What a file of points holds, and the names that are understood."""

LEAST_POINTS = 12
"""Points that a map takes at least, and in at least 3 places of speed and of torque each."""

SMOOTHINGS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
"""Weights of the curvature that are tried."""

FOLDS = 5

RIDGE = 1e-9
"""Weight of the distance from the Willans line itself, where neither points nor curvature tell."""


@dataclass(frozen=True)
class EnginePoints:
    """Measured points of steady fuel: rad/s, N m and kg/s, shape (n,) each."""

    speed: Floats
    torque: Floats
    fuel: Floats


def read_points(path: str | Path) -> EnginePoints:
    """Return the points of a table, CSV or Parquet, with the columns engine_speed, engine_torque and fuel_flow.

    Raises:
        InputError: it cannot be read, a column is missing or twice there, a unit does not fit, or values cannot be.
    """
    where, table = str(path), read_table(Path(path))
    columns = [_column(table, channel, names, where) for channel, names in COLUMNS.items()]
    speed, torque, fuel = (each[np.isfinite(columns).all(axis=0)] for each in columns)
    for name, values, low, high, unit in (
        ("engine_speed", speed, 10.0, 1500.0, "rad/s"), ("engine_torque", torque, -1000.0, 5000.0, "N m"),
        ("fuel_flow", fuel, 0.0, 0.1, "kg/s"),
    ):  # fmt: skip
        wrong = values[(values < low) | (values > high)]
        if wrong.size:
            mend = f"expected {low:g}..{high:g} {unit}; a unit may stand in the header, as speed_rpm or fuel_g_per_s"
            raise InputError(where, f"{name}: {wrong[0]:g} {unit}", mend)
    return EnginePoints(speed, torque, fuel)


def _column(table: Any, channel: Channel, names: tuple[str, ...], where: str) -> Floats:
    found = [name for name in table.column_names if header_unit(name, names) is not None]
    if len(found) != 1:
        mend = f"expected one named {' or '.join(names)}, its unit behind it as in speed_rpm; it has " + ", ".join(
            table.column_names[:8]
        )
        raise InputError(where, f"{len(found) or 'no'} columns of {channel.name}", mend)
    try:
        unit = metadata_unit(table, found[0]) or header_unit(found[0], names) or channel.unit
        scale, offset = conversion(unit, channel.unit)
    except UnitError as error:
        raise InputError(where, f"{found[0]}: {error}", f"expected a unit such as {channel.unit}") from None
    return column_floats(table, found[0], where) * scale + offset


def within(points: EnginePoints, speeds: Floats, torques: Floats, where: str) -> EnginePoints:
    """Return the points that lie between the nodes of a map.

    Raises:
        InputError: too few of them, or all at one or two speeds or torques.
    """
    inside = (points.speed >= speeds[0]) & (points.speed <= speeds[-1])
    inside &= (points.torque >= torques[0]) & (points.torque <= torques[-1])
    kept = EnginePoints(points.speed[inside], points.torque[inside], points.fuel[inside])
    apart = [np.unique((each * 50.0 / top).round()).size for each, top in
             ((kept.speed, speeds[-1]), (kept.torque, torques[-1]))]  # fmt: skip
    if kept.speed.size < LEAST_POINTS or min(apart, default=0) < 3:
        mend = f"expected {LEAST_POINTS} at 3 speeds and 3 torques at least"
        raise InputError(
            where,
            f"{kept.speed.size} points within {speeds[0]:.0f}..{speeds[-1]:.0f} rad/s and 0..{torques[-1]:.0f} N m",
            mend,
        )
    return kept


def smooth_map(points: EnginePoints, speeds: Floats, torques: Floats, base: Floats) -> Floats:
    """Return the fuel at the nodes, kg/s, shape (speeds, torques).

    Args:
        points: within the nodes, see `within`; speeds, torques: of the nodes, rad/s and N m, evenly spaced.
        base: fuel of the Willans line at the nodes, kg/s, likewise.
    """
    weight = 1.0 / (points.fuel + 0.1 * points.fuel.mean())
    rows = _bilinear(points, speeds, torques) * weight[:, np.newaxis]
    wanted, flat, unit = points.fuel * weight, base.ravel(), float(points.fuel.mean())
    bent = _curvature(len(speeds), len(torques)) / unit
    bending = bent.T @ bent
    fold = np.arange(len(wanted)) % FOLDS

    def normal(kept: Any, smoothing: float) -> tuple[Floats, Floats]:
        """Return matrix and right-hand side of the least squares without bounds."""
        held = np.count_nonzero(kept) * (smoothing * bending + RIDGE / unit**2 * np.eye(flat.size))
        return rows[kept].T @ rows[kept] + held, rows[kept].T @ wanted[kept] + held @ flat

    def missed(smoothing: float) -> float:
        """Return the squared errors of points that were left out."""
        return sum(
            float(np.sum((rows[fold == k] @ np.linalg.solve(*normal(fold != k, smoothing)) - wanted[fold == k]) ** 2))
            for k in range(FOLDS)
        )

    matrix, right = normal(fold >= 0, min(SMOOTHINGS, key=missed))
    factor: Floats = np.asarray(np.linalg.cholesky(matrix).T, np.float64)
    rising = np.kron(np.eye(len(speeds)), np.tril(np.ones((len(torques), len(torques)))))  # sums over torque
    steps = positive_least_squares(factor @ rising, np.asarray(np.linalg.solve(factor.T, right), np.float64))
    return (rising @ steps).reshape(base.shape)


def _bilinear(points: EnginePoints, speeds: Floats, torques: Floats) -> Floats:
    """Return the shares of the nodes in each point, shape (n, nodes)."""
    shares = np.ones((len(points.speed), len(speeds), len(torques)))
    for nodes, values, axis in ((speeds, points.speed, 1), (torques, points.torque, 2)):
        place = (values - nodes[0]) / (nodes[1] - nodes[0])
        share = np.maximum(1.0 - np.abs(place[:, np.newaxis] - np.arange(len(nodes))), 0.0)
        shares *= np.expand_dims(share, 3 - axis)
    return shares.reshape(len(points.speed), -1)


def _curvature(speeds: int, torques: int) -> Floats:
    """Return the second differences of a map over speed, over torque, and mixed, shape (differences, nodes)."""
    one, other = np.eye(speeds), np.eye(torques)
    second = (np.diff(one, 2, axis=0), np.diff(other, 2, axis=0))
    mixed = np.kron(np.diff(one, axis=0), np.diff(other, axis=0))
    parts = (np.kron(second[0], other), np.kron(one, second[1]), np.sqrt(2.0) * mixed)
    return np.concatenate(parts).astype(np.float64)
