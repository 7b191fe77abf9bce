"""The picture of a planned drive beside others: speed, gear, engine speed, fuel and height over the way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np

from bitepoint.recording import Floats, Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE
from bitepoint.report.panels import MOST_POINTS, RPM

PLANNED = "plan"
"""Text of the speed and the gear that the planned drive is to follow."""

_LEAST_CLIMB = 1.0
"""Difference in height from which a road is drawn, m."""

_ROWS = ("speed, km/h", "gear", "engine, rpm", "fuel, g")


def drives_figure(drives: Mapping[str, Recording], title: str) -> Any:
    """Return the Plotly figure of drives over one way; the first of them follows a plan, which is drawn too.

    Args:
        drives: recordings by the text of the legend, all with the channels of a conventional vehicle.
    """
    from plotly import subplots
    from plotly.graph_objects import Scatter

    library, scatter = subplots, Scatter
    first = next(iter(drives.values()))
    hills = "elevation" in first and float(np.ptp(first["elevation"])) > _LEAST_CLIMB
    rows = (*_ROWS, "height, m") if hills else _ROWS
    figure: Any = library.make_subplots(rows=len(rows), cols=1, shared_xaxes=True, vertical_spacing=0.03)

    def line(row: int, recording: Recording, values: Floats, text: str, style: dict[str, Any]) -> None:
        thin = slice(None, None, -(-len(values) // MOST_POINTS))
        trace = scatter(
            x=recording["distance"][thin].round(3), y=values[thin], name=text, legendgroup=text, mode="lines",
            line=style, showlegend=row == 1,
        )  # fmt: skip
        figure.add_trace(trace, row=row, col=1)

    planned: dict[str, Any] = {"color": GREY, "dash": "dot", "width": 1.6}
    line(1, first, first["speed_wanted"] * 3.6, PLANNED, planned)
    line(2, first, first["gear_wanted"], PLANNED, {**planned, "shape": "hv"})
    for (text, recording), colour in zip(drives.items(), cycle((BLUE, ORANGE, GREEN)), strict=False):
        style: dict[str, Any] = {"color": colour, "width": 1.8}
        line(1, recording, recording["vehicle_speed"] * 3.6, text, style)
        engaged = np.where(recording["gear"] > 0.0, recording["gear"], math.nan)
        line(2, recording, engaged, text, {**style, "shape": "hv"})
        line(3, recording, recording["engine_speed"] * RPM, text, style)
        line(4, recording, recording["fuel_used"] * 1e3, text, style)
    if hills:
        line(5, first, first["elevation"], "road", {"color": GREY, "width": 1.6})
    for row, label in enumerate(rows, 1):
        figure.update_yaxes(title_text=label, row=row, col=1)
    figure.update_yaxes(dtick=1, row=2, col=1)
    figure.update_xaxes(title_text="way, m", row=len(rows), col=1)
    figure.update_layout(
        template="plotly_white", title={"text": title, "x": 0.02, "font": {"size": 15}}, height=180 * len(rows),
        margin={"l": 70, "r": 40, "t": 70, "b": 50}, legend={"orientation": "h", "y": 1.02, "yanchor": "bottom"},
    )  # fmt: skip
    return figure
