"""Fits against systems that are known, and against an independent computation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bitepoint.identification.armax import fit_armax
from bitepoint.identification.arx import Fit, fit_arx, information
from bitepoint.identification.delays import estimate_delay
from bitepoint.identification.diagnostics import cross_correlations, identifiability, whiteness
from bitepoint.identification.orders import best_orders, try_orders
from bitepoint.identification.regression import Orders, Roles, Run, regressors, stacked
from bitepoint.identification.validation import errors_of
from bitepoint.models.arx import ArxModel

ROLES = Roles(("engine_speed", "slip"), ("clutch_torque",), ("engine_torque", "load_torque"))
P = np.array([[[1.2, 0.1], [0.0, 1.1]], [[-0.4, 0.0], [0.05, -0.3]]])
Q = np.array([[[-0.5], [-0.8]]])
G = np.array([[[0.4, 0.0], [0.3, 0.02]]])
C = np.array([[[-0.6, 0.1], [0.0, 0.4]]])


def system(c: np.ndarray | None = None, p: np.ndarray = P) -> ArxModel:
    errors = np.zeros((0, 2, 2)) if c is None else c
    return ArxModel(ROLES.outputs, ROLES.inputs, ROLES.disturbances, 0.01, p, Q, G, errors)


def simulated(
    model: ArxModel, lengths: tuple[int, ...], noise: float, seed: int = 1, *, on_output: bool = False
) -> list[Run]:
    """Runs of a model with white noise in its equation, or on its outputs."""
    rng = np.random.default_rng(seed)
    runs: list[Run] = []
    for n in lengths:
        u, d = np.repeat(rng.normal(50.0, 8.0, (n // 5 + 1, 1)), 5, axis=0)[:n], rng.normal(50.0, 10.0, (n, 2))
        y, e = np.zeros((n, 2)), noise * rng.standard_normal((n, 2))
        for k in range(2, n):
            y[k] = sum(m @ y[k - i] for i, m in enumerate(model.past_outputs, 1))
            y[k] += model.past_inputs[0] @ u[k - 1] + model.past_disturbances[0] @ d[k - 1]
            if not on_output:
                y[k] += e[k] + sum(m @ e[k - i] for i, m in enumerate(model.past_errors, 1))
        runs.append(Run(y + e if on_output else y, u, d))
    return runs


def distance(fit: Fit, truth: ArxModel) -> float:
    """Largest error of a coefficient in standard errors."""
    blocks = [np.hstack(list(m)) for m in (truth.past_outputs, truth.past_inputs, truth.past_disturbances)]
    return float(np.abs((fit.coefficients - np.hstack(blocks)) / fit.standard_errors).max())


def test_least_squares_is_that_of_numpy_over_stacked_runs() -> None:
    runs = simulated(system(), (60, 90, 40), 0.3)
    fit = fit_arx(runs, ROLES, (2, 1, 1), 0.01, "least squares")
    x = np.vstack([np.hstack([r.y[1:-1], r.y[:-2], r.u[1:-1], r.d[1:-1]]) for r in runs])
    y = np.vstack([r.y[2:] for r in runs])
    by_numpy, squares, _, _ = np.linalg.lstsq(x, y, rcond=None)
    assert fit.coefficients == pytest.approx(by_numpy.T, rel=1e-9)
    assert sum((e**2).sum() for e in fit.residuals) == pytest.approx(squares.sum())
    spread = np.sqrt(np.outer(squares / (len(x) - 7), np.diag(np.linalg.inv(x.T @ x))))
    assert fit.standard_errors == pytest.approx(spread, rel=1e-6)


def test_least_squares_finds_a_noise_free_system() -> None:
    fit = fit_arx(simulated(system(), (80, 50), 0.0), ROLES, (2, 1, 1), 0.01, "least squares")
    assert fit.model.past_outputs == pytest.approx(P, abs=1e-9)
    assert fit.model.past_inputs == pytest.approx(Q, abs=1e-9)
    assert fit.model.past_disturbances == pytest.approx(G, abs=1e-9)
    assert fit.parameters == 14


def test_no_row_is_predicted_across_two_runs() -> None:
    runs = simulated(system(), (30, 40), 0.1)
    x, y = stacked(runs, (2, 1, 1), 2)
    assert len(x) == len(y) == 28 + 38
    assert np.array_equal(x[28], regressors(runs[1], (2, 1, 1), 2)[0])
    assert [len(e) for e in fit_arx(runs, ROLES, (2, 1, 1), 0.01, "least squares").residuals] == [28, 38]


def test_standard_errors_are_those_of_many_experiments() -> None:
    fits = [fit_arx(simulated(system(), (150,), 0.5, s), ROLES, (2, 1, 1), 0.01, "least squares") for s in range(60)]
    scatter = np.std([fit.coefficients for fit in fits], axis=0)
    stated = np.mean([fit.standard_errors for fit in fits], axis=0)
    assert (scatter / stated).mean() == pytest.approx(1.0, abs=0.15)
    assert max(distance(fit, system()) for fit in fits) < 6.0


def test_noise_on_the_outputs_biases_least_squares_and_not_the_instruments() -> None:
    runs = simulated(system(), (400,) * 5, 2.0, on_output=True)
    plain = fit_arx(runs, ROLES, (2, 1, 1), 0.01, "least squares")
    better = fit_arx(runs, ROLES, (2, 1, 1), 0.01, "instruments")
    assert distance(plain, system()) > 20.0
    assert distance(better, system()) < 4.0
    assert np.abs(better.model.past_outputs - P).max() < 0.1 < 0.3 < np.abs(plain.model.past_outputs - P).max()
    assert fit_arx(runs, ROLES, (2, 1, 1), 0.01).method == "instruments"


def test_armax_finds_the_moving_average() -> None:
    truth = system(C)
    fit = fit_armax(simulated(truth, (700, 500, 300), 0.5), ROLES, (2, 1, 1), 1, 0.01)
    assert fit.model.kind == "armax"
    assert fit.model.orders == (2, 1, 1, 1)
    assert fit.model.past_errors == pytest.approx(C, abs=0.1)
    assert distance(fit, truth) < 4.0
    assert all(check.probability > 0.001 for check in whiteness(fit))
    assert fit.parameters == 18


def test_armax_on_output_noise_has_the_poles_as_its_moving_average() -> None:
    fit = fit_armax(simulated(system(), (700, 500), 1.0, on_output=True), ROLES, (2, 1, 1), 2, 0.01)
    assert fit.model.past_outputs == pytest.approx(P, abs=0.1)
    assert fit.model.past_errors == pytest.approx(-P, abs=0.15)


@pytest.mark.parametrize("orders", [(1, 1, 1), (2, 1, 1), (3, 1, 1)])
def test_the_criteria_pick_the_true_orders(orders: Orders) -> None:
    past = {
        1: np.array([[[0.8, 0.1], [0.0, 0.7]]]), 2: P, 3: np.concatenate([P, [[[0.1, 0.0], [0.0, -0.1]]]]),
    }[orders[0]]  # fmt: skip
    found = try_orders(simulated(system(p=past), (600, 400), 0.5), ROLES, 0.01)
    assert min(found, key=lambda candidate: candidate.bic).orders == orders
    best = best_orders(found)  # Akaike's criterion takes a column too many one time in six, but never one too few
    assert best[0] == orders[0]
    assert all(a >= b for a, b in zip(best, orders, strict=True))
    assert found[0].orders == best
    truth = next(candidate for candidate in found if candidate.orders == orders)
    assert truth.aic - found[0].aic < 10.0
    assert len(found) == 36


def test_the_criteria_are_those_of_the_fits_over_the_same_rows() -> None:
    runs = simulated(system(), (100, 60), 0.5)
    aic, bic = information(8.0, 100, 14)
    assert aic == pytest.approx(28 + 100 * np.log(0.08))
    assert bic == pytest.approx(14 * np.log(100) + 100 * np.log(0.08))
    found = {candidate.orders: candidate for candidate in try_orders(runs, ROLES, 0.01, highest=(2, 1, 1))}
    fit = fit_arx(runs, ROLES, (2, 1, 1), 0.01, "least squares")
    assert found[2, 1, 1].aic == pytest.approx(fit.aic)
    assert found[2, 1, 1].bic == pytest.approx(fit.bic)
    shorter = [replace(run, y=run.y[1:], u=run.u[1:], d=run.d[1:]) for run in runs]
    assert found[1, 1, 1].aic == pytest.approx(fit_arx(shorter, ROLES, (1, 1, 1), 0.01, "least squares").aic)


def test_residuals_of_the_true_orders_are_white_and_those_of_too_low_ones_are_not() -> None:
    runs = simulated(system(), (800, 700), 0.5)
    for orders, white in (((2, 1, 1), True), ((1, 1, 1), False)):
        fit = fit_arx(runs, ROLES, orders, 0.01, "least squares")
        checks = whiteness(fit)
        assert all((check.probability > 0.01) is white for check in checks)
        beyond = np.mean([np.abs(check.correlation) > check.band for check in checks])
        assert bool(beyond < 0.15) is white


def test_ljung_box_has_its_distribution() -> None:
    rng = np.random.default_rng(2)
    fit = fit_arx(simulated(system(), (300,), 0.5), ROLES, (2, 1, 1), 0.01, "least squares")
    p = [c.probability for _ in range(100) for c in whiteness(replace(fit, residuals=(rng.standard_normal((400, 2)),)))]
    assert np.mean(np.array(p) < 0.1) == pytest.approx(0.1, abs=0.06)
    assert np.mean(p) == pytest.approx(0.5, abs=0.08)


def test_runs_shorter_than_the_lags_count_where_they_reach() -> None:
    runs = simulated(system(), (21, 9, 60), 0.5)
    fit = fit_arx(runs, ROLES, (2, 1, 1), 0.01, "least squares")
    long = [each[:, 0] - np.concatenate([e[:, 0] for e in fit.residuals]).mean() for each in fit.residuals]
    power = sum(float(e @ e) for e in long)
    for lag in (8, 20, 25):
        product = sum(float(e[lag:] @ e[:-lag]) for e in long if len(e) > lag)
        assert whiteness(fit)[0].correlation[lag - 1] == pytest.approx(product / power)
    assert all(np.isfinite(each.correlation).all() for each in cross_correlations(fit, runs, ROLES))
    few = fit_arx(runs[:1], ROLES, (2, 1, 1), 0.01, "least squares")
    assert len(whiteness(few)[0].correlation) == 18


def test_what_an_input_still_explains_shows_in_the_correlation() -> None:
    runs = simulated(system(), (500,), 0.5)
    late = [Run(run.y, np.vstack([run.u[:1]] * 2 + [run.u[:-2]]), run.d) for run in runs]
    good, bad = (
        max(np.abs(each.correlation[1:]).max() / each.band for each in cross_correlations(fit, data, ROLES))
        for data in (runs, late)
        for fit in (fit_arx(data, ROLES, (2, 1, 1), 0.01, "least squares"),)
    )
    assert good < 2.0
    assert bad > 2.5


def test_what_the_data_cannot_tell_is_told() -> None:
    runs = simulated(system(), (200, 100), 0.5)
    assert identifiability(fit_arx(runs, ROLES, (2, 1, 1), 0.01), runs, ROLES) == []
    flat = [Run(run.y, run.u, np.column_stack([run.d[:, 0], 82.0 + 0.01 * run.d[:, 1]])) for run in runs]
    warnings = identifiability(fit_arx(flat, ROLES, (2, 1, 1), 0.01), flat, ROLES)
    assert any(w.startswith("load_torque is all but constant in training (82.") for w in warnings)
    same = [Run(run.y, run.u, np.column_stack([run.d[:, 0], 2.0 * run.d[:, 0]])) for run in runs]
    assert any("condition number" in w for w in identifiability(fit_arx(same, ROLES, (2, 1, 1), 0.01), same, ROLES))
    fit = fit_arx(runs, ROLES, (2, 1, 1), 0.01)
    unstable = replace(fit, model=system(p=2.0 * P))
    assert any("not stable" in w for w in identifiability(unstable, runs, ROLES))


def test_errors_are_those_of_the_predictions() -> None:
    runs = simulated(system(), (60, 40), 0.5)
    errors = errors_of(system(), runs)
    one = np.vstack([(run.y - system().one_step(run.y, run.u, run.d))[2:] for run in runs])
    free = np.vstack([(run.y - system().free_run(run.y, run.u, run.d))[2:] for run in runs])
    for n, name in enumerate(ROLES.outputs):
        assert errors[name].one_step_rms == pytest.approx(np.sqrt((one[:, n] ** 2).mean()))
        assert errors[name].free_run_max == pytest.approx(np.abs(free[:, n]).max())
    assert errors["slip"].one_step_rms == pytest.approx(0.5, rel=0.2)
    assert errors_of(system(p=50.0 * P), simulated(system(), (400,), 0.5))["slip"].free_run_max == np.inf


@pytest.mark.parametrize("rows", [-4, 0, 1, 5])
def test_a_delay_of_the_torque_is_found(rows: int) -> None:
    rng = np.random.default_rng(3)
    torque = np.repeat(rng.normal(50.0, 8.0, 200), 6)
    speed = np.concatenate([[150.0], 150.0 + np.cumsum(0.036 * (50.0 - torque))[:-1]]) + 0.1 * rng.standard_normal(1200)
    logged = np.roll(torque, rows)[20:-20]
    run = Run(np.column_stack([speed, speed])[20:-20], logged[:, np.newaxis], np.zeros((1160, 2)))
    found = estimate_delay([run], "clutch_torque", "engine_speed", 0.01)
    assert found is not None
    assert found.delay == pytest.approx(0.01 * rows)
    assert found.correlation < 0.0
    noise = Run(rng.normal(size=(1000, 2)), rng.normal(size=(1000, 1)), np.zeros((1000, 2)))
    assert estimate_delay([noise], "clutch_torque", "engine_speed", 0.01) is None
