"""What the checker knows of a value: its type, and for an integer the interval that it lies in."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from bitepoint.records import Field, Record

UNKNOWN_LOW, UNKNOWN_HIGH = -(1 << 63), (1 << 63) - 1


@dataclass(frozen=True)
class Value:
    """A value: kind is "float", "int", "bool", "none", "record", "array" or "records" (an array of records).

    Attributes:
        low, high: closed interval of an integer.
        record: type of a record, or of the elements of an array of records.
        field: declaration of the array or of the record's field that this is.
    """

    kind: str
    low: int = UNKNOWN_LOW
    high: int = UNKNOWN_HIGH
    record: type[Record] | None = None
    field: Field | None = None

    @property
    def known(self) -> bool:
        """Whether the interval of an integer says anything."""
        return self.low > UNKNOWN_LOW and self.high < UNKNOWN_HIGH

    def describe(self) -> str:
        """Return the type as a person calls it."""
        return self.record.__name__ if self.record is not None else self.kind


FLOAT, BOOL = Value("float"), Value("bool")


def integer(low: int = UNKNOWN_LOW, high: int = UNKNOWN_HIGH) -> Value:
    """Return an integer in low..high; one that may wrap may be anything."""
    if low < UNKNOWN_LOW or high > UNKNOWN_HIGH:
        low, high = UNKNOWN_LOW, UNKNOWN_HIGH
    return Value("int", low, high)


def of_field(field: Field) -> Value:
    """Return what reading the field of a record gives."""
    if field.record is not None:
        return Value("records" if field.shape else "record", record=field.record, field=field)
    if field.shape:
        return Value("array", field=field)
    if field.kind == "int":
        return replace(integer(int(field.low), int(field.high)), field=field)
    return Value("float", field=field)


def element_of(array: Value) -> Value:
    """Return what one element of an array is."""
    assert array.field is not None
    if array.kind == "records":
        return Value("record", record=array.record)
    return of_field(replace(array.field, shape=()))


def union(a: Value, b: Value) -> Value:
    """Return the value that is either a or b, of one type."""
    return replace(a, low=min(a.low, b.low), high=max(a.high, b.high)) if a.kind == "int" else a


def widened(before: Value, after: Value) -> Value:
    """Return `after` with every bound that has moved since `before` as far away as can be."""
    if after.kind != "int" or before == after:
        return after
    low = after.low if after.low == before.low else UNKNOWN_LOW
    return replace(after, low=low, high=after.high if after.high == before.high else UNKNOWN_HIGH)


def arithmetic(operator: str, a: Value, b: Value) -> Value:
    """Return the integer a + b, a - b or a * b; an unknown bound is an infinite one."""
    low, high, other_low, other_high = _ends(a) + _ends(b)
    if operator == "Add":
        corners = [low + other_low, high + other_high]
    elif operator == "Sub":
        corners = [low - other_high, high - other_low]
    else:
        corners = [x * y if x and y else 0 for x in (low, high) for y in (other_low, other_high)]
    least, most = min(corners), max(corners)
    return Value(
        "int",
        UNKNOWN_LOW if least <= UNKNOWN_LOW else int(least),
        UNKNOWN_HIGH if most >= UNKNOWN_HIGH else int(most),
    )


def _ends(value: Value) -> tuple[float, float]:
    low = -math.inf if value.low == UNKNOWN_LOW else value.low
    return low, math.inf if value.high == UNKNOWN_HIGH else value.high


def limited(function: str, a: Value, b: Value) -> Value:
    """Return the integer min(a, b) or max(a, b)."""
    pick = min if function == "min" else max
    return integer(pick(a.low, b.low), pick(a.high, b.high))
