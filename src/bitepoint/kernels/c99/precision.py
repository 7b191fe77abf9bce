"""What floats and integers are in C, and a record's memory layout in each precision."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import numpy as np

from bitepoint.records import Field, Record, RecordArray


@dataclass(frozen=True)
class Precision:
    """The types of one precision.

    Attributes:
        name: as the command line has it.
        real, integer: C types of floats and integers, of the same size, so that records have no padding.
        size: of each, bytes.
        literal: suffix of a literal; maths: suffix of a function of the maths library.
        epsilon: what kernels call EPSILON.
        largest: largest finite float.
    """

    name: str
    real: str
    integer: str
    size: int
    literal: str
    maths: str
    epsilon: str
    largest: float

    @property
    def real_dtype(self) -> np.dtype[Any]:
        """NumPy's type of a float."""
        return np.dtype(f"f{self.size}")

    @property
    def integer_dtype(self) -> np.dtype[Any]:
        """NumPy's type of an integer."""
        return np.dtype(f"i{self.size}")

    def layout(self, record: type[Record]) -> np.dtype[Any]:
        """Return the memory layout of a record: its own in float64, the same order of smaller numbers in float32."""
        return _layout(self, record)

    def convert(self, array: RecordArray, record: type[Record]) -> RecordArray:
        """Return records in this precision; a float beyond its range becomes infinite, an integer must fit."""
        words = np.ascontiguousarray(array).view(np.int64).reshape(len(array), -1)
        floats = words.view(np.float64)
        with np.errstate(over="ignore"):
            result = floats.astype(self.real_dtype)
        whole = np.flatnonzero(whole_words(record))
        result.view(self.integer_dtype)[:, whole] = words[:, whole]
        return result.reshape(-1).view(self.layout(record))


@cache
def _layout(precision: Precision, record: type[Record]) -> np.dtype[Any]:
    def member(field: Field) -> tuple[Any, ...]:
        if field.record is not None:
            return (field.name, _layout(precision, field.record), field.shape)
        return (field.name, precision.real_dtype if field.kind == "float" else precision.integer_dtype, field.shape)

    return np.dtype([member(field) for field in record.fields.values()], align=True)


@cache
def whole_words(record: type[Record]) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return for each word of a record, in the order of its memory, whether it is an integer."""
    parts: list[np.ndarray[Any, np.dtype[np.bool_]]] = []
    for field in record.fields.values():
        size = int(np.prod(field.shape, dtype=int))
        if field.record is not None:
            parts.append(np.tile(whole_words(field.record), size))
        else:
            parts.append(np.full(size, field.kind == "int"))
    words = cast("np.ndarray[Any, np.dtype[np.bool_]]", np.concatenate(parts))
    words.flags.writeable = False
    return words


FLOAT64 = Precision("float64", "float64_t", "int64_t", 8, "", "", "DBL_EPSILON", float(np.finfo(np.float64).max))
FLOAT32 = Precision("float32", "float32_t", "int32_t", 4, "F", "f", "FLT_EPSILON", float(np.finfo(np.float32).max))

PRECISIONS: Mapping[str, Precision] = {precision.name: precision for precision in (FLOAT64, FLOAT32)}
"""Both, by name."""
