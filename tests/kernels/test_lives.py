"""The lives of a kernel agree, to the bit, also where Python alone would raise."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bitepoint.kernels import Life, clamp, is_finite, kernel, sign, to_index
from bitepoint.records import FloatArray, Record, RecordElements, count, nested, quantity
from tests.conftest import OTHER_LIVES
from tests.kernels.subset_examples import Example, all_that_is_allowed

EDGES = [0.0, -0.0, 1.0, -1.0, 0.5, math.inf, -math.inf, math.nan, 5e-324, 1e308, -1e308, 710.0, -745.5, 1e-300]
"""Numbers at which some operation of some life could raise, overflow or lose its sign."""


@kernel
def operations(x: float, y: float) -> float:
    """Whatever Python would raise on."""
    return x / y + x**2 - min(x, y) * max(y, x)


@kernel
def functions(x: float) -> float:
    """Functions with poles, domains and overflow."""
    total = math.sqrt(x) + math.log(x) + math.log1p(x) - math.asin(x)
    return total + math.sin(x) * math.cos(x) + math.tan(x) + math.acos(x)


@kernel
def growth(x: float) -> float:
    """Functions that overflow."""
    return math.exp(x) - math.sinh(x) * math.cosh(x) + math.expm1(x)


@kernel
def powers(x: float, y: float) -> float:
    """The power with all its special cases."""
    return math.pow(x, y)


@kernel
def constant_powers(x: float, y: float) -> float:
    """Powers that a compiler would like to compute in another way."""
    low = math.pow(2.0, x) + math.pow(10.0, y) - math.pow(y, 0.5) * math.pow(x, -0.5)
    return low + math.pow(x, 2.0) - math.pow(y, 3.0) + math.pow(x, -1.0) * math.pow(0.5, y)


@kernel
def smooth(x: float, y: float) -> float:
    """Functions that are defined everywhere."""
    return math.atan2(x, y) + math.tanh(x) - math.atan(y) + math.copysign(x, y) + math.fabs(x)


@kernel
def limits(x: float) -> float:
    """The helpers."""
    inside = 1.0 if is_finite(x) else 0.0
    return clamp(x, -2.0, 3.0) + sign(x) + inside + float(to_index(x, -5, 7))


@kernel
def in_place(e: Example, x: float) -> None:
    """Augmented assignments."""
    e.x /= x
    e.x += 1.0
    e.x *= x
    e.table[1] -= e.x / x


def bits(values: np.ndarray) -> list[bytes]:
    """The bytes of each number; every NaN is the same one."""
    return [b"nan" if math.isnan(value) else struct.pack("d", value) for value in values]


def same(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays of records hold the same bits; every NaN is the same one."""
    return bits(a.view(np.float64)) == bits(b.view(np.float64))


PAIRS = [(x, y) for x in EDGES for y in EDGES]


each_life = pytest.mark.parametrize("life", OTHER_LIVES)


@each_life
@pytest.mark.parametrize("function", [operations, powers, constant_powers, smooth], ids=lambda k: k.name)
def test_agree_on_edges_of_two(function, life: Life) -> None:
    x, y = (np.array(column) for column in zip(*PAIRS, strict=True))
    assert bits(function.run(x, y)) == bits(function.run(x, y, life=life))


@each_life
@pytest.mark.parametrize("function", [functions, growth, limits], ids=lambda k: k.name)
def test_agree_on_edges_of_one(function, life: Life) -> None:
    x = np.array(EDGES)
    assert bits(function.run(x)) == bits(function.run(x, life=life))


@each_life
@settings(max_examples=200, deadline=None)
@given(pairs=st.lists(st.tuples(st.floats(), st.floats()), min_size=1, max_size=20))
def test_agree_on_any_floats(pairs: list[tuple[float, float]], life: Life) -> None:
    x, y = (np.array(column) for column in zip(*pairs, strict=True))
    for function in (operations, powers, constant_powers, smooth):
        assert bits(function.run(x, y)) == bits(function.run(x, y, life=life))


@each_life
def test_powers_of_constants_agree(life: Life) -> None:
    rng = np.random.default_rng(8)
    x, y = rng.uniform(-60, 60, 20_000), rng.uniform(0, 60, 20_000)
    assert bits(constant_powers.run(x, y)) == bits(constant_powers.run(x, y, life=life))


