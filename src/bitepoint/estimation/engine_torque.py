"""Observer of the engine's torque, lag and error, from its speed and the clutch torque.

An engine that follows its command with an unknown lag is watched by several observers, each with a lag of its own:

    dT/dt = (command - T) / lag        Je dw/dt = T + b - Tc - ce w

where b, the error of the torque, is what the measured speed asks for. Each corrects speed and error by the share of the
speed that it did not foresee, and keeps the forgetting sum E of the squares of that share. The estimate is the mean of
all, weighted by exp(-(E - least E) / tolerance): a soft choice of the lag that explains the speed best.
"""

from __future__ import annotations

import math

import numpy as np

from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.models.launch import LaunchModel
from bitepoint.records import FloatArray, Record, RecordArray, quantity

CANDIDATES = 4


class EngineObserver(Record):
    """Parameters; `design_engine_observer` makes them."""

    period: float = quantity("s", 1e-4, 1, "time between two steps")
    inertia: float = quantity("kg*m^2", 0.01, 50, "of the engine, with its transient loss")
    friction: float = quantity("N*m*s/rad", 0, 1, "viscous friction of the crankshaft")
    lag: FloatArray = quantity("s", 0, 5, "time constants that are tried", shape=(CANDIDATES,))
    speed_gain: float = quantity("1", 0, 1, "share of the speed error that corrects the speed")
    torque_gain: float = quantity("1", 0, 1, "share that corrects the error of the torque")
    memory: float = quantity("1", 0, 1, "share of the sum of squares that is kept per step")
    tolerance: float = quantity("rad^2/s^2", 1e-9, 1e6, "difference of sums at which a candidate loses its weight")


class EngineObserverState(Record):
    """Memory between two steps, and the estimate."""

    torque: FloatArray = quantity("N*m", -1e5, 1e5, "lagged command by candidate", shape=(CANDIDATES,))
    error: FloatArray = quantity("N*m", -1e9, 1e9, "error of the torque by candidate", shape=(CANDIDATES,))
    speed: FloatArray = quantity("rad/s", -1e9, 1e9, "engine speed by candidate", shape=(CANDIDATES,))
    misfit: FloatArray = quantity("rad^2/s^2", 0, 1e18, "forgetting sum of squares", shape=(CANDIDATES,))
    mean_torque: float = quantity("N*m", -1e5, 1e5, "estimate: lagged command")
    mean_error: float = quantity("N*m", -1e9, 1e9, "estimate: error of the torque, true less lagged command")
    mean_speed: float = quantity("rad/s", -1e9, 1e9, "estimate: engine speed")
    mean_lag: float = quantity("s", 0, 5, "estimate: lag")


@kernel
def engine_observer_reset(s: EngineObserverState, torque: float, speed: float) -> None:
    """Begin in a steady state: at a torque (N m) that holds a speed (rad/s), with all lags alike."""
    for n in range(CANDIDATES):
        s.torque[n] = torque
        s.error[n] = 0.0
        s.speed[n] = speed
        s.misfit[n] = 0.0
    s.mean_torque = torque
    s.mean_error = 0.0
    s.mean_speed = speed
    s.mean_lag = 0.0


@kernel
def engine_observer_mean(p: EngineObserver, s: EngineObserverState) -> None:
    """Write the weighted mean of the candidates."""
    least = s.misfit[0]
    for n in range(1, CANDIDATES):
        least = min(least, s.misfit[n])
    total = 0.0
    s.mean_torque = 0.0
    s.mean_error = 0.0
    s.mean_speed = 0.0
    s.mean_lag = 0.0
    for n in range(CANDIDATES):
        weight = math.exp((least - s.misfit[n]) / p.tolerance)
        total += weight
        s.mean_torque += weight * s.torque[n]
        s.mean_error += weight * s.error[n]
        s.mean_speed += weight * s.speed[n]
        s.mean_lag += weight * p.lag[n]
    s.mean_torque = s.mean_torque / total
    s.mean_error = s.mean_error / total
    s.mean_speed = s.mean_speed / total
    s.mean_lag = s.mean_lag / total


@kernel
def engine_observer_step(
    p: EngineObserver, s: EngineObserverState, command: float, clutch: float, speed: float
) -> None:
    """Take in a step: torque commanded (N m) and clutch torque (N m) since the last one, speed measured now (rad/s).

    What is not finite leaves the state as it is.
    """
    # never: else, in a part that holds back measurements that are no numbers
    if is_finite(command) and is_finite(clutch) and is_finite(speed):
        for n in range(CANDIDATES):
            kept = 0.0
            mean = command
            if p.lag[n] > 0.0:
                kept = math.exp(-p.period / p.lag[n])
                mean = command + (s.torque[n] - command) * (1.0 - kept) * p.lag[n] / p.period
            s.torque[n] = command + (s.torque[n] - command) * kept
            net = mean + s.error[n] - clutch - p.friction * s.speed[n]
            foreseen = s.speed[n] + p.period * net / p.inertia
            surprise = clamp(speed - foreseen, -1000.0, 1000.0)
            s.speed[n] = foreseen + p.speed_gain * surprise
            s.error[n] = clamp(s.error[n] + p.torque_gain * surprise * p.inertia / p.period, -1e4, 1e4)
            s.misfit[n] = p.memory * s.misfit[n] + surprise**2
        engine_observer_mean(p, s)


def design_engine_observer(model: LaunchModel, period: float = 0.01) -> RecordArray:
    """Return the observer for a vehicle, shape (1,). Gains are chosen: errors are found in about 0.2 s."""
    observer = EngineObserver.zeros()
    observer["period"], observer["inertia"], observer["friction"] = period, model.engine_inertia, model.engine_friction
    observer["lag"] = np.array([0.0, 0.05, 0.1, 0.15])
    observer["speed_gain"], observer["torque_gain"] = 0.5, 0.05
    observer["memory"], observer["tolerance"] = 0.98, 1.0
    return observer
