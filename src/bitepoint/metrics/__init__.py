"""Figures of merit: a recording in, numbers with units out; the same for simulated and measured recordings."""

from bitepoint.metrics.driveline import LEAST_STEP
from bitepoint.metrics.driving import DRIVING_UNITS
from bitepoint.metrics.excitation import EXCITATION_UNITS, excitation_set
from bitepoint.metrics.family import FAMILIES, Family
from bitepoint.metrics.jerk import JERK_SAMPLING, jerk, jerk_peak
from bitepoint.metrics.launch import (
    LAUNCH_UNITS,
    SETTLING_TIME,
    friction_work,
    launch,
    pedal_onset,
    sync_time,
)
from bitepoint.metrics.metric import Metric, Metrics, energy_residual

__all__ = [
    "DRIVING_UNITS", "EXCITATION_UNITS", "FAMILIES", "JERK_SAMPLING", "LAUNCH_UNITS", "LEAST_STEP", "SETTLING_TIME",
    "Family", "Metric", "Metrics", "energy_residual", "excitation_set", "friction_work", "jerk", "jerk_peak", "launch",
    "pedal_onset", "sync_time",
]  # fmt: skip
