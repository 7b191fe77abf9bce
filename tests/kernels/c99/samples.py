"""Kernels whose translation has something to get wrong."""

from __future__ import annotations

import math

from bitepoint.kernels import EPSILON, clamp, kernel, to_index
from bitepoint.records import FloatArray, Record, RecordElements, count, nested, quantity

SIZE = 4
HALF = 0.5


class Cell(Record):
    """An element; its text holds */ and "quotes" and ², which a comment must survive."""

    weight: float = quantity("kg*m^2", -10, 10, "a weight /* of a kind */")
    hits: int = count(0, 1000, "a counter")


class Bag(Record):
    """What the samples work on."""

    x: float = quantity("m/s^2", -1e9, 1e9, "a number")
    used: int = count(0, 4, "cells in use")
    table: FloatArray = quantity("1", -1, 1, "a table", shape=(SIZE,))
    matrix: FloatArray = quantity("1", -1, 1, "a matrix", shape=(2, 3))
    cell: Cell = nested(Cell, "a nested record")
    cells: RecordElements[Cell] = nested(Cell, "an array of records", shape=(SIZE,))


@kernel
def grouping(a: float, b: float, c: float) -> float:
    """Groups that a flat rewriting would lose."""
    x = a - (b - c) + a / (b * c) - a / b / c
    y = -(a + b) * -c - -a
    z = (a + b) ** 2 - (a - b) * (a - b) + (a if b > c else b) * (1.0 if a > 0.0 else -1.0)
    return x * y - (x + (y - z))


@kernel
def logic(a: float, b: float, n: int) -> float:
    """Conditions with every operator, and integers among floats."""
    no = a < b or n < 0
    yes = (a > b or b >= 1.0) and not (a == b and n != 2)
    m = to_index(float(n), -9, 9)
    k = m * m - 2 * m + abs(m) - max(m, 3) + min(-m, 2)
    return (1.0 if yes else 0.0) - (2.0 if no else 0.0) + k / 3 + n * a + float(n) - 2 * b


@kernel
def blocks(a: float, n: int) -> float:
    """Locals that get their value in branches and loops."""
    if a > 0.0:
        sign = 1.0
        inner = 0.0
        if a > 1.0:
            twice = a * 2.0
            inner = twice
        else:
            inner = a * 3.0
        sign = sign + inner
    elif a < -1.0:
        sign = -1.0
    elif a < -0.5:
        sign = -0.5
    else:
        sign = 0.0
    total = 0.0
    for i in range(1, 10, 3):
        step = sign * i
        for _j in range(3, 0, -1):
            step = step + HALF
            if step > 20.0:
                break
        total += step
    for i in range(n):
        total -= i
    return total


@kernel
def moving_end(b: Bag) -> int:
    """A loop whose end changes while it runs: it was looked at once."""
    for _turn in range(b.used):
        b.used = max(b.used - 1, 0)
        b.cell.hits = min(b.cell.hits + 1, 1000)
    return b.cell.hits


@kernel
def step(b: Bag, clamp_: float) -> float:
    """A local called like a function of its own, and like one of the library."""
    step_ = clamp(clamp_, -1.0, 1.0)
    y1 = math.fabs(step_)  # why: a comment beside a line
    # why: a comment of its own
    index = to_index(b.x, 0, 3)
    yn = b.table[index] if y1 > EPSILON else b.matrix[1, 2]
    b.cells[index].hits = min(b.cells[index].hits + 1, 1000)
    b.cell.weight = add(b.cells[index], yn)
    return b.cell.weight


@kernel
def add(c: Cell, real_min: float) -> float:
    """Parameters called like a helper."""
    return min(c.weight, real_min) + max(real_min, 0.25) - (c.weight * 2.0) ** 2


@kernel
def large_constant(x: float) -> float:
    """A number that float32 has not."""
    return x * 1e300  # here


@kernel
def small_constant(x: float) -> float:
    """A number that would be zero in float32."""
    return x / 1e-300  # here


ALL = (grouping, logic, blocks, moving_end, step, add)


T = 3.0
DBL_MAX = 7.0


@kernel
def scaled(x: float) -> float:
    """A constant of an everyday name, and one that is a macro in C."""
    return x * T + DBL_MAX


@kernel
def upper_names(T: float, GAIN: float) -> float:  # noqa: N803
    """Parameters called like a constant of a callee, a local called like a type, and one that nobody reads."""
    float64_t = scaled(T) + GAIN
    unread = float64_t * 2.0  # noqa: F841
    return float64_t


@kernel
def two_names(a: Bag, b: Bag) -> float:
    """A loop whose end changes under another name of the same record."""
    total = 0.0
    for _turn in range(a.used):
        b.used = 1
        total = total + 1.0
    return total


@kernel
def whole_squares(n: int) -> int:
    """The square of an integer expression."""
    m = to_index(float(n), -9, 9)
    return (m + 1) ** 2 - m**2


OTHERS = (scaled, upper_names, two_names, whole_squares)
