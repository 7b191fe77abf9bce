"""Panels of lines over time, one below the other, each with a legend of its own beside it."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

from bitepoint.recording import Floats, Recording

Line = tuple[str, str, float, str, str]
"""Channel, text of the legend, factor to the unit of the panel, colour, dash."""

Panel = tuple[str, Sequence[Line]]
"""Text of the axis with its unit, and the lines."""

RPM = 60.0 / (2.0 * math.pi)

MOST_POINTS = 10_000
"""Points of a line; of longer ones every second, third, ... point is drawn."""


def panels(
    recording: Recording,
    drawn: Sequence[Panel],
    more: int,
    title: str,
    *,
    held: Collection[str] = (),
    height: int = 200,
) -> Any:
    """Return a Plotly figure; channels that the recording lacks are left out.

    Args:
        drawn: panels, the first on top; `more` empty ones follow, for `add_line`.
        held: texts of lines that are constant from one sample to the next.
        height: of a panel, pixels.
    """
    from plotly import subplots

    library: Any = subplots
    rows = len(drawn) + more
    figure = library.make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.14 / rows)
    for row, (label, lines) in enumerate(drawn, 1):
        for name, text, scale, colour, dash in lines:
            if name in recording:
                add_line(figure, row, (text, colour, dash), recording.time, recording[name] * scale, held=text in held)
        figure.update_yaxes(title_text=label, row=row, col=1)
    figure.update_xaxes(title_text="time, s", row=rows, col=1)
    figure.update_layout(
        template="plotly_white", title={"text": title, "x": 0.02, "font": {"size": 15}}, height=height * rows,
        margin={"l": 70, "r": 190, "t": 70, "b": 50}, hovermode="x unified",
    )  # fmt: skip
    for row, axis in enumerate(figure.select_yaxes(), 1):
        figure.update_layout({_legend(row): {"y": axis.domain[1], "yanchor": "top", "x": 1.01}})
    return figure


def add_line(figure: Any, row: int, style: tuple[str, str, str], x: Floats, y: Floats, *, held: bool = False) -> None:
    """Draw y over x into a panel; `style` is the text of the legend, colour and dash."""
    import plotly.graph_objects as go

    text, colour, dash = style
    line = {"color": colour, "dash": dash, "width": 1.8, "shape": "hv" if held else "linear"}
    thin = slice(None, None, -(-len(x) // MOST_POINTS))
    trace = go.Scatter(x=x[thin].round(6), y=y[thin], name=text, mode="lines", line=line, legend=_legend(row))
    figure.add_trace(trace, row=row, col=1)


def _legend(row: int) -> str:
    return "legend" if row == 1 else f"legend{row}"


def settings_of(recording: Recording) -> list[str]:
    """Return what was set for a run, a text each."""
    return [f"{key.removeprefix('set.')} = {value}" for key, value in recording.about.items() if key.startswith("set.")]
