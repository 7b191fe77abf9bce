"""Figures of merit: a recording in, numbers with units out; the same for simulated and measured recordings.

Definitions follow Yang et al., doi:10.11835/j.issn.1000-582X.2020.014, section 2.1.3, made unambiguous.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bitepoint.numerics.filters import PADDING, butterworth_forward_backward
from bitepoint.recording import Floats, Recording
from bitepoint.units import display

PEDAL_THRESHOLD = 0.01
"""Pedal above which the driver wants to move off."""

SETTLING_TIME = 0.5
"""Time after sync that the settled figures include, s."""

JERK_SAMPLING = 100.0
"""Sampling frequency of the speed that jerk is made from, Hz."""

JERK_CUTOFF = 10.0
"""Cut-off frequency of the jerk filter, Hz."""


@dataclass(frozen=True)
class Metric:
    """A figure with its unit; the value is None where the figure does not exist, which `reason` may explain."""

    value: float | None
    unit: str
    reason: str = ""

    def __str__(self) -> str:
        """Return it as a person reads it: four digits, and a dash where it does not exist, with the reason if known."""
        if self.value is None:
            return f"– ({self.reason})" if self.reason else "–"
        digits = ".0f" if 1e4 <= abs(self.value) < 1e9 else ".4g"
        return f"{self.value:{digits}} {display(self.unit)}".rstrip()


Metrics = Mapping[str, Metric]


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


def jerk(recording: Recording, end: float) -> Floats:
    """Return the jerk, m/s^3, at 100 Hz from the first sample until `end` (s).

    Vehicle speed sampled at 100 Hz, differenced twice, cut at the end of the window, then filtered forwards and
    backwards by a Butterworth filter of order 2 at 10 Hz. Another order of these steps can find twice as much.
    """
    start, rate = float(recording.time[0]), JERK_SAMPLING
    raster = start + np.arange(math.floor((end - start) * rate + 1e-6) + 1, dtype=np.float64) / rate
    speed: Floats = np.interp(raster, recording.time, recording["vehicle_speed"])
    result: Floats = np.ascontiguousarray(np.diff(speed, 2) * rate**2)
    if result.size >= 2:
        work = np.empty(result.size + 2 * PADDING)
        butterworth_forward_backward.run(result, result.size, JERK_CUTOFF / rate, work)
    return result


def jerk_peak(recording: Recording, end: float) -> float | None:
    """Return the largest magnitude of the jerk until `end` (s), m/s^3, or None for less than three samples."""
    values = jerk(recording, end)
    return float(np.abs(values).max()) if values.size else None


def energy_residual(recording: Recording) -> float | None:
    """Return the share of the engine's work that the energy balance does not account for, or None if not recorded.

    Engine work - friction work - losses - change of kinetic, elastic and potential energy, over the engine work.
    """
    if "stored_energy" not in recording:
        return None
    work, heat, losses, stored = (
        float(recording[name][-1] - recording[name][0])
        for name in ("engine_work", "friction_heat", "losses", "stored_energy")
    )
    return abs(work - heat - losses - stored) / abs(work) if work != 0.0 else None


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
    return {name: Metric(_existing(values[name]), unit) for name, unit in LAUNCH_UNITS.items()}


def _existing(value: float | None) -> float | None:
    """Return a figure, or None where the recording it is made from is not finite."""
    return value if value is not None and math.isfinite(value) else None


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


def excitation(recording: Recording) -> Metrics:
    """Return the figures of a run for identification, over the time in which the vehicle moves and the clutch slips."""
    moving = (recording["vehicle_held"] < 0.5) & (recording["clutch_locked"] < 0.5)
    speed = recording["engine_speed"][moving]
    values = {
        "slip_time": float(moving.sum() * (recording.time[1] - recording.time[0])) if recording.time.size > 1 else 0.0,
        "engine_speed_min": float(speed.min()) if speed.size else None,
        "engine_speed_max": float(speed.max()) if speed.size else None,
        "energy_residual": energy_residual(recording),
    }
    return {name: Metric(_existing(values[name]), unit) for name, unit in EXCITATION_UNITS.items()}


def excitation_set(logs: Sequence[Recording], figures: Sequence[Metrics]) -> Metrics:
    """Return the figures of many runs for identification: how much was logged, and the extremes over all runs."""

    def extreme(name: str, pick: Callable[[list[float]], float]) -> Metric:
        values = [value for each in figures if name in each and (value := each[name].value) is not None]
        return Metric(pick(values) if values else None, EXCITATION_UNITS[name])

    return {
        "runs": Metric(float(len(logs)), "1"),
        "rows": Metric(float(sum(len(log.time) for log in logs)), "1"),
        "slip_time_min": extreme("slip_time", min),
        "engine_speed_min": extreme("engine_speed_min", min),
        "engine_speed_max": extreme("engine_speed_max", max),
        "energy_residual": extreme("energy_residual", max),
    }


EXCITATION_UNITS: Mapping[str, str] = {
    "slip_time": "s",
    "engine_speed_min": "rad/s",
    "engine_speed_max": "rad/s",
    "energy_residual": "1",
}
"""The figures of a run for identification and their units."""

FAMILIES: Mapping[str, Callable[[Recording], Metrics]] = {"launch": launch, "excitation": excitation}
"""The sets of figures that a scenario can ask for."""
