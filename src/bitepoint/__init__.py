"""Bitepoint: an open bench for vehicle launch and driveline torque control."""

__version__ = "0.1.0"

from bitepoint.api import BatchResult, Result, run, run_batch
from bitepoint.errors import BitepointError, InputError
from bitepoint.recording import Recording

__all__ = ["BatchResult", "BitepointError", "InputError", "Recording", "Result", "__version__", "run", "run_batch"]
