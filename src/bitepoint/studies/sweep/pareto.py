"""Pareto fronts: the rows that no other row beats in two figures at once."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bitepoint.errors import InputError
from bitepoint.recording import Floats

PARETO = "--pareto"
"""What errors name as the place of the two figures."""


@dataclass(frozen=True)
class Objective:
    """A figure that is to be as small as it can, or as large."""

    figure: str
    largest: bool = False

    @property
    def sign(self) -> float:
        """What the figure is multiplied by, so that less is better."""
        return -1.0 if self.largest else 1.0


def read_objectives(text: str, figures: Collection[str]) -> tuple[Objective, Objective]:
    """Return the two figures of a text such as "friction_work,jerk_peak".

    Args:
        text: names with a comma between; `-NAME` and `NAME:max` ask for the largest, `NAME:min` for the smallest.
        figures: names that there are.

    Raises:
        InputError: not two different ones of them.
    """
    found = [_objective(part.strip()) for part in text.split(",")]
    names = [objective.figure for objective in found]
    if len(found) != 2 or len(set(names)) != 2 or not set(names) <= set(figures):
        mend = f"expected two of {', '.join(figures)}, such as NAME,NAME:max"
        raise InputError(PARETO, f"got {text}", mend)
    return found[0], found[1]


def _objective(text: str) -> Objective:
    name, _, end = text.partition(":")
    if end in ("min", "max"):
        return Objective(name, end == "max")
    return Objective(text[1:], True) if text.startswith("-") else Objective(text)


def front(points: Floats) -> npt.NDArray[np.bool_]:
    """Return which points no other point dominates, shape (n,).

    A point dominates another where it is no worse in either number and better in one; less is better. Equal points
    do not dominate each other. A point that is not finite is on no front.

    Args:
        points: shape (n, 2).
    """
    kept = np.zeros(len(points), bool)
    best, reached = np.inf, np.inf  # least second number so far, and at a smaller first number
    first = np.nan
    for n in _sorted(points):
        x, y = points[n]
        if x != first:
            first, reached = x, best
        kept[n] = y < reached and y <= best
        best = min(best, y)
    return kept


def _sorted(points: Floats) -> Sequence[int]:
    finite = np.flatnonzero(np.isfinite(points).all(axis=1))
    order = np.lexsort((points[finite, 1], points[finite, 0]))
    return finite[order].tolist()
