"""Figures of a drive: fuel, time, way and speed, what is felt of it, and how often the gear changed.

The stop rule ends a run up to one tick after its limit, so the figures of a way of 150 m are those of the row at the
end: compare drives at the way that each has gone, or use a short tick.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bitepoint.metrics.jerk import jerk_peak
from bitepoint.metrics.metric import Metric, Metrics, energy_residual, existing
from bitepoint.metrics.speed_trace import TARGET, speed_error_rms, within_tolerance
from bitepoint.recording import Recording

DRIVING_UNITS: Mapping[str, str] = {
    "fuel_used": "kg",
    "drive_time": "s",
    "distance": "m",
    "mean_speed": "m/s",
    "end_speed": "m/s",
    "end_speed_error": "m/s",
    "gear_changes": "1",
    "acceleration_peak": "m/s^2",
    "jerk_peak": "m/s^3",
    "friction_heat": "J",
    "speed_error_rms": "m/s",
    "within_tolerance": "1",
    "energy_residual": "1",
}
"""The figures and their units."""


def driving(recording: Recording) -> Metrics:
    """Return the figures; those whose channels are missing are None.

    `end_speed_error` is the speed at the end less the target there; `gear_changes` counts gears that engage after
    another one. A speed that a driver follows by a plan counts as the one to follow.
    """
    followed = "speed_wanted" if "speed_wanted" in recording else TARGET
    time, speed = recording.time, recording["vehicle_speed"]
    seconds = float(time[-1] - time[0])
    values: dict[str, float | None] = {"drive_time": seconds, "end_speed": float(speed[-1])}
    for name in ("fuel_used", "distance", "friction_heat"):
        values[name] = float(recording[name][-1] - recording[name][0]) if name in recording else None
    way = values["distance"]
    values["mean_speed"] = way / seconds if way is not None and seconds > 0.0 else None
    values["end_speed_error"] = None
    if "speed_target" in recording:
        values["end_speed_error"] = float(speed[-1] - recording["speed_target"][-1])
    values["gear_changes"] = gear_changes(recording)
    values["acceleration_peak"] = None
    if "vehicle_acceleration" in recording:
        values["acceleration_peak"] = float(np.abs(recording["vehicle_acceleration"]).max())
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that left the finite numbers
        values["jerk_peak"] = jerk_peak(recording, float(time[-1]))
        values["speed_error_rms"] = speed_error_rms(recording, followed)
        values["within_tolerance"] = within_tolerance(recording, followed)
        values["energy_residual"] = energy_residual(recording)
    return {name: Metric(existing(values[name]), unit) for name, unit in DRIVING_UNITS.items()}


def gear_changes(recording: Recording) -> float | None:
    """Return how often another gear was engaged, or None where the gear is not recorded; neutral is no gear."""
    if "gear" not in recording:
        return None
    engaged = recording["gear"][recording["gear"] > 0.0]
    return float(np.count_nonzero(np.diff(engaged)))
