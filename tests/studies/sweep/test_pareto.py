"""Fronts, beside what the definition says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.studies.sweep.pareto import Objective, front, read_objectives
from tests.conftest import Refused

COORDINATE = st.integers(0, 6) | st.just(np.nan)


def dominated(points: list[tuple[float, float]], n: int) -> bool:
    x, y = points[n]
    return any((a <= x and b <= y) and (a < x or b < y) for a, b in points)


@given(st.lists(st.tuples(COORDINATE, COORDINATE), max_size=30))
def test_a_front_is_what_nothing_dominates(points: list[tuple[float, float]]) -> None:
    found = front(np.array(points, float).reshape(-1, 2))
    expected = [not np.isnan(points[n]).any() and not dominated(points, n) for n in range(len(points))]
    assert found.tolist() == expected


@pytest.mark.parametrize(
    ("text", "objectives"),
    [
        ("a,b", (Objective("a"), Objective("b"))),
        ("-a, b:max", (Objective("a", True), Objective("b", True))),
        ("b:min,a", (Objective("b"), Objective("a"))),
    ],
)
def test_objectives_are_read(text: str, objectives: tuple[Objective, Objective]) -> None:
    assert read_objectives(text, ("a", "b", "c")) == objectives


@pytest.mark.parametrize("text", ["a", "a,a", "a,b,c", "a,d", "a:most,b", "", "a,-a"])
def test_objectives_are_two_figures_that_there_are(text: str, refused: Refused) -> None:
    refused(lambda: read_objectives(text, ("a", "b", "c")), f"--pareto: got {text}", "expected two of a, b, c")
