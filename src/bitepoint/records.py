"""Records: parameters, states and signals declared once, with unit, range and meaning.

    class Body(Record):
        \"\"\"The body of a car. Source: ...\"\"\"

        mass: float = quantity("kg", 100, 60_000, "mass of the loaded vehicle")
        points: int = count(0, 8, "points in use")
        speeds: FloatArray = quantity("rad/s", 0, 1200, "grid", shape=(8,))
        engine: Engine = nested(Engine, "the engine")
        full_load: Curve = curve(("speed", "rad/s", 0, 1200), ("torque", "N*m", 0, 900), "full-load torque")
        fuel: Map = characteristic_map(
            ("speed", "rad/s", 0, 1200), ("torque", "N*m", 0, 900), ("flow", "kg/s", 0, 0.1), "fuel flow"
        )

From the one declaration come an aligned NumPy dtype, the validation of YAML with units, and the tables of the docs.
Every number is a float64 or an int64, so that a record is the same bytes to NumPy, to compiled code and to C.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Protocol, TypeVar, cast

import numpy as np

from bitepoint import field_values
from bitepoint.errors import InputError
from bitepoint.fields import (
    CURVE_POINTS,
    MAP_POINTS,
    Axis,
    Field,
    characteristic_map,
    count,
    curve,
    joined,
    nested,
    quantity,
)
from bitepoint.units import display

__all__ = [
    "CURVE_POINTS", "MAP_POINTS", "Axis", "Curve", "Field", "FloatArray", "IntArray", "Map", "Record", "RecordArray",
    "RecordElements", "characteristic_map", "count", "curve", "nested", "quantity", "tabulated",
]  # fmt: skip

RecordArray = np.ndarray[Any, Any]
"""A one-dimensional NumPy array whose elements are records of one type: one element per lane."""


class FloatArray(Protocol):
    """A fixed-size array of floats inside a record, as a kernel sees it."""

    def __getitem__(self, index: int | tuple[int, int], /) -> float: ...
    def __setitem__(self, index: int | tuple[int, int], value: float, /) -> None: ...


class IntArray(Protocol):
    """A fixed-size array of integers inside a record, as a kernel sees it."""

    def __getitem__(self, index: int | tuple[int, int], /) -> int: ...
    def __setitem__(self, index: int | tuple[int, int], value: int, /) -> None: ...


R_co = TypeVar("R_co", covariant=True)


class RecordElements(Protocol[R_co]):
    """A fixed-size array of records inside a record, as a kernel sees it."""

    def __getitem__(self, index: int, /) -> R_co: ...


class Record:
    """Base of all records. A record type is never instantiated: its values live in NumPy arrays of its dtype."""

    fields: ClassVar[dict[str, Field]] = {}
    dtype: ClassVar[np.dtype[Any]] = np.dtype([])

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if cls.__bases__ != (Record,):
            raise TypeError(f"{cls.__name__}: a record has no other base than Record; nest records instead")
        annotations = inspect.get_annotations(cls)
        fields: dict[str, Field] = {}
        for name, annotation in annotations.items():
            declared = cls.__dict__.get(name)
            if not isinstance(declared, Field):
                mend = "quantity(), count(), nested(), curve() or characteristic_map()"
                raise TypeError(f"{cls.__name__}.{name} must be declared by {mend}")
            record = _table_type(declared.kind) if declared.axes else declared.record
            fields[name] = replace(declared, name=name, record=record)
            _check_annotation(f"{cls.__name__}.{name}", annotation, fields[name])
            delattr(cls, name)
        for name, value in cls.__dict__.items():
            if isinstance(value, Field):
                raise TypeError(f"{cls.__name__}.{name} has no annotation")
        cls.fields = fields
        cls.dtype = np.dtype([_layout(field) for field in fields.values()], align=True)

    @classmethod
    def zeros(cls, lanes: int = 1) -> RecordArray:
        """Return `lanes` records, every number 0."""
        return np.zeros(lanes, cls.dtype)

    @classmethod
    def parse(cls, data: object, where: str, key: str = "") -> RecordArray:
        """Return one record, shape (1,), from a mapping as YAML gives it.

        Args:
            data: mapping from field names to numbers, texts with units, lists, or nested mappings.
            where: what errors name as the place, usually the file.
            key: dotted path of this record inside the file, for errors.

        Raises:
            InputError: unknown or missing key, wrong dimension, out of range, NaN, or wrong shape.
        """
        result = cls.zeros()
        mapping = field_values.mapping(data, where, key or cls.__name__, "expected a block of keys")
        prefix = f"{key}." if key else ""
        for name in mapping:
            if name not in cls.fields:
                raise InputError(where, f"{prefix}{name}: unknown key", f"expected one of {', '.join(cls.fields)}")
        for name, field in cls.fields.items():
            if name in mapping:
                _store(result[name], field, mapping[name], where, prefix + name)
            elif field.kind == "record" and field.record is not None and field.record.is_optional():
                result[name] = field.record.parse({}, where, prefix + name)[0]
            elif field.default is None:
                raise InputError(where, f"{prefix}{name}: missing", field.expected())
            else:
                result[name] = field.default
        return result

    @classmethod
    def is_optional(cls) -> bool:
        """Return whether a file may leave the whole record out: every field has a default."""
        return all(
            field.default is not None
            or (field.kind == "record" and field.record is not None and field.record.is_optional())
            for field in cls.fields.values()
        )

    @classmethod
    def assign(cls, target: RecordArray, key: str, value: Any, where: str, prefix: str = "") -> None:
        """Set the field at the dotted path `key` of every record in `target` to `value`, validated.

        `value` may also be a sequence of one value per record of `target`, where the field is a scalar.
        Errors name `prefix` and `key`.

        Raises:
            InputError: no such field, or a value that it does not take; `target` is then unchanged.
        """
        field, view = cls.locate(target, key, where, prefix)
        key = prefix + key
        if not isinstance(value, str) and np.ndim(value) == 1 and not field.shape and field.kind in ("float", "int"):
            values = cast("Sequence[object]", value)
            if len(values) != len(target):
                mend = f"expected {len(target)} values, one per lane"
                raise InputError(where, f"{key}: got {len(values)} values", mend)
            view[...] = [field_values.scalar(field, item, where, key) for item in values]
        else:
            _store(view, field, value, where, key)

    @classmethod
    def locate(cls, target: RecordArray, key: str, where: str, prefix: str = "") -> tuple[Field, RecordArray]:
        """Return the field at the dotted path `key`, and the view of `target` that holds it."""
        name, _, rest = key.partition(".")
        field = cls.fields.get(name)
        if field is None:
            raise InputError(where, f"{prefix}{key}: unknown key", f"expected one of {', '.join(cls.fields)}")
        if not rest:
            return field, target[name]
        if field.kind != "record" or field.record is None:
            raise InputError(where, f"{prefix}{key}: {name} has no keys of its own", field.expected())
        return field.record.locate(target[name], rest, where, f"{prefix}{name}.")

    @classmethod
    def to_mapping(cls, record: Any) -> dict[str, Any]:
        """Return one record (an element of an array) as a mapping in SI that `parse` takes again."""
        return {name: plain(field, record[name]) for name, field in cls.fields.items()}

    @classmethod
    def table(cls, prefix: str = "") -> Iterator[tuple[str, Field]]:
        """Yield (dotted path, field) for every number, curve and map, nested records included."""
        for name, field in cls.fields.items():
            if field.kind == "record" and field.record is not None:
                yield from field.record.table(f"{prefix}{name}.")
            else:
                yield prefix + name, field

    @classmethod
    def markdown(cls) -> str:
        """Return the table of this record for the documentation."""
        rows = ["| name | unit | range | default | meaning |", "| --- | --- | --- | --- | --- |"]
        for path, field in cls.table():
            if field.axes:
                *over, last = (f"{axis.name} ({display(axis.unit) or 'ratio'})" for axis in field.axes)
                unit, span = f"{last} over {joined(over)}", f"{field.axes[-1].low:g} .. {field.axes[-1].high:g}"
            else:
                unit, span = display(field.unit) or "–", f"{field.low:g} .. {field.high:g}"
            default = "–" if field.default is None else f"{field.default:g}"
            rows.append(f"| `{path}` | {unit} | {span} | {default} | {field.meaning} |")
        return "\n".join(rows)


def _check_annotation(where: str, annotation: object, field: Field) -> None:
    wanted = {"float": "FloatArray" if field.shape else "float", "int": "IntArray" if field.shape else "int"}
    nested_name = field.record.__name__ if field.record is not None else ""
    nested_name = f"RecordElements[{nested_name}]" if field.record is not None and field.shape else nested_name
    name = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", str(annotation))
    if name != wanted.get(field.kind, nested_name):
        raise TypeError(f"{where} is annotated {name} but declared {wanted.get(field.kind, nested_name)}")


def _layout(field: Field) -> tuple[Any, ...]:
    base: Any = {"float": np.float64, "int": np.int64}.get(field.kind)
    if field.record is not None:
        base = field.record.dtype
    return (field.name, base, field.shape) if field.shape else (field.name, base)


def _store(view: RecordArray, field: Field, value: object, where: str, key: str) -> None:
    """Write a validated value into `view`, the field's column: (lanes, *shape)."""
    if field.kind == "record" and field.record is not None:
        view[...] = field.record.parse(value, where, key)[0]
    elif field.axes:
        view[...] = tabulated(field, *field_values.table(field, value, where, key))[0]
    elif field.shape:
        view[...] = field_values.array(field, value, where, key)
    else:
        view[...] = field_values.scalar(field, value, where, key)


