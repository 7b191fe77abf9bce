"""The picture of a sweep: its figures over what was swept.

Over one key, a panel per figure; over two keys, a heat map per figure, to be chosen from a menu, or panels with a line
for each text where one of the two is no number; over more, parallel coordinates. Rows without a figure are marked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bitepoint.recording import Floats
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED
from bitepoint.report.sweep_columns import Column, columns

_COLOURS = (BLUE, ORANGE, GREEN, GREY, "#8e44ad", "#16a085", "#b7950b")
_SCALE = "Viridis"

MOST_REASONS = 5000
"""Most rows of a sweep whose picture tells why they failed."""

MOST_TICKS = 12
"""Most values of a key that are all written beside an axis."""


def overview_figure(rows: Any, metric: str | None) -> Any:
    """Return the Plotly figure of a sweep.

    Args:
        rows: a pyarrow Table, as `studies.sweep` makes it.
        metric: the figure of merit that is shown first where only one is; None: the first.
    """
    swept, figures = columns(rows, "swept"), columns(rows, "figure")
    shown = next((n for n, figure in enumerate(figures) if figure.name == metric), 0)
    hints = _hints(rows)
    texts = [column for column in swept if not column.numeric]
    if len(swept) == 1:
        return _panels(swept[0], None, figures, hints)
    if len(swept) == 2 and len(texts) == 1:
        return _panels(next(column for column in swept if column.numeric), texts[0], figures, hints)
    if len(swept) == 2:
        return _heat_maps(swept[1], swept[0], figures, hints, shown)
    return _parallel(swept, figures, shown)


def _hints(rows: Any) -> Any:
    """Return what is read over each row that lacks a figure; of many rows without the reason, which fills the page."""
    numbers, statuses, reasons = (rows[name].to_pylist() for name in ("row", "status", "reason"))
    told = [f"<br>{_folded(reason)}" if rows.num_rows <= MOST_REASONS else "" for reason in reasons]
    texts = [f"row {n}: {status}{reason}" for n, status, reason in zip(numbers, statuses, told, strict=True)]
    return np.array(texts, object)


def _folded(text: str) -> str:
    """Return a sentence in lines that fit into a hint."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > 70:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".lstrip()
    return "<br>".join(lines)


