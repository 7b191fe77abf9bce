"""The quadratic programme on a Cortex-M7: the same answers, within a budget of instructions, code and stack."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bitepoint.export.c import toolchain, vectors
from bitepoint.export.c.driving import drive
from bitepoint.export.c.package import lay_down, same
from bitepoint.export.c.sources import Sources
from bitepoint.kernels.c99 import FLOAT32, FLOAT64, PRECISIONS, Precision
from bitepoint.numerics.qp_records import SOLVED
from tests.conftest import needs_c, needs_target
from tests.export.qp_part import part, sequences
from tests.numerics.qp_families import Programmes, dense, mpc, solve

MOST_CODE, MOST_STACK = 8192, 1024
MOST_INSTRUCTIONS = {"20 limits in 10 rows": 17_000, "20 limits in 20 rows": 17_000, "40 limits in 20 rows": 32_000}
"""In float32, for the hardest of all that are drawn: limits on 5 moves and their rates as they are stated in predictive
control, the same with a row for each side, and dense rows with two sides each."""

DRAWN, WORST, ANY = 100_000, 60, 60
"""Programmes that are drawn; of which so many are taken for their iterations, and so many as they come."""

each_precision = pytest.mark.parametrize("precision", PRECISIONS.values(), ids=PRECISIONS.keys())


def hardest(programmes: Programmes) -> Programmes:
    """The programmes that take most iterations, and some others."""
    iterations = solve(programmes).iterations
    chosen = np.concatenate([np.argsort(iterations)[-WORST:], np.arange(ANY)])
    arrays = (programmes.hessian, programmes.gradient, programmes.constraints, programmes.low, programmes.high)
    return Programmes(*(array[chosen] for array in arrays))


@pytest.fixture(scope="module")
def families() -> dict[str, Programmes]:
    rng = np.random.default_rng(21)
    return {
        "20 limits in 10 rows": hardest(mpc(rng, DRAWN, two_sided=True)),
        "20 limits in 20 rows": hardest(mpc(rng, DRAWN, two_sided=False)),
        "40 limits in 20 rows": hardest(dense(rng, DRAWN // 5, 5, 20)),
    }


@needs_c
@each_precision
def test_lives_agree_and_c_solves(families: dict[str, Programmes], precision: Precision) -> None:
    for programmes in families.values():
        for sequence in sequences(programmes):
            answer = drive(part(), sequence, "c", precision)
            assert answer.statuses[1] == SOLVED
            if precision is FLOAT64:
                assert same(part(), answer, drive(part(), sequence))
                assert answer.outputs[1, 5] <= 1e-9
            else:
                assert answer.outputs[1, 5] <= 1e-3


@needs_target
@each_precision
@pytest.mark.parametrize("name", MOST_INSTRUCTIONS)
def test_within_budget_on_the_target(
    families: dict[str, Programmes], name: str, precision: Precision, tmp_path: Path
) -> None:
    sources = Sources(part(), precision, "quadratic programme of 5 variables and 20 rows", name)
    chosen = sequences(families[name])
    folder, work = tmp_path / "qp", tmp_path / "work"
    work.mkdir()
    lay_down(sources, chosen, vectors.answers(sources, chosen), folder)
    toolchain.run_host(folder, work)
    run = toolchain.run_target(sources, folder, work, "cortex-m7")
    built = toolchain.build(sources, folder, work)
    assert run is not None
    assert built is not None
    assert run.differences == 0
    assert run.steps == len(chosen)
    if precision is FLOAT32:
        assert run.instructions_worst <= MOST_INSTRUCTIONS[name]
        assert built.code_bytes <= MOST_CODE
        assert max(built.stack_bytes, run.stack_measured) <= MOST_STACK
