"""What a plant is to the rest of the bench."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bitepoint.kernels import Kernel
from bitepoint.records import Record, RecordArray


@dataclass(frozen=True)
class Plant:
    """A whole plant: its records, and two kernels over them.

    Attributes:
        name: what vehicle files call it.
        parameters: its blocks are the blocks of a vehicle file, and `road` of the scenario.
        inputs, outputs: signals, all floats; names are the one vocabulary that parts are wired by.
        state, work: memory between and within steps; their content is the plant's own business.
        init: kernel (parameters, state, inputs, outputs, work) that puts it at its initial state, inputs included.
        step: kernel (parameters, state, inputs, outputs, work, dt) -> status that advances it by dt with constant
            inputs and then writes the outputs; status 0 is good, anything else stops the run.
        check: raises InputError, naming the place it is given, where parameters contradict each other.
        longitudinal: from its parameters to a `LongitudinalModel`, for plans and shift schedules; None: it has no
            gears, or no fuel.
    """

    name: str
    parameters: type[Record]
    state: type[Record]
    inputs: type[Record]
    outputs: type[Record]
    work: type[Record]
    init: Kernel[..., None]
    step: Kernel[..., int]
    check: Callable[[RecordArray, str], None]
    longitudinal: Callable[[RecordArray], RecordArray] | None = None