def _panels(x: Column, beside: Column | None, figures: list[Column], hints: Any) -> Any:
    from plotly import subplots

    library: Any = subplots
    count = -(-len(figures) // 2)
    names = [figure.label for figure in figures]
    figure = library.make_subplots(rows=count, cols=2, subplot_titles=names, vertical_spacing=0.2 / count)
    for n, each in enumerate(figures):
        for k, level in enumerate([None] if beside is None else beside.levels):
            which = np.array([level is None or value == level for value in (beside or x).values])
            _line(figure, n, x, each, which, hints, (k, level))
    for n in range(max(len(figures) - 2, 0), len(figures)):
        figure.update_xaxes(title_text=x.label, row=n // 2 + 1, col=n % 2 + 1)
    figure.update_layout(
        template="plotly_white", height=240 * count + 150, margin={"l": 70, "r": 30, "t": 100, "b": 50},
        legend={"orientation": "h", "y": 1.0 + 75.0 / (240.0 * count), "yanchor": "bottom"},
    )  # fmt: skip
    return figure


def _line(figure: Any, n: int, x: Column, y: Column, which: Any, hints: Any, level: tuple[int, Any]) -> None:
    """Draw one figure over one key: a line with a gap, and a cross at the bottom, where there is no number."""
    import plotly.graph_objects as go

    place, name = level
    row, column = n // 2 + 1, n % 2 + 1
    colour = _COLOURS[place % len(_COLOURS)]
    across = np.array(x.values, object)[which]
    values = y.numbers[which]
    order = np.argsort(x.numbers[which], kind="stable")
    mode = "lines+markers" if x.numeric else "markers"
    shared: dict[str, Any] = {"legendgroup": str(name), "name": str(name), "text": hints[which][order]}
    line = go.Scatter(
        x=across[order], y=_gaps(values[order]), mode=mode, line={"color": colour, "width": 1.8}, marker={"size": 6},
        showlegend=name is not None and n == 0, hovertemplate="%{x}: %{y:.4g}<br>%{text}<extra></extra>", **shared,
    )  # fmt: skip
    figure.add_trace(line, row=row, col=column)
    lacking = ~np.isfinite(values[order])
    if lacking.any():
        bottom = np.nanmin(y.numbers) if np.isfinite(y.numbers).any() else 0.0
        cross = go.Scatter(
            x=across[order][lacking], y=np.full(int(lacking.sum()), bottom), mode="markers", showlegend=False,
            marker={"symbol": "x", "color": RED, "size": 8}, legendgroup=str(name), text=hints[which][order][lacking],
            hovertemplate="%{x}: no figure<br>%{text}<extra></extra>",
        )  # fmt: skip
        figure.add_trace(cross, row=row, col=column)


def _gaps(values: Floats) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]


def _heat_maps(x: Column, y: Column, figures: list[Column], hints: Any, shown: int) -> Any:
    import plotly.graph_objects as go

    figure = go.Figure()
    across, up = ([str(level) if not c.numeric else level for level in c.levels] for c in (x, y))
    places = {(a, b): n for n, (a, b) in enumerate(zip(x.values, y.values, strict=True))}
    order = np.array([[places.get((a, b), -1) for a in x.levels] for b in y.levels])
    for n, each in enumerate(figures):
        values = np.append(each.numbers, np.nan)[order]
        told = np.append(hints, "")[order]
        figure.add_trace(
            go.Heatmap(
                x=across, y=up, z=values, customdata=order, colorscale=_SCALE, visible=n == shown,
                colorbar={"title": {"text": each.label, "side": "right"}},
                hovertemplate="row %{customdata}: %{x}, %{y}: %{z:.4g}<extra></extra>",
            )
        )  # fmt: skip
        rows, places_across = np.nonzero(~np.isfinite(values))
        figure.add_trace(
            go.Scatter(
                x=[across[k] for k in places_across], y=[up[k] for k in rows], mode="markers", visible=n == shown,
                marker={"symbol": "x", "color": RED, "size": 8}, text=told[rows, places_across], showlegend=False,
                hovertemplate="%{x}, %{y}: no figure<br>%{text}<extra></extra>",
            )
        )  # fmt: skip
    buttons: list[dict[str, Any]] = []
    for n, each in enumerate(figures):
        visible = [k // 2 == n for k in range(2 * len(figures))]
        buttons.append({"label": each.name.replace("_", " "), "method": "update", "args": [{"visible": visible}]})
    _menu(figure, buttons, shown)
    figure.update_layout(xaxis_title=x.label, yaxis_title=y.label)
    figure.update_layout(xaxis=_ticks(x), yaxis=_ticks(y))
    return figure


def _ticks(column: Column) -> dict[str, Any]:
    if not column.numeric:
        return {"type": "category"}
    return {"tickvals": column.levels} if len(column.levels) <= MOST_TICKS else {}


def _parallel(swept: list[Column], figures: list[Column], shown: int) -> Any:
    """Return parallel coordinates of the rows that have all figures: each a line, coloured by one figure."""
    import plotly.graph_objects as go

    drawn = [each for each in figures if np.isfinite(each.numbers).any()]
    whole: Any = np.isfinite([each.numbers for each in [*swept, *drawn]]).all(axis=0)
    dimensions: list[dict[str, Any]] = []
    for column in [*swept, *drawn]:
        dimension: dict[str, Any] = {
            "label": column.label,
            "values": column.numbers[whole],
            "tickformat": _format(column),
        }
        if not column.numeric:
            ticks = list(range(len(column.levels)))
            dimension |= {"tickvals": ticks, "ticktext": [str(level) for level in column.levels]}
        dimensions.append(dimension)
    coloured = [_coloured(each, whole) for each in drawn]
    first = drawn.index(figures[shown]) if figures[shown] in drawn else 0
    figure = go.Figure(go.Parcoords(dimensions=dimensions, line=coloured[first], labelangle=-20))
    buttons = [
        {
            "label": each.name.replace("_", " "), "method": "restyle",
            "args": [{"line.color": [line["color"]], "line.cmin": [line["cmin"]], "line.cmax": [line["cmax"]],
                      "line.colorbar.title.text": [each.label]}],
        }
        for each, line in zip(drawn, coloured, strict=True)
    ]  # fmt: skip
    _menu(figure, buttons, first)
    left_out = int((~whole).sum())
    note = f"{left_out} of {len(whole)} rows lack a figure and are not drawn" if left_out else ""
    figure.update_layout(
        height=620, margin={"l": 80, "r": 60, "t": 140, "b": 40}, updatemenus=[{"y": 1.32}],
        annotations=[{"text": note, "xref": "paper", "yref": "paper", "x": 1, "y": 1.32, "showarrow": False}],
    )  # fmt: skip
    return figure


def _format(column: Column) -> str:
    """Return plain digits, or letters for the powers of ten of what is large or small."""
    most = np.nanmax(np.abs(column.numbers), initial=0.0)
    return ".4~g" if most == 0.0 or 0.01 <= most < 1e4 else ".4~s"


def _coloured(column: Column, whole: Any) -> dict[str, Any]:
    values = column.numbers[whole]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    title = {"text": column.label, "side": "right"}
    return {"color": values, "cmin": low, "cmax": high, "colorscale": _SCALE, "showscale": True,
            "colorbar": {"title": title}}  # fmt: skip


def _menu(figure: Any, buttons: list[dict[str, Any]], active: int) -> None:
    menu = {"buttons": buttons, "active": active, "x": 0, "xanchor": "left", "y": 1.16, "yanchor": "top"}
    figure.update_layout(
        template="plotly_white", height=560, updatemenus=[menu], margin={"l": 80, "r": 30, "t": 80, "b": 60}
    )
