"""Hints at delays between channels, from the correlation of their changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bitepoint.identification.regression import Run
from bitepoint.recording import Floats

REACH = 0.3
"""Longest delay that is looked for, s."""

LEAST_CORRELATION = 0.15
"""Weaker correlations give no hint (chosen)."""

DEVIATIONS = 5.0
"""Nor do those that are less than this many standard deviations of the correlation of independent channels."""

EXPECTED = 1
"""Rows by which the acceleration of the speed, set as in `estimate_delay`, follows a torque that is not delayed."""


@dataclass(frozen=True)
class DelayHint:
    """How late an input seems to be logged, seen from an output.

    Attributes:
        delay: s; positive: the input is logged after what it does, as a slow sensor would.
        correlation: of input change and output acceleration at that delay.
    """

    signal: str
    output: str
    delay: float
    correlation: float


def estimate_delay(runs: Sequence[Run], signal: str, output: str, period: float) -> DelayHint | None:
    """Return how late the first input is, seen from the first output, or None where nothing stands out.

    A torque that changes from one row on changes the speed from the next row on: so the change of the torque, seen from
    row to row, goes with the change of the acceleration one row later. Differences take all slow motion out.
    """
    moves = [np.diff(run.u[:, 0])[1:] for run in runs]
    answers = [np.diff(run.y[:, 0], 2) for run in runs]
    reach = round(REACH / period)
    hints = ((lag, *_correlation(moves, answers, lag)) for lag in range(-reach, reach + 1))
    sure = [(lag, found) for lag, found, rows in hints if abs(found) > max(LEAST_CORRELATION, DEVIATIONS / rows**0.5)]
    if not sure:
        return None
    lag, found = max(sure, key=lambda hint: abs(hint[1]))
    return DelayHint(signal, output, (EXPECTED - lag) * period, found)


def _correlation(a: Sequence[Floats], b: Sequence[Floats], lag: int) -> tuple[float, int]:
    """Return the correlation of a(k) with b(k + lag), and over how many rows; at least one is told."""
    pairs = [
        (x[max(0, -lag) : len(x) - max(0, lag)], y[max(0, lag) : len(y) - max(0, -lag)])
        for x, y in zip(a, b, strict=True)
        if len(x) > abs(lag)
    ]
    product = sum(float(x @ y) for x, y in pairs)
    power = sum(float(x @ x) for x, _ in pairs) * sum(float(y @ y) for _, y in pairs)
    return product / power**0.5 if power > 0.0 else 0.0, max(sum(len(x) for x, _ in pairs), 1)
