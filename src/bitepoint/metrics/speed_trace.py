"""Figures of a speed that is followed."""

from __future__ import annotations

import numpy as np

from bitepoint.recording import Floats, Recording

SPEED_TOLERANCE = 2.0 / 3.6
"""Tolerance of the speed, m/s (2 km/h), of UN Regulation 83, annex 4."""

TIME_TOLERANCE = 1.0
"""Tolerance of the time, s, of the same."""

_SAMPLING = 10.0
"""Rate at which the tolerance is looked at, Hz."""


TARGET = "speed_target"


def speed_error_rms(recording: Recording, target: str = TARGET) -> float | None:
    """Return the root mean square of target less speed, m/s, or None where there is no channel `target`."""
    if target not in recording:
        return None
    return float(np.sqrt(np.mean((recording[target] - recording["vehicle_speed"]) ** 2)))


def within_tolerance(recording: Recording, target: str = TARGET) -> float | None:
    """Return the share of the time in which the speed is in the band of its target, or None where there is none.

    The band at a time goes from 2 km/h below the lowest to 2 km/h above the highest target of the time up to 1 s before
    and after.
    """
    if target not in recording:
        return None
    start, end = float(recording.time[0]), float(recording.time[-1])
    raster: Floats = start + np.arange(int((end - start) * _SAMPLING + 1e-6) + 1) / _SAMPLING
    speed, wanted = (np.interp(raster, recording.time, recording[name]) for name in ("vehicle_speed", target))
    reach = round(TIME_TOLERANCE * _SAMPLING)
    near = np.lib.stride_tricks.sliding_window_view(np.pad(wanted, reach, mode="edge"), 2 * reach + 1)
    inside = (speed >= near.min(axis=1) - SPEED_TOLERANCE) & (speed <= near.max(axis=1) + SPEED_TOLERANCE)
    return float(inside.mean())
