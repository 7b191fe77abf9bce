"""Pictures of cheap launches: drives over distance, fuel against time, savings, and what wrong steps promise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bitepoint.models.plan import SpeedPlan
from bitepoint.recording import Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED
from bitepoint.report.panels import RPM

_COLOURS = (GREY, BLUE, GREEN, ORANGE)

_LAUNCH = (
    ("vehicle_speed", "speed, km/h", 3.6),
    ("gear", "gear", 1.0),
    ("engine_torque", "engine torque, N m", 1.0),
    ("engine_speed", "engine speed, rpm", RPM),
    ("fuel_used", "fuel, g", 1e3),
)
_HILLS = (
    ("elevation", "height, m", 1.0),
    ("vehicle_speed", "speed, km/h", 3.6),
    ("gear", "gear", 1.0),
    ("brake_torque", "brake, N m", 1.0),
)

_POINTS = 4000
"""Points of a line; of longer ones every second, third, ... point is drawn."""

Point = tuple[float, float]
"""Time, s, and fuel, kg."""


def launch_figure(drives: Mapping[str, Recording]) -> Any:
    """Return the picture of launches over distance, by name."""
    return _over_distance(drives, _LAUNCH, 1.0, "distance, m")


def hills_figure(drives: Mapping[str, Recording]) -> Any:
    """Return the picture of drives over hills, by name."""
    return _over_distance(drives, _HILLS, 1e-3, "distance, km")


def _over_distance(
    drives: Mapping[str, Recording], signals: Sequence[tuple[str, str, float]], scale: float, label: str
) -> Any:
    figure, go = _grid(rows=len(signals), cols=1, shared_xaxes=True, vertical_spacing=0.03)
    for (name, recording), colour in zip(drives.items(), _COLOURS, strict=False):
        thin = slice(None, None, -(-len(recording.time) // _POINTS))
        for row, (signal, text, factor) in enumerate(signals, 1):
            line = {"color": colour, "width": 1.6, "shape": "hv" if signal == "gear" else "linear"}
            values = recording[signal][thin] * factor
            if signal == "gear":
                values = [None if gear < 0.5 else float(gear) for gear in values]
            trace = go.Scatter(
                x=(recording["distance"][thin] * scale).round(4), y=values, name=name, mode="lines", line=line,
                legendgroup=name, showlegend=row == 1,
            )  # fmt: skip
            figure.add_trace(trace, row=row, col=1)
            figure.update_yaxes(title_text=text, row=row, col=1)
    figure.update_xaxes(title_text=label, row=len(signals), col=1)
    return _finished(figure, 190 * len(signals))


def front_figure(
    front: Sequence[SpeedPlan],
    published: Mapping[float, float],
    free: Mapping[float, float],
    drives: Mapping[str, tuple[Point, Point]],
    bound: float,
) -> Any:
    """Return the picture of fuel against time.

    Args:
        front: plans, the slowest first; published, free: fuel (kg) by time (s) where shifts cost nothing.
        drives: a driver and the plan of his time as driven, by name; bound: fuel at the best efficiency, kg.
    """
    figure, go = _grid(rows=1, cols=1)
    lines = (
        ("plans", [(plan.total_time, plan.total_fuel) for plan in front], BLUE, "lines+markers", "circle"),
        ("plans, shifts cost nothing", list(free.items()), GREEN, "markers", "diamond-open"),
        ("published, shifts cost nothing", list(published.items()), RED, "markers", "x-thin-open"),
        ("drivers", [one for one, _ in drives.values()], GREY, "markers+text", "square"),
        ("plans of their time, driven", [other for _, other in drives.values()], ORANGE, "markers", "triangle-down"),
    )
    for name, points, colour, mode, symbol in lines:
        text = list(drives) if "text" in mode else None
        trace = go.Scatter(
            x=[time for time, _ in points], y=[1e3 * fuel for _, fuel in points], name=name, mode=mode, text=text,
            textposition="top center", line={"color": colour, "width": 1.8},
            marker={"color": colour, "symbol": symbol, "size": 9, "line": {"width": 1.8, "color": colour}},
        )  # fmt: skip
        figure.add_trace(trace)
    least = "work at the wheels of the cheapest plan, at the best efficiency"
    figure.add_hline(y=1e3 * bound, line={"color": GREY, "dash": "dash"}, annotation_text=least)
    figure.update_xaxes(title_text="time, s")
    figure.update_yaxes(title_text="fuel, g")
    return _finished(figure, 480)


def savings_figure(savings: Mapping[str, tuple[float, float, float]], published: float) -> Any:
    """Return the picture of savings by driver: cheapest plan raw, slower by 3.18 km/h raw, equal time and energy."""
    figure, go = _grid(rows=1, cols=1)
    names = (
        ("the cheapest plan, raw", GREY), ("3.18 km/h slower, raw (the paper's protocol)", ORANGE),
        ("equal time and energy", BLUE),
    )  # fmt: skip
    for n, (name, colour) in enumerate(names):
        values = [100.0 * each[n] for each in savings.values()]
        text = [f"{value:.1f}" for value in values]
        figure.add_trace(
            go.Bar(x=list(savings), y=values, name=name, marker_color=colour, text=text, textposition="outside")
        )
    label = f"published, {100.0 * published:.2f} %"
    figure.add_hline(
        y=100.0 * published, line={"color": RED, "dash": "dash"}, annotation_text=label,
        annotation_position="top left",
    )  # fmt: skip
    figure.update_xaxes(title_text="driver")
    figure.update_yaxes(title_text="saving of fuel, %")
    return _finished(figure, 440)


def euler_figure(errors: Mapping[float, float], promised: Mapping[str, Mapping[float, float]], bound: float) -> Any:
    """Return the picture of steps over their length, m: error of the speed (m/s), and the promised fuel (kg)."""
    figure, go = _grid(rows=1, cols=2, subplot_titles=["too fast after 10 m at 2 m/s²", "fuel of 150 m as reckoned"])
    line = {"color": RED, "width": 1.8}
    error = go.Scatter(
        x=list(errors), y=[3.6 * each for each in errors.values()], mode="lines+markers", line=line, showlegend=False
    )
    figure.add_trace(error, row=1, col=1)
    for (name, fuels), colour in zip(promised.items(), (RED, BLUE), strict=True):
        line = {"color": colour, "width": 1.8}
        y = [1e3 * fuel for fuel in fuels.values()]
        figure.add_trace(go.Scatter(x=list(fuels), y=y, name=name, mode="lines+markers", line=line), row=1, col=2)
    dashed = {"color": GREY, "dash": "dash"}
    figure.add_hline(y=1e3 * bound, line=dashed, annotation_text="at the best efficiency", row=1, col=2)
    figure.update_xaxes(title_text="step, m", type="log", tickvals=list(errors), ticktext=[f"{x:g}" for x in errors])
    figure.update_yaxes(title_text="speed, km/h", row=1, col=1)
    figure.update_yaxes(title_text="fuel, g", rangemode="tozero", row=1, col=2)
    return _finished(figure, 420)


def cruise_figure(saved: Mapping[float, tuple[float, float]]) -> Any:
    """Return the picture of savings, and what explains them, over the grade's standard deviation."""
    figure, go = _grid(rows=1, cols=1)
    for n, (name, colour) in enumerate(
        (("saving in equal time", BLUE), ("what less braking and overrun explains", ORANGE))
    ):
        y = [round(100.0 * each[n], 3) + 0.0 for each in saved.values()]
        text = [f"{value:.1f}" for value in y]
        x = [f"{100.0 * grade:g} %" for grade in saved]
        figure.add_trace(go.Bar(x=x, y=y, name=name, marker_color=colour, text=text, textposition="outside"))
    figure.update_xaxes(title_text="standard deviation of the grade", type="category")
    figure.update_yaxes(title_text="fuel, % of the held set speed")
    return _finished(figure, 400)


def _grid(**shape: Any) -> tuple[Any, Any]:
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    return library.make_subplots(**shape), go


def _finished(figure: Any, height: int) -> Any:
    figure.update_layout(
        template="plotly_white", height=height, margin={"l": 70, "r": 30, "t": 60, "b": 50},
        legend={"orientation": "h", "yanchor": "bottom", "y": 1.0 + 30.0 / height, "x": 0.0},
    )  # fmt: skip
    return figure
