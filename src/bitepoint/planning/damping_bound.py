"""The physical optimum of damping: how little a driveline can swing when the engine's torque steps.

    minimise the largest |y| over the motor's torque u      |u| <= limit,  |du/dt| <= rate limit,  u = 0 at the end

The engine follows the step by its own lag; the motor knows of it when it happens and not before, obeys by its lag, and
must have let go after a while, so that no torque of it is left. On the linear driveline model this is a linear
programme.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.driveline import (
    CLUTCH_TWIST,
    ENGINE_TORQUE,
    HALFSHAFT_TWIST,
    DrivelineModel,
)
from bitepoint.recording import Floats

PERIOD = 0.01
"""Time for which the torque of the motor is held, s; 2 ms instead change the least peak by less than 1 %."""

SUBSTEPS = 4
"""Points per period in which the torsional speed counts."""

CHANGE_COST = 1e-6
"""Peak that a change of the torque by 1 N m is worth, rad/s: it costs less than 0.1 % of the peak."""

HELD, SEEN = 0.8, 1.6
"""Time after which the motor has let go, and over which the torsional speed counts, s."""


@dataclass(frozen=True)
class DampingBound:
    """An optimal tip-in or tip-out.

    Attributes:
        peak: least possible largest torsional speed, rad/s; undamped: the same with no torque of the motor.
        time: s, shape (points,), from the step on; torsional_speed: rad/s over it.
        motor_torque: commanded torque of the motor by period, N m.
    """

    peak: float
    undamped: float
    time: Floats
    torsional_speed: Floats
    motor_torque: Floats

    @property
    def motor_time(self) -> Floats:
        """Time from which on each torque of the motor is commanded, s."""
        return np.asarray(PERIOD * np.arange(len(self.motor_torque)), np.float64)

    @property
    def reduction(self) -> float:
        """Share of the undamped peak that can be taken away."""
        return 1.0 - self.peak / self.undamped


def least_torsional_speed(
    model: DrivelineModel,
    before: float,
    after: float,
    torque_limit: float,
    torque_rate_limit: float,
    *,
    delay: float = 0.0,
) -> DampingBound:
    """Return the optimum for an engine that is asked for `before` and, from now on, for `after` (N m).

    Args:
        torque_limit: of the motor, N m; torque_rate_limit: N m/s.
        delay: dead time of the motor, s, rounded to periods.

    Raises:
        InputError: no step, or limits that are negative.
    """
    if before == after or torque_limit < 0.0 or torque_rate_limit < 0.0:
        raise InputError(
            "bounds", f"a step from {before:g} to {after:g} N m", "expected a step, and limits of 0 or more"
        )
    free, response = _responses(model, before, after, round(delay / PERIOD))
    torque = _least_peak(free, response, torque_limit, torque_rate_limit * PERIOD)
    speed = free + response @ torque
    time = (np.arange(len(free)) + 1.0) * PERIOD / SUBSTEPS
    return DampingBound(float(np.abs(speed).max()), float(np.abs(free).max()), time, speed, torque)


def _responses(model: DrivelineModel, before: float, after: float, late: int) -> tuple[Floats, Floats]:
    """Return the torsional speed with no motor, (points,), and per torque of the motor by period, (points, periods)."""
    a, b = model.difference(PERIOD / SUBSTEPS)
    points, periods = round(SEEN / PERIOD) * SUBSTEPS, round(HELD / PERIOD)
    free, impulse = np.empty(points), np.empty(points)
    x, one = _steady(model, before), np.zeros(len(a))
    for k in range(points):
        x = a @ x + b[:, 0] * after
        one = a @ one + b[:, 1] * (k < SUBSTEPS)
        free[k], impulse[k] = model.output @ x, model.output @ one
    response = np.zeros((points, periods))
    for j in range(periods):
        start = (j + late) * SUBSTEPS
        response[start:, j] = impulse[: points - start]
    return free, response


def _steady(model: DrivelineModel, torque: float) -> Floats:
    """Return the state of a driveline that accelerates steadily under a torque of the engine, without load."""
    inertia = model.vehicle_inertia + (model.engine_inertia + model.motor_inertia) * model.ratio**2
    acceleration = torque * model.ratio / inertia  # of the wheels, rad/s^2
    x = np.zeros(8)
    x[ENGINE_TORQUE] = torque
    x[CLUTCH_TWIST] = (torque - model.engine_inertia * acceleration * model.ratio) / model.clutch_stiffness
    x[HALFSHAFT_TWIST] = model.vehicle_inertia * acceleration / model.halfshaft_stiffness
    return x


def _least_peak(free: Floats, response: Floats, limit: float, change: float) -> Floats:
    """Return the torque by period: of all that have the least peak, one that changes little."""
    from scipy.optimize import linprog  # pyright: ignore[reportUnknownVariableType]

    points, periods = response.shape
    changes = np.eye(periods + 1, periods) - np.eye(periods + 1, periods, k=-1)
    peak, sizes = np.ones((points, 1)), np.eye(periods + 1)  # variables: torques, the peak, sizes of the changes
    none, nothing = np.zeros((points, periods + 1)), np.zeros((periods + 1, 1))
    rows = np.block(
        [[response, -peak, none], [-response, -peak, none], [changes, nothing, -sizes], [-changes, nothing, -sizes]]
    )
    limits = np.concatenate([-free, free, np.zeros(2 * (periods + 1))])
    bounds = [(-limit, limit)] * periods + [(0.0, None)] + [(0.0, change)] * (periods + 1)
    cost = np.concatenate([np.zeros(periods), [1.0], np.full(periods + 1, CHANGE_COST)])
    found = cast("Any", linprog)(cost, A_ub=rows, b_ub=limits, bounds=bounds, method="highs")
    torque: Floats = found.x[:periods]  # never infeasible: no torque at all keeps every limit
    return torque
