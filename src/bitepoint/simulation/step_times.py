"""How long a controller takes: each of its steps in a run again, on the measurements that it had, by the clock.

A wall time is not reproducible, so it is taken after the run, for itself, and never in a batch. What is measured is a
call of the compiled step from Python, by ctypes with prepared addresses; nothing is subtracted.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np

from bitepoint.kernels import Life
from bitepoint.kernels.interpreted import raise_pending
from bitepoint.kernels.kernel import ENTRY
from bitepoint.recording import Floats, Recording
from bitepoint.simulation.system import Part, argument_addresses, argument_types


class StepTimes(NamedTuple):
    """Steps that were taken again.

    Attributes:
        seconds: of each step, by the wall clock, shape (steps,).
        outputs: what it commanded, shape (steps, outputs): the same as in the recording, or these are other steps.
    """

    seconds: Floats
    outputs: Floats


def step_times(part: Part, recording: Recording, life: Life = "compiled") -> StepTimes:
    """Step a controller of one lane again through a recording of its closed loop, from its initialisation on."""
    every = max(round(part.period / float(recording.time[1] - recording.time[0])), 1) if len(recording.time) > 1 else 1
    seen = [f"{name}_measured" if f"{name}_measured" in recording else name for name in part.inputs.fields]
    table = np.ascontiguousarray(np.array([recording[name][::every] for name in seen]).T)
    records = {record: role for record, role in argument_types(part).items() if role != "parameters"}
    memory = {role: record.zeros() for record, role in records.items()}
    inputs, outputs = memory["inputs"].view(np.float64), memory["outputs"].view(np.float64)
    arrays = {**memory, "parameters": part.parameters[:1], "period": np.array([part.period])}
    arrays["status"] = np.zeros(1, np.int64)
    inputs[:] = table[0]
    first, each = (argument_addresses(kernel, part, arrays) for kernel in (part.init, part.step))
    zeros = np.zeros(len(each) + 1, np.int64)  # one lane
    ENTRY(part.init.entry(life))(first.ctypes.data, zeros.ctypes.data, 1)
    step, call = ENTRY(part.step.entry(life)), (each.ctypes.data, zeros.ctypes.data, 1)
    nanoseconds, shown = np.zeros(len(table), np.int64), np.zeros((len(table), len(outputs)))
    clock = time.perf_counter_ns
    for row, measured in enumerate(table):
        inputs[:] = measured
        begun = clock()
        step(*call)
        nanoseconds[row] = clock() - begun
        shown[row] = outputs
    raise_pending()
    return StepTimes(np.asarray(1e-9 * nanoseconds, np.float64), shown)
