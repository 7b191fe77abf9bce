"""Figures of an intention estimator: how often it is right, what it takes for what, and when it has decided."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.identification.intent.launches import PERIOD, Integers, Launches
from bitepoint.recording import Floats

INSTANTS = (27, 49, 79, 99, 199)
"""Samples of the window that tables show: 0.28 s, 0.5 s, 0.8 s, 1 s and 2 s after pedal onset."""


@dataclass(frozen=True)
class Figures:
    """Figures over windows of one lot of launches.

    Attributes:
        accuracy: share of samples, from the network's first decision on, that are decided rightly.
        accuracy_at: share of launches decided rightly at each sample of the window, shape (samples,).
        plain_at, other_at: the same of launches with a plain press, and of all others.
        first, last: launches by truth (row) and intention (column), at the network's first decision and at the end of
            the window, shape (3, 3).
        settled: time from pedal onset after which the intention no longer changes, s, shape (n,).
    """

    accuracy: float
    accuracy_at: Floats
    plain_at: Floats
    other_at: Floats
    first: Integers
    last: Integers
    settled: Floats

    def summary(self) -> dict[str, Any]:
        """Return what tables show, rounded."""
        return {
            "accuracy": round(self.accuracy, 4),
            "accuracy_at": _at_instants(self.accuracy_at),
            "plain_at": _at_instants(self.plain_at),
            "other_at": _at_instants(self.other_at),
            "first": self.first.tolist(),
            "last": self.last.tolist(),
            "settled": [round(float(np.quantile(self.settled, share)), 2) for share in (0.5, 0.75, 0.9)],
        }


def figures(decided: Integers, launches: Launches, first: int, opening: int) -> Figures:
    """Return the figures.

    Args:
        decided: intention told at each sample of each window, shape (n, samples).
        launches: that these are the windows of.
        first: sample of the network's first decision.
        opening: sample of the first decision of this estimator.
    """
    truth = launches.intention
    right = decided == truth[:, None]
    changed = np.diff(decided[:, opening:], axis=1) != 0
    last_change = np.where(changed.any(axis=1), changed.shape[1] - np.argmax(changed[:, ::-1], axis=1), 0)
    return Figures(
        accuracy=float(right[:, first:].mean()),
        accuracy_at=right.mean(axis=0),
        plain_at=right[launches.plain].mean(axis=0),
        other_at=right[~launches.plain].mean(axis=0),
        first=confusion(decided[:, first], truth),
        last=confusion(decided[:, -1], truth),
        settled=(opening + 1 + last_change) * PERIOD,
    )


def confusion(decided: Integers, truth: Integers) -> Integers:
    """Return the counts by truth (row) and decision (column), shape (3, 3)."""
    counts = np.zeros((3, 3), np.int64)
    np.add.at(counts, (truth, decided), 1)
    return counts


def _at_instants(values: Floats) -> list[float]:
    return [round(float(values[sample]), 4) for sample in INSTANTS]
