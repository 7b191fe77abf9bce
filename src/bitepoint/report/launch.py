"""The picture of a launch: speeds, torques, motion, and jerk, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bitepoint import metrics
from bitepoint.metrics import Metrics
from bitepoint.recording import Floats, Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED, bullets, figures_table, page, pictures

_RPM = 60.0 / (2.0 * np.pi)

_HELD = ("clutch capacity commanded", "throttle", "engine target")
"""Commands: constant from one step of the controller to the next."""

_PANELS: Sequence[tuple[str, Sequence[tuple[str, str, float, str, str]]]] = (
    (
        "speed, rpm",
        (
            ("engine_speed", "engine", _RPM, BLUE, "solid"),
            ("clutch_speed", "clutch plate", _RPM, ORANGE, "solid"),
            ("engine_speed_target", "engine target", _RPM, GREY, "dot"),
        ),
    ),
    (
        "torque, N m",
        (
            ("engine_torque", "engine", 1.0, BLUE, "solid"),
            ("clutch_torque", "clutch", 1.0, ORANGE, "solid"),
            ("clutch_torque_command", "clutch capacity commanded", 1.0, GREY, "dot"),
        ),
    ),
    (
        "opening, %",
        (("pedal", "pedal", 100.0, GREY, "solid"), ("throttle", "throttle", 100.0, BLUE, "solid")),
    ),
    ("speed, km/h", (("vehicle_speed", "vehicle", 3.6, GREEN, "solid"),)),
)


def launch_figure(recording: Recording, title: str) -> Any:
    """Return the Plotly figure of a launch; channels that the recording lacks are left out."""
    from plotly import subplots

    library: Any = subplots
    figure = library.make_subplots(rows=5, cols=1, shared_xaxes=True, vertical_spacing=0.028)
    for row, (label, traces) in enumerate(_PANELS, 1):
        for name, text, scale, colour, dash in traces:
            if name in recording:
                _line(figure, row, text, recording.time, recording[name] * scale, colour, dash)
        figure.update_yaxes(title_text=label, row=row, col=1)
    _add_jerk(figure, recording)
    onset = metrics.pedal_onset(recording)
    sync = None if onset is None else metrics.sync_time(recording, onset)
    for time, text in ((onset, "pedal onset"), (sync, "sync")):
        if time is not None:
            figure.add_vline(x=time, line={"color": RED, "width": 1, "dash": "dash"}, row="all", col=1)
            note = {"text": text, "yanchor": "bottom", "showarrow": False, "font": {"color": RED, "size": 11}}
            figure.add_annotation(x=time, y=1.0, yref="y domain", xref="x", **note)
    figure.update_xaxes(title_text="time, s", row=5, col=1)
    figure.update_layout(
        template="plotly_white", title={"text": title, "x": 0.02, "font": {"size": 15}}, height=1000,
        margin={"l": 70, "r": 190, "t": 70, "b": 50}, hovermode="x unified",
    )  # fmt: skip
    for row, axis in enumerate(figure.select_yaxes(), 1):  # a legend of its own beside each panel
        figure.update_layout({_legend(row): {"y": axis.domain[1], "yanchor": "top", "x": 1.01}})
    return figure


def _line(figure: Any, row: int, text: str, x: Floats, y: Floats, colour: str, dash: str) -> None:
    import plotly.graph_objects as go

    line = {"color": colour, "dash": dash, "width": 1.8, "shape": "hv" if text in _HELD else "linear"}
    trace = go.Scatter(x=x.round(6), y=y, name=text, mode="lines", line=line, legend=_legend(row))
    figure.add_trace(trace, row=row, col=1)


def _legend(row: int) -> str:
    return "legend" if row == 1 else f"legend{row}"


def _add_jerk(figure: Any, recording: Recording) -> None:
    values = metrics.jerk(recording, float(recording.time[-1]))
    time = recording.time[0] + (np.arange(values.size) + 1) / metrics.JERK_SAMPLING
    if "vehicle_acceleration" in recording:
        acceleration = recording["vehicle_acceleration"]
        _line(figure, 5, "acceleration", recording.time, acceleration, GREEN, "dot")
    _line(figure, 5, "jerk", time, values, RED, "solid")
    figure.update_yaxes(title_text="jerk, m/s³; acceleration, m/s²", row=5, col=1)


def launch_page(recording: Recording, figures: Metrics, status: str, reason: str) -> str:
    """Return a self-contained HTML page: the figures of merit, the picture, and what was run."""
    title = " · ".join(recording.about.get(key, "") for key in ("scenario", "vehicle", "controller"))
    settings = [
        f"{key.removeprefix('set.')} = {value}" for key, value in recording.about.items() if key.startswith("set.")
    ]
    body = figures_table(figures) + bullets(settings, "Settings") + pictures([("", launch_figure(recording, ""))])
    footer = (
        f"bitepoint {recording.about.get('version', '')}. Jerk: vehicle speed at 100 Hz, differenced twice, order-2 "
        "Butterworth forwards and backwards at 10 Hz. jerk peak counts to sync, jerk peak settled to sync + 0.5 s."
    )
    return page(title, f"{status}: {reason}", body, footer)
