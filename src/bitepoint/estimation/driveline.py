"""Kalman observer of a hybrid's driveline: twists, torques and load from three noisy speeds.

    predict   x(k|k-1) = A x(k-1|k-1) + B [r1, r2](k-1)        correct   x(k|k) = x(k|k-1) + L (z - C x(k|k-1))

x is the state of `models.driveline`, z the speeds of engine, motor and wheels. The load is a random walk, so that a
grade, air and a wrong mass leave no lasting error of the twists. L is the steady gain, designed once.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from bitepoint.kernels import kernel
from bitepoint.models.driveline import (
    ENGINE_SPEED,
    MOTOR_SPEED,
    WHEEL_SPEED,
    DrivelineModel,
)
from bitepoint.numerics.unrolling import unrolled
from bitepoint.records import FloatArray, Record, RecordArray, quantity

STATES = 8
TWISTING = 5
"""Of the states, the first are speeds and twists."""

MOST = 1e9

PROCESS_NOISE = np.array([0.5, 0.01, 0.5, 0.01, 0.1, 5.0, 2.0, 20.0])
"""What the model does not know of its states, per square root of a second, each in its unit (chosen)."""


class DrivelineObserver(Record):
    """Parameters; `design_driveline_observer` makes them."""

    transition: FloatArray = quantity("1", -MOST, MOST, "A", shape=(STATES, STATES))
    effect: FloatArray = quantity("1", -MOST, MOST, "B", shape=(STATES, 2))
    gain: FloatArray = quantity("1", -MOST, MOST, "L", shape=(STATES, 3))


class DrivelineEstimate(Record):
    """The state of the driveline, as `models.driveline.STATES` names it, in SI."""

    x: FloatArray = quantity("1", -1e12, 1e12, "the state", shape=(STATES,))


@kernel
def _predict(
    p: DrivelineObserver, s: DrivelineEstimate, w: DrivelineEstimate, engine_request: float, motor_request: float
) -> None:
    """Move the estimate on by one period in which these torques, N m, were asked for; `w` is scratch.

    Speeds and twists follow from everything; each torque follows its request alone, and the load stays as it is.
    """
    for i in range(TWISTING):
        total = p.effect[i, 0] * engine_request + p.effect[i, 1] * motor_request
        for j in range(STATES):
            total += p.transition[i, j] * s.x[j]
        w.x[i] = total
    for i in range(TWISTING):
        s.x[i] = w.x[i]
    s.x[5] = p.effect[5, 0] * engine_request + p.transition[5, 5] * s.x[5]
    s.x[6] = p.effect[6, 1] * motor_request + p.transition[6, 6] * s.x[6]


driveline_predict = unrolled(_predict, "driveline_predict", {}, {"STATES": STATES})


@kernel
def driveline_correct(
    p: DrivelineObserver, s: DrivelineEstimate, engine_speed: float, motor_speed: float, wheel_speed: float
) -> None:
    """Correct the estimate by the speeds that are measured now, rad/s."""
    engine = engine_speed - s.x[0]
    motor = motor_speed - s.x[2]
    wheel = wheel_speed - s.x[4]
    for i in range(STATES):
        s.x[i] += p.gain[i, 0] * engine + p.gain[i, 1] * motor + p.gain[i, 2] * wheel


def design_driveline_observer(
    model: DrivelineModel, period: float, noise: tuple[float, float, float], *, euler: bool = False
) -> RecordArray:
    """Return the observer of a model, shape (1,).

    Args:
        period: s.
        noise: standard deviations of the measured speeds of engine, motor and wheels, rad/s, each above 0.
        euler: predict by forward Euler; the gain is that of the exact model.
    """
    from scipy.linalg import solve_discrete_are  # pyright: ignore[reportUnknownVariableType]

    a = model.difference(period)[0]
    c = np.eye(STATES)[[ENGINE_SPEED, MOTOR_SPEED, WHEEL_SPEED]]
    uncertainty, variance = np.diag(PROCESS_NOISE**2 * period), np.diag(np.square(noise))
    covariance = cast("Any", solve_discrete_are)(a.T, c.T, uncertainty, variance)
    observer = DrivelineObserver.zeros()
    observer["gain"] = covariance @ c.T @ np.linalg.inv(c @ covariance @ c.T + variance)
    observer["transition"], observer["effect"] = model.difference(period, euler=euler)
    return observer
