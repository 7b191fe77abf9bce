"""Families of figures: the set that a scenario asks for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from bitepoint.metrics.driveline import CostWeights, driveline
from bitepoint.metrics.driving import driving
from bitepoint.metrics.excitation import excitation
from bitepoint.metrics.launch import launch
from bitepoint.metrics.metric import Metrics
from bitepoint.recording import Recording
from bitepoint.records import Record, RecordArray


@dataclass(frozen=True)
class Family:
    """A set of figures.

    Attributes:
        figures: recording, and the settings where there are some -> figures.
        settings: what a user can choose of them, all with defaults; None for nothing.
    """

    figures: Callable[..., Metrics]
    settings: type[Record] | None = None

    def measure(self, settings: RecordArray | None = None) -> Callable[[Recording], Metrics]:
        """Return the function that makes the figures of a recording, with settings, one record; None for defaults."""
        if self.settings is None:
            return self.figures
        chosen: Any = self.settings.parse({}, "") if settings is None else settings
        return partial(self.figures, settings=chosen)

    def __call__(self, recording: Recording) -> Metrics:
        """Return the figures of a recording with default settings."""
        return self.measure()(recording)


FAMILIES: Mapping[str, Family] = {
    "launch": Family(launch),
    "excitation": Family(excitation),
    "driveline": Family(driveline, CostWeights),
    "driving": Family(driving),
}
"""The sets of figures that a scenario can ask for."""
