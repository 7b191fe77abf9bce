"""What a controller is to the rest of the bench."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bitepoint.kernels import Kernel
from bitepoint.models.arx import ArxModel
from bitepoint.records import Record, RecordArray

Design = Callable[[RecordArray, RecordArray], RecordArray]
"""(vehicle parameters, one record; calibrations) -> controller parameters, one record per calibration."""

DesignOn = Callable[[RecordArray, RecordArray, ArxModel], RecordArray]
"""The same on a difference model that was identified; InputError where the controller cannot use it."""


def only_defaults() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations of a controller that ships with one, all defaults."""
    return {"default": {}}


@dataclass(frozen=True)
class Controller:
    """A controller: its records, two kernels over them, and how it is designed.

    Attributes:
        name: what scenarios call it.
        plants: names of the plants that it can drive.
        calibration: what an engineer tunes; the keys of `controller.*`.
        calibrations: the named calibrations that ship, as the mappings that `calibration.parse` takes.
        parameters: what the step reads: the calibration and what design() makes of the vehicle.
        measurement, command: signals, all floats; wired to the plant by name.
        init: kernel (parameters, state, measurement, command) for the moment the controller takes over.
        step: kernel (parameters, state, measurement, command, dt) -> status; status 0 is good. Where the controller
            has work, both kernels take it after the command.
        period: time between two steps, s.
        work: scratch of the kernels, or None; what is in it before a step does not matter.
        desktop: whether it is there to be compared with, and no ECU could afford it: it exports, but nothing is
            promised of its time there.
        design_on: design on a model from a file, or None where the controller takes none.
    """

    name: str
    meaning: str
    plants: tuple[str, ...]
    calibration: type[Record]
    calibrations: Callable[[], Mapping[str, Mapping[str, Any]]]
    default_calibration: str
    parameters: type[Record]
    state: type[Record]
    measurement: type[Record]
    command: type[Record]
    design: Design
    init: Kernel[..., None]
    step: Kernel[..., int]
    period: float = 0.01
    work: type[Record] | None = None
    design_on: DesignOn | None = None
    desktop: bool = False
