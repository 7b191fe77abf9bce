"""Records as C structs."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator

from bitepoint.errors import InputError
from bitepoint.fields import joined
from bitepoint.kernels.c99.names import KEYWORDS, Names
from bitepoint.kernels.c99.precision import Precision
from bitepoint.kernels.c99.text import WIDTH, comment, indented, plain
from bitepoint.records import Field, Record


def with_nested(records: Iterable[type[Record]]) -> list[type[Record]]:
    """Return the records and all that they are made of, parts before wholes, each once."""
    found: dict[type[Record], None] = {}
    for record in records:
        parts = [field.record for field in record.fields.values() if field.record is not None]
        found |= dict.fromkeys([*with_nested(parts), record])
    return list(found)


def struct(record: type[Record], names: Names, precision: Precision) -> Iterator[str]:
    """Yield the lines of the struct that has the memory layout of a record in this precision.

    Raises:
        InputError: a field whose name C keeps for itself, or an integer that the precision cannot hold.
    """
    yield from comment(inspect.getdoc(record) or record.__name__)
    yield "typedef struct"
    yield "{"
    yield from indented(_lines(record, names, precision))
    yield f"}} {names.type(record)};"


def _lines(record: type[Record], names: Names, precision: Precision) -> Iterator[str]:
    for name, field in record.fields.items():
        where = f"{record.__name__}.{name}"
        if name in KEYWORDS:
            raise InputError(where, "the name means something in C", "give the field another name")
        if field.kind == "int" and not (field.low >= -(2**31) and field.high < 2**31):
            raise InputError(where, f"ranges over {field.low}..{field.high}", "integers in C have 32 bits")
        kind = {"float": precision.real, "int": precision.integer}.get(field.kind, "")
        kind = kind or names.type(field.record) if field.record is not None else kind
        size = "".join(f"[{length}]" for length in field.shape)
        line = f"{kind} {name}{size};"
        remark = f"/* {plain(describe(field))} */"
        if len(line) + len(remark) + 1 <= WIDTH - 4:
            yield f"{line} {remark}"
        else:
            yield from comment(describe(field), 1)
            yield line


def describe(field: Field) -> str:
    """Return unit, range and meaning of a field."""
    if field.axes:
        *over, last = (f"{axis.name} ({axis.unit}, {axis.low:g} .. {axis.high:g})" for axis in field.axes)
        return f"{last} over {joined(over)}: {field.meaning}"
    if field.record is not None:
        return field.meaning
    unit = "" if field.unit == "1" else f"{field.unit}, "
    return f"{unit}{field.low:g} .. {field.high:g}: {field.meaning}"
