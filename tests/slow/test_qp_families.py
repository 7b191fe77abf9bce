"""A million quadratic programmes of each family: how many iterations they take, and how well they end. `make slow`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from bitepoint.numerics.qp import qp_solver
from bitepoint.numerics.qp_records import SOLVED
from tests.numerics.qp_families import Programmes, dense, mpc, solve
from tests.tolerances import QP_RESIDUAL

pytestmark = pytest.mark.slow

SOLVER = qp_solver(5, 20)
CHUNK, CHUNKS = 50_000, 20

FAMILIES: dict[str, tuple[Callable[[np.random.Generator], Programmes], int]] = {
    "predictive control, 10 two-sided rows": (lambda rng: mpc(rng, CHUNK, two_sided=True), 25),
    "predictive control, 20 one-sided rows": (lambda rng: mpc(rng, CHUNK, two_sided=False), 25),
    "dense, 20 two-sided rows": (lambda rng: dense(rng, CHUNK, 5, 20), 50),
}
"""How to draw a chunk, and the most iterations that any may take."""


@pytest.mark.parametrize("family", FAMILIES)
def test_a_million_programmes(family: str, record_property: Callable[[str, object], None]) -> None:
    draw, most = FAMILIES[family]
    rng = np.random.default_rng(20)
    histogram, residual = np.zeros(SOLVER.iterations + 1, np.int64), 0.0
    for _ in range(CHUNKS):
        found = solve(draw(rng), SOLVER)
        assert (found.status == SOLVED).all()
        histogram += np.bincount(found.iterations, minlength=len(histogram))
        residual = max(residual, found.residual.max())
    worst = int(np.flatnonzero(histogram)[-1])
    counts = {n: int(histogram[n]) for n in range(worst + 1)}
    print(f"\n{family}: iterations {counts}; worst residual {residual:.1e}; cap {SOLVER.iterations}")
    record_property("iterations", counts)
    record_property("residual", residual)
    assert worst <= most
    assert residual <= QP_RESIDUAL
