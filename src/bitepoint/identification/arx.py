"""ARX models with measured disturbances, from several runs.

Least squares is right where the noise enters the equation. Where it sits on the measured outputs instead, they are
noisy regressors, and least squares is biased; instruments are then right: the same equations, multiplied by regressors
whose outputs are simulated by the model, and so free of the noise [1, sec. 7.6]. Both are fitted; the one that
simulates the training runs better is taken.

[1] Ljung, System Identification: Theory for the User, 2nd ed., 1999.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.identification.regression import Orders, Roles, Run, model_of, regressors, stacked
from bitepoint.models.arx import ArxModel
from bitepoint.recording import Floats

_linalg: Any = np.linalg

METHODS = ("auto", "least squares", "instruments")
"""How an ARX model can be fitted."""

PASSES = 5
"""Times that the instruments are made anew from the latest model."""


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Attributes:
        method: how it was fitted.
        residuals: one-step prediction errors of each run, shape (n - warm-up, outputs).
        standard_errors: of the coefficients of outputs, inputs and disturbances, shape (outputs, columns).
        coefficients: these coefficients, likewise.
        condition: condition number of the columns, each scaled to unit length.
        parameters: number of coefficients, C included.
    """

    model: ArxModel
    method: str
    residuals: tuple[Floats, ...]
    coefficients: Floats
    standard_errors: Floats
    condition: float
    parameters: int

    @property
    def aic(self) -> float:
        """Akaike's criterion."""
        return self._information()[0]

    @property
    def bic(self) -> float:
        """Schwarz's criterion."""
        return self._information()[1]

    def _information(self) -> tuple[float, float]:
        squares = sum(float((each**2).sum()) for each in self.residuals)
        return information(squares, sum(each.size for each in self.residuals), self.parameters)


def information(squares: float, n: int, k: int) -> tuple[float, float]:
    """Return AIC = 2 k + n ln(S / n) and BIC = k ln(n) + n ln(S / n).

    Args:
        squares: S, the sum of all n squared residuals, those of every output; k: number of coefficients.
    """
    fit = n * math.log(max(squares / n, 1e-300))
    return 2.0 * k + fit, k * math.log(n) + fit


def fit_arx(runs: Sequence[Run], roles: Roles, orders: Orders, period: float, method: str = "auto") -> Fit:
    """Return the ARX model of the runs.

    Args:
        runs: each longer than the largest order.
        method: one of `METHODS`; "auto" takes what simulates the runs better.
    """
    plain = least_squares(runs, roles, orders, period)
    if method == "least squares":
        return plain
    better = instruments(runs, roles, orders, period, plain.model)
    if better is None:
        return plain
    if method == "instruments":
        return better
    return min((plain, better), key=lambda fit: free_run_loss(fit.model, runs))


def least_squares(runs: Sequence[Run], roles: Roles, orders: Orders, period: float) -> Fit:
    """Return the least-squares fit; columns are scaled to unit length before."""
    first = max(orders)
    x, y = stacked(runs, orders, first)
    scale = np.maximum(np.linalg.norm(x, axis=0), 1e-300)
    solution: Floats
    singular: Floats
    solution, _, _, singular = _linalg.lstsq(x / scale, y, rcond=None)
    theta = solution.T / scale
    inverse: Floats = _linalg.pinv((x / scale).T @ (x / scale))
    spread = np.sqrt(np.maximum(np.diag(inverse), 0.0)) / scale
    return _fit("least squares", theta, spread, singular, runs, (roles, orders, period, first))


def instruments(
    runs: Sequence[Run], roles: Roles, orders: Orders, period: float, start: ArxModel
) -> Fit | None:  # fmt: skip
    """Return the fit by instruments, begun with a model; None where that leads nowhere (no noise, or unstable)."""
    first = max(orders)
    x, y = stacked(runs, orders, first)
    scale = np.maximum(np.linalg.norm(x, axis=0), 1e-300)
    singular: Floats = _linalg.svd(x / scale, compute_uv=False)
    model, theta, spread = start, start.past_outputs, scale
    for _ in range(PASSES):
        simulated = [model.free_run(run.y, run.u, run.d) for run in runs]
        z = np.vstack([regressors(run, orders, first, s) for run, s in zip(runs, simulated, strict=True)])
        if not np.isfinite(z).all() or np.abs(z).max() > 1e9:
            return None
        z = z / np.maximum(np.linalg.norm(z, axis=0), 1e-300)
        moments = z.T @ (x / scale)
        if _linalg.cond(moments) > 1e14:
            return None
        inverse: Floats = _linalg.inv(moments)
        theta = (inverse @ z.T @ y).T / scale
        spread = np.sqrt(np.maximum(np.diag(inverse @ (z.T @ z) @ inverse.T), 0.0)) / scale
        model = model_of(theta, orders, roles, period)
    return _fit("instruments", theta, spread, singular, runs, (roles, orders, period, first))


def _fit(
    method: str, theta: Floats, spread: Floats, singular: Floats, runs: Sequence[Run],
    setting: tuple[Roles, Orders, float, int],
) -> Fit:  # fmt: skip
    """Return a fit with its residuals; `spread` is the standard error of the coefficients over that of the noise."""
    roles, orders, period, first = setting
    residuals = tuple(run.y[first:] - regressors(run, orders, first) @ theta.T for run in runs)
    every = np.vstack(residuals)
    freedom = max(len(every) - theta.shape[1], 1)
    noise = np.sqrt((every**2).sum(axis=0) / freedom)
    condition = float(singular[0] / max(singular[-1], 1e-300))
    model = model_of(theta, orders, roles, period)
    return Fit(model, method, residuals, theta, noise[:, np.newaxis] * spread, condition, theta.size)


def free_run_loss(model: ArxModel, runs: Sequence[Run]) -> float:
    """Return the mean square of the free-run errors over all runs, each output in units of its own spread."""
    total, count = 0.0, 0
    spread = np.maximum(np.vstack([run.y for run in runs]).std(axis=0), 1e-9)
    for run in runs:
        error = (run.y - model.free_run(run.y, run.u, run.d)) / spread
        with np.errstate(over="ignore", invalid="ignore"):
            total += float((error**2).sum())
        count += error.size
    return total / count if math.isfinite(total) else math.inf
