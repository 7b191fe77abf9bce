"""ARMAX models: ARX with a moving average of the prediction errors, fitted by the prediction-error method.

    e(k) = y(k) - theta x(k) - sum_i C_i e(k-i)

is made least in its weighted sum of squares over theta and C [1, sec. 7.2], by Levenberg and Marquardt's method with
exact derivatives, which obey the same recursion. White noise on the outputs is the case C_i = -P_i.

[1] Ljung, System Identification: Theory for the User, 2nd ed., 1999.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bitepoint.identification.arx import Fit, fit_arx
from bitepoint.identification.regression import Orders, Roles, Run, model_of, regressors
from bitepoint.recording import Floats

_linalg: Any = np.linalg

LARGEST = 1e6
"""Prediction error that stands for all larger ones: an unstable C."""

START = 0.8
"""Share of -P_i that C_i starts from."""


def fit_armax(runs: Sequence[Run], roles: Roles, orders: Orders, moving_average: int, period: float) -> Fit:
    """Return the ARMAX model of the runs.

    Args:
        runs: each longer than the largest order.
        orders: n_a, n_b, n_g; moving_average: n_c, 1 or more.
    """
    from scipy import optimize

    library: Any = optimize
    start = fit_arx(runs, roles, orders, period)
    problem = _Problem(runs, orders, moving_average, start.residuals)
    past = start.model.past_outputs[:moving_average]
    guess = np.zeros((moving_average, *past.shape[1:]))
    guess[: len(past)] = [-(START**i) * p for i, p in enumerate(past, 1)]
    best: Any = None
    for c in (np.zeros_like(guess), guess):
        found = library.least_squares(
            problem.errors, np.concatenate([start.coefficients.ravel(), c.ravel()]), problem.jacobian, method="lm",
            x_scale="jac", ftol=1e-7, xtol=1e-7, max_nfev=60,
        )  # fmt: skip
        best = found if best is None or found.cost < best.cost else best
    theta, c = problem.split(best.x)
    rows = problem.rows
    noise = 2.0 * best.cost / max(rows * theta.shape[0] - best.x.size, 1)
    jacobian: Floats = best.jac
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    covariance: Floats = _linalg.pinv((jacobian / scale).T @ (jacobian / scale))
    spread = np.sqrt(np.maximum(np.diag(covariance) * noise, 0.0)) / scale
    model = model_of(theta, orders, roles, period, c)
    errors = tuple(run.y[problem.first :] - model.one_step(run.y, run.u, run.d)[problem.first :] for run in runs)
    standard = spread[: theta.size].reshape(theta.shape)
    return Fit(model, "prediction error", errors, theta, standard, start.condition, int(best.x.size))


class _Problem:
    """Prediction errors and their derivatives; all runs advance together, shorter ones padded with zeros."""

    def __init__(
        self, runs: Sequence[Run], orders: Orders, moving_average: int, residuals: Sequence[Floats]
    ) -> None:  # fmt: skip
        self.first = max(*orders, moving_average)
        columns = [regressors(run, orders, self.first) for run in runs]
        longest = max(map(len, columns))
        self.lanes, self.width, self.outputs = len(runs), columns[0].shape[1], runs[0].y.shape[1]
        self.moving_average = moving_average
        self.x = np.zeros((longest, self.lanes, self.width))
        self.y = np.zeros((longest, self.lanes, self.outputs))
        self.there = np.zeros((longest, self.lanes), bool)
        for lane, (run, rows) in enumerate(zip(runs, columns, strict=True)):
            self.x[: len(rows), lane], self.y[: len(rows), lane] = rows, run.y[self.first :]
            self.there[: len(rows), lane] = True
        self.rows = int(self.there.sum())
        covariance = np.cov(np.vstack(residuals).T).reshape(self.outputs, self.outputs)
        floor = 1e-12 * np.trace(covariance) + 1e-300
        self.weight: Floats = _linalg.inv(_linalg.cholesky(covariance + floor * np.eye(self.outputs)))

    def split(self, point: Floats) -> tuple[Floats, Floats]:
        """Return theta and C of a point."""
        count = self.outputs * self.width
        theta = point[:count].reshape(self.outputs, self.width)
        return theta, point[count:].reshape(self.moving_average, self.outputs, self.outputs)

    def errors(self, point: Floats) -> Floats:
        """Return the weighted prediction errors of all rows, in one line."""
        return (self._errors(point)[self.moving_average :][self.there] @ self.weight.T).ravel()

    def _errors(self, point: Floats) -> Floats:
        """Return the prediction errors, shape (n_c + steps, runs, outputs), those before the first row zero."""
        theta, c = self.split(point)
        m = self.moving_average
        e = np.zeros((m + len(self.x), self.lanes, self.outputs))
        e[m:] = self.y - self.x @ theta.T
        for k in range(m, len(e)):
            for i in range(m):
                e[k] -= e[k - 1 - i] @ c[i].T
            np.clip(e[k], -LARGEST, LARGEST, out=e[k])
        return e

    def jacobian(self, point: Floats) -> Floats:
        """Return their derivatives, shape (rows * outputs, parameters)."""
        theta, c = self.split(point)
        m, count = self.moving_average, theta.size
        e = self._errors(point)
        s = np.zeros((m + len(self.x), self.outputs, self.lanes, point.size))
        for a in range(self.outputs):
            s[m:, a, :, a * self.width : (a + 1) * self.width] = -self.x
            for i in range(m):
                place = count + (i * self.outputs + a) * self.outputs
                s[m:, a, :, place : place + self.outputs] = -e[m - 1 - i : len(e) - 1 - i]
        flat = s.reshape(len(s), self.outputs, -1)
        for k in range(m, len(s)):
            for i in range(m):
                flat[k] -= c[i] @ flat[k - 1 - i]
            np.clip(flat[k], -(LARGEST**2), LARGEST**2, out=flat[k])
        slopes = s[m:].transpose(0, 2, 1, 3)[self.there]
        return np.einsum("ab,nbp->nap", self.weight, slopes).reshape(-1, point.size)