def plain(field: Field, value: Any) -> Any:
    """Return a value of a field, one of an element of an array, as `parse` takes it: numbers, lists and mappings."""
    if field.axes and field.record is not None:
        sizes, columns = _members(field.record)
        points = [slice(int(value[name])) for name in sizes]
        used = [(part,) for part in points] + [tuple(points)]
        return {axis.name: value[c][part].tolist() for axis, c, part in zip(field.axes, columns, used, strict=True)}
    if field.kind == "record" and field.record is not None:
        return [field.record.to_mapping(each) for each in value] if field.shape else field.record.to_mapping(value)
    if field.shape:
        return value.tolist()
    return int(value) if field.kind == "int" else float(value)


class Curve(Record):
    """A piecewise linear curve y(x), held constant beyond its ends. Units are the declaring field's."""

    points: int = count(2, CURVE_POINTS, "points in use")
    x: FloatArray = quantity("1", -1e12, 1e12, "abscissae, increasing; the unused ones repeat the last", shape=(32,))
    y: FloatArray = quantity("1", -1e12, 1e12, "ordinates; the unused ones repeat the last", shape=(32,))

    @classmethod
    def through(cls, x: Sequence[float], y: Sequence[float]) -> RecordArray:
        """Return the curve, shape (1,), through 2 to 32 points whose abscissae increase."""
        return _tabulated(cls, x, y)


