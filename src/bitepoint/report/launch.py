"""The picture of a launch: speeds, torques, motion, and jerk, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bitepoint import metrics
from bitepoint.metrics import Metrics
from bitepoint.recording import Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED, bullets, figures_table, page, pictures
from bitepoint.report.panels import RPM, Panel, add_line, panels, settings_of

_HELD = ("clutch capacity commanded", "throttle", "engine target")
"""Commands: constant from one step of the controller to the next."""

_PANELS: Sequence[Panel] = (
    (
        "speed, rpm",
        (
            ("engine_speed", "engine", RPM, BLUE, "solid"),
            ("clutch_speed", "clutch plate", RPM, ORANGE, "solid"),
            ("engine_speed_target", "engine target", RPM, GREY, "dot"),
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
    figure = panels(recording, _PANELS, 1, title, held=_HELD)
    _add_jerk(figure, recording)
    onset = metrics.pedal_onset(recording)
    sync = None if onset is None else metrics.sync_time(recording, onset)
    for time, text in ((onset, "pedal onset"), (sync, "sync")):
        if time is not None:
            figure.add_vline(x=time, line={"color": RED, "width": 1, "dash": "dash"}, row="all", col=1)
            note = {"text": text, "yanchor": "bottom", "showarrow": False, "font": {"color": RED, "size": 11}}
            figure.add_annotation(x=time, y=1.0, yref="y domain", xref="x", **note)
    return figure


def _add_jerk(figure: Any, recording: Recording) -> None:
    values = metrics.jerk(recording, float(recording.time[-1]))
    time = recording.time[0] + (np.arange(values.size) + 1) / metrics.JERK_SAMPLING
    if "vehicle_acceleration" in recording:
        acceleration = recording["vehicle_acceleration"]
        add_line(figure, 5, ("acceleration", GREEN, "dot"), recording.time, acceleration)
    add_line(figure, 5, ("jerk", RED, "solid"), time, values)
    figure.update_yaxes(title_text="jerk, m/s³; acceleration, m/s²", row=5, col=1)


def launch_page(recording: Recording, figures: Metrics, status: str, reason: str) -> str:
    """Return a self-contained HTML page: the figures of merit, the picture, and what was run."""
    title = " · ".join(recording.about.get(key, "") for key in ("scenario", "vehicle", "controller"))
    body = (
        figures_table(figures)
        + bullets(settings_of(recording), "Settings")
        + pictures([("", launch_figure(recording, ""))])
    )
    footer = (
        f"bitepoint {recording.about.get('version', '')}. Jerk: vehicle speed at 100 Hz, differenced twice, order-2 "
        "Butterworth forwards and backwards at 10 Hz. jerk peak counts to sync, jerk peak settled to sync + 0.5 s."
    )
    return page(title, f"{status}: {reason}", body, footer)
