"""Figures of a launch.

Definitions follow Yang et al., doi:10.11835/j.issn.1000-582X.2020.014, section 2.1.3, made unambiguous.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bitepoint.metrics.jerk import jerk_peak
from bitepoint.metrics.metric import Metric, Metrics, energy_residual, existing
from bitepoint.recording import Recording

PEDAL_THRESHOLD = 0.01
"""Pedal above which the driver wants to move off."""

SETTLING_TIME = 0.5
"""Time after sync that the settled figures include, s."""


def pedal_onset(recording: Recording) -> float | None:
    """Return the time, s, at which the pedal passes 1 %; the first time where there is no pedal channel."""
    if "pedal" not in recording:
        return float(recording.time[0])
    time, pedal = recording.time, recording["pedal"]
    pressed = np.flatnonzero(pedal > PEDAL_THRESHOLD)
    if not pressed.size or pressed[0] == 0:
        return float(time[0]) if pressed.size else None
    k = int(pressed[0])
    return float(time[k - 1] + (time[k] - time[k - 1]) * (PEDAL_THRESHOLD - pedal[k - 1]) / (pedal[k] - pedal[k - 1]))


def sync_time(recording: Recording, onset: float) -> float | None:
    """Return the time, s, at which the slip first reaches 0 after the onset, or None.

    A recorded `clutch_locked_time` says it to the last digit. Else, between two samples, it is where the slip would
    have been 0 at its latest rate: with a lock within the step, a straight line would always end at the later sample.
    """
    time, slip = recording.time, recording["engine_speed"] - recording["clutch_speed"]
    before, after = slip[:-1], slip[1:]
    closed = np.flatnonzero((before != 0.0) & (after * np.sign(before) <= 0.0) & (time[1:] > onset))
    if not closed.size:
        return None
    k = int(closed[0]) + 1
    if slip[k] == 0.0 and "clutch_locked_time" in recording:
        return float(time[k] - recording["clutch_locked_time"][k])
    fall = slip[k - 1] - slip[k]
    if slip[k] == 0.0 and k >= 2:
        rate = (slip[k - 2] - slip[k - 1]) * (time[k] - time[k - 1]) / (time[k - 1] - time[k - 2])
        fall = rate if abs(rate) > abs(fall) and rate * fall > 0.0 else fall
    return float(time[k - 1] + (time[k] - time[k - 1]) * slip[k - 1] / fall)


def friction_work(recording: Recording, start: float, end: float) -> float:
    """Return the heat in the clutch from start to end (s), J: the integral of clutch torque times slip.

    A recorded `friction_heat` is that integral already, without the error of the raster (0.3 % at 2 ms).
    """
    time = recording.time
    if "friction_heat" in recording:
        before, after = np.interp([start, end], time, recording["friction_heat"])
        return float(after - before)
    power = recording["clutch_torque"] * (recording["engine_speed"] - recording["clutch_speed"])
    inside = (time > start) & (time < end)
    raster = np.concatenate(([start], time[inside], [end]))
    return float(np.trapezoid(np.interp(raster, time, power), raster))


def launch(recording: Recording) -> Metrics:
    """Return the figures of a launch; those that need a sync, or a missing channel, are None."""
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that left the finite numbers
        return _launch(recording)


def _launch(recording: Recording) -> Metrics:
    onset = pedal_onset(recording) if "engine_speed" in recording else None
    complete = all(name in recording for name in ("clutch_speed", "clutch_torque", "vehicle_speed"))
    sync = sync_time(recording, onset) if onset is not None and complete else None
    values: dict[str, float | None] = dict.fromkeys(LAUNCH_UNITS)
    if onset is not None:
        after = recording.time >= onset
        until = recording.time[-1] if sync is None else sync + SETTLING_TIME
        values["engine_speed_min"] = float(recording["engine_speed"][after & (recording.time <= until)].min())
    if onset is not None and sync is not None:
        values["launch_time"] = sync - onset
        values["friction_work"] = friction_work(recording, onset, sync)
        values["jerk_peak"] = jerk_peak(recording, sync)
        values["end_speed"] = float(np.interp(sync, recording.time, recording["vehicle_speed"]))
        if sync + SETTLING_TIME <= recording.time[-1]:
            both = (values["jerk_peak"], jerk_peak(recording, sync + SETTLING_TIME))
            values["jerk_peak_settled"] = max((peak for peak in both if peak is not None), default=None)
    values["energy_residual"] = energy_residual(recording)
    return {name: Metric(existing(values[name]), unit) for name, unit in LAUNCH_UNITS.items()}


LAUNCH_UNITS: Mapping[str, str] = {
    "launch_time": "s",
    "friction_work": "J",
    "jerk_peak": "m/s^3",
    "jerk_peak_settled": "m/s^3",
    "engine_speed_min": "rad/s",
    "end_speed": "m/s",
    "energy_residual": "1",
}
"""The figures of a launch and their units."""
