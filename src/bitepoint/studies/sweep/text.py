"""A sweep as lines of text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from bitepoint.report.sweep_columns import cell
from bitepoint.studies.sweep.table import names
from bitepoint.units import display

if TYPE_CHECKING:
    from bitepoint.studies.sweep.result import SweepResult

MOST_LINES = 30
"""Most rows that are shown."""


def lines(found: SweepResult) -> Iterator[str]:
    """Yield how the rows ended, and then all rows where they are few, else those on the front, with its two figures.

    Rows on the front have a star.
    """
    reasons = dict(zip(found.rows["status"].to_pylist()[::-1], found.rows["reason"].to_pylist()[::-1], strict=True))
    for status, count in found.counts.items():
        first = f", the first: {reasons[status]}" if status in found.failures else ""
        yield f"  {count} {status}{first}"
    front = found.front()
    few = found.rows.num_rows <= MOST_LINES
    shown = found.rows if few else front.slice(0, MOST_LINES)
    if not shown.num_rows:
        return
    if not few:
        of = " and ".join(each.figure for each in found.objectives)
        count = f"{front.num_rows} row{'s' if front.num_rows > 1 else ''}"
        yield f"front of {of}, {count}" + (f", {MOST_LINES} of them" if front.num_rows > MOST_LINES else "")
    columns = ["row", *names(shown, "swept"), "status", *(each.figure for each in found.objectives)]
    yield from _table(shown, columns, frozenset(front["row"].to_pylist()))


def _table(rows: Any, columns: Sequence[str], stars: frozenset[int]) -> Iterator[str]:
    units = [display(rows.schema.field(name).metadata[b"unit"].decode()) for name in columns]
    cells = [[cell(value) for value in rows[name].to_pylist()] for name in columns]
    cells[0] = [f"{number}{'*' if int(number) in stars else ' '}" for number in cells[0]]
    widths = [max(map(len, (name, unit, *column))) for name, unit, column in zip(columns, units, cells, strict=True)]
    for line in (columns, units, *zip(*cells, strict=True)):
        yield _aligned(line, widths)


def _aligned(cells: Sequence[str], widths: Sequence[int]) -> str:
    return "  ".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True)).rstrip()
