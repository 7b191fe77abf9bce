"""Timing things side by side: in rounds, one after the other, so that what else the machine does hits all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from bitepoint.recording import Floats


@dataclass(frozen=True)
class Samples:
    """Seconds per call of each candidate, one number per round."""

    seconds: Mapping[str, Floats]

    def median(self, name: str) -> float:
        """Return the median time of a call, s."""
        return float(np.median(self.seconds[name]))

    def ratio(self, name: str, other: str) -> float:
        """Return the median over the rounds of the time of `name` over the time of `other` in the same round."""
        return float(np.median(self.seconds[name] / self.seconds[other]))


def side_by_side(
    candidates: Mapping[str, Callable[[], object]], rounds: int, calls: int | Mapping[str, int] = 1
) -> Samples:
    """Call every candidate once, unmeasured; then, in each round, each of them `calls` times: A B A B ..."""
    times = dict.fromkeys(candidates, calls) if isinstance(calls, int) else calls
    for candidate in candidates.values():
        candidate()
    seconds = {name: np.empty(rounds) for name in candidates}
    for n in range(rounds):
        for name, candidate in candidates.items():
            start = time.perf_counter()
            for _ in range(times[name]):
                candidate()
            seconds[name][n] = (time.perf_counter() - start) / times[name]
    return Samples(seconds)
