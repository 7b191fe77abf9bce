"""The steady map of an engine through measured points, wherever in speed and torque these lie.

    least  sum ((map(w, T) - fuel) / (fuel + mean fuel / 10))^2
           + n / (mean fuel)^2 * (smoothing * sum d2^2 + RIDGE * sum (1 + distance)^4 d^2)      d = map - Willans line
    with   map >= 0, and never falling over torque

d2: second differences of d between nodes; distance: of a node from the nearest of the n points, in nodes. The map is
bilinear between nodes of even spacing, so what is bent between points is bent as the Willans line is. Just beyond the
points d goes on straight, farther off it fades, and the map becomes the line. The smoothing is chosen by leaving out
strips of speed, then strips of torque, a node wide each: whole rows of a grid, its edges among them.
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
"""Of the strips that are left out each fifth is so at once."""

RIDGE = 3e-9
"""Weight of the departure from the Willans line itself, at a point (chosen: edges of published maps, left out)."""


@dataclass(frozen=True)
class EnginePoints:
    """Measured points of steady fuel: rad/s, N m and kg/s, shape (n,) each."""

    speed: Floats
    torque: Floats
    fuel: Floats

    def rows(self, kept: Any) -> EnginePoints:
        """Return those that are kept, a mask."""
        return EnginePoints(self.speed[kept], self.torque[kept], self.fuel[kept])


def read_points(path: str | Path, density: float | None = None) -> EnginePoints:
    """Return the points of a table, CSV or Parquet, with the columns engine_speed, engine_torque and fuel_flow.

    Args:
        path: of the table; density: of the fuel, kg/m^3, for a flow of volume.

    Raises:
        InputError: it cannot be read, a column is missing or twice there, a unit does not fit, values cannot be, or a
            flow is one of volume and there is no density.
    """
    where, table = str(path), read_table(Path(path))
    columns = [_column(table, channel, names, where, density) for channel, names in COLUMNS.items()]
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


def _column(table: Any, channel: Channel, names: tuple[str, ...], where: str, density: float | None) -> Floats:
    found = [name for name in table.column_names if header_unit(name, names) is not None]
    if len(found) != 1:
        mend = f"expected one named {' or '.join(names)}, its unit behind it as in speed_rpm or fuel_g_per_s; it has "
        mend += ", ".join(table.column_names[:8])
        raise InputError(where, f"{len(found) or 'no'} columns of {channel.name}", mend)
    unit = metadata_unit(table, found[0]) or header_unit(found[0], names) or channel.unit
    try:
        scale, offset = conversion(unit, channel.unit)
    except UnitError as error:
        per_volume = _volume(unit) if channel.name == "fuel_flow" else None
        if per_volume is None:
            raise InputError(where, f"{found[0]}: {error}", f"expected a unit such as {channel.unit}") from None
        if density is None:
            mend = "add --density, such as '0.835 g/mL' for diesel fuel or '0.743 g/mL' for petrol"
            raise InputError(where, f"{found[0]}: a flow of volume, {unit}, and no density", mend) from None
        scale, offset = per_volume * density, 0.0
    return column_floats(table, found[0], where) * scale + offset


def _volume(unit: str) -> float | None:
    """Return the m^3/s of a unit; None where it is none of a flow of volume."""
    try:
        return conversion(unit, "m^3/s")[0]
    except UnitError:
        return None


def within(
    points: EnginePoints, speeds: Floats, torques: Floats, where: str, most: Floats | None = None
) -> EnginePoints:
    """Return the points that lie between the nodes of a map; most: torque up to which each may, N m, shape (n,).

    Raises:
        InputError: too few of them, all at one or two speeds or torques, or none that takes fuel.
    """
    inside = (points.speed >= speeds[0]) & (points.speed <= speeds[-1])
    inside &= (points.torque >= torques[0]) & (points.torque <= torques[-1])
    if most is not None:
        inside &= points.torque <= most
    kept = points.rows(inside)
    apart = [np.unique((each * 50.0 / top).round()).size for each, top in
             ((kept.speed, speeds[-1]), (kept.torque, torques[-1]))]  # fmt: skip
    if kept.speed.size < LEAST_POINTS or min(apart, default=0) < 3:
        mend = f"expected {LEAST_POINTS} at 3 speeds and 3 torques at least"
        span = f"{speeds[0]:.0f}..{speeds[-1]:.0f} rad/s, 0..{torques[-1]:.0f} N m"
        full = "" if most is None else " and full load"
        raise InputError(where, f"{kept.speed.size} of {points.speed.size} points within {span}{full}", mend)
    if not kept.fuel.any():
        raise InputError(where, f"fuel_flow is zero at all {kept.fuel.size} points", "expected a measured fuel flow")
    return kept


def relative_weight(fuel: Floats) -> Floats:
    """Return by what errors are multiplied, s/kg, shape (n,), so that small flows count as large ones do."""
    return 1.0 / (fuel + 0.1 * fuel.mean())


def smooth_map(points: EnginePoints, speeds: Floats, torques: Floats, base: Floats) -> tuple[Floats, float]:
    """Return the fuel at the nodes, kg/s, shape (speeds, torques), and the smoothing that was chosen.

    Args:
        points: within the nodes, see `within`; speeds, torques: of the nodes, rad/s and N m, evenly spaced.
        base: fuel of the Willans line at the nodes, kg/s, likewise.
    """
    weight, unit = relative_weight(points.fuel), float(points.fuel.mean())
    rows = _bilinear(points, speeds, torques) * weight[:, np.newaxis]
    left = points.fuel * weight - rows @ base.ravel()
    nodes = tuple(each.ravel() for each in np.meshgrid(speeds, torques, indexing="ij"))
    bent = _curvature(len(speeds), len(torques)) / unit
    bending = bent.T @ bent

    def normal(kept: Any) -> tuple[Floats, Floats, Floats]:
        """Return matrix without smoothing, what smoothing adds, and right-hand side, for the departure."""
        count = np.count_nonzero(kept)
        pull = RIDGE * (1.0 + distances(points.rows(kept), speeds, torques, *nodes)) ** 4
        matrix = rows[kept].T @ rows[kept] + count / unit**2 * np.diag(pull)
        return matrix, count * bending, rows[kept].T @ left[kept]

    missed = np.zeros(len(SMOOTHINGS))
    for out in _strips(points, speeds, torques):
        matrix, more, right = normal(~out)
        for k, smoothing in enumerate(SMOOTHINGS):
            missed[k] += np.sum((rows[out] @ np.linalg.solve(matrix + smoothing * more, right) - left[out]) ** 2)
    smoothing = SMOOTHINGS[int(np.argmin(missed))]

    matrix, more, right = normal(np.ones(len(left), bool))
    matrix = matrix + smoothing * more
    factor: Floats = np.asarray(np.linalg.cholesky(matrix).T, np.float64)
    rising = np.kron(np.eye(len(speeds)), np.tril(np.ones((len(torques), len(torques)))))  # sums over torque
    target = np.linalg.solve(factor.T, right + matrix @ base.ravel())
    steps = positive_least_squares(factor @ rising, np.asarray(target, np.float64))
    return (rising @ steps).reshape(base.shape), smoothing


def distances(points: EnginePoints, speeds: Floats, torques: Floats, at_speed: Floats, at_torque: Floats) -> Floats:
    """Return how far the nearest point is from each place, in nodes, shape (m,).

    Args:
        speeds, torques: of the nodes, rad/s and N m, evenly spaced; at_speed, at_torque: of the places, shape (m,).
    """
    across = np.subtract.outer(at_speed, points.speed) / (speeds[1] - speeds[0])
    along = np.subtract.outer(at_torque, points.torque) / (torques[1] - torques[0])
    return np.sqrt((across**2 + along**2).min(axis=1))


def _strips(points: EnginePoints, speeds: Floats, torques: Floats) -> list[Any]:
    """Return which points are left out at once: every fifth strip of speed, then of torque; some are always kept."""
    folds: list[Any] = []
    for nodes, values in ((speeds, points.speed), (torques, points.torque)):
        strip = np.rint((values - nodes[0]) / (nodes[1] - nodes[0])).astype(int) % FOLDS
        folds += [strip == k for k in range(FOLDS)]
    return [out for out in folds if out.any() and not out.all()]


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
