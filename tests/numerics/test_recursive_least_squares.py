"""Recursive least squares: the problem solved at once, long times without excitation, and every life."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bitepoint.kernels import Kernel, Life, kernel
from bitepoint.kernels.c99 import FLOAT32, FLOAT64, Precision
from bitepoint.kernels.c99.host import host_entry
from bitepoint.kernels.kernel import ENTRY, addresses_of
from bitepoint.numerics.recursive_least_squares import (
    NOT_TAKEN,
    UPDATED,
    LeastSquares,
    LeastSquaresState,
    least_squares_reset,
    least_squares_step,
)
from tests.conftest import OTHER_LIVES, needs_c

LONG = 1_000_000
"""Steps without excitation: almost three hours at 100 Hz."""


@kernel
def never_excited(p: LeastSquares, s: LeastSquaresState, steps: int, noise: float) -> float:
    """Repeat one regressor, whose parameters give 0, with noise of a multiplicative generator; return the largest
    change of a parameter."""
    seed = 1.0
    largest = 0.0
    for _step in range(steps):
        seed = seed * 171.0
        for _fold in range(171):
            if seed >= 30269.0:
                seed = seed - 30269.0
        for j in range(8):
            s.regressors[j] = 0.0
        s.regressors[0] = 1.0
        s.regressors[1] = 2.0
        least_squares_step(p, s, noise * (seed / 15134.5 - 1.0))
        for j in range(8):
            largest = max(largest, abs(s.parameters[j] - p.prior[j]))
    return largest


def method(size: int, forgetting: float = 0.98, floor: float = 1e-6, **more: Any) -> np.ndarray:
    p = LeastSquares.parse({"size": size, "forgetting": forgetting, **more}, "test")
    p["floor"] = floor
    return p


def fresh(p: np.ndarray) -> np.ndarray:
    s = LeastSquaresState.zeros(len(p))
    s.view(np.float64)[...] = 3.0  # reset must not rely on what was there
    least_squares_reset.run(p, s)
    return s


def data(size: int, steps: int, seed: int, condition: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(steps, size)) * np.geomspace(1.0, 1.0 / condition, size)
    mixed = x @ np.linalg.qr(rng.normal(size=(size, size)))[0]
    truth = rng.normal(size=size) * (1.0 + np.linspace(0.0, 1.0, steps)[:, None])
    return mixed, (mixed * truth).sum(1) + 0.1 * rng.normal(size=steps)


def follow(p: np.ndarray, s: np.ndarray, x: np.ndarray, y: np.ndarray, life: Life = "compiled") -> np.ndarray:
    """Step through the rows of x; return the parameters after each."""
    size, found = x.shape[1], []
    for row, right in zip(x, y, strict=True):
        s["regressors"][:, :size] = row
        assert least_squares_step.run(p, s, right, life=life)[0] == UPDATED
        found.append(s["parameters"][0, :size].copy())
    return np.array(found)


def weighted(x: np.ndarray, y: np.ndarray, forgetting: float) -> np.ndarray:
    weights = forgetting ** (0.5 * np.arange(len(x))[::-1])
    return np.linalg.lstsq(x * weights[:, None], y * weights, rcond=None)[0]


@pytest.mark.parametrize("size", [1, 2, 5, 8])
@pytest.mark.parametrize("forgetting", [1.0, 0.998, 0.9])
def test_is_the_weighted_least_squares_of_all_data(size: int, forgetting: float) -> None:
    x, y = data(size, 500, seed=size)
    p = method(size, forgetting)
    found = follow(p, fresh(p), x, y)
    for step in (40, 200, 500):
        expected = weighted(x[:step], y[:step], forgetting)
        assert found[step - 1] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_is_as_exact_with_regressors_of_a_bad_condition() -> None:
    x, y = data(8, 500, seed=9, condition=1e5)
    p = method(8, 1.0)
    found = follow(p, fresh(p), x, y)[-1]
    rows, right = np.vstack([1e-6 * np.eye(8), x]), np.append(np.zeros(8), y)  # the floor shares in what is so weak
    expected = np.linalg.lstsq(rows, right, rcond=None)[0]
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_with_its_floor_it_is_a_regularised_problem_solved_at_once() -> None:
    size, forgetting, steps = 5, 0.95, 120
    x, y = data(size, steps, seed=3)
    prior, floor = np.linspace(-2.0, 2.0, 8), np.linspace(0.2, 1.0, 8)
    p = method(size, forgetting, floor, prior=prior.tolist())  # type: ignore[arg-type]
    found = follow(p, fresh(p), x, y)
    rows = [floor[n] * np.eye(size)[n] for n in range(size)]
    right, age = [*(floor[:size] * prior[:size])], [0.0] * size
    for k in range(steps):
        n = k % size
        rows += [x[k], floor[n] * np.sqrt(size * (1.0 - forgetting)) * np.eye(size)[n]]
        right += [y[k], rows[-1][n] * found[k, n]]
        age += [k + 1.0, k + 1.0]
    weights = forgetting ** (0.5 * (steps - np.array(age)))
    expected = np.linalg.lstsq(np.array(rows) * weights[:, None], np.array(right) * weights, rcond=None)[0]
    assert found[-1] == pytest.approx(expected, rel=1e-9)
    assert np.abs(found[-1] - weighted(x, y, forgetting)).max() > 1e-3  # the floors are felt


def test_a_million_steps_without_excitation_leave_it_as_it_was() -> None:
    prior = [2.0, -1.0, 0.5, -0.3, 7.0, 0.0, 1.0, 1.0]
    p = method(8, 0.98, 1e-2, prior=prior)
    quiet, noisy = fresh(p), fresh(p)
    assert never_excited.run(p, quiet, LONG, 0.0)[0] == 0.0
    assert never_excited.run(p, noisy, LONG, 0.1)[0] < 0.05  # along the one direction that is excited
    for s in (quiet, noisy):
        assert np.array_equal(s["parameters"][0, 2:], prior[2:])
        assert np.linalg.svd(s["triangle"][0], compute_uv=False).min() > 0.9e-2
        x, y = data(8, 1000, seed=4)
        found = follow(p, s, x, y)
        assert np.abs(found).max() < 20.0  # no burst
        assert found[-1] == pytest.approx(weighted(x, y, 0.98), abs=1e-4)


def test_the_textbook_form_does_not_survive_that() -> None:
    covariance = np.eye(2) * 1e4
    x = np.array([1.0, 2.0])
    for _ in range(4000):
        gain = covariance @ x / (0.98 + x @ covariance @ x)
        covariance = (covariance - np.outer(gain, x @ covariance)) / 0.98
    assert np.abs(covariance).max() > 1e12 or np.linalg.eigvalsh(covariance).min() < 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200, 1e13])
def test_what_is_no_number_or_too_large_is_a_status_and_changes_nothing(bad: float) -> None:
    p = method(3)
    s = fresh(p)
    x, y = data(3, 50, seed=5)
    follow(p, s, x, y)
    for place in range(4):
        s["regressors"][0, :3] = x[0]
        if place < 3:
            s["regressors"][0, place] = bad
        before = s.copy()
        assert least_squares_step.run(p, s, bad if place == 3 else y[0])[0] == NOT_TAKEN
        assert s.tobytes() == before.tobytes()
    s["regressors"][0, :3] = x[0]
    s["regressors"][0, 3:] = np.nan  # places that are not in use do not matter
    assert least_squares_step.run(p, s, y[0])[0] == UPDATED
    assert np.isfinite(s["parameters"]).all()


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_agree_to_the_bit(life: Life) -> None:
    x, y = data(8, 300, seed=6, condition=1e3)
    p = method(8, 0.95, 1e-3)
    states = [fresh(p), fresh(p)]
    one, other = (follow(p, s, x, y, each) for s, each in zip(states, ("compiled", life), strict=True))
    assert one.tobytes() == other.tobytes()
    assert states[0].tobytes() == states[1].tobytes()


class Exported:
    """A kernel of one state in generated C of a precision, called one step at a time."""

    def __init__(self, k: Kernel[..., Any], p: np.ndarray, s: np.ndarray, precision: Precision, *more: float) -> None:
        numbers = [np.array([m], precision.integer_dtype if isinstance(m, int) else precision.real_dtype) for m in more]
        kind = precision.real_dtype if k.result == "float" else precision.integer_dtype
        self.state = precision.convert(s, LeastSquaresState)
        self.arguments = [precision.convert(p, LeastSquares), self.state, *numbers, np.zeros(1, kind)]
        self.entry = ENTRY(host_entry(k, precision))
        self.addresses, self.steps = addresses_of(self.arguments), np.zeros(len(self.arguments), np.int64)

    def __call__(self) -> Any:
        self.entry(self.addresses.ctypes.data, self.steps.ctypes.data, 1)
        return self.arguments[-1][0]


@needs_c
@pytest.mark.parametrize(("condition", "bound"), [(1.0, 5e-6), (100.0, 1e-4)])
def test_float32_in_c_is_within_its_bound(condition: float, bound: float) -> None:
    x, y = data(8, 2000, seed=7, condition=condition)
    p = method(8, 0.99, 1e-3)
    double = follow(p, fresh(p), x, y)
    step = Exported(least_squares_step, p, fresh(p), FLOAT32, 0.0)
    worst = 0.0
    for k in range(len(y)):
        step.state["regressors"][0], step.arguments[2][0] = x[k], y[k]
        assert step() == UPDATED
        if k >= 50:
            worst = max(worst, np.abs(step.state["parameters"][0] - double[k]).max() / np.abs(double[k]).max())
    assert worst < bound


@needs_c
def test_float32_survives_a_million_steps_without_excitation() -> None:
    prior = [2.0, -1.0, 0.5, -0.3, 7.0, 0.0, 1.0, 1.0]
    p = method(8, 0.98, 1e-2, prior=prior)
    single = Exported(never_excited, p, fresh(p), FLOAT32, LONG, 0.1)
    assert single() < 0.05
    kept = single.state["parameters"][0, 2:]
    assert np.array_equal(kept, np.array(prior[2:], np.float32))
    double = Exported(never_excited, p, fresh(p), FLOAT64, 1000, 0.1)
    double()
    assert np.isfinite(single.state["triangle"]).all()
