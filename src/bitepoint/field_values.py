"""Values of fields as files give them: numbers with units, arrays, curves and maps, checked and in SI."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, cast

import numpy as np

from bitepoint.errors import InputError, brief
from bitepoint.fields import Axis, Field, joined
from bitepoint.units import UnitError, parse

Numbers = np.ndarray[Any, np.dtype[np.float64]]


def mapping(data: object, where: str, key: str, mend: str) -> dict[str, object]:
    """Return a block of keys.

    Raises:
        InputError: it is none; the error names `where` and `key` and ends with `mend`.
    """
    if not isinstance(data, Mapping):
        raise InputError(where, f"{key}: got {brief(data)}", mend)
    return {str(name): value for name, value in cast("Mapping[object, object]", data).items()}


def scalar(field: Field, value: Any, where: str, key: str, assumed: str | None = None) -> float:
    """Return the validated number; where it comes without a unit, it is in `assumed`, or else in the field's own.

    Raises:
        InputError: it is none, of another dimension, out of range, or no whole number where one is wanted.
    """
    plain = cast("object", value.item()) if isinstance(value, np.generic) else value
    if field.kind == "int":
        plain = _told(field, plain)
    try:
        number = parse(plain, field.unit, assumed)
    except UnitError as error:
        raise InputError(where, f"{key}: {error}", field.expected()) from None
    if not field.low <= number <= field.high or not math.isfinite(number):
        raise InputError(where, f"{key}: got {brief(plain)}", field.expected())
    if field.kind == "int" and number != int(number):
        raise InputError(where, f"{key}: got {brief(plain)}", field.expected())
    return number


def _told(field: Field, value: object) -> object:
    """Return the number that the name of a value stands for, or true or false for a flag; anything else as it is."""
    if isinstance(value, str) and value in field.names:
        return int(field.low) + field.names.index(value)
    if (field.low, field.high, field.names) == (0, 1, ()):
        return {"true": 1, "false": 0}.get(str(value).lower(), value)
    return value


def array(field: Field, value: object, where: str, key: str) -> Numbers:
    """Return the validated numbers of an array, in the shape of the field.

    Raises:
        InputError: another shape, or a number that `scalar` refuses.
    """
    values, unit = _listed(value, field.unit, where, key, field.expected())
    if field.padded and 1 <= len(values) < field.shape[0]:
        values = [*values, *[0.0] * (field.shape[0] - len(values))]
    places = list(_flattened(values, field, where, key))
    return np.array([scalar(field, item, where, place, unit) for place, item in places]).reshape(field.shape)


def table(field: Field, value: object, where: str, key: str) -> list[Numbers]:
    """Return the validated columns of a curve or a map: the points of each axis, and the values over them.

    Raises:
        InputError: an unknown or missing column, too few or too many points, an axis that does not increase, values
            in another shape than one per point, or a number that `scalar` refuses.
    """
    block = mapping(value, where, key, field.expected())
    names = [axis.name for axis in field.axes]
    for name in block:
        if name not in names:
            raise InputError(where, f"{key}.{name}: unknown key", f"expected {joined(names)}")
    for name in names:
        if name not in block:
            raise InputError(where, f"{key}.{name}: missing", field.expected())
    *over, last = field.axes
    grid = [_points(axis, field.most_points, block[axis.name], where, f"{key}.{axis.name}") for axis in over]
    element = _element(last, tuple(len(points) for points in grid))
    return [*grid, array(element, block[last.name], where, f"{key}.{last.name}")]


def _points(axis: Axis, most: int, value: object, where: str, key: str) -> Numbers:
    """Return the points along one axis."""
    element = _element(axis)
    values, unit = _listed(value, axis.unit, where, key, element.expected())
    if not 2 <= len(values) <= most:
        raise InputError(where, f"{key}: got {len(values)} points", f"expected 2 to {most}")
    points = [scalar(element, item, where, key, unit) for item in values]
    if any(after <= before for before, after in pairwise(points)):
        raise InputError(where, f"{key}: not strictly increasing", "sort the points and remove repeated ones")
    return np.array(points)


def _element(axis: Axis, shape: tuple[int, ...] = ()) -> Field:
    return Field(axis.name, "float", "", axis.unit, axis.low, axis.high, shape=shape)


def _flattened(value: object, field: Field, where: str, key: str, depth: int = 0) -> Iterator[tuple[str, object]]:
    """Yield (place, element) of nested lists, as long as these have the shape of the field; places name the row."""
    if depth == len(field.shape):
        yield key, value
        return
    items = list(cast("Sequence[object]", value)) if isinstance(value, list | tuple) else []
    if len(items) != field.shape[depth]:
        got = f"{len(items)} values" if isinstance(value, list | tuple) else brief(value)
        raise InputError(where, f"{key}: got {got}", field.expected())
    rows = depth < len(field.shape) - 1
    for number, item in enumerate(items):
        yield from _flattened(item, field, where, f"{key}[{number}]" if rows else key, depth + 1)


def _listed(value: object, unit: str, where: str, key: str, mend: str) -> tuple[list[object], str]:
    """Return the numbers and the unit of `[1, 2]` or `{unit: rpm, values: [1, 2]}`."""
    if isinstance(value, Mapping):
        block = mapping(cast("object", value), where, key, mend)
        if set(block) != {"unit", "values"}:
            raise InputError(where, f"{key}: got keys {', '.join(block) or 'none'}", "expected unit and values")
        unit, value = str(block["unit"]), block["values"]
    if isinstance(value, np.ndarray):
        value = cast("object", value.tolist())
    if not isinstance(value, list | tuple):
        raise InputError(where, f"{key}: got {brief(value)}", f"{mend}, as a list or {{unit: ..., values: [...]}}")
    return list(cast("Sequence[object]", value)), unit
