"""The quadratic programmes that a run of `damping_mpc` solved, and what it made of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.controllers.damping_mpc_records import TORQUE_SCALE


class DampingProgramme(NamedTuple):
    """One step: the records of its programme, its first move (N m), and what the future follows from."""

    matrices: np.void
    data: np.void
    move: float
    past: np.ndarray


def programmes(scenario: str, settings: Mapping[str, Any] | None = None) -> Iterator[DampingProgramme]:
    """Yield the programme of each step in which the clutch is closed and a gear engaged."""
    part = assemble(scenario, settings or {}).system.controllers[-1]
    assert part.work is not None
    recording = bitepoint.run(scenario, settings or {}).recording
    memory: list[Any] = [part.parameters, *(t.zeros() for t in (part.state, part.inputs, part.outputs, part.work))]
    every = round(part.period / float(recording.time[1] - recording.time[0]))
    for row in range(0, len(recording.time), every):
        for signal in part.inputs.fields:
            memory[2][signal] = recording[signal][row]
        if row == 0:
            part.init.run(*memory)
        part.step.run(*memory, part.period)
        gear = int(memory[1]["gear"][0])
        if gear > 0:
            solution = memory[4]["solution"][0]
            matrices = part.parameters["gear"]["matrices"][0, gear - 1]
            move, past = TORQUE_SCALE * float(solution["x"][0]), memory[4]["past"][0].copy()
            yield DampingProgramme(matrices, memory[4]["data"][0].copy(), move, past)
