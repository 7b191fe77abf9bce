"""Figures of an intention estimator: how often it is right, what it takes for what, and when it has decided."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.identification.intent.launches import PERIOD, Integers
from bitepoint.recording import Floats


@dataclass(frozen=True)
class Figures:
    """Figures over windows of one lot of launches.

    Attributes:
        accuracy: share of samples, from the first decision on, that are decided rightly.
        accuracy_at: the same for each sample of the window, shape (samples,).
        confusion: launches by truth (row) and by the intention told at the end of the window (column), shape (3, 3).
        settled: time from pedal onset after which the intention no longer changes, s, shape (n,); not before the
            first decision.
        changes: changes of the intention after the first decision, shape (n,).
    """

    accuracy: float
    accuracy_at: Floats
    confusion: Integers
    settled: Floats
    changes: Integers


def figures(decided: Integers, truth: Integers, first: int) -> Figures:
    """Return the figures.

    Args:
        decided: intention told at each sample of each window, shape (n, samples).
        truth: shape (n,).
        first: sample from which on decisions count: of the first decision of the network.
    """
    right = decided == truth[:, None]
    changed = np.diff(decided[:, first:], axis=1) != 0
    last_change = np.where(changed.any(axis=1), changed.shape[1] - np.argmax(changed[:, ::-1], axis=1), 0)
    return Figures(
        accuracy=float(right[:, first:].mean()),
        accuracy_at=right.mean(axis=0),
        confusion=confusion(decided[:, -1], truth),
        settled=(first + 1 + last_change) * PERIOD,
        changes=changed.sum(axis=1),
    )


def confusion(decided: Integers, truth: Integers) -> Integers:
    """Return the counts by truth (row) and decision (column), shape (3, 3)."""
    counts = np.zeros((3, 3), np.int64)
    np.add.at(counts, (truth, decided), 1)
    return counts
