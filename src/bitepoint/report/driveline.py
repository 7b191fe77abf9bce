"""The picture of a driveline that is excited by changes of torque: speeds, torques, what swings, and motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from bitepoint import metrics
from bitepoint.metrics import Metrics
from bitepoint.recording import Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED, bullets, figures_table, page, pictures
from bitepoint.report.panels import RPM, Panel, add_line, panels, settings_of

_PANELS: Sequence[Panel] = (
    (
        "torque, N m",
        (
            ("torque_request", "driver", 1.0, GREY, "dot"),
            ("shaped_torque", "shaped", 1.0, GREEN, "dot"),
            ("engine_torque", "engine", 1.0, BLUE, "solid"),
            ("motor_torque", "motor", 1.0, ORANGE, "solid"),
        ),
    ),
    (
        "torsional speed, rad/s",
        (
            ("torsional_speed", "half-shafts", 1.0, RED, "solid"),
            ("torsional_speed_estimate", "observed", 1.0, GREY, "dot"),
        ),
    ),
    ("acceleration, m/s²", (("vehicle_acceleration", "vehicle", 1.0, GREEN, "solid"),)),
    (
        "speed, rpm",
        (("engine_speed", "engine", RPM, BLUE, "solid"), ("motor_speed", "motor", RPM, ORANGE, "dot")),
    ),
    (
        "speed, km/h",
        (("speed_target", "target", 3.6, GREY, "dot"), ("vehicle_speed", "vehicle", 3.6, GREEN, "solid")),
    ),
    ("slip of the tyres, %", (("tyre_slip", "driving", 100.0, BLUE, "solid"),)),
)


def driveline_figure(recording: Recording, title: str) -> Any:
    """Return the Plotly figure of a run; channels that the recording lacks are left out."""
    figure = panels(recording, _PANELS, 1, title)
    values = metrics.jerk(recording, float(recording.time[-1]))
    time = recording.time[0] + (np.arange(values.size) + 1) / metrics.JERK_SAMPLING
    add_line(figure, len(_PANELS) + 1, ("jerk", RED, "solid"), time, values)
    figure.update_yaxes(title_text="jerk, m/s³", row=len(_PANELS) + 1, col=1)
    return figure


def driveline_page(recording: Recording, figures: Metrics, status: str, reason: str) -> str:
    """Return a self-contained HTML page: the figures of merit, the picture, and what was run."""
    title = " · ".join(recording.about.get(key, "") for key in ("scenario", "vehicle", "controller"))
    picture = pictures([("", driveline_figure(recording, ""))])
    body = figures_table(figures) + bullets(settings_of(recording), "Settings") + picture
    footer = (
        f"bitepoint {recording.about.get('version', '')}. Peaks are largest magnitudes over the run. Jerk: vehicle "
        "speed at 100 Hz, differenced twice, order-2 Butterworth forwards and backwards at 10 Hz; jerk peak raw is not "
        "filtered. torque response time: 90 % of the driver's step by engine and motor together, longest of the run."
    )
    return page(title, f"{status}: {reason}", body, footer)
