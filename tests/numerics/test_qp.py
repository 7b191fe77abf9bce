"""The quadratic programme: against DAQP and quadprog, its own certificate, its statuses, its two lives."""

from __future__ import annotations

from dataclasses import replace

import daqp
import numpy as np
import pytest
import quadprog
from hypothesis import given, settings
from hypothesis import strategies as st

from bitepoint.numerics import qp
from bitepoint.numerics.qp import qp_solver
from bitepoint.numerics.qp_records import INACCURATE, INFEASIBLE, ITERATION_CAP, NOT_FINITE, SOLVED
from tests.numerics.qp_families import (
    FEASIBLE,
    Floats,
    Programmes,
    dense,
    mpc,
    parallel,
    redundant,
    scaled,
    shortfall,
    solve,
)
from tests.tolerances import QP_OBJECTIVE, QP_POINT, QP_RESIDUAL

SOLVER = qp_solver(5, 20)
LANES = 800
"""Programmes per family: 14 families, some 11 000 in all."""

CAP = SOLVER.iterations


def by_daqp(hessian: Floats, gradient: Floats, rows: Floats, low: Floats, high: Floats) -> tuple[Floats, bool, bool]:
    """Return x, whether DAQP solved the programme, and whether it holds it for infeasible."""
    sense = np.where(low == high, 5, 0).astype(np.int32)
    ends = np.minimum(high, 1e30), np.maximum(low, -1e30)
    x, _, flag, _ = daqp.solve(hessian.copy(), gradient.copy(), rows.copy(), *ends, sense, primal_tol=1e-9)
    return np.asarray(x), flag == 1, flag == -1


def by_quadprog(hessian: Floats, gradient: Floats, rows: Floats, low: Floats, high: Floats) -> Floats:
    """Return x of a programme all of whose limits are finite, or one-sided."""
    below, above = np.isfinite(low), np.isfinite(high)
    normals = np.vstack([rows[below], -rows[above]]).T.copy()
    return quadprog.solve_qp(hessian.copy(), -gradient, normals, np.concatenate([low[below], -high[above]]))[0]


def distances(programmes: Programmes, x: Floats, others: Floats) -> tuple[Floats, Floats]:
    """Return the distances of points in the metric of the Hessian, and of objectives, relative, each (lanes,)."""
    lower = np.linalg.cholesky(programmes.hessian)
    free = np.linalg.norm(np.linalg.solve(lower, programmes.gradient[:, :, None])[:, :, 0], axis=1)
    size = free + np.linalg.norm(np.einsum("lij,li->lj", lower, x), axis=1)
    points = np.linalg.norm(np.einsum("lij,li->lj", lower, x - others), axis=1) / size
    return points, np.abs(objective(programmes, x) - objective(programmes, others)) / size**2


def objective(programmes: Programmes, x: Floats) -> Floats:
    return 0.5 * np.einsum("li,lij,lj->l", x, programmes.hessian, x) + np.einsum("li,li->l", programmes.gradient, x)


def part_of(programmes: Programmes, lanes: slice | Floats) -> Programmes:
    p = programmes
    return Programmes(p.hessian[lanes], p.gradient[lanes], p.constraints[lanes], p.low[lanes], p.high[lanes])


@pytest.mark.parametrize("family", FEASIBLE)
def test_agrees_with_other_solvers_and_certifies_itself(family: str) -> None:
    programmes = FEASIBLE[family](np.random.default_rng(7), LANES)
    found = solve(programmes, SOLVER)
    assert (found.status == SOLVED).all()
    assert found.residual.max() <= QP_RESIDUAL
    assert shortfall(programmes, found.x, found.multipliers).max() <= QP_RESIDUAL
    assert found.iterations.max() <= 0.75 * CAP
    answers = [by_daqp(*one) for one in programmes]
    solved = np.array([answer[1] for answer in answers])
    # DAQP holds a vertex of many rows for infeasible now and then, and most wedges
    assert solved.mean() > (0.25 if "wedges" in family else 0.995)
    points, objectives = distances(programmes, found.x, np.array([answer[0] for answer in answers]))
    assert points[solved].max() <= QP_POINT
    assert objectives[solved].max() <= QP_OBJECTIVE


