"""Cross-validation within the training logs: what a model is worth on rows that it was not fitted on.

The folds are the logs, one left out at a time (a single log is cut into four), and one more: the fifth of the rows with
the highest specific power, after a fit on the others. The last one asks what a harder drive will ask.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from bitepoint.identification.fuel.drives import Drive, Rows
from bitepoint.recording import Floats

PIECES = 4
"""Pieces of a single log."""

HARDEST = 0.2
"""Share of the rows that makes up the hardest fold."""

Fit = Callable[[Drive], Callable[[Drive], Floats]]
"""From rows to a function from rows to their fuel."""


def folds_of(drive: Drive) -> list[Rows]:
    """Return which rows are left out in each fold; the last is the hardest."""
    groups = drive.run
    if len(np.unique(groups)) < 2:
        groups = np.arange(len(drive)) * PIECES // len(drive)
    power = drive.specific_power
    return [*(groups == each for each in np.unique(groups)), power > np.quantile(power, 1.0 - HARDEST)]


def fold_scores(fit: Fit, drive: Drive, folds: Sequence[Rows]) -> Floats:
    """Return for each fold 1 - squared errors over squared deviations from the mean of all rows, shape (folds,)."""
    mean = float(drive.fuel.mean())
    scores: list[float] = []
    for left_out in folds:
        found = fit(drive.rows(~left_out))
        tested = drive.rows(left_out)
        spread = float(np.sum((tested.fuel - mean) ** 2))
        errors = float(np.sum((tested.fuel - found(tested)) ** 2))
        scores.append(1.0 - errors / spread if spread > 0.0 else 0.0)
    return np.array(scores)
