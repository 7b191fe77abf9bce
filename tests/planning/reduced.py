"""The same launch, planned by other means: a clutch torque of few parameters, and for each a linear programme.

Given the clutch torque over time, the vehicle's motion is known, and what is left, to run the engine so that the clutch
is heated least, is linear: min sum of Tc we, over engine speed and engine torque on a raster, by HiGHS.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog
from scipy.sparse import csr_array, eye_array, hstack, vstack

from bitepoint.models.launch_vehicle import LaunchVehicle

Floats = npt.NDArray[np.float64]
STEP = 0.01
"""Of the raster, s."""

KNEE = 160.0
"""Speed up to which the full load of the car rises steeply, rad/s."""


def clutch_profiles(vehicle: LaunchVehicle, time: float, end_speed: float, jerk: float) -> Iterator[Floats]:
    """Yield clutch torques over a raster: jerk up, none, down, none, so that `end_speed` is reached on a flat road."""
    model = vehicle.model
    held = vehicle.release_torque / model.torque_rate_limit
    moving = time - held
    raster = held + np.linspace(0.0, moving, round(moving / STEP) + 1)
    for up, down in product(np.linspace(0.05, 0.7, 27) * moving, np.linspace(0.0, 0.6, 25) * moving):
        peak, low = jerk * up, jerk * (up - down)
        rest = moving - up - down
        if low < 0.0 or rest < 0.0:
            continue
        covered = 0.5 * peak * up + 0.5 * (peak + low) * down
        first = (end_speed - covered - low * rest) / (peak - low) if down else 0.0
        if not -1e-9 <= first <= rest or (not down and abs(covered + low * rest - end_speed) > 0.02 * end_speed):
            continue
        corners = held + np.cumsum([0.0, up, first, down, rest - first])
        acceleration = np.interp(raster, corners, [0.0, peak, peak, low, low])
        yield vehicle.release_torque + acceleration / model.metres_per_radian * model.inertia / model.efficiency


def engine_limits(vehicle: LaunchVehicle, end: float) -> list[tuple[float, float]]:
    """Return offset and slope of two lines, the lower of which is below the highest torque from idle to `end` (rad/s).

    One rises from idle to the knee of the full load, one is flat from there on: less than the engine can.
    """
    at = np.linspace(vehicle.idle_speed, max(end, KNEE), 400)
    highest = np.interp(at, vehicle.engine_speeds, vehicle.highest_torque)
    rising = (at > at[0]) & (at <= KNEE)
    slope = float(((highest - highest[0])[rising] / (at - at[0])[rising]).min())
    return [(float(highest[0] - slope * at[0]), slope), (float(highest[at >= KNEE - 1.0].min()), 0.0)]


def least_work(vehicle: LaunchVehicle, clutch: Floats, time: float, torque_rate: float) -> float | None:
    """Return the least friction work, J, of a launch of that time (s) with this clutch torque (N m), or None.

    `clutch` is given over the moving phase, at equal steps; held, it rises at its fastest, at idle.
    """
    model, n = vehicle.model, len(clutch)
    held = vehicle.release_torque / model.torque_rate_limit
    h = (time - held) / (n - 1)
    load = (vehicle.rolling_torque + vehicle.grade_torque) / model.ratio
    acceleration = (model.efficiency * clutch - load) / model.inertia
    speed = np.concatenate(([0.0], np.cumsum(h * 0.5 * (acceleration[1:] + acceleration[:-1]))))
    one, none = eye_array(n, format="csr"), csr_array((n - 1, n))
    mean, change = one[1:] * 0.5 + one[:-1] * 0.5, one[1:] - one[:-1]
    lines = engine_limits(vehicle, 1.3 * float(speed[-1]))
    ends = csr_array(([1.0, 1.0, 1.0, -model.engine_friction], ([0, 1, 2, 2], [0, n - 1, 2 * n - 1, n - 1])))
    final = clutch[-1] + model.engine_inertia * acceleration[-1]
    weight = np.full(n, h)
    weight[[0, -1]] = h / 2
    found = linprog(
        np.concatenate((weight * clutch, np.zeros(n))),
        A_ub=vstack([hstack([none, change]), hstack([none, -change]), *(hstack([-k * one, one]) for _, k in lines)]),
        b_ub=np.concatenate((np.full(2 * (n - 1), torque_rate * h), np.repeat([offset for offset, _ in lines], n))),
        A_eq=vstack([hstack([model.engine_inertia / h * change + model.engine_friction * mean, -mean]), ends]),
        b_eq=np.concatenate((-(mean @ clutch), [vehicle.idle_speed, speed[-1], final])),
        bounds=[(max(vehicle.idle_speed, w), None) for w in speed] + [(min(vehicle.lowest_torque), None)] * n,
        method="highs",
    )  # fmt: skip
    rise = 0.5 * vehicle.release_torque * held * vehicle.idle_speed
    return float(found.fun - (weight * clutch * speed).sum()) + rise if found.success else None
