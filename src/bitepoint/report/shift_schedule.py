"""The picture of a shift schedule: speed over throttle, a line up and a line down for each pair of gears."""

from __future__ import annotations

from typing import Any

from bitepoint.planning.shift_schedule import ShiftSchedule
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED

COLOURS = (BLUE, ORANGE, GREEN, RED, "#7b4fa3", GREY, "#00838f")


def shift_schedule_figure(schedule: ShiftSchedule, title: str) -> Any:
    """Return a Plotly figure of a schedule: upshifts drawn through, downshifts dashed."""
    import plotly.graph_objects as go

    library: Any = go
    figure = library.Figure()
    for n, (up, down) in enumerate(zip(schedule.up, schedule.down, strict=True)):
        for speed, dash, text in ((up, "solid", f"{n + 1} → {n + 2}"), (down, "dash", f"{n + 2} → {n + 1}")):
            figure.add_trace(
                library.Scatter(
                    x=(100.0 * schedule.throttle).round(3), y=(3.6 * speed).round(3), name=text, mode="lines",
                    line={"color": COLOURS[n], "dash": dash, "width": 1.8},
                )
            )  # fmt: skip
    figure.update_xaxes(title_text="throttle, % of full load", range=[0, 100])
    figure.update_yaxes(title_text="speed, km/h", rangemode="tozero")
    figure.update_layout(
        template="plotly_white", title={"text": title, "x": 0.02, "font": {"size": 15}}, height=520,
        margin={"l": 70, "r": 120, "t": 60, "b": 50},
    )  # fmt: skip
    return figure
