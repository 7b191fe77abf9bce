"""Checks that plants share: parameters, each in its range, that contradict each other."""

from __future__ import annotations

import numpy as np

from bitepoint.errors import InputError
from bitepoint.parts.amt import LEAST_RATIO
from bitepoint.records import RecordArray


def check_gearbox(gearbox: RecordArray, where: str) -> None:
    """Raise InputError where the gear of the start has no ratio; `gearbox`: records of AutomatedGearbox."""
    for number in np.unique(gearbox["gear"]).tolist():
        chosen = gearbox[gearbox["gear"] == number]
        if (chosen["ratios"][:, number - 1] * chosen["final_drive"] < LEAST_RATIO).any():
            mend = f"expected at least {LEAST_RATIO:g} with the final drive"
            raise InputError(where, f"gearbox.ratios: gear {number} has no ratio", mend)


def check_engine(engine: RecordArray, where: str) -> None:
    """Raise InputError where the speeds of an engine are in no order; `engine`: records of TorqueEngine."""
    for low, high in (("firing_speed", "idle_speed"), ("idle_speed", "speed_limit")):
        if (engine[low] >= engine[high]).any():
            got = float(engine[low].max())
            raise InputError(where, f"engine.{low}: got {got:g} rad/s", f"expected it below engine.{high}")
