"""Bitepoint: an open bench for vehicle launch and driveline torque control."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bitepoint.api import (
    BatchResult,
    FuelIdentification,
    Identification,
    Result,
    identify,
    identify_fuel,
    run,
    run_batch,
)
from bitepoint.errors import BitepointError, InputError
from bitepoint.recording import Recording
from bitepoint.version import __version__

if TYPE_CHECKING:
    from bitepoint.studies.sweep import SweepResult, sweep

__all__ = [
    "BatchResult",
    "BitepointError",
    "FuelIdentification",
    "Identification",
    "InputError",
    "Recording",
    "Result",
    "SweepResult",
    "__version__",
    "identify",
    "identify_fuel",
    "run",
    "run_batch",
    "sweep",
]


def __getattr__(name: str) -> Any:
    """Import the studies when they are first asked for: a single run starts without them."""
    if name not in ("SweepResult", "sweep"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from bitepoint.studies import sweep as study

    return getattr(study, name)
