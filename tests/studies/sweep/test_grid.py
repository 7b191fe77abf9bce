"""What `--over` reads, and the order of the rows."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.studies.sweep.grid import MOST_ROWS, Axis, Grid, axis, read_over
from bitepoint.units import parse
from tests.conftest import Refused

DECIMALS = st.decimals(-1000, 1000, allow_nan=False, allow_infinity=False, places=3)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0:20:5 %", ("0 %", "5 %", "10 %", "15 %", "20 %")),
        ("1:4", ("1", "2", "3", "4")),
        ("0:1:0.1", tuple(str(n / 10) if n % 10 else str(n // 10) for n in range(11))),
        ("10 : 100 : 30rpm", ("10 rpm", "40 rpm", "70 rpm", "100 rpm")),
        ("20:0:-10", ("20", "10", "0")),
        ("0:10:4", ("0", "4", "8")),
        ("-1.5:1.5:1.5", ("-1.5", "0", "1.5")),
        ("7:7", ("7",)),
        ("1e3:3e3:1e3 kg", ("1000 kg", "2000 kg", "3000 kg")),
        ("1400,1600,1800 kg", ("1400 kg", "1600 kg", "1800 kg")),
        ("1400 kg, 4000 lb", ("1400 kg", "4000 lb")),
        ("slow,normal", ("slow", "normal")),
        ("launch_mpc", ("launch_mpc",)),
        ("[3.3, 1.7],[3.2, 1.6]", ([3.3, 1.7], [3.2, 1.6])),
        ("{a: [0, 1], b: [2, 3]}", ({"a": [0, 1], "b": [2, 3]},)),
        ("C:\\one.yaml,C:\\two.yaml", ("C:\\one.yaml", "C:\\two.yaml")),
    ],
)
def test_a_text_stands_for_values(text: str, values: tuple[object, ...]) -> None:
    assert axis("key", text) == Axis("key", values)


@given(DECIMALS, st.decimals("0.001", 50, places=3), st.integers(0, 200), st.booleans())
def test_a_range_has_both_ends_and_no_drift(start: Fraction, step: Fraction, count: int, down: bool) -> None:
    first, width = Fraction(start), Fraction(step) * (-1 if down else 1)
    stop = first + count * width
    text = f"{start}:{float(stop)!r}:{'-' if down else ''}{step} kg"
    found = [parse(value, "kg") for value in axis("key", text).values]
    assert found == [float(first + n * width) for n in range(count + 1)]


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.floats(0, 1e4))
def test_a_range_never_goes_beyond_its_stop(start: float, step: float, length: float) -> None:
    stop = start + length
    if (stop - start) / step >= 1000:
        return
    found = [float(value) for value in axis("key", f"{start!r}:{stop!r}:{step!r}").values]
    assert all(start <= value <= stop for value in found)
    assert math.isclose(found[-1] + step, stop, abs_tol=1e-6) or found[-1] + step > stop


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("0:20:0", ("from 0 to 20 in steps of 0",)),
        ("20:0", ("from 20 to 0 in steps of 1", "20:0:-5")),
        ("0:20:5:3", ("got '0:20:5:3'", "start:stop:step")),
        ("0 %:20 %", ("start:stop:step", "unit after the last")),
        ("0:1e999", ("finite",)),
        ("0:1e9", (f"at most {MOST_ROWS}",)),
        ("0:1e15:1e-15", (f"at most {MOST_ROWS}",)),
        ("a,,b", ("got 'a,,b'",)),
        ("a,b,a", ("got 'a' twice",)),
        ("[1,2", ("not YAML",)),
    ],
)
def test_a_text_that_stands_for_nothing_is_refused(text: str, parts: tuple[str, ...], refused: Refused) -> None:
    refused(lambda: axis("road.grade", text), "--over", "road.grade", *parts)


@pytest.mark.parametrize("values", [[], 3.0])
def test_a_sequence_has_values(values: object, refused: Refused) -> None:
    refused(lambda: axis("key", values), "--over: key: ")  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("text", ["road.grade", "=1:2", "road.grade="])
def test_what_is_swept_has_a_key_and_values(text: str, refused: Refused) -> None:
    refused(lambda: read_over([text]), f"--over: got '{text}'", "KEY=start:stop:step")


def test_a_key_is_swept_once(refused: Refused) -> None:
    refused(lambda: read_over(["a=1:2", "a=3"]), "--over: a: given twice")


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4))
def test_rows_are_all_combinations_and_the_last_key_changes_fastest(sizes: list[int]) -> None:
    axes = tuple(Axis(f"k{n}", tuple(range(size))) for n, size in enumerate(sizes))
    grid = Grid(axes)
    rows = [tuple(grid.row(number).values()) for number in range(grid.rows)]
    assert rows == list(itertools.product(*map(range, sizes)))


@given(st.lists(st.tuples(st.integers(1, 4), st.booleans()), min_size=1, max_size=4))
def test_groups_hold_each_row_once_and_share_what_they_have_to(axes: list[tuple[int, bool]]) -> None:
    grid = Grid(tuple(Axis(f"k{n}", tuple(range(size))) for n, (size, _) in enumerate(axes)))
    alike = {f"k{n}": same for n, (_, same) in enumerate(axes)}
    groups = grid.groups(range(grid.rows), alike)
    assert sorted(row for group in groups for row in group) == list(range(grid.rows))
    shared = [{tuple(v for k, v in grid.row(row).items() if alike[k]) for row in group} for group in groups]
    assert all(len(values) == 1 for values in shared)
    assert len(groups) == len(set.union(*shared)) == math.prod(size for size, same in axes if same)


def test_a_grid_has_a_limit(refused: Refused) -> None:
    wide = [axis(f"k{n}", "1:400") for n in range(2)]
    refused(lambda: Grid(tuple(wide)), "--over: 400 x 400 values are 160000 rows", f"at most {MOST_ROWS} rows")
    refused(lambda: Grid(()), "--over: nothing is swept")
