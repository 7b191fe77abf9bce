"""Interior point beside the kernel: on all programmes of a run, and what is said without it."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from bitepoint.controllers.damping_mpc_records import SOLVER, TORQUE_SCALE
from bitepoint.numerics.interior_point import load_piqp, solve_interior
from bitepoint.numerics.qp_records import INFEASIBLE, SOLVED
from tests.conftest import Refused
from tests.controllers.damping_programmes import programmes

FIRST_MOVE = 0.01
"""How far the first moves of both may be apart, N m."""


@pytest.mark.parametrize(("settings", "limited"), [({}, 10), ({"motor.torque_limit": "60 N*m"}, 40)])
def test_the_first_move_is_that_of_the_kernel_over_a_whole_run(settings: dict[str, str], limited: int) -> None:
    pytest.importorskip("piqp", reason="PIQP is not installed: pip install 'bitepoint[interior]'")
    steps, active = 0, 0
    for matrices, data, move, _ in programmes("p2-tip-step", settings):
        answer = solve_interior(matrices, data)
        assert answer.status == SOLVED
        assert abs(TORQUE_SCALE * answer.x[0] - move) <= FIRST_MOVE
        steps += 1
        active += bool(np.abs(answer.multipliers).max() > 1e-3)
    assert steps == 401
    assert active >= limited


def test_contradicting_rows_are_told() -> None:
    pytest.importorskip("piqp", reason="PIQP is not installed: pip install 'bitepoint[interior]'")
    matrices, data = SOLVER.matrices.zeros()[0], SOLVER.data.zeros()[0]
    matrices["variables"], matrices["rows"] = 1, 2
    matrices["hessian"][0, 0] = 1.0
    matrices["constraints"][:2, 0] = 1.0
    data["low"][:2], data["high"][:2] = (1.0, -3.0), (2.0, -2.0)
    answer = solve_interior(matrices, data)
    assert answer.status == INFEASIBLE
    assert (answer.x == 0.0).all()


def test_without_it_one_line_names_the_extra(refused: Refused, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "piqp", None)
    refused(load_piqp, "PIQP", "bitepoint[interior]")
