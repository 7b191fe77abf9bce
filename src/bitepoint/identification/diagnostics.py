"""What residuals and regressors say of a fit: whiteness, influence of inputs that is left, what data cannot tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.identification.arx import Fit
from bitepoint.identification.orders import STABLE
from bitepoint.identification.regression import Roles, Run
from bitepoint.recording import Floats

LAGS = 25
"""Lags of the correlations."""

CONFIDENCE = 1.959964
"""95 % of a normal distribution lie within this many standard deviations."""

LEAST_VARIATION = 0.08
"""Standard deviation over root mean square below which a signal is all but constant (chosen)."""

LARGEST_STANDARD_ERROR = 0.2
"""Relative standard error above which a coefficient is not known (chosen)."""

LARGEST_CONDITION = 1e6
"""Condition number above which columns are all but multiples of each other (chosen)."""


@dataclass(frozen=True)
class Whiteness:
    """Autocorrelation of the residuals of one output.

    Attributes:
        correlation: at lags 1, 2, ...; a white residual stays within +- `band`, 95 % of the time.
        ljung_box: statistic of all lags together; probability: of a larger one if the residual is white.
    """

    output: str
    correlation: Floats
    band: float
    ljung_box: float
    probability: float


@dataclass(frozen=True)
class CrossCorrelation:
    """Correlation of a residual with a past input: at lags 0, 1, ...; what is left beyond `band` was not modelled."""

    output: str
    signal: str
    correlation: Floats
    band: float


def _products(a: Sequence[Floats], b: Sequence[Floats], lag: int) -> float:
    """Return the sum of a(k) b(k - lag) over all runs, none across two of them."""
    return float(sum((x[lag:] * y[: max(len(y) - lag, 0)]).sum() for x, y in zip(a, b, strict=True)))


def whiteness(fit: Fit, lags: int = LAGS) -> list[Whiteness]:
    """Return the whiteness of the residuals, by output; fewer lags where there are fewer rows."""
    from scipy import special

    library: Any = special
    found: list[Whiteness] = []
    lags = min(lags, sum(map(len, fit.residuals)) - 1)
    for n, name in enumerate(fit.model.outputs):
        runs = [
            each[:, n] - np.mean(np.concatenate([other[:, n] for other in fit.residuals])) for each in fit.residuals
        ]
        rows = sum(map(len, runs))
        power = max(_products(runs, runs, 0), 1e-300)
        correlation = np.array([_products(runs, runs, lag) / power for lag in range(1, lags + 1)])
        statistic = rows * (rows + 2) * float((correlation**2 / (rows - np.arange(1, lags + 1))).sum())
        probability = float(library.chdtrc(lags, statistic))
        found.append(Whiteness(name, correlation, CONFIDENCE / math.sqrt(rows), statistic, probability))
    return found


def cross_correlations(fit: Fit, runs: Sequence[Run], roles: Roles, lags: int = LAGS) -> list[CrossCorrelation]:
    """Return the correlation of each residual with each input and disturbance."""
    found: list[CrossCorrelation] = []
    for m, signal in enumerate((*roles.inputs, *roles.disturbances)):
        table = [np.hstack([run.u, run.d])[len(run) - len(e) :, m] for run, e in zip(runs, fit.residuals, strict=True)]
        every = np.concatenate(table)
        changes = [each - every.mean() for each in table]
        for n, name in enumerate(fit.model.outputs):
            residual = [each[:, n] for each in fit.residuals]
            power = math.sqrt(max(_products(residual, residual, 0) * _products(changes, changes, 0), 1e-300))
            correlation = np.array([_products(residual, changes, lag) / power for lag in range(lags + 1)])
            found.append(CrossCorrelation(name, signal, correlation, CONFIDENCE / math.sqrt(len(every))))
    return found


def identifiability(fit: Fit, runs: Sequence[Run], roles: Roles) -> list[str]:
    """Return sentences on what the data cannot tell."""
    warnings: list[str] = []
    columns = roles.columns(fit.model.orders[:3])
    relative = fit.standard_errors / np.maximum(np.abs(fit.coefficients), 1e-300)
    for n, name in enumerate((*roles.inputs, *roles.disturbances)):
        every = np.concatenate([np.hstack([run.u, run.d])[:, n] for run in runs])
        low, high, size = float(every.min()), float(every.max()), float(np.sqrt((every**2).mean()))
        if every.std() < LEAST_VARIATION * size or size == 0.0:
            warnings.append(
                f"{name} is all but constant in training ({low:.4g} to {high:.4g}): its coefficient is not "
                "identifiable, expect large errors where it differs; train with more variation"
            )
        mine = [m for m, (signal, _) in enumerate(columns) if signal == name]
        best = float(relative[:, mine].min())
        if best > LARGEST_STANDARD_ERROR:
            warnings.append(
                f"no coefficient of {name} is known to better than {100 * best:.0f} %: it is hardly identifiable"
            )
    if fit.condition > LARGEST_CONDITION:
        warnings.append(
            f"condition number {fit.condition:.1e}: some columns are all but multiples of others, single "
            "coefficients mean little; lower the orders or excite more"
        )
    largest = float(np.abs(fit.model.poles()[0]))
    if largest > STABLE:
        warnings.append(f"not stable: a pole of magnitude {largest:.3f}; a free run leaves all bounds")
    return warnings
