"""Least squares of what is never below zero: y = max(0, X c) + e, an engine whose fuel is cut where its line ends."""

from __future__ import annotations

from typing import Any

import numpy as np

from bitepoint.recording import Floats

MOST_ROUNDS = 60
"""Rounds after which the best coefficients so far are taken."""


def clipped_least_squares(x: Floats, y: Floats, least: Floats | None = None) -> Floats:
    """Return the coefficients c that make max(0, x c) closest to y, shape (columns,).

    Rows at which the line is below zero do not pull on it; which ones these are is found by repetition. The result is
    a local minimum; that with the smallest sum of squares of all rounds.

    Args:
        x: shape (n, columns); y: shape (n,), not below zero.
        least: lower bounds of the coefficients, shape (columns,); None: none.
    """
    base = np.zeros(x.shape[1]) if least is None else least
    scale = np.sqrt(np.mean(x**2, axis=0))
    scale[scale == 0.0] = 1.0
    above = np.ones(len(y), bool)
    best, fewest = np.zeros(x.shape[1]), np.inf
    for _ in range(MOST_ROUNDS):
        left = y[above] - x[above] @ base
        found = base + _solved(x[above] / scale, left, least is not None) / scale
        line = x @ found
        squares = float(np.sum((np.maximum(line, 0.0) - y) ** 2))
        if squares < fewest:
            best, fewest = found, squares
        if np.array_equal(line > 0.0, above) or not (line > 0.0).any():
            break
        above = line > 0.0
    return best


def _solved(x: Floats, y: Floats, positive: bool) -> Floats:
    if not positive:
        return np.asarray(np.linalg.lstsq(x.T @ x, x.T @ y, rcond=None)[0], np.float64)
    return positive_least_squares(x, y)


def positive_least_squares(x: Floats, y: Floats) -> Floats:
    """Return the c >= 0 that makes x c closest to y, shape (columns,); x: shape (n, columns)."""
    from scipy import optimize

    library: Any = optimize
    return np.asarray(library.nnls(x, y)[0], np.float64)


def r_squared(measured: Floats, modelled: Floats) -> float:
    """Return 1 - squared errors over squared deviations from the mean; NaN where nothing deviates."""
    spread = float(np.sum((measured - measured.mean()) ** 2))
    return 1.0 - float(np.sum((measured - modelled) ** 2)) / spread if spread > 0.0 else float("nan")
