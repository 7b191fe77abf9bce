"""The longest step of a part: searched for on this machine, by counting the basic blocks that each step runs through.

Random sequences are drawn, and each of the longest is changed a little again and again, as long as that helps. The
parameters are those that were designed, with as many points in each curve and map as there can be. On a Cortex-M7 the
step with most blocks here is the one with most instructions there: over 22 000 steps of a predictive controller the
two correlate with 0.998, and the ten longest are the same.

What is found is no bound: where a solver takes part, another search may find a third more, seldom. The cap of its
iterations is the bound.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.export.c import vectors
from bitepoint.export.c.driving import Floats, iteration_counts
from bitepoint.export.c.driving import Sequence as Inputs
from bitepoint.export.c.probe import BlockCounter
from bitepoint.export.c.sources import Sources
from bitepoint.fields import Field
from bitepoint.records import RecordArray, plain, tabulated
from bitepoint.simulation.system import Part

DRAWN = 500
"""Sequences that are drawn."""

LINES, FEW_LINES = 10, 2
"""The longest of them, which are changed: where a solver's loops may be longer than any that was seen, and else."""

PATIENCE = 300
"""Changes in a row that may help nothing before the next one is taken."""

SEED = 3
"""Of the changes: of five that were tried the one that found the longest step of `ddpc`."""

MOST_BLOCKS = 1_000_000_000
"""Basic blocks after which the search ends in any case: a few seconds."""


def full(part: Part) -> RecordArray:
    """Return the parameters that were designed, with as many points in each curve and map as there can be.

    The added points lie between those that are there, so that the curve is the same and the search in it the longest.
    """
    parameters = part.parameters[:1].copy()
    for path, field in part.parameters_type.table():
        if field.axes:
            view = part.parameters_type.locate(parameters, path, part.name)[1]
            for place in np.ndindex(view.shape):
                told = plain(field, view[place])
                if all(len(told[axis.name]) > 1 for axis in field.axes):  # else there is none
                    view[place] = _filled(field, told)
    return parameters


def _filled(field: Field, told: Mapping[str, Any]) -> np.void:
    """Return a curve or a map with all the points that it can have."""
    columns: list[Floats] = [np.array(told[axis.name], np.float64) for axis in field.axes]
    for place, points in enumerate(columns[:-1]):
        columns[place] = _finer(points, field.most_points)
        columns[-1] = _between(columns[-1], place, points, columns[place])
    return tabulated(field, *columns)[0]


def _between(values: Floats, axis: int, points: Floats, finer: Floats) -> Floats:
    """Return values over the points of an axis at the finer points."""
    if values.ndim == 1:
        return np.interp(finer, points, values)
    if axis == 0:
        return _between(values.T, 1, points, finer).T
    return np.array([np.interp(finer, points, values[row]) for row in range(len(values))], np.float64)


def _finer(points: Floats, most: int) -> Floats:
    """Return increasing points, with as many added in the middle of the widest gaps as there is room for."""
    while len(points) < most:
        widest = int(np.argmax(np.diff(points)))
        points = np.insert(points, widest + 1, 0.5 * (points[widest] + points[widest + 1]))
    return points


def drawn(part: Part, recorded: Sequence[Inputs]) -> list[Floats]:
    """Return the inputs that the search begins with: recorded ones and random ones, for every precision the same."""
    random = itertools.islice(vectors.random_inputs(part, recorded), DRAWN)
    return [*(run.inputs for run in recorded), *random]


def longest(sources: Sources, tables: Sequence[Floats], folder: Path) -> Inputs:
    """Return the sequence with the longest step that was found, up to that step; the same one every time.

    Args:
        tables: inputs to begin with, each of shape (rows, inputs): see `drawn`.
    """
    search = _Search(sources, folder)
    found = [search.until_longest(table) for table in tables if search.spent < MOST_BLOCKS]
    found.sort(key=lambda line: -line[0])
    rng = np.random.default_rng(SEED)
    lines = LINES if any(iteration_counts(sources.part)) else FEW_LINES
    _, table = max((search.improved(line, rng) for line in found[:lines]), key=lambda line: line[0])
    return Inputs(f"the longest step that was found in {sources.precision.name}", search.parameters, table)


class _Search:
    """A counter of blocks, and how many it has counted; a line is some inputs, and the blocks of their last step."""

    def __init__(self, sources: Sources, folder: Path) -> None:
        self.part = sources.part
        self.counter = BlockCounter(sources, folder)
        self.parameters = full(sources.part)
        self.spent = 0

    def until_longest(self, table: Floats) -> tuple[int, Floats]:
        """Return the blocks of the longest step of some inputs, and the inputs up to it."""
        counts = self.counter.count(Inputs("", self.parameters, table))
        self.spent += int(counts.sum())
        worst = int(counts.argmax())
        return int(counts[worst]), table[: worst + 2]

    def improved(self, line: tuple[int, Floats], rng: np.random.Generator) -> tuple[int, Floats]:
        """Return the line after changes that made its longest step longer, or left it as long."""
        since = 0
        while since < PATIENCE and self.spent < MOST_BLOCKS:
            tried = self.until_longest(_changed(line[1], self.part, rng))
            since = 0 if tried[0] > line[0] else since + 1
            line = tried if tried[0] >= line[0] else line
        return line


def _changed(table: Floats, part: Part, rng: np.random.Generator) -> Floats:
    """Return inputs some of which are, for a while, a little larger or smaller, or constant."""
    result = table.copy()
    for column, field in enumerate(part.inputs.fields.values()):
        if rng.random() < 0.5:
            continue
        low, high = max(field.low, -1e6), min(field.high, 1e6)
        first = int(rng.integers(len(table)))
        some = slice(first, first + int(rng.integers(1, len(table) + 1)))
        kind = rng.random()
        if kind < 0.4:
            result[some, column] += (high - low) * 10.0 ** rng.uniform(-5.0, -0.5) * rng.normal()
        elif kind < 0.8:
            result[some, column] *= rng.uniform(0.3, 1.7)
        else:
            result[some, column] = rng.uniform(low, high)
        result[some, column] = np.clip(result[some, column], low, high)
    return result
