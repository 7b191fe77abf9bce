"""The page of a sweep: its figures over what was swept, the front of two of them, and the rows that failed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from bitepoint.report.page import BLUE, GREY, ORANGE, RED, bullets, page, pictures, table
from bitepoint.report.sweep_columns import Column, cell, columns
from bitepoint.report.sweep_overview import overview_figure

MOST_LISTED = 50
"""Most rows that a table of the page lists."""


class Objective(Protocol):
    """A figure of the front, see `studies.sweep.pareto.Objective`."""

    @property
    def figure(self) -> str:
        """Its name."""
        ...

    @property
    def largest(self) -> bool:
        """Whether more is better."""
        ...


class Sweep(Protocol):
    """A sweep, see `studies.sweep.SweepResult`."""

    @property
    def scenario(self) -> str:
        """Its name."""
        ...

    @property
    def rows(self) -> Any:
        """All rows, a pyarrow Table."""
        ...

    @property
    def counts(self) -> Mapping[str, int]:
        """How many rows ended how."""
        ...

    @property
    def failures(self) -> Sequence[str]:
        """Statuses of rows that failed."""
        ...

    @property
    def objectives(self) -> Sequence[Objective]:
        """The two figures of the front, or none."""
        ...

    @property
    def counted(self) -> npt.NDArray[np.bool_]:
        """Which rows may be on the front."""
        ...

    def front(self) -> Any:
        """The rows on the front, a pyarrow Table."""
        ...


def sweep_page(found: Sweep) -> str:
    """Return a self-contained HTML page."""
    swept = [column.name for column in columns(found.rows, "swept")]
    ended = ", ".join(f"{count} {status}" for status, count in found.counts.items())
    about = json.loads(found.rows.schema.metadata[b"bitepoint"])
    settings = bullets((f"{key} = {value}" for key, value in about["settings"].items()), "Settings")
    shown = [("", overview_figure(found.rows, None))]
    if found.objectives:
        shown.append((f"Front: {_traded(found.objectives)}", front_figure(found)))
    body = settings + pictures(shown)
    if found.objectives:
        body += _listed(found.front())
    body += _failed(found)
    footer = f"bitepoint {about['version']}, code {about['code']}, seed {about['seed']}. All numbers in SI."
    summary = f"{found.rows.num_rows} rows over {', '.join(swept)}: {ended}"
    return page(f"Sweep: {found.scenario}", summary, body, footer)


def _traded(objectives: Sequence[Objective]) -> str:
    return " and ".join(f"{'largest' if each.largest else 'least'} {_words(each.figure)}" for each in objectives)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _listed(rows: Any) -> str:
    """Return a table of the rows on the front with their figures."""
    if not rows.num_rows:
        return ""
    shown = rows.slice(0, MOST_LISTED)
    found = [*columns(shown, "swept"), *columns(shown, "figure")]
    values = [shown["row"].to_pylist(), *(column.values for column in found)]
    cells = ([cell(value) for value in row] for row in zip(*values, strict=True))
    more = rows.num_rows - shown.num_rows
    tail = f"<p>and {more} more, in sweep.parquet</p>" if more else ""
    rows_table = table(("row", *(column.label for column in found)), cells)
    return f"<h2>Rows on the front</h2><div style='overflow-x: auto'>{rows_table}</div>{tail}"


def _failed(found: Sweep) -> str:
    """Return a table of the reasons for which rows failed, the most frequent first, or nothing."""
    ended = zip(*(found.rows[name].to_pylist() for name in ("status", "reason", "row")), strict=True)
    rows: dict[str, list[int]] = {}
    for status, reason, number in ended:
        if status in found.failures:
            rows.setdefault(f"{status}: {reason}", []).append(number)
    if not rows:
        return ""
    reasons = sorted(rows, key=lambda reason: -len(rows[reason]))[:MOST_LISTED]
    cells = ([reason, str(len(rows[reason])), str(rows[reason][0])] for reason in reasons)
    return f"<h2>Rows that failed</h2>{table(('reason', 'rows', 'the first'), cells)}"


def front_figure(found: Sweep) -> Any:
    """Return the Plotly figure of two figures of merit over each other: all rows, and those on the front."""
    import plotly.graph_objects as go

    named = {column.name: column for column in columns(found.rows, "figure")}
    x, y = (named[each.figure] for each in found.objectives)
    numbers: Sequence[int] = found.rows["row"].to_pylist()
    texts = np.array(_told(found.rows), object)
    both = np.isfinite(x.numbers) & np.isfinite(y.numbers)
    places = {number: place for place, number in enumerate(numbers)}
    front = [places[number] for number in found.front()["row"].to_pylist()]
    figure = go.Figure()
    for name, which, marker in (
        ("rows", np.flatnonzero(both & found.counted), {"color": BLUE, "size": 6, "opacity": 0.55}),
        ("ended otherwise", np.flatnonzero(both & ~found.counted), {"color": GREY, "size": 7, "symbol": "x"}),
        ("front", front, {"color": ORANGE, "size": 10, "line": {"color": RED, "width": 1}}),
    ):
        if len(which):
            mode = "lines+markers" if name == "front" else "markers"
            figure.add_trace(
                go.Scatter(
                    x=x.numbers[which], y=y.numbers[which], mode=mode, name=name, marker=marker, text=texts[which],
                    line={"color": ORANGE, "width": 1.2, "dash": "dot"},
                    hovertemplate="%{text}<br>%{x:.4g}, %{y:.4g}<extra></extra>",
                )
            )  # fmt: skip
    lacking = int((~both).sum())
    note = f"{lacking} rows lack one of the two figures" if lacking else ""
    figure.update_layout(
        template="plotly_white", height=560, xaxis_title=x.label, yaxis_title=y.label,
        margin={"l": 80, "r": 30, "t": 60, "b": 60}, legend={"orientation": "h", "y": 1.08},
        annotations=[{"text": note, "xref": "paper", "yref": "paper", "x": 1, "y": 1.08, "showarrow": False}],
    )  # fmt: skip
    return figure


def _told(rows: Any) -> list[str]:
    """Return what a person reads over each row: its number, what was swept, and how it ended."""
    swept: list[Column] = columns(rows, "swept")
    texts: list[str] = []
    for n, (number, status) in enumerate(zip(rows["row"].to_pylist(), rows["status"].to_pylist(), strict=True)):
        texts.append("<br>".join([f"row {number}: {status}", *(f"{c.name} {cell(c.values[n])}" for c in swept)]))
    return texts
