"""Jerk of the vehicle."""

from __future__ import annotations

import math

import numpy as np

from bitepoint.numerics.filters import PADDING, butterworth_forward_backward
from bitepoint.recording import Floats, Recording

JERK_SAMPLING = 100.0
"""Sampling frequency of the speed that jerk is made from, Hz."""

JERK_CUTOFF = 10.0
"""Cut-off frequency of the jerk filter, Hz."""


def jerk(recording: Recording, end: float) -> Floats:
    """Return the jerk, m/s^3, at 100 Hz from the first sample until `end` (s).

    Vehicle speed sampled at 100 Hz, differenced twice, cut at the end of the window, then filtered forwards and
    backwards by a Butterworth filter of order 2 at 10 Hz. Another order of these steps can find twice as much.
    """
    result = raw_jerk(recording, end)
    if result.size >= 2:
        work = np.empty(result.size + 2 * PADDING)
        butterworth_forward_backward.run(result, result.size, JERK_CUTOFF / JERK_SAMPLING, work)
    return result


def raw_jerk(recording: Recording, end: float) -> Floats:
    """Return the same before it is filtered."""
    start, rate = float(recording.time[0]), JERK_SAMPLING
    raster = start + np.arange(math.floor((end - start) * rate + 1e-6) + 1, dtype=np.float64) / rate
    speed: Floats = np.interp(raster, recording.time, recording["vehicle_speed"])
    return np.ascontiguousarray(np.diff(speed, 2) * rate**2)


def jerk_peak(recording: Recording, end: float) -> float | None:
    """Return the largest magnitude of the jerk until `end` (s), m/s^3, or None for less than three samples."""
    values = jerk(recording, end)
    return float(np.abs(values).max()) if values.size else None
