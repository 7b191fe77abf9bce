"""Quadratic programmes from Python: the same answers as the kernels give, and errors that say what is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.numerics.dense_qp import DenseQp
from bitepoint.numerics.qp import qp_solver
from bitepoint.numerics.qp_records import INFEASIBLE, SOLVED
from tests.conftest import Refused
from tests.numerics.qp_families import dense, solve


def test_gives_what_the_kernels_give() -> None:
    programmes = dense(np.random.default_rng(1), 50, 5, 20)
    batch, one = solve(programmes), DenseQp(5, 20)
    answers = [one.solve(*programme) for programme in programmes]
    assert np.array_equal([answer.x for answer in answers], batch.x)
    assert np.array_equal([answer.multipliers for answer in answers], batch.multipliers)
    assert [answer.iterations for answer in answers] == list(batch.iterations)
    assert [answer.residual for answer in answers] == list(batch.residual)
    assert {(answer.status, answer.reason) for answer in answers} == {(SOLVED, "solved")}


def test_solves_again_with_the_same_matrices() -> None:
    qp = DenseQp(2, 1)
    first = qp.solve([[1.0, 0.0], [0.0, 2.0]], [-1.0, -2.0], [[1.0, 1.0]], [-np.inf], [1.0])
    assert first.x == pytest.approx([1 / 3, 2 / 3])
    assert first.multipliers == pytest.approx([2 / 3])
    second = qp.solve_again([-1.0, -2.0], [3.0], [np.inf])
    assert second.x == pytest.approx([5 / 3, 4 / 3])
    assert second.multipliers == pytest.approx([-2 / 3])
    assert first.x == pytest.approx([1 / 3, 2 / 3])  # not overwritten
    none = qp.solve_again([-1.0, -2.0], [3.0], [2.0])
    assert (none.status, none.reason) == (INFEASIBLE, "no point satisfies all rows")
    assert not none.x.any()


def test_one_variable_and_no_rows() -> None:
    assert DenseQp(1, 0).solve([[4.0]], [2.0], np.zeros((0, 1)), [], []).x == pytest.approx([-0.5])
    assert DenseQp(1, 1).solve([[4.0]], [2.0], [[2.0]], [-0.5], [1.0]).x == pytest.approx([-0.25])


def test_says_what_is_wrong(refused: Refused) -> None:
    qp, limits = DenseQp(2, 1), ([0.0], [1.0])
    unit, row = np.eye(2), np.ones((1, 2))
    refused(lambda: qp.solve_again([0, 0], *limits), "not finite", "factorise")
    refused(lambda: qp.solve(np.eye(3), [0, 0], row, *limits), "hessian has shape (3, 3)", "expected (2, 2)")
    refused(lambda: qp.solve(unit, [0, 0, 0], row, *limits), "gradient has shape (3,)", "expected (2,)")
    refused(lambda: qp.solve(unit, [0, 0], [1.0, 1.0], *limits), "constraints has shape (2,)", "expected (1, 2)")
    refused(lambda: qp.solve(unit, [0, 0], row, 0.0, [1.0]), "low has shape ()", "expected (1,)")
    refused(lambda: qp.solve(-unit, [0, 0], row, *limits), "not positive definite")
    refused(lambda: qp.solve(unit * np.nan, [0, 0], row, *limits), "not finite")
    refused(lambda: qp.solve(unit, [np.nan, 0], row, *limits), "not finite", "gradient")
    for variables, rows, what in (
        (0, 1, "0 variables"),
        (33, 1, "33 variables"),
        (2, 129, "129 rows"),
        (2, -1, "-1 rows"),
    ):
        refused(lambda v=variables, r=rows: DenseQp(v, r), what, "expected")


def test_solvers_are_made_once() -> None:
    assert qp_solver(5, 20) is qp_solver(5, 20)
    assert qp_solver(1, 0) is qp_solver(3, 1)
