"""What the checker refuses, where it says so, and what it lets pass."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

from bitepoint.errors import SubsetError
from bitepoint.kernels import Kernel, kernel
from bitepoint.kernels.subset import check
from tests.kernels import subset_examples


@pytest.mark.parametrize("kernel", subset_examples.REFUSED, ids=lambda kernel: kernel.name)
def test_refuses_with_file_and_line(kernel: Kernel[..., Any]) -> None:
    lines, first = inspect.getsourcelines(kernel.function)
    marked = first + next(number for number, line in enumerate(lines) if "# here" in line)
    with pytest.raises(SubsetError) as caught:
        check(kernel)
    assert caught.value.line == marked
    assert str(caught.value).startswith(f"{subset_examples.__file__}:{marked}: ")
    assert "\n" not in str(caught.value)
    assert "; " in str(caught.value)  # the mend


def test_every_refused_example_is_listed() -> None:
    kernels = [value for value in vars(subset_examples).values() if isinstance(value, Kernel)]
    own = [kernel for kernel in kernels if kernel.__module__ == subset_examples.__name__]
    assert len(own) - len(subset_examples.REFUSED) == 3  # reads_example, bump and all_that_is_allowed


def test_allows_the_subset() -> None:
    found = check(subset_examples.all_that_is_allowed)
    assert (found.locals["k"].low, found.locals["k"].high) == (0, 3)
    assert found.result.kind == "float"
    assert found.written == {"e"}
    assert check(subset_examples.reads_example).written == set()


@kernel
def counters(e: subset_examples.Example) -> int:
    """Counters in locals: one bounded above, one that runs both ways, and their sum."""
    up = 0
    both = 0
    total = 0
    for _i in range(4):
        up = min(up + 1, 3)
        both = max(min(both + (1 if e.x > 0.0 else -1), 2), -2)
        total = max(min(total + up * both, 1000), -1000)
        e.table[up] = e.x
    e.mode = up
    return both + max(total, -5) + i_of(up)


@kernel
def i_of(k: int) -> int:
    """Return k in 0..3."""
    return max(min(k, 3), 0)


def test_counters_in_locals_are_bounded_by_min_and_max() -> None:
    found = check(counters)
    assert (found.locals["up"].low, found.locals["up"].high) == (0, 3)
    assert (found.locals["both"].low, found.locals["both"].high) == (-2, 2)
    lives = ("compiled", "interpreted")
    assert len({int(counters.run(subset_examples.Example.zeros(), life=life)[0]) for life in lives}) == 1


def test_check_comes_before_any_life() -> None:
    with pytest.raises(SubsetError):
        subset_examples.negative_index.entry("compiled")
    with pytest.raises(SubsetError):
        subset_examples.negative_index.entry("interpreted")
