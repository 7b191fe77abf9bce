"""Kernels outside the subset, each with what the checker has to say. Line numbers are found by the mark `# here`."""

# ruff: noqa
# pyright: basic
from __future__ import annotations

import math

from bitepoint.kernels import clamp, kernel, to_index
from bitepoint.records import FloatArray, Record, count, nested, quantity

SIZE = 4
gain = 2.0


class Inner(Record):
    """A nested record."""

    value: float = quantity("1", -1, 1, "a number")


class Example(Record):
    """What the examples work on."""

    x: float = quantity("1", -1e9, 1e9, "a number")
    mode: int = count(0, 3, "a mode")
    large: int = count(0, 1_000_000_000, "a large number")
    table: FloatArray = quantity("1", -1, 1, "a table", shape=(SIZE,))
    matrix: FloatArray = quantity("1", -1, 1, "a matrix", shape=(2, 3))
    inner: Inner = nested(Inner, "a nested record")


@kernel
def unannotated(e: Example, x) -> float:  # here
    return x


@kernel
def no_result(e: Example):  # here
    e.x = 1.0


@kernel
def while_loop(e: Example) -> None:
    while e.x > 0.0:  # here
        e.x = e.x - 1.0


@kernel
def early_return(x: float) -> float:
    if x > 0.0:
        return 1.0  # here
    return 0.0


@kernel
def two_types(x: float) -> float:
    y = 1
    y = 2.5  # here
    return x + y


@kernel
def integer_for_float(e: Example) -> None:
    e.x = 1  # here


@kernel
def float_for_integer(e: Example) -> None:
    e.mode = e.x  # here


@kernel
def integer_out_of_range(e: Example) -> None:
    e.mode = e.mode + 1  # here


@kernel
def negative_index(e: Example) -> float:
    return e.table[-1]  # here


@kernel
def index_too_large(e: Example) -> float:
    y = 0.0
    for i in range(SIZE):
        y = y + e.table[i + 1]  # here
    return y


@kernel
def unchecked_index(e: Example, i: int) -> float:
    return e.table[i]  # here


@kernel
def float_index(e: Example) -> float:
    return e.table[e.x]  # here


@kernel
def growing_index(e: Example) -> float:
    k = 0
    for i in range(3):
        k = k + 1  # here
    return e.table[k]


@kernel
def one_index_for_two(e: Example) -> float:
    return e.matrix[1]  # here


@kernel
def int_of_float(x: float) -> int:
    return int(x)  # here


@kernel
def a_slice(e: Example) -> float:
    return e.table[0:2]  # here


@kernel
def an_alias(e: Example) -> float:
    inner = e.inner  # here
    return inner.value


@kernel
def a_tuple(x: float) -> float:
    a, b = x, x  # here
    return a + b


@kernel
def modulo(x: float) -> float:
    return x % 2.0  # here


@kernel
def floor_division(x: float) -> float:
    return x // 2.0  # here


@kernel
def cube(x: float) -> float:
    return x**3  # here


@kernel
def number_as_condition(x: float) -> float:
    return 1.0 if x else 0.0  # here


@kernel
def chained(x: float) -> float:
    return 1.0 if 0.0 < x < 1.0 else 0.0  # here


@kernel
def three_arguments(x: float) -> float:
    return max(x, 0.0, 1.0)  # here


@kernel
def mixed_maximum(x: float) -> float:
    return max(x, 0)  # here


@kernel
def other_maths(x: float) -> float:
    return math.gamma(x)  # here


@kernel
def a_string(x: float) -> float:
    y = "text"  # here
    return x


@kernel
def lower_case_global(x: float) -> float:
    return gain * x  # here


@kernel
def unknown_field(e: Example) -> float:
    return e.nothing  # here


@kernel
def maybe_unset(x: float) -> float:
    if x > 0.0:
        y = 1.0
    return y  # here


@kernel
def loop_variable_afterwards(x: float) -> int:
    for i in range(3):
        x2 = x
    return i  # here


