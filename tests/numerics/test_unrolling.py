"""Loops written out: the same numbers, and only the loops that are meant."""

from __future__ import annotations

import numpy as np

from bitepoint.kernels import kernel
from bitepoint.numerics.unrolling import unrolled
from bitepoint.records import FloatArray, Record, quantity

SIZE = 3


class Square(Record):
    """A square matrix and a sum."""

    entries: FloatArray = quantity("1", -1e9, 1e9, "entries", shape=(SIZE, SIZE))
    total: float = quantity("1", -1e9, 1e9, "sum", default=0)


@kernel
def add_up(s: Square) -> float:
    """Return the sum of the entries, less twice that of the first column but its first."""
    s.total = 0.0
    for i in range(SIZE):
        for j in range(SIZE):
            s.total += s.entries[i, j]
    for i in range(1, SIZE):
        s.total -= 2.0 * s.entries[i, 0]
    for i in range(SIZE):
        # a remark
        # in two lines
        if s.entries[i, i] < 0.0:
            break
        if s.total > 1e9:
            s.total = 1e9
        # another one
        elif s.total < -1e9:
            s.total = -1e9
        s.total += 1.0
    return s.total


def test_the_same_numbers_from_innermost_loops_written_out() -> None:
    other = unrolled(add_up, "add_up_written_out", {"SIZE": SIZE}, {"SIZE": SIZE})
    text = other.source.text
    assert text.count("for ") == 2  # the outer one, and the one with a break
    assert all(f"s.entries[i, {j}]" in text for j in range(SIZE))
    assert text.count("s.total -= 2.0") == SIZE - 1
    squares = Square.zeros(20)
    assert "        # a remark\n        # in two lines\n        if s.entries[i, i] < 0.0:\n" in text
    assert "        # another one\n        elif s.total < -" in text
    squares["entries"] = np.random.default_rng(1).normal(size=(20, SIZE, SIZE))
    for life in ("compiled", "interpreted"):
        assert np.array_equal(other.run(squares, life=life), add_up.run(squares, life=life))
