"""The table of a sweep: a row per combination; what a column is, its unit and its meaning in its metadata.

The role of a column is `swept`, `outcome` (number, status, reason), `figure`, or `origin` (configuration and version).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from bitepoint.studies.sweep.plan import SEED, Plan, code_digest
from bitepoint.studies.sweep.rows import Row
from bitepoint.version import __version__

ROLES = ("outcome", "swept", "figure", "origin")
"""Order of the columns."""

_ORIGIN: Mapping[str, str] = {
    "configuration": "scenario, vehicle, controller, seed and all settings of the row, as JSON",
    "parameters": "digest of the effective parameters of the run",
    "version": "version of bitepoint",
    "code": "digest of the sources that the run depends on",
}


def table_of(plan: Plan, rows: Sequence[Row]) -> Any:
    """Return the rows as a pyarrow Table."""
    pa = _arrow()
    columns = list(_columns(plan, rows))
    fields = [
        pa.field(name, _type(kind), metadata={"role": role, "unit": unit, "meaning": meaning})
        for role, name, kind, unit, meaning, _ in columns
    ]
    arrays = [pa.array(values, each.type) for each, (*_, values) in zip(fields, columns, strict=True)]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def _arrow() -> Any:
    import pyarrow as pa

    return pa


def _type(kind: str) -> Any:
    pa = _arrow()
    return {"int": pa.int64(), "float": pa.float64(), "text": pa.string()}[kind]


_Column = tuple[str, str, str, str, str, list[Any]]


def _columns(plan: Plan, rows: Sequence[Row]) -> Iterator[_Column]:
    """Yield role, name, kind, unit, meaning and values of each column."""
    yield "outcome", "row", "int", "1", "number of the row in the grid", [row.number for row in rows]
    yield "outcome", "status", "text", "1", "how the run ended", [row.status for row in rows]
    yield "outcome", "reason", "text", "1", "why it ended, or why it was refused", [row.reason for row in rows]
    places = np.array(np.unravel_index([row.number for row in rows], plan.grid.shape))
    for swept, place in zip(plan.swept, places.tolist(), strict=True):
        channel = swept.channel
        yield "swept", channel.name, swept.kind, channel.unit, channel.meaning, [swept.values[n] for n in place]
    units = {name: metric.unit for row in rows for name, metric in row.metrics.items()}
    for name, unit in units.items():
        found = [row.metrics.get(name) for row in rows]
        values = [None if metric is None else metric.value for metric in found]
        yield "figure", name, "float", unit, name.replace("_", " "), values
    given = [plan.row(row.number) for row in rows]
    if all(swept.axis.key != SEED for swept in plan.swept):
        yield "origin", SEED, "int", "1", "seed of the noise", [seed for _, seed in given]
    texts = {
        "configuration": [configuration(plan, row) for row in rows],
        "parameters": [row.parameters or None for row in rows],
        "version": [__version__] * len(rows),
        "code": [code_digest()] * len(rows),
    }
    for name, values in texts.items():
        yield "origin", name, "text", "1", _ORIGIN[name], values


def configuration(plan: Plan, row: Row) -> str:
    """Return all that a row was made of, as JSON: its settings are what `bitepoint run --set` takes."""
    settings, seed = plan.row(row.number)
    own = {name: str(settings.get(name, getattr(plan.scenario, name))) for name in ("vehicle", "controller")}
    about = {"scenario": plan.name, **own, "seed": seed, "settings": settings}
    return json.dumps(about, ensure_ascii=False, default=str)


def merged(tables: Iterable[Any], about: Mapping[str, Any]) -> Any:
    """Return all rows of tables in order, as one table with `about` in its metadata.

    What a table has no column for is null there: figures, where all its rows were refused.
    """
    pa = _arrow()
    ordered = sorted((table for table in tables if table.num_rows), key=lambda table: table["row"][0].as_py())
    found = {field.name: field for table in ordered for field in table.schema}
    fields = sorted(found.values(), key=lambda field: ROLES.index(field.metadata[b"role"].decode()))
    schema = pa.schema(fields, metadata={"bitepoint": json.dumps(dict(about), default=str)})
    return pa.concat_tables([_widened(table, schema) for table in ordered]).sort_by("row").combine_chunks()


def _widened(table: Any, schema: Any) -> Any:
    pa = _arrow()
    columns = [
        table[field.name] if field.name in table.column_names else pa.nulls(table.num_rows, field.type)
        for field in schema
    ]
    return pa.Table.from_arrays(columns, schema=schema)


def names(table: Any, role: str) -> list[str]:
    """Return the names of the columns of one role."""
    return [field.name for field in table.schema if field.metadata[b"role"].decode() == role]


def numbers(table: Any, name: str) -> Any:
    """Return a column of numbers as a NumPy array of floats, NaN where it is null."""
    return np.array(table[name].to_numpy(zero_copy_only=False), np.float64)
