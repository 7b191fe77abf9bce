"""Fields of records: what is declared of each number, once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bitepoint.units import display

if TYPE_CHECKING:
    from bitepoint.records import Record

CURVE_POINTS = 32
"""Most points that a curve can have."""

MAP_POINTS = 16
"""Most points that a map can have along each of its two axes."""


@dataclass(frozen=True)
class Axis:
    """One coordinate of a curve or a map: its name in files, its unit and its range."""

    name: str
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class Field:
    """What a record says of one of its fields.

    Attributes:
        kind: "float", "int", "record", or "curve" or "map" (a nested `Curve` or `Map` with units of its own).
        unit: of a float, in pint's spelling; "1" for a plain ratio.
        low, high: closed range that validation enforces and that index checks rely on.
        default: value where a file leaves the field out; None means that it must be given.
        shape: of a fixed-size array; () for a scalar.
        padded: whether a file may give fewer numbers than the shape; the rest is then 0.
        record: the type of a nested record; of a curve or a map, `Curve` or `Map`.
        axes: of a curve or a map: what it is over, and last what it gives; () for anything else.
        names: of its values, the whole numbers from low to high; () where they have none.
    """

    name: str
    kind: str
    meaning: str
    unit: str = "1"
    low: float = -math.inf
    high: float = math.inf
    default: float | None = None
    shape: tuple[int, ...] = ()
    padded: bool = False
    record: type[Record] | None = None
    axes: tuple[Axis, ...] = ()
    names: tuple[str, ...] = ()

    @property
    def most_points(self) -> int:
        """Most points along an axis of a curve or a map."""
        return CURVE_POINTS if self.kind == "curve" else MAP_POINTS

    def expected(self) -> str:
        """Return what a valid value looks like, in a few words."""
        if self.kind == "record":
            return "expected a block of keys"
        if self.axes:
            return f"expected a block with {joined([f'{axis.name} ({axis.unit})' for axis in self.axes])}"
        if self.kind == "int" and self.names and not self.shape:
            return f"expected one of {', '.join(self.names)}"
        noun = "a whole number" if self.kind == "int" else "a number"
        many = "" if not self.shape else " x ".join(str(size) for size in self.shape) + " times "
        many = f"up to {many}" if self.padded else many
        unit = "" if self.unit == "1" else f" {display(self.unit)}"
        return f"expected {many}{noun} in {self.low:g}..{self.high:g}{unit}"


def quantity(  # noqa: PLR0913 - four numbers that every field has, and four that few have, by name
    unit: str,
    low: float,
    high: float,
    meaning: str,
    *,
    default: float | None = None,
    shape: tuple[int, ...] = (),
    padded: bool = False,
    names: tuple[str, ...] = (),
) -> Any:
    """Declare a float field (or a fixed-size array of them) with its unit, closed range and meaning.

    A signal that tells a mode has `names`, one for each whole number from low to high; its meaning then tells them too.
    """
    told = _told(meaning, low, high, names)
    return Field("", "float", told, unit, low, high, default, shape, padded, names=names)


def count(
    low: int,
    high: int,
    meaning: str,
    *,
    default: int | None = None,
    shape: tuple[int, ...] = (),
    names: tuple[str, ...] = (),
) -> Any:
    """Declare an integer field: a count, an index, a flag (0..1), or a mode with the names of its values."""
    return Field("", "int", _told(meaning, low, high, names), "1", low, high, default, shape, names=names)


def _told(meaning: str, low: float, high: float, names: tuple[str, ...]) -> str:
    """Return a meaning with the names of the values: "phase: 0 waiting, 1 slipping"."""
    if not names:
        return meaning
    if len(names) != high - low + 1 or low != int(low) or len(set(names)) != len(names):
        raise TypeError(f"{meaning}: {len(names)} names; expected a different one for each value in {low:g}..{high:g}")
    return f"{meaning}: {', '.join(f'{int(low) + n} {name}' for n, name in enumerate(names))}"


def nested(record: type[Record], meaning: str, *, shape: tuple[int, ...] = ()) -> Any:
    """Declare a field that is itself a record, or a fixed-size array of records (which no file can give)."""
    return Field("", "record", meaning, record=record, shape=shape)


def curve(x: tuple[str, str, float, float], y: tuple[str, str, float, float], meaning: str) -> Any:
    """Declare a curve y(x) of 2 to 32 points; `x` and `y` are (name in files, unit, low, high)."""
    return Field("", "curve", meaning, axes=(Axis(*x), Axis(*y)))


def characteristic_map(
    x: tuple[str, str, float, float], y: tuple[str, str, float, float], z: tuple[str, str, float, float], meaning: str
) -> Any:
    """Declare a map z(x, y) of 2 to 16 points along each axis; each is (name in files, unit, low, high)."""
    return Field("", "map", meaning, axes=(Axis(*x), Axis(*y), Axis(*z)))


def joined(names: Sequence[str]) -> str:
    """Return names as a sentence has them: "a, b and c"."""
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else "".join(names)
