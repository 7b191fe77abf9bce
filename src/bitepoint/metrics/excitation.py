"""Figures of runs for identification."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from bitepoint.metrics.metric import Metric, Metrics, energy_residual, existing
from bitepoint.recording import Recording


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
    return {name: Metric(existing(values[name]), unit) for name, unit in EXCITATION_UNITS.items()}


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
