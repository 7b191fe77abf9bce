"""The picture of a drive: speed, gears, throttle, torques, engine speed, height, fuel and acceleration over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bitepoint.metrics import Metrics
from bitepoint.recording import Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED, bullets, figures_table, page, pictures
from bitepoint.report.panels import RPM, Panel, panels, settings_of
from bitepoint.report.planned import drives_figure

_HELD = ("gear wanted", "clutch capacity commanded", "throttle")
"""Commands: constant from one step of the controller to the next."""

_PANELS: Sequence[Panel] = (
    (
        "speed, km/h",
        (("speed_wanted", "followed", 3.6, GREY, "dot"), ("vehicle_speed", "vehicle", 3.6, GREEN, "solid")),
    ),
    ("gear", (("gear_wanted", "gear wanted", 1.0, GREY, "dot"), ("gear", "gear", 1.0, BLUE, "solid"))),
    (
        "speed, rpm",
        (("engine_speed", "engine", RPM, BLUE, "solid"), ("clutch_speed", "clutch plate", RPM, ORANGE, "solid")),
    ),
    (
        "torque, N m",
        (
            ("engine_torque_wanted", "driver", 1.0, GREY, "dot"),
            ("engine_torque", "engine", 1.0, BLUE, "solid"),
            ("clutch_torque", "clutch", 1.0, ORANGE, "solid"),
        ),
    ),
    ("opening, %", (("throttle", "throttle", 100.0, BLUE, "solid"),)),
    ("brake, N m", (("brake_torque", "brake", 1.0, RED, "solid"),)),
    ("acceleration, m/s²", (("vehicle_acceleration", "vehicle", 1.0, GREEN, "solid"),)),
    ("height, m", (("elevation", "road", 1.0, GREY, "solid"),)),
    ("fuel, g", (("fuel_used", "fuel", 1e3, RED, "solid"),)),
)


def driving_figure(recording: Recording, title: str) -> Any:
    """Return the Plotly figure of a drive; channels that the recording lacks are left out."""
    return panels(recording, _PANELS, 0, title, held=_HELD, height=150)


def driving_page(
    recording: Recording, figures: Metrics, status: str, reason: str, compared: Mapping[str, Recording]
) -> str:
    """Return a self-contained HTML page: the figures of merit, the pictures, and what was run.

    Args:
        compared: drives over the same way, by name; none for one that was not planned.
    """
    title = " · ".join(recording.about.get(key, "") for key in ("scenario", "vehicle", "controller"))
    drawn = [("Over time", driving_figure(recording, ""))]
    if compared:
        drives = {"planned, driven": recording, **{name: compared[name] for name in sorted(compared)}}
        drawn.insert(0, ("Over the way, beside the other drives", drives_figure(drives, "")))
    body = figures_table(figures) + bullets(settings_of(recording), "Settings") + pictures(drawn)
    where = "where the way ends" if compared else "of the last row"
    footer = (
        f"bitepoint {recording.about.get('version', '')}. Fuel, time, way and speed are those {where}. "
        "Peaks are largest magnitudes over the run. Jerk: vehicle speed at 100 Hz, differenced twice, order-2 "
        "Butterworth forwards and backwards at 10 Hz."
    )
    return page(title, f"{status}: {reason}", body, footer)