class Map(Record):
    """A map z(x, y), bilinear on a grid and held constant beyond its edges. Units are the declaring field's."""

    x_points: int = count(2, MAP_POINTS, "points in use along x")
    y_points: int = count(2, MAP_POINTS, "points in use along y")
    x: FloatArray = quantity("1", -1e12, 1e12, "grid along x, increasing; the unused ones repeat the last", shape=(16,))
    y: FloatArray = quantity("1", -1e12, 1e12, "grid along y, increasing; the unused ones repeat the last", shape=(16,))
    z: FloatArray = quantity(
        "1", -1e12, 1e12, "values, a row for each x; the unused ones repeat the last", shape=(16, 16)
    )

    @classmethod
    def through(cls, x: Sequence[float], y: Sequence[float], z: Sequence[Sequence[float]]) -> RecordArray:
        """Return the map, shape (1,), over 2 to 16 increasing points of x and of y; z is (points of x, points of y)."""
        return _tabulated(cls, x, y, z)


def tabulated(field: Field, *columns: Any) -> RecordArray:
    """Return the curve or the map of a field, shape (1,), through its columns: x and y, or x, y and z."""
    return _table_type(field.kind).through(*columns)


def _table_type(kind: str) -> type[Curve] | type[Map]:
    return Curve if kind == "curve" else Map


def _members(table: type[Record]) -> tuple[list[str], list[str]]:
    """Return the fields of a curve or a map that tell how many points are in use, and those that hold them."""
    kinds = ("int", "float")
    sizes, columns = ([name for name, field in table.fields.items() if field.kind == kind] for kind in kinds)
    return sizes, columns


def _tabulated(table: type[Record], *columns: Any) -> RecordArray:
    """Return a curve or a map, shape (1,), whose columns are filled up by repeating their last values."""
    result = table.zeros()
    sizes, names = _members(table)
    for name, points in zip(sizes, np.shape(columns[-1]), strict=True):
        result[name] = points
    for name, column in zip(names, columns, strict=True):
        room = table.fields[name].shape
        spare = [(0, most - used) for most, used in zip(room, np.shape(column), strict=True)]
        result[name] = np.pad(np.asarray(column, np.float64), spare, mode="edge")
    return result
