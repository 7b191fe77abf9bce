"""A figure with its unit, and what all families of figures share."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bitepoint.recording import Recording
from bitepoint.units import display


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


def energy_residual(recording: Recording) -> float | None:
    """Return the share of the work done that the energy balance does not account for, or None if not recorded.

    Work of engine and motor - heat of friction - losses - change of kinetic, elastic and potential energy, over the
    work of the engine and all that the motor moved, driving or generating.
    """
    if "stored_energy" not in recording:
        return None
    work, heat, losses, stored = (
        float(recording[name][-1] - recording[name][0])
        for name in ("engine_work", "friction_heat", "losses", "stored_energy")
    )
    moved = abs(work)
    if "motor_work" in recording:
        motor = np.diff(recording["motor_work"])
        work, moved = work + float(motor.sum()), moved + float(np.abs(motor).sum())
    return abs(work - heat - losses - stored) / moved if moved != 0.0 else None


def existing(value: float | None) -> float | None:
    """Return a figure, or None where the recording it is made from is not finite."""
    return value if value is not None and math.isfinite(value) else None