@pytest.mark.parametrize("family", ["predictive control, 20 one-sided rows", "dense", "few variables, many rows"])
def test_agrees_with_quadprog(family: str) -> None:
    programmes = FEASIBLE[family](np.random.default_rng(8), LANES)
    found = solve(programmes, SOLVER)
    points, objectives = distances(programmes, found.x, np.array([by_quadprog(*one) for one in programmes]))
    assert points.max() <= QP_POINT
    assert objectives.max() <= QP_OBJECTIVE


def test_sees_what_is_infeasible_as_daqp_does() -> None:
    rng = np.random.default_rng(9)
    programmes = dense(rng, LANES, 5, 20)
    width = programmes.high - programmes.low
    apart = 2 * width * (rng.random(width.shape) < 0.1)
    programmes = replace(programmes, low=programmes.low + apart, high=programmes.high + 2 * apart)
    found = solve(programmes, SOLVER)
    expected = np.array([by_daqp(*one)[2] for one in programmes])
    assert 0.2 < expected.mean() < 0.9
    assert np.array_equal(found.status == INFEASIBLE, expected)
    assert set(found.status) == {SOLVED, INFEASIBLE}


def test_sees_limits_of_the_same_row_that_exclude_each_other() -> None:
    programmes = redundant(np.random.default_rng(10), LANES)
    low, high = programmes.low.copy(), programmes.high.copy()
    ratio = programmes.constraints[:, 10, 0] / programmes.constraints[:, 0, 0]
    beyond = (high[:, 0] + 1e-6 * np.abs(high[:, 0])) * ratio
    low[:, 10], high[:, 10] = np.where(ratio > 0, beyond, -np.inf), np.where(ratio > 0, np.inf, beyond)
    assert (solve(replace(programmes, low=low, high=high), SOLVER).status == INFEASIBLE).all()
    crossed = replace(programmes, low=programmes.high, high=programmes.low - 1e-9)
    assert (solve(crossed, SOLVER).status == INFEASIBLE).all()


def test_rows_turned_round_count_once() -> None:
    two_sided, one_sided = (mpc(np.random.default_rng(12), LANES, two_sided=two) for two in (True, False))
    once, twice = solve(two_sided, SOLVER), solve(one_sided, SOLVER)
    assert np.array_equal(once.x, twice.x)
    assert np.array_equal(once.iterations, twice.iterations)
    assert np.array_equal(once.multipliers, twice.multipliers[:, :10] - twice.multipliers[:, 10:])
    assert (twice.multipliers >= 0.0).all()
    matrices, _ = one_sided.records(SOLVER)
    SOLVER.factorise.run(matrices)
    assert (matrices["slabs"] == 9).all()  # the first move and its change are limited by the same row


@pytest.mark.parametrize(("beyond", "status"), [(1e-15, SOLVED), (1e-6, INFEASIBLE)])
def test_parallel_rows_that_miss_each_other_by_rounding_meet(beyond: float, status: int) -> None:
    programmes = parallel(np.random.default_rng(13), LANES)
    level = 1.0 + np.einsum("li,li->l", programmes.constraints[:, 0], programmes.gradient)
    factor = (programmes.constraints[:, 5] / programmes.constraints[:, 0])[:, 0]
    low, high = np.full_like(programmes.low, -np.inf), np.full_like(programmes.high, np.inf)
    high[:, 0], end = level, (level + beyond * np.abs(level)) * factor
    low[:, 5], high[:, 5] = np.where(factor > 0, end, -np.inf), np.where(factor > 0, np.inf, end)
    apart = replace(programmes, low=low, high=high)
    found = solve(apart, SOLVER)
    assert (found.status == status).all()
    if status == SOLVED:
        assert shortfall(apart, found.x, found.multipliers).max() <= QP_RESIDUAL


