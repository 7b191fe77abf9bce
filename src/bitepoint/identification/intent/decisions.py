"""What the step function makes of recorded launches: the network's inputs, and its decisions over the window.

Everything is taken from the kernel that runs in the car, so that training sees what the car will see.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.controllers.launch_intent import (
    CONTROLLER,
    LaunchIntentCalibration,
    LaunchIntentCommand,
    LaunchIntentMeasurement,
    LaunchIntentState,
    init,
    step,
)
from bitepoint.identification.intent.launches import PERIOD, Integers
from bitepoint.kernels import Life
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

UNDECIDED = -1


@dataclass(frozen=True)
class Windows:
    """Windows of launches; sample k is the (k + 1)-th after pedal onset, shape (n, samples) unless said otherwise.

    Attributes:
        inputs: of the network, shape (n, samples, 3): pedal, pedal rate in 1/s, vehicle speed in m/s.
        scores: of the network, shape (n, samples, 3).
        intention: 0 slow, 1 normal, 2 urgent; UNDECIDED beyond the end of the trace.
        status: `intention_status`.
        highest_pedal, highest_rate: what the rule looks at.
    """

    inputs: Floats
    scores: Floats
    intention: Integers
    status: Integers
    highest_pedal: Floats
    highest_rate: Floats


def calibration(name: str = "trained") -> RecordArray:
    """Return a calibration of `launch_intent` that ships, shape (1,)."""
    values = {key: value for key, value in CONTROLLER.calibrations()[name].items() if key != "source"}
    return LaunchIntentCalibration.parse(values, f"launch_intent, {name}")


def windows(settings: RecordArray, pedal: Floats, speed: Floats, life: Life = "compiled") -> Windows:
    """Return the last window of each trace: from its last pedal onset until `window_longest` or the trace's end.

    Args:
        settings: calibration, shape (1,).
        pedal: ratio, shape (n, samples), at 100 Hz.
        speed: m/s, same shape.
        life: which life runs.

    Raises:
        ValueError: a trace that ends with the pedal released has no such window.
    """
    rows = record_states(settings, pedal, speed, life)
    time = rows["time"]
    lanes, samples = time.shape
    fresh = time <= 0.5 * PERIOD
    if fresh[:, -1].any():
        raise ValueError(f"trace {int(np.flatnonzero(fresh[:, -1])[0])} ends with the pedal released")
    onset = samples - np.argmax(fresh[:, ::-1], axis=1)
    length = round(float(settings["window_longest"][0]) / PERIOD)
    place = onset[:, None] + np.arange(length)
    inside = place < samples
    place = np.minimum(place, samples - 1)
    cut = {name: values[np.arange(lanes)[:, None], place] for name, values in rows.items()}
    intention = np.where(inside, cut["intention"], UNDECIDED)
    parts = (cut["inputs"], cut["scores"], intention, cut["status"], cut["highest_pedal"], cut["highest_rate"])
    return Windows(*parts)


def record_states(settings: RecordArray, pedal: Floats, speed: Floats, life: Life) -> dict[str, Any]:
    """Run all traces and return what the step remembers and tells after each sample, each (n, samples, ...)."""
    parameters = CONTROLLER.design(settings, settings)
    lanes = len(pedal)
    state, measurement = LaunchIntentState.zeros(lanes), LaunchIntentMeasurement.zeros(lanes)
    command = LaunchIntentCommand.zeros(lanes)
    init.run(parameters, state, measurement, command, life=life)
    found: dict[str, list[Any]] = {}
    for seen, rolled in zip(pedal.T, speed.T, strict=True):
        measurement["pedal"], measurement["vehicle_speed"] = seen, rolled
        step.run(parameters, state, measurement, command, PERIOD, life=life)
        now = {name: state[name] for name in ("time", "intention", "highest_pedal", "highest_rate")}
        now |= {name: state["network"][name] for name in ("inputs", "scores")}
        now["status"] = command["intention_status"].astype(np.int64)
        for name, values in now.items():
            found.setdefault(name, []).append(values.copy())
    return {name: np.stack(values, axis=1) for name, values in found.items()}
