"""The columns of a sweep's table, as pictures and tables need them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from bitepoint.recording import Floats
from bitepoint.units import display


@dataclass(frozen=True)
class Column:
    """A column: its name, its unit as a person reads it, its values, and whether they are numbers."""

    name: str
    unit: str
    values: Sequence[Any]
    numeric: bool

    @property
    def label(self) -> str:
        """Name and unit: "launch time, s"; a dotted key as it is written."""
        name = self.name if "." in self.name else self.name.replace("_", " ")
        return f"{name}, {self.unit}".removesuffix(", ")

    @cached_property
    def numbers(self) -> Floats:
        """Its numbers, NaN where there is none; of texts, the place among the different ones."""
        if self.numeric:
            return np.array([np.nan if value is None else value for value in self.values], np.float64)
        return np.array([self.levels.index(value) for value in self.values], np.float64)

    @cached_property
    def levels(self) -> list[Any]:
        """Its different values: numbers in increasing order, texts in order of the first."""
        found = [value for value in dict.fromkeys(self.values) if value is not None and value == value]
        return sorted(found) if self.numeric else found


def columns(rows: Any, role: str) -> list[Column]:
    """Return the columns of a pyarrow Table that have a role: "swept" or "figure"."""
    return [
        Column(field.name, display(field.metadata[b"unit"].decode()), rows[field.name].to_pylist(), _numeric(field))
        for field in rows.schema
        if field.metadata[b"role"].decode() == role
    ]


def _numeric(field: Any) -> bool:
    import pyarrow as pa

    return pa.types.is_floating(field.type) or pa.types.is_integer(field.type)


def cell(value: Any) -> str:
    """Return a value as a person reads it: four digits, a dash where there is none."""
    if value is None:
        return "–"
    if not isinstance(value, float):
        return str(value)
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e9 else f"{value:.4g}"