@kernel
def assigned_parameter(x: float) -> float:
    x = 2.0 * x  # here
    return x


@kernel
def raising(x: float) -> float:
    raise ValueError  # here


@kernel
def comprehension(x: float) -> float:
    return sum([x for _ in range(3)])  # here


@kernel
def keyword_call(x: float) -> float:
    return clamp(x, low=0.0, high=1.0)  # here


@kernel
def wrong_record(e: Inner) -> float:
    return reads_example(e)  # here


@kernel
def reads_example(e: Example) -> float:
    return e.x


@kernel
def plain_python(x: float) -> float:
    return helper(x)  # here


def helper(x: float) -> float:
    return x


@kernel
def default_argument(x: float = 1.0) -> float:  # here
    return x


@kernel
def loop_over_table(e: Example) -> float:
    y = 0.0
    for value in e.table:  # here
        y = y + value
    return y


@kernel
def bool_arithmetic(x: float) -> float:
    return 2.0 * (x > 0.0)  # here


@kernel
def recursive(x: float) -> float:  # here
    return recursive(x)


@kernel
def wrong_result(x: float) -> int:
    return x  # here


@kernel
def bounds_the_wrong_way(e: Example, x: float) -> float:
    return e.table[to_index(x, 5, e.mode)]  # here


@kernel
def overflowing_product(e: Example) -> float:
    return e.table[min(e.large * e.large * e.large, 3)]  # here


@kernel
def unknown_sum(n: int) -> int:
    return n + 1  # here


@kernel
def huge_constant(x: float) -> float:
    return x + float(100000000000000000000)  # here


@kernel
def double(x: float) -> float:  # here
    return x


@kernel
def shadowed(x: float) -> float:  # here
    register = x
    return register


@kernel
def bump(e: Example) -> float:
    e.x = e.x + 1.0
    return e.x


@kernel
def hidden_order(e: Example) -> float:
    return bump(e) - 2.0 * e.x  # here


@kernel
def loop_name_is_a_local(x: float) -> float:
    i = 7
    for i in range(3):  # here
        y = x
    return x


@kernel
def index_by_call(e: Example) -> None:
    e.table[to_index(e.x, 0, 3)] /= 2.0  # here


@kernel
def only_a_docstring(x: float) -> float:  # here
    """Nothing."""


REFUSED = [
    unannotated, no_result, while_loop, early_return, two_types, integer_for_float, float_for_integer,
    integer_out_of_range, negative_index, index_too_large, unchecked_index, float_index, growing_index,
    one_index_for_two, int_of_float, a_slice, an_alias, a_tuple, modulo, floor_division, cube, number_as_condition,
    chained, three_arguments, mixed_maximum, other_maths, a_string, lower_case_global, unknown_field, maybe_unset,
    loop_variable_afterwards, assigned_parameter, raising, comprehension, keyword_call, wrong_record, plain_python,
    default_argument, loop_over_table, bool_arithmetic, recursive, wrong_result, bounds_the_wrong_way,
    overflowing_product, unknown_sum, huge_constant, double, shadowed, hidden_order, loop_name_is_a_local,
    index_by_call, only_a_docstring,
]  # fmt: skip


@kernel
def all_that_is_allowed(e: Example, x: float, n: int) -> float:
    """Everything in the subset once."""
    total = 0.0
    k = 0
    for i in range(SIZE - 1, -1, -1):
        if e.table[i] > x:
            break
        k = i
    for row in range(2):
        for column in range(3):
            total += e.matrix[row, column] * float(row + column)
    if n > 2 and not (x == 0.0):
        total = total + e.table[k]
    elif n < 0 or x != x:
        total = total - 1.0
    else:
        total /= 3.0
    j = to_index(x, 0, SIZE - 1)
    e.mode = min(max(n, 0), 3)
    e.table[j] = clamp(x, -1.0, 1.0)
    e.inner.value = math.tanh(x) if x > 0.0 else math.sqrt(x)
    return total + abs(x) + x**2 + max(x, 0.5) - min(e.x, x) / x
