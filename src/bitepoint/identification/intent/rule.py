"""Tuning of the pedal rule: the baseline of the network, and what stands in for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.identification.intent.launches import Integers
from bitepoint.recording import Floats

LEADS = np.arange(0, 61) / 100.0
CUTS = 400


@dataclass(frozen=True)
class Rule:
    """Numbers of the rule: score = pedal + lead * rate, normal and urgent above their thresholds.

    `accuracy` is that on the data it was tuned on.
    """

    lead: float
    normal: float
    urgent: float
    accuracy: float

    def decide(self, pedal: Floats, rate: Floats) -> Integers:
        """Return intentions from the highest pedal and the highest pedal rate, of one shape."""
        score = pedal + self.lead * rate
        return (score > self.normal).astype(np.int64) + (score > self.urgent)


def tune_rule(pedal: Floats, rate: Floats, intention: Integers) -> Rule:
    """Return the rule that decides most samples rightly, by trying all leads and thresholds of a fine grid.

    Args:
        pedal: highest pedal until each sample, ratio, any shape.
        rate: highest pedal rate until each sample, 1/s, same shape.
        intention: the truth, same shape.
    """
    return max((_thresholds(float(lead), pedal + lead * rate, intention) for lead in LEADS), key=lambda r: r.accuracy)


def _thresholds(lead: float, score: Floats, intention: Integers) -> Rule:
    """Return the best thresholds for one lead.

    Rightly decided are the slow below the first, the normal between, and the urgent above the second one; each count
    is a difference of cumulative ones, so all pairs are tried at once.
    """
    cuts = np.linspace(score.min(), score.max(), CUTS)
    below = np.array([np.searchsorted(np.sort(score[intention == k]), cuts, side="right") for k in range(3)])
    right = below[0][:, None] + (below[1][None, :] - below[1][:, None]) + ((intention == 2).sum() - below[2])[None, :]
    right[np.tril_indices(CUTS, -1)] = -1
    first, second = np.unravel_index(int(np.argmax(right)), right.shape)
    return Rule(lead, float(cuts[first]), float(cuts[second]), float(right[first, second] / score.size))
