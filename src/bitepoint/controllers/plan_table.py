"""A plan of speed, gear and engine torque over distance, as a controller holds it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bitepoint.errors import InputError
from bitepoint.kernels import clamp, kernel, to_index
from bitepoint.parts.amt import GEARS
from bitepoint.recording import Floats
from bitepoint.records import FloatArray, Record, RecordArray, count, quantity

PLAN_POINTS = 1024
"""Most points of a plan."""


class PlanTable(Record):
    """A plan over distance, its points at a constant spacing from 0 m on.

    Between two points the acceleration is constant, hence the speed squared is linear; gear and torques are those of
    the point before. Beyond the last point the plan stays as it is there.
    """

    points: int = count(0, PLAN_POINTS, "points in use; 0 or 1: no plan", default=0)
    spacing: float = quantity("m", 0.01, 10_000, "distance from point to point", default=1.0)
    speed: FloatArray = quantity("m/s", 0, 100, "speed of the vehicle", shape=(1024,), padded=True, default=0.0)
    gear: FloatArray = quantity("1", 0, GEARS, "gear; 0 none", shape=(1024,), padded=True, default=0.0)
    torque: FloatArray = quantity("N*m", -500, 5000, "engine torque", shape=(1024,), padded=True, default=0.0)
    brake: FloatArray = quantity(
        "N*m", 0, 1e5, "torque of the brake, all wheels together", shape=(1024,), padded=True, default=0.0
    )


@kernel
def plan_row(t: PlanTable, distance: float) -> int:
    """Return the row of the last point that is not beyond a distance (m), the last but one at most."""
    return max(min(to_index(distance / t.spacing, 0, 1022), t.points - 2), 0)


@kernel
def planned_speed(t: PlanTable, distance: float) -> float:
    """Return the speed, m/s, at a distance (m)."""
    k = plan_row(t, distance)
    share = clamp(distance / t.spacing - k, 0.0, 1.0)
    before = t.speed[k] * t.speed[k]
    after = t.speed[k + 1] * t.speed[k + 1]
    return math.sqrt(max(before + share * (after - before), 0.0))


@kernel
def planned_gear(t: PlanTable, distance: float) -> float:
    """Return the gear at a distance (m)."""
    return t.gear[plan_row(t, distance)]


@kernel
def planned_torque(t: PlanTable, distance: float) -> float:
    """Return the engine torque, N m, at a distance (m)."""
    return t.torque[plan_row(t, distance)]


@kernel
def planned_brake(t: PlanTable, distance: float) -> float:
    """Return the torque of the brake, N m, at a distance (m)."""
    return t.brake[plan_row(t, distance)]


def plan_parameters(
    distance: Floats | Sequence[float],
    speed: Floats | Sequence[float],
    gear: Floats | Sequence[float],
    torque: Floats | Sequence[float],
    brake: Floats | Sequence[float] | None = None,
) -> RecordArray:
    """Return a plan as a table, shape (1,): the constant spacing that its points have, or 1023 of equal length.

    Args:
        distance: m, from 0 on, increasing, shape (n,).
        speed: m/s at these points, shape (n,); its square is taken as linear between them.
        gear, torque, brake: gear, engine torque and that of the brake (N m) from each point to the next, shape (n,) or
            (n - 1,); None: the brake is not used.

    Raises:
        InputError: lengths that do not fit, fewer than two points, distances that do not rise from 0, or values outside
            the range of the table.
    """
    s, v, g, t = (np.asarray(each, np.float64) for each in (distance, speed, gear, torque))
    b = np.zeros(s.shape) if brake is None else np.asarray(brake, np.float64)
    fits = s.ndim == 1 and s.shape == v.shape and {g.shape, t.shape, b.shape} <= {s.shape, (s.size - 1,)}
    if not fits or s.size < 2 or s[0] != 0.0 or not (np.diff(s) > 0.0).all():
        mend = "expected as many distances, two at least, rising from 0 m, as speeds, gears and torques"
        raise InputError("plan", f"got {s.size} distances, {v.size} speeds, {g.size} gears, {t.size} torques", mend)
    spacing = float(s[-1]) / (s.size - 1)
    at: Floats = s
    if s.size > PLAN_POINTS or np.abs(np.diff(s) - spacing).max() > 1e-6 * spacing:
        spacing = float(s[-1]) / (PLAN_POINTS - 1)
        at = np.linspace(0.0, float(s[-1]), PLAN_POINTS)
    held = np.searchsorted(s, at + 1e-6 * spacing, side="right") - 1
    row = np.minimum(np.maximum(held, 0), min(g.size, t.size, b.size) - 1)
    columns = {"speed": np.sqrt(np.interp(at, s, v**2)), "gear": g[row], "torque": t[row], "brake": b[row]}
    table = PlanTable.zeros()
    table["points"], table["spacing"] = at.size, spacing
    for name, values in columns.items():
        field = PlanTable.fields[name]
        if not ((values >= field.low) & (values <= field.high)).all():
            raise InputError("plan", f"{name}: got {values.min():g} to {values.max():g}", field.expected())
        table[name][0, : at.size] = values
    return table
