"""Regression over several runs: which columns a difference model has, and from coefficients to the model.

Columns, in this order, each with its lags 1, 2, ...: outputs, inputs, disturbances (and prediction errors).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.models.arx import ArxModel
from bitepoint.recording import Floats, Recording

Orders = tuple[int, int, int]
"""n_a, n_b, n_g."""


@dataclass(frozen=True)
class Roles:
    """What the signals are to the model, by name."""

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    disturbances: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.outputs, *self.inputs, *self.disturbances)

    def columns(self, orders: Orders) -> list[tuple[str, int]]:
        """Return signal and lag of each column."""
        groups = zip((self.outputs, self.inputs, self.disturbances), orders, strict=True)
        return [(name, lag) for names, order in groups for lag in range(1, order + 1) for name in names]


@dataclass(frozen=True)
class Run:
    """One run: y, u and d of shapes (n, outputs), (n, inputs), (n, disturbances)."""

    y: Floats
    u: Floats
    d: Floats

    @staticmethod
    def of(recording: Recording, roles: Roles) -> Run:
        """Return the signals of a recording."""
        groups = (roles.outputs, roles.inputs, roles.disturbances)
        y, u, d = (np.ascontiguousarray(np.array([recording[name] for name in names]).T) for names in groups)
        return Run(y, u, d)

    def __len__(self) -> int:
        return len(self.y)


def regressors(run: Run, orders: Orders, first: int, outputs: Floats | None = None) -> Floats:
    """Return the columns for the rows from `first` on, shape (n - first, columns).

    Args:
        outputs: what stands for y in the columns; None: y itself.
    """
    n = len(run)
    groups = zip((run.y if outputs is None else outputs, run.u, run.d), orders, strict=True)
    return np.hstack([signal[first - i : n - i] for signal, order in groups for i in range(1, order + 1)])


def stacked(runs: Sequence[Run], orders: Orders, first: int) -> tuple[Floats, Floats]:
    """Return columns and outputs of all runs, one below the other."""
    columns = np.vstack([regressors(run, orders, first) for run in runs])
    return columns, np.vstack([run.y[first:] for run in runs])


def model_of(
    theta: Floats, orders: Orders, roles: Roles, period: float, errors: Floats | None = None,
    about: Mapping[str, Any] | None = None,
) -> ArxModel:  # fmt: skip
    """Return the model with coefficients theta, shape (outputs, columns), and C, shape (n_c, outputs, outputs)."""
    rows, start = len(roles.outputs), 0
    parts: list[Floats] = []
    for width, order in zip((rows, len(roles.inputs), len(roles.disturbances)), orders, strict=True):
        block = theta[:, start : start + width * order]
        parts.append(np.ascontiguousarray(block.reshape(rows, order, width).transpose(1, 0, 2)))
        start += width * order
    c = np.zeros((0, rows, rows)) if errors is None else errors
    p, q, g = parts
    return ArxModel(roles.outputs, roles.inputs, roles.disturbances, period, p, q, g, c, about or {})
