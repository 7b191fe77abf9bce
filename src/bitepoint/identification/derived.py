"""Signals that a production car does not measure, made from those that it does.

Engine torque comes from the engine model, load torque from the motion of the wheels. What a model is worth that was
identified on them is a matter of experiment; see the documentation.
"""

from __future__ import annotations

import math

import numpy as np

from bitepoint.models.launch import LaunchModel
from bitepoint.parts.engine import engine_torque, throttle_effect
from bitepoint.recording import Floats, Recording
from bitepoint.records import RecordArray


def with_channel(recording: Recording, name: str, values: Floats) -> Recording:
    """Return a recording with one channel exchanged.

    Raises:
        KeyError: there is no such channel.
    """
    names = [channel.name for channel in recording.channels]
    if name not in names:
        raise KeyError(f"no channel {name}; there are {', '.join(names)}")
    data = recording.data.copy()
    data[names.index(name)] = values
    return Recording(recording.time, recording.channels, data, recording.about)


def map_torque(recording: Recording, engine: RecordArray, throttle: float | Floats) -> Floats:
    """Return the steady torque of the engine model, N m, at the logged engine speed and a throttle of 0..1.

    It lacks the transient loss, which then counts as inertia.
    """
    speed = np.ascontiguousarray(recording["engine_speed"])
    engines = np.repeat(engine, len(speed))
    effect = throttle_effect.run(engines, np.broadcast_to(throttle, speed.shape).astype(float))
    return engine_torque.run(engines, effect, speed)


def observed_load(recording: Recording, model: LaunchModel, period: float, time_constant: float = 0.1) -> Floats:
    """Return the load torque at the wheels, N m, that the motion tells: i (eta Tc - J dwc/dt), low-pass filtered.

    The filter makes the derivative: how far the filtered clutch speed lags behind, over the lag of a steady rise. It
    needs some three time constants to settle.

    Args:
        recording: channels clutch_torque and wheel_speed, on a raster of `period`, s.
        model: the vehicle as it is believed to be; its mass scales the acceleration.
        time_constant: of the filter, s.
    """
    keep = math.exp(-period / time_constant)
    lag = period * keep / (1.0 - keep)  # of the filtered speed behind a speed that rises steadily
    speed, torque = model.ratio * recording["wheel_speed"], recording["clutch_torque"]
    slow, mean = float(speed[0]), float(torque[0])
    found = np.empty(len(speed))
    for k in range(len(speed)):
        slow = keep * slow + (1.0 - keep) * float(speed[k])
        if k:
            mean = keep * mean + (1.0 - keep) * float(torque[k - 1])
        acceleration = (float(speed[k]) - slow) / lag
        found[k] = model.ratio * (model.efficiency * mean - model.inertia * acceleration)
    return found
