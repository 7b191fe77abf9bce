"""What a sweep varies: the values of each key, and the grid of all their combinations."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from bitepoint.errors import InputError, brief
from bitepoint.files import parse_yaml_value

OVER = "--over"
"""What errors name as the place of a swept key."""

MOST_ROWS = 100_000
"""Most rows of a sweep."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RANGE = re.compile(rf"({_NUMBER})\s*:\s*({_NUMBER})\s*(?::\s*({_NUMBER}))?\s*([^:,]*)")
_QUANTITY = re.compile(rf"({_NUMBER})\s*(.*)")


@dataclass(frozen=True)
class Axis:
    """A swept key with its values, each as `--set` takes it."""

    key: str
    values: tuple[Any, ...]


def read_over(texts: Sequence[str]) -> dict[str, str]:
    """Return what is swept by key, from texts such as "road.grade=0:20:5 %".

    Raises:
        InputError: no equals sign, no key, or a key given twice.
    """
    over: dict[str, str] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not key or not value:
            mend = "expected KEY=start:stop:step or KEY=a,b,c, such as vehicle.mass='1400:1900:100 kg'"
            raise InputError(OVER, f"got {text!r}", mend)
        if key in over:
            raise InputError(OVER, f"{key}: given twice", "give all its values at once, as in KEY=a,b,c")
        over[key] = value
    return over


def axis(key: str, values: str | Sequence[Any] | npt.NDArray[Any]) -> Axis:
    """Return a swept key with its values: those of a text, or a sequence as it is.

    A text is `start:stop:step`, with both ends, a step of 1 where none is given, and a unit for all three after the
    last; or `a,b,c`, where a unit after the last number is that of all that have none.

    Raises:
        InputError: no such text, no value, one given twice, or more of them than a sweep can have.
    """
    if isinstance(values, str):
        found = _read(key, values.strip())
    elif np.ndim(values) == 0:
        raise InputError(OVER, f"{key}: got {brief(values)}", "expected a text such as 0:20:5, or a sequence")
    else:
        found = [plain(value) for value in values]
    if not found:
        raise InputError(OVER, f"{key}: no value", "expected one or more")
    _refuse_many(key, len(found))
    twice = [text for text, times in Counter(map(repr, found)).items() if times > 1]
    if twice:
        raise InputError(OVER, f"{key}: got {twice[0]} twice", "leave one of them out")
    return Axis(key, tuple(found))


def plain(value: Any) -> Any:
    """Return a value without NumPy's types."""
    return cast("Any", value.tolist()) if isinstance(value, np.generic | np.ndarray) else value


def _read(key: str, text: str) -> list[Any]:
    match = _RANGE.fullmatch(text)
    if match is not None:
        return _between(key, *match.groups())
    if re.match(rf"{_NUMBER}[^,:]*:", text):
        raise InputError(OVER, f"{key}: got {brief(text)}", "expected start:stop:step, with a unit after the last")
    items = list(_split(text))
    if not all(items):
        raise InputError(OVER, f"{key}: got {brief(text)}", "expected values with a comma between each two")
    last = _QUANTITY.fullmatch(items[-1])
    if last is not None and last[2]:
        items = [f"{item} {last[2]}" if re.fullmatch(_NUMBER, item) else item for item in items]
    return [parse_yaml_value(item, f"{OVER} {key}") if item[0] in "[{" else item for item in items]


def _split(text: str) -> Iterator[str]:
    """Yield what stands between commas that are in no bracket."""
    depth, start = 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "[{") - (letter in "]}")
        if letter == "," and depth <= 0:
            yield text[start:place].strip()
            start = place + 1
    yield text[start:].strip()


def _between(key: str, start: str, stop: str, step: str | None, unit: str) -> list[str]:
    """Return the values from start to stop, exact fractions until each is rounded once."""
    ends = [float(start), float(stop), float(step or 1)]
    if not all(map(math.isfinite, ends)):
        raise InputError(OVER, f"{key}: got {brief(f'{start}:{stop}')}", "expected finite numbers")
    if ends[2] == 0.0 or (ends[1] - ends[0]) * ends[2] < 0.0:
        mend = "expected steps that lead from start to stop, such as 0:20:5 or 20:0:-5"
        raise InputError(OVER, f"{key}: from {start} to {stop} in steps of {step or 1}", mend)
    _refuse_many(key, 1.0 + (ends[1] - ends[0]) // ends[2])
    first, last, width = Fraction(start), Fraction(stop), Fraction(step or 1)
    numbers = [float(first + n * width) for n in range((last - first) // width + 1)]
    return [f"{_shortest(number)} {unit}".rstrip() for number in numbers]


def _shortest(number: float) -> str:
    return str(int(number)) if number == int(number) and abs(number) < 1e15 else repr(number)


def _refuse_many(what: str, count: float) -> None:
    if not count <= MOST_ROWS:
        shown = f"{count:.0f}" if count < 1e9 else f"{count:.1e}"
        raise InputError(OVER, f"{what}: {shown} values", f"expected at most {MOST_ROWS}; take a larger step")


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some keys, numbered from 0: the last key changes fastest."""

    axes: tuple[Axis, ...]

    def __post_init__(self) -> None:
        """Hold the number of rows below its limit, and keys apart."""
        if not self.axes:
            raise InputError(OVER, "nothing is swept", "expected one or more, such as road.grade=0:20:5 %")
        if self.rows > MOST_ROWS:
            sizes = " x ".join(str(size) for size in self.shape)
            mend = f"expected at most {MOST_ROWS} rows; take larger steps, or sweep fewer keys at once"
            raise InputError(OVER, f"{sizes} values are {self.rows} rows", mend)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each key."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def rows(self) -> int:
        """Number of combinations."""
        return math.prod(self.shape)

    def row(self, number: int) -> dict[str, Any]:
        """Return the values of row `number` by key."""
        places = np.unravel_index(number, self.shape)
        return {axis.key: axis.values[int(place)] for axis, place in zip(self.axes, places, strict=True)}

    def place(self, number: int, key: str) -> int:
        """Return the place of the value that row `number` has of a key, among its values."""
        keys = [axis.key for axis in self.axes]
        return int(np.unravel_index(number, self.shape)[keys.index(key)])

    def groups(self, rows: Sequence[int], alike: Mapping[str, bool]) -> list[list[int]]:
        """Return `rows` in groups that share the values of the keys in `alike` that are True, in order of the first."""
        places = np.array(np.unravel_index(np.asarray(rows, np.intp), self.shape))
        shared = [n for n, axis in enumerate(self.axes) if alike[axis.key]]
        groups: dict[tuple[int, ...], list[int]] = {}
        for row, place in zip(rows, places[shared].T.tolist(), strict=True):
            groups.setdefault(tuple(place), []).append(row)
        return list(groups.values())