def test_without_limits_it_is_a_linear_equation() -> None:
    programmes = dense(np.random.default_rng(11), LANES, 5, 20)
    none = np.full_like(programmes.low, np.inf)
    found = solve(replace(programmes, low=-none, high=none), SOLVER)
    assert (found.iterations == 0).all()
    wanted = np.linalg.solve(programmes.hessian, -programmes.gradient[:, :, None])[:, :, 0]
    assert found.x == pytest.approx(wanted, rel=1e-9, abs=1e-9)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.sampled_from(sorted(FEASIBLE)))
def test_order_and_length_of_rows_do_not_matter(seed: int, family: str) -> None:
    rng = np.random.default_rng(seed)
    programmes = FEASIBLE[family](rng, 20)
    order = rng.permutation(programmes.size[1])
    moved = replace(
        programmes,
        constraints=programmes.constraints[:, order],
        low=programmes.low[:, order],
        high=programmes.high[:, order],
    )
    factors = 10 ** rng.uniform(-2, 2, moved.low.shape) * rng.choice([-1.0, 1.0], moved.low.shape)
    one, other = solve(programmes, SOLVER), solve(scaled(moved, factors), SOLVER)
    assert (other.status == SOLVED).all()
    points, objectives = distances(programmes, one.x, other.x)
    assert points.max() <= QP_POINT
    assert objectives.max() <= QP_OBJECTIVE
    assert shortfall(moved, other.x, other.multipliers * factors).max() <= QP_RESIDUAL


def spoiled(rng: np.random.Generator, lanes: int) -> Programmes:
    """Return programmes of all families, some numbers of most of them exchanged for NaN, infinity and the like."""
    parts = [p for p in (family(rng, lanes) for family in FEASIBLE.values()) if p.size == (5, 20)]
    arrays = ("hessian", "gradient", "constraints", "low", "high")
    mixed = {name: np.concatenate([getattr(p, name) for p in parts]) for name in arrays}
    for name, array in mixed.items():
        at = rng.random(array.shape) < (0.05 if name == "gradient" else 0.004)
        array[at] = rng.choice([np.nan, np.inf, -np.inf, 0.0, 1e300, -1e300, 1e-300, 1e30], at.sum())
    return Programmes(**mixed)


def test_both_lives_agree_bit_for_bit_whatever_the_numbers() -> None:
    programmes = spoiled(np.random.default_rng(12), 25)
    compiled, interpreted = solve(programmes, SOLVER), solve(programmes, SOLVER, life="interpreted")
    assert {SOLVED, INFEASIBLE, NOT_FINITE} <= set(compiled.status)
    for name in ("status", "x", "multipliers", "iterations", "residual"):
        assert getattr(compiled, name).tobytes() == getattr(interpreted, name).tobytes(), name
    unsolved = compiled.status != SOLVED
    assert not compiled.x[unsolved].any()
    assert not compiled.multipliers[unsolved].any()
    assert (compiled.residual[unsolved] == -1.0).all()
    assert np.isfinite(compiled.x).all()
    assert np.isfinite(compiled.multipliers).all()


def test_nothing_that_is_not_a_number_gets_through() -> None:
    programmes = dense(np.random.default_rng(13), 2, 5, 20)
    for name in ("hessian", "gradient", "constraints", "low", "high"):
        array = getattr(programmes, name).copy()
        array[0].flat[-1] = np.nan
        assert list(solve(replace(programmes, **{name: array}), SOLVER).status) == [NOT_FINITE, SOLVED], name
    infinite = programmes.gradient.copy()
    infinite[0, 0] = np.inf
    assert solve(replace(programmes, gradient=infinite), SOLVER).status[0] == NOT_FINITE
    unreachable = programmes.low.copy()
    unreachable[0, 3] = np.inf
    assert solve(replace(programmes, low=unreachable, high=unreachable + np.inf), SOLVER).status[0] == INFEASIBLE


