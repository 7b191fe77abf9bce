"""Bitepoint: an open bench for vehicle launch and driveline torque control."""

from bitepoint.api import BatchResult, Identification, Result, identify, run, run_batch
from bitepoint.errors import BitepointError, InputError
from bitepoint.recording import Recording
from bitepoint.studies.sweep import SweepResult, sweep
from bitepoint.version import __version__

__all__ = [
    "BatchResult",
    "BitepointError",
    "Identification",
    "InputError",
    "Recording",
    "Result",
    "SweepResult",
    "__version__",
    "identify",
    "run",
    "run_batch",
    "sweep",
]
