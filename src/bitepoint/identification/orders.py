"""Search of the orders by information criteria."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from bitepoint.identification.arx import information
from bitepoint.identification.regression import Orders, Roles, Run, model_of, stacked
from bitepoint.recording import Floats

HIGHEST: Orders = (4, 3, 3)
"""Highest orders that are tried."""

STABLE = 1.02
"""Magnitude of a pole above which a model is not stable; those of a vehicle that coasts lie close to 1."""


@dataclass(frozen=True)
class Candidate:
    """Orders that were tried: criteria of the least-squares fit, and the magnitude of the largest pole."""

    orders: Orders
    parameters: int
    aic: float
    bic: float
    largest_pole: float

    @property
    def stable(self) -> bool:
        """Whether a free run can be expected to stay finite."""
        return self.largest_pole <= STABLE


def try_orders(runs: Sequence[Run], roles: Roles, period: float, highest: Orders = HIGHEST) -> list[Candidate]:
    """Return all orders up to the highest ones with their criteria, each over the same rows, the best AIC first.

    Without the same rows a higher order would win by predicting fewer.
    """
    first, largest = max(highest), roles.columns(highest)
    x, y = stacked(runs, highest, first)
    scale = np.maximum(np.linalg.norm(x, axis=0), 1e-300)
    # the triangle holds all that least squares needs of the rows
    triangle = cast("Floats", np.linalg.qr(np.hstack([x / scale, y]), mode="r"))
    found: list[Candidate] = []
    for n_a, n_b, n_g in itertools.product(*(range(1, order + 1) for order in highest)):
        orders = (n_a, n_b, n_g)
        columns = [largest.index(column) for column in roles.columns(orders)]
        solution = np.linalg.lstsq(triangle[:, columns], triangle[:, len(largest) :], rcond=None)[0]
        left = triangle[:, len(largest) :] - triangle[:, columns] @ solution
        theta = np.ascontiguousarray((solution / scale[columns, np.newaxis]).T)
        aic, bic = information(float((left**2).sum()), y.size, theta.size)
        pole = float(np.abs(model_of(theta, orders, roles, period).poles()[0]))
        found.append(Candidate(orders, theta.size, aic, bic, pole))
    return sorted(found, key=lambda candidate: candidate.aic)


def best_orders(candidates: Sequence[Candidate]) -> Orders:
    """Return the orders of the lowest AIC among stable models; among all where none is stable."""
    return min(candidates, key=lambda candidate: (not candidate.stable, candidate.aic)).orders
