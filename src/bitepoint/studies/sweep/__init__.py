"""Sweeps: a scenario over the grid of some keys, resumable, with the configuration and the code version of each row."""

from bitepoint.studies.sweep.result import SweepResult
from bitepoint.studies.sweep.study import sweep

__all__ = ["SweepResult", "sweep"]
