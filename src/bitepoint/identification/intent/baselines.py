"""What the network is held to: the pedal rule, which also stands in for it, and a linear discriminant.

The discriminant is fitted anew for each instant of the window, from five numbers: what can be had without memory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.identification.intent.decisions import Windows
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
    cuts: Floats = np.linspace(float(score.min()), float(score.max()), CUTS)
    below: Integers = np.array([np.searchsorted(np.sort(score[intention == k]), cuts, side="right") for k in range(3)])
    right = below[0][:, None] + (below[1][None, :] - below[1][:, None]) + ((intention == 2).sum() - below[2])[None, :]
    right[np.tril_indices(CUTS, -1)] = -1
    first, second = np.unravel_index(int(np.argmax(right)), right.shape)
    return Rule(lead, float(cuts[first]), float(cuts[second]), float(right[first, second] / score.size))


def discriminant(training: Windows, truth: Integers, windows: Windows, sample: int) -> Integers:
    """Return the intentions by linear discriminant analysis at one sample of the windows, shape (n,).

    Classes are taken for normal with one covariance (Fisher, doi:10.1111/j.1469-1809.1936.tb02137.x) in the logarithms
    of highest pedal, present pedal and highest rate, and in the vehicle speed now and at the onset.

    Args:
        training: windows that it is fitted to.
        truth: their intentions, shape (m,).
        windows: those to decide.
        sample: of the window; it has seen nothing after it.
    """
    known, seen = _numbers(training, sample), _numbers(windows, sample)
    means = np.array([known[truth == k].mean(axis=0) for k in range(3)])
    precision = np.linalg.inv(np.cov((known - means[truth]).T))
    scores: Floats = np.array([(seen - 0.5 * mean) @ precision @ mean for mean in means])
    return scores.argmax(axis=0)


def _numbers(w: Windows, sample: int) -> Floats:
    pedal, speed = w.inputs[:, :, 0], w.inputs[:, :, 2]
    logarithms = (w.highest_pedal[:, sample] + 0.01, pedal[:, sample] + 0.01, w.highest_rate[:, sample] + 0.05)
    return np.stack([*map(np.log, logarithms), speed[:, sample], speed[:, 0]], axis=1)
