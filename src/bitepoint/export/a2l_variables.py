"""What lies where in the memory of a part: every number of its records, by the path that C calls it."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bitepoint.export.c.sources import Sources
from bitepoint.kernels.c99 import Precision
from bitepoint.records import Field, Record
from bitepoint.simulation.system import Part


@dataclass(frozen=True)
class Variable:
    """A number, an array of numbers, a curve or a map in memory.

    Attributes:
        name: its path in C, such as `launch_pid_state.engine_speed.throttle`.
        symbol: the variable of C that it is part of; offset: from there, bytes.
        field: what is declared of it.
    """

    name: str
    symbol: str
    offset: int
    field: Field


@dataclass(frozen=True)
class Node:
    """A record in memory: its numbers, curves and maps, and the records that it is made of, each in their order."""

    name: str
    meaning: str
    variables: list[Variable]
    parts: list[Node]

    def all_variables(self) -> Iterator[Variable]:
        """Yield its variables and those of its parts."""
        yield from self.variables
        for part in self.parts:
            yield from part.all_variables()

    def all_nodes(self) -> Iterator[Node]:
        """Yield it and its parts, wholes before parts."""
        yield self
        for part in self.parts:
            yield from part.all_nodes()


def symbols(part: Part, precision: Precision) -> dict[str, tuple[str, type[Record]]]:
    """Return the variables of C that hold the records of a part: name -> (role, record type).

    A variable is called as the struct of its record, without the _t. Roles are parameters, state, inputs, outputs, and
    work where the part has scratch.

    Raises:
        SubsetError, InputError: the part cannot be translated; see `kernels.c99.translate`.
    """
    sources = Sources(part, precision, "", "")
    return {sources.instance(role): (role, record) for role, record in sources.records.items()}


def symbol_sizes(part: Part, precision: Precision) -> dict[str, int]:
    """Return how many bytes each variable of `symbols` takes, as `elf.symbol_addresses` wants to know.

    Raises:
        SubsetError, InputError: as `symbols` does.
    """
    return {name: precision.layout(record).itemsize for name, (_, record) in symbols(part, precision).items()}


def node(symbol: str, record: type[Record], precision: Precision) -> Node:
    """Return the tree of all that lies in the variable `symbol` of C, whose type is the struct of `record`."""
    meaning = (inspect.getdoc(record) or record.__name__).partition("\n\n")[0]
    return _node(symbol, symbol, 0, record, meaning, precision)


def _node(name: str, symbol: str, start: int, record: type[Record], meaning: str, precision: Precision) -> Node:
    found = Node(name, meaning, [], [])
    for field in record.fields.values():
        path, offset = f"{name}.{field.name}", start + _offset(record, field.name, precision)
        if field.record is None or field.axes:
            found.variables.append(Variable(path, symbol, offset, field))
            continue
        size = precision.layout(field.record).itemsize
        for place, index in enumerate(np.ndindex(field.shape)):
            element = path + "".join(f"[{number}]" for number in index)
            found.parts.append(_node(element, symbol, offset + place * size, field.record, field.meaning, precision))
    return found


def _offset(record: type[Record], name: str, precision: Precision) -> int:
    layout: Any = precision.layout(record).fields
    return int(layout[name][1])


def table_members(table: Variable, precision: Precision) -> Iterator[Variable]:
    """Yield the members of a curve or a map as variables of their own, x, y and z with the units of its axes."""
    record = table.field.record
    assert record is not None
    axes = iter(table.field.axes)
    for name, declared in record.fields.items():
        field = replace(declared, meaning=f"{table.field.meaning}: {declared.meaning}")
        if declared.kind == "float":
            axis = next(axes)
            field = replace(field, unit=axis.unit, low=axis.low, high=axis.high)
        yield Variable(f"{table.name}.{name}", table.symbol, table.offset + _offset(record, name, precision), field)
