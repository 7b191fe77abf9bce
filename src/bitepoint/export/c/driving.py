"""A part driven step by step through recorded inputs, in any life and precision: what vectors are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.kernels import Kernel
from bitepoint.kernels.c99 import FLOAT64, Precision
from bitepoint.kernels.interpreted import raise_pending
from bitepoint.kernels.kernel import ENTRY, Life
from bitepoint.records import RecordArray
from bitepoint.simulation.system import Part, argument_addresses, argument_types

Floats = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Sequence:
    """Inputs for a part from its initialisation on.

    Attributes:
        name: where they come from.
        parameters: one record, in float64.
        inputs: shape (rows, inputs); row 0 is what init sees, each further row is one step.
        designed: whether the parameters are those that were designed, and no random ones.
    """

    name: str
    parameters: RecordArray
    inputs: Floats
    designed: bool = True


@dataclass(frozen=True)
class Answers:
    """What a part answered to a sequence.

    Attributes:
        outputs: shape (rows, outputs); statuses: shape (rows,), the one of row 0 is 0.
        state: one record, at the end.
        iterations: most iterations that a solver inside took in one step, or None where there is none.
    """

    outputs: Floats
    statuses: np.ndarray[Any, np.dtype[np.int64]]
    state: RecordArray
    iterations: int | None


def drive(part: Part, sequence: Sequence, life: Life = "compiled", precision: Precision = FLOAT64) -> Answers:
    """Step a part through a sequence; in float32 only the life "c" exists."""
    entries = [_entry(kernel, life, precision) for kernel in (part.init, part.step)]
    return drive_entries(part, sequence, precision, *entries)


Entry = Callable[[int, int, int], None]
"""An entry as a function: addresses of arguments, address of steps, lanes."""


def drive_entries(part: Part, sequence: Sequence, precision: Precision, init: Entry, step: Entry) -> Answers:
    """Step a part through a sequence by the entries of its two kernels."""
    answers = Driver(part, precision).run(sequence, init, step)
    raise_pending()
    return answers


def _entry(kernel: Kernel[..., Any], life: Life, precision: Precision) -> Entry:
    if precision is FLOAT64:
        return ENTRY(kernel.entry(life))
    from bitepoint.kernels.c99.host import host_entry

    return ENTRY(host_entry(kernel, precision))


def iteration_counts(part: Part) -> Iterator[tuple[str, str, int]]:
    """Yield role, path and cap of every count of a solver's iterations in the memory of a part."""
    for record, role in argument_types(part).items():
        for path, field in record.table() if role != "parameters" else ():
            if path.rpartition(".")[2] == "iterations" and field.kind == "int":
                yield role, path, int(field.high)


class Driver:
    """The memory of one part in one precision."""

    def __init__(self, part: Part, precision: Precision) -> None:
        self.part = part
        self.precision = precision
        self.roles = argument_types(part)
        self.records = {role: record for record, role in self.roles.items()}
        self.memory = {
            role: np.zeros(1, precision.layout(record)) for role, record in self.records.items() if role != "parameters"
        }
        self.parameters = self.precision.convert(part.parameters[:1], self.records["parameters"])
        self.period = np.array([part.period], precision.real_dtype)
        self.status = np.zeros(1, precision.integer_dtype)
        self.counters = [
            self.records[role].locate(self.memory[role], path, role)[1] for role, path, _ in iteration_counts(part)
        ]

    def begin(self, sequence: Sequence, init: Entry) -> Floats:
        """Clear the memory and initialise the part for a sequence; return the inputs in this precision."""
        self.parameters = self.precision.convert(sequence.parameters, self.records["parameters"])
        for array in self.memory.values():
            array[...] = np.zeros((), array.dtype)
        real = self.precision.real_dtype
        with np.errstate(over="ignore"):
            inputs = np.ascontiguousarray(sequence.inputs.astype(real))
        self.memory["inputs"].view(real)[:] = inputs[0]
        first = self.arguments(self.part.init)
        steps = np.zeros(len(first), np.int64)
        init(first.ctypes.data, steps.ctypes.data, 1)
        return inputs

    def run(self, sequence: Sequence, init: Entry, step: Entry) -> Answers:
        """Step the part through a sequence."""
        inputs = self.begin(sequence, init)
        each = self.arguments(self.part.step)
        steps = np.zeros(len(each), np.int64)
        real = self.precision.real_dtype
        outputs = np.zeros((len(inputs), len(self.part.outputs.fields)), real)
        statuses = np.zeros(len(inputs), np.int64)
        seen = self.memory["inputs"].view(real)
        shown = self.memory["outputs"].view(real)
        iterations = 0
        for row in range(len(inputs)):
            if row > 0:
                seen[:] = inputs[row]
                step(each.ctypes.data, steps.ctypes.data, 1)
                statuses[row] = self.status[0]
            outputs[row] = shown
            iterations = max([iterations, *(int(counter.max()) for counter in self.counters)])
        state = self.memory["state"].copy()
        return Answers(outputs, statuses, state, iterations if self.counters else None)

    def arguments(self, kernel: Kernel[..., Any]) -> np.ndarray[Any, Any]:
        """Return the addresses of what a kernel of the part takes, and of its status."""
        arrays = {**self.memory, "parameters": self.parameters, "period": self.period, "status": self.status}
        return argument_addresses(kernel, self.part, arrays)