def test_hessians_that_are_not_positive_definite_or_not_symmetric() -> None:
    programmes = dense(np.random.default_rng(14), 3, 5, 20)
    hessian = np.broadcast_to(np.eye(5), (3, 5, 5)).copy()
    hessian[0, 4, 4], hessian[1, 4, 4] = 0.0, -1.0
    hessian[2, 0, 4] = 0.5  # the factor is that of the lower triangle
    found = solve(replace(programmes, hessian=hessian), SOLVER)
    assert list(found.status) == [NOT_FINITE, NOT_FINITE, INACCURATE]
    assert not found.x.any()
    matrices, data = programmes.records(SOLVER)
    never = SOLVER.solve.run(matrices, data, SOLVER.work.zeros(), SOLVER.solution.zeros(3))
    assert list(never) == [NOT_FINITE] * 3


def test_the_residual_sees_what_is_wrong() -> None:
    programmes = dense(np.random.default_rng(19), 50, 5, 20)
    matrices, data = programmes.records(SOLVER)
    SOLVER.factorise.run(matrices)
    work, solution = SOLVER.work.zeros(50), SOLVER.solution.zeros(50)
    SOLVER.solve.run(matrices, data, work, solution)
    everything = (matrices, data, work, solution)
    assert qp.qp_row_residual.run(*everything).max() <= QP_RESIDUAL
    assert qp.qp_stationarity.run(*everything).max() <= QP_RESIDUAL
    active = work["members"] > 0
    assert active.sum() > 30
    solution["multipliers"] *= -1.0
    for kernel in (qp.qp_row_residual, qp.qp_stationarity):
        assert (kernel.run(*everything)[active] > 1e-6).all(), kernel
    solution["multipliers"] *= -1.0
    solution["x"] += 1e-6 * np.abs(solution["x"]).sum(1)[:, None]
    for kernel in (qp.qp_row_residual, qp.qp_stationarity):
        seen = kernel.run(*everything)
        assert (seen[active] > 1e-9).all(), kernel
        assert (seen < 1e-3).all(), kernel


def test_the_cap_is_a_status() -> None:
    programmes = dense(np.random.default_rng(15), LANES, 5, 20)
    full = solve(programmes, SOLVER)
    capped = replace(SOLVER, solve=SOLVER.solve.specialise("qp_solve_capped", {"ITERATIONS": 6}))
    for life in ("compiled", "interpreted"):
        some = slice(None) if life == "compiled" else slice(20)
        found, wanted = solve(part_of(programmes, some), capped, life), full.iterations[some] > 6
        assert np.array_equal(found.status, np.where(wanted, ITERATION_CAP, SOLVED))
        assert not found.x[wanted].any()
        assert not found.multipliers[wanted].any()
        assert np.array_equal(found.x[~wanted], full.x[some][~wanted])


def test_unused_places_of_records_do_not_matter() -> None:
    programmes = dense(np.random.default_rng(16), LANES, 3, 7)
    exact = solve(programmes, qp_solver(3, 7))
    for solver, fill in ((SOLVER, 0.0), (SOLVER, np.nan), (qp_solver(8, 32), np.inf), (qp_solver(10, 20), np.nan)):
        found = solve(programmes, solver, fill=fill)
        for name in ("status", "x", "multipliers", "iterations", "residual"):
            assert getattr(found, name).tobytes() == getattr(exact, name).tobytes(), (solver.rows, name)


def test_loops_written_out_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    programmes = dense(np.random.default_rng(17), LANES, 5, 20)
    monkeypatch.setattr(qp, "MOST_UNROLLED", 0)
    looped = qp_solver.__wrapped__(5, 20)
    assert looped.solve.source.text != SOLVER.solve.source.text or looped is not SOLVER
    one, other = solve(programmes, looped), solve(programmes, SOLVER)
    assert one.x.tobytes() == other.x.tobytes()


@pytest.mark.parametrize("two_sided", [True, False])
def test_the_cap_is_far_away_in_predictive_control(two_sided: bool) -> None:
    programmes = mpc(np.random.default_rng(18), 20_000, two_sided=two_sided)
    found = solve(programmes, SOLVER)
    assert (found.status == SOLVED).all()
    assert found.iterations.max() <= CAP / 3
    assert found.residual.max() <= QP_RESIDUAL
    assert shortfall(programmes, found.x, found.multipliers).max() <= QP_RESIDUAL
