"""The picture of the logs for identification: all runs over time, in one figure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bitepoint.metrics import Metrics
from bitepoint.recording import Recording
from bitepoint.report.page import figures_table, page, pictures, table

_PANELS = (
    ("engine_speed", "engine speed, rad/s"),
    ("slip", "slip, rad/s"),
    ("clutch_torque", "clutch torque, N m"),
    ("engine_torque", "engine torque, N m"),
    ("load_torque", "load torque at wheels, N m"),
)


def excitation_figure(logs: Mapping[str, Recording]) -> Any:
    """Return the Plotly figure of logs: a panel per channel, a line per run, time from the first row of each."""
    import plotly.graph_objects as go
    from plotly import colors, subplots

    library: Any = subplots
    palette: Any = colors
    figure = library.make_subplots(rows=len(_PANELS), cols=1, shared_xaxes=True, vertical_spacing=0.025)
    shades = palette.sample_colorscale("Viridis", [n / max(len(logs) - 1, 1) for n in range(len(logs))])
    for shade, (name, log) in zip(shades, logs.items(), strict=True):
        label = f"{name}: {_case(log)}"
        for row, (channel, _) in enumerate(_PANELS, 1):
            shape = "hv" if channel == "clutch_torque" else "linear"
            line = {"color": shade, "width": 1.2, "shape": shape}
            time = (log.time - log.time[0]).round(6)
            first = row == 1
            trace = go.Scatter(x=time, y=log[channel], name=label, line=line, legendgroup=name, showlegend=first)
            figure.add_trace(trace, row=row, col=1)
    for row, (_, title) in enumerate(_PANELS, 1):
        figure.update_yaxes(title_text=title, row=row, col=1)
    figure.update_xaxes(title_text="time since the vehicle moves, s", row=len(_PANELS), col=1)
    figure.update_layout(template="plotly_white", height=1100, margin={"l": 70, "r": 20, "t": 30, "b": 50})
    return figure


def _case(log: Recording) -> str:
    """Return what was particular about the run of a log."""
    keys = {key.removeprefix("run."): value for key, value in log.about.items() if key.startswith("run.")}
    return ", ".join(f"{key.partition('.')[2]} {value}" for key, value in keys.items() if key.count("sequence") == 0)


def excitation_page(logs: Mapping[str, Recording], figures: Metrics, status: str, reason: str) -> str:
    """Return a self-contained HTML page: figures, what was logged, and the picture."""
    about = next(iter(logs.values())).about
    title = " · ".join(about.get(key, "") for key in ("scenario", "vehicle", "controller"))
    rows = [[name, _case(log), str(len(log.time)), log.about["status"]] for name, log in logs.items()]
    settings = [[key.removeprefix("set."), value] for key, value in about.items() if key.startswith("set.")]
    body = figures_table(figures)
    body += table(("setting", "value"), settings) if settings else ""
    body += pictures([("All runs", excitation_figure(logs))])
    body += table(("log", "run", "rows", "ended"), rows)
    footer = (
        f"bitepoint {about.get('version', '')}. Rows: the vehicle moves, the clutch slips. Torques act from a row on."
    )
    return page(title, f"{status}: {reason}", body, footer)