@each_life
def test_agree_on_records(life: Life) -> None:
    rng = np.random.default_rng(1)
    records = Example.zeros(200)
    for name in ("table", "matrix"):
        records[name] = rng.uniform(-1, 1, records[name].shape)
    records["x"] = rng.normal(size=200)
    x, n = rng.normal(0, 3, 200), rng.integers(-3, 9, 200)
    x[::7] = np.nan
    again = records.copy()
    assert bits(all_that_is_allowed.run(records, x, n)) == bits(all_that_is_allowed.run(again, x, n, life=life))
    assert records["mode"].tolist() == again["mode"].tolist()
    assert same(records, again)
    in_place.run(records, x)
    in_place.run(again, x, life=life)
    assert same(records, again)


def test_to_index_is_always_inside() -> None:
    x = np.array([*EDGES, 6.999, 7.0, 7.5, -5.5, 2**63, -(2.0**70)])
    index = to_index.run(x, -5, 7)
    assert index.min() >= -5
    assert index.max() <= 7
    assert index[EDGES.index(1.0)] == 1
    assert to_index.run(math.nan, 2, 7)[0] == 2
    assert to_index.run(3.9, 0, 7)[0] == 3
    assert to_index.run(-3.9, -7, 7)[0] == -3


def test_clamp_of_nan_is_low() -> None:
    assert clamp.run(math.nan, 1.0, 2.0)[0] == 1.0


def test_lanes_are_independent_and_shared_arguments_stay() -> None:
    batch = Example.zeros(3)
    batch["x"] = [1.0, 2.0, 4.0]
    in_place.run(batch, 2.0)
    assert batch["x"].tolist() == [3.0, 4.0, 6.0]


def test_wrong_calls_raise() -> None:
    with pytest.raises(TypeError, match="takes 2 arguments"):
        in_place.run(Example.zeros())
    with pytest.raises(TypeError, match="records"):
        in_place.run(np.zeros(3), 1.0)
    with pytest.raises(TypeError, match="lanes do not match"):
        in_place.run(Example.zeros(3), np.ones(2))
    with pytest.raises(TypeError, match="contiguous"):
        in_place.run(Example.zeros(6)[::2], 1.0)


class Row(Record):
    """An element of an array of records."""

    weight: float = quantity("1", -10, 10, "a weight")
    hits: int = count(0, 10, "a counter")


class Rows(Record):
    """A record with an array of records."""

    used: int = count(0, 4, "rows in use")
    row: RecordElements[Row] = nested(Row, "the rows", shape=(4,))
    out: FloatArray = quantity("1", -100, 100, "results", shape=(4,))


@kernel
def weigh(rows: Rows, x: float) -> float:
    """Read and write an array of records."""
    total = 0.0
    for i in range(4):
        if i < rows.used:
            rows.row[i].hits = min(rows.row[i].hits + 1, 10)
            rows.out[i] = x * rows.row[i].weight
            total = total + rows.out[i]
    return total


@each_life
def test_arrays_of_records(life: Life) -> None:
    lanes = Rows.zeros(2)
    lanes["used"] = [2, 4]
    lanes["row"]["weight"] = [[1, 2, 3, 4], [5, 6, 7, 8]]
    again = lanes.copy()
    assert weigh.run(lanes, 2.0).tolist() == [6.0, 52.0]
    assert weigh.run(again, 2.0, life=life).tolist() == [6.0, 52.0]
    assert lanes.tobytes() == again.tobytes()
    assert lanes["row"]["hits"].tolist() == [[1, 1, 0, 0], [1, 1, 1, 1]]


def test_an_index_outside_is_an_error_when_interpreted() -> None:
    from bitepoint.kernels.interpreted import view_class

    lane = Example.zeros()
    view = view_class(Example)(lane.ctypes.data)
    with pytest.raises(IndexError, match="outside"):
        _ = view.table[-1]  # pyright: ignore


def test_an_exception_in_an_interpreted_kernel_reaches_the_caller() -> None:
    @kernel(trusted=True)
    def broken(x: float) -> int:
        raise RuntimeError("seen")

    with pytest.raises(RuntimeError, match="seen"):
        broken.run(1.0, life="interpreted")
