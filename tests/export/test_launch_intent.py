"""The intention block as C: the same bits, decisions that float32 keeps, and its size on a Cortex-M7."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bitepoint.controllers.launch_intent import CONTROLLER, UNUSABLE
from bitepoint.export.c import toolchain, vectors
from bitepoint.export.c.driving import Sequence, drive
from bitepoint.export.c.package import lay_down, same
from bitepoint.export.c.sources import Sources
from bitepoint.identification.intent.decisions import calibration
from bitepoint.identification.intent.launches import draw_launches
from bitepoint.kernels.c99 import FLOAT32, PRECISIONS, Precision
from bitepoint.simulation.system import Part
from tests.conftest import needs_c, needs_target

MOST_CODE, MOST_STACK, MOST_INSTRUCTIONS = 4096, 1024, 6000
"""Bytes, bytes and instructions of one step that it may take on a Cortex-M7 in float32."""

each_precision = pytest.mark.parametrize("precision", PRECISIONS.values(), ids=PRECISIONS.keys())


def part() -> Part:
    c = CONTROLLER
    parameters = c.design(calibration(), calibration())
    return Part(c.name, c.init, c.step, parameters, c.parameters, c.state, c.measurement, c.command, None, c.period)


@pytest.fixture(scope="module")
def sequences() -> list[Sequence]:
    """Generated launches, in some of which a sensor fails."""
    launches = draw_launches(77, 8, 2)
    rows = np.stack([launches.pedal, launches.speed], axis=2)[:, :200]
    rows[::5, 60, 0], rows[1::5, 60, 1] = np.nan, np.inf
    return [Sequence(f"launch {n}", part().parameters, np.ascontiguousarray(table)) for n, table in enumerate(rows)]


@needs_c
@each_precision
def test_c_decides_as_the_simulation(sequences: list[Sequence], precision: Precision) -> None:
    unusable = 0
    for sequence in sequences:
        answer, wanted = drive(part(), sequence, "c", precision), drive(part(), sequence)
        if precision is FLOAT32:
            differing = (np.abs(answer.outputs - wanted.outputs) > 1e-6).any(axis=1).sum()
            assert differing <= 2  # a score passes another one a step earlier or later
        else:
            assert same(part(), answer, wanted)
        unusable += (wanted.outputs[:, 2] == UNUSABLE).sum()
    assert unusable > 0


@needs_target
@each_precision
def test_within_budget_on_the_target(sequences: list[Sequence], precision: Precision, tmp_path: Path) -> None:
    sources = Sources(part(), precision, CONTROLLER.meaning, "generated launches")
    folder, work = tmp_path / "intent", tmp_path / "work"
    work.mkdir()
    lay_down(sources, sequences, vectors.answers(sources, sequences), folder)
    toolchain.run_host(folder, work)
    run = toolchain.run_target(sources, folder, work, "cortex-m7")
    built = toolchain.build(sources, folder, work)
    assert run is not None
    assert built is not None
    assert run.differences == 0
    if precision is FLOAT32:
        assert run.instructions_worst <= MOST_INSTRUCTIONS
        assert built.code_bytes <= MOST_CODE
        assert max(built.stack_bytes, run.stack_measured) <= MOST_STACK
