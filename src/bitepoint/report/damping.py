"""Pictures of damping: runs over each other, what is possible, sweeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from bitepoint.recording import Floats, Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED

_COLOURS = (GREY, ORANGE, BLUE, GREEN, RED)

_SIGNALS = (
    ("torsional_speed", "torsional speed, rad/s"),
    ("vehicle_acceleration", "acceleration, m/s²"),
    ("engine_torque", "engine torque, N m"),
    ("motor_torque", "motor torque, N m"),
)

_FIGURES = (
    ("correction_torque_rms", "correction, N m"),
    ("torsional_speed_peak", "torsional speed, rad/s"),
    ("jerk_peak", "jerk, m/s³"),
    ("mean_absolute_jerk", "mean jerk, m/s³"),
)


class Optimum(Protocol):
    """An optimal torque of the motor, see `planning.damping_bound.DampingBound`."""

    @property
    def time(self) -> Floats: ...  # noqa: D102
    @property
    def torsional_speed(self) -> Floats: ...  # noqa: D102
    @property
    def motor_time(self) -> Floats: ...  # noqa: D102
    @property
    def motor_torque(self) -> Floats: ...  # noqa: D102


class Batch(Protocol):
    """Figures by name, shape (lanes,), see `api.BatchResult`."""

    @property
    def metrics(self) -> Mapping[str, Floats]: ...  # noqa: D102


def runs_figure(runs: Mapping[str, Recording]) -> Any:
    """Return the picture of runs over each other, by name."""
    figure, go = _rows(len(_SIGNALS))
    for n, (name, recording) in enumerate(runs.items()):
        for row, (signal, label) in enumerate(_SIGNALS, 1):
            line = {"color": _COLOURS[n % len(_COLOURS)], "width": 1.4}
            trace = go.Scatter(
                x=recording.time[::5].round(4), y=recording[signal][::5], name=name, mode="lines", line=line,
                legendgroup=name, showlegend=row == 1,
            )  # fmt: skip
            figure.add_trace(trace, row=row, col=1)
            figure.update_yaxes(title_text=label, row=row, col=1)
    return _finished(figure, "time, s", len(_SIGNALS))


def bound_figure(bounds: Mapping[float, Optimum]) -> Any:
    """Return the picture of the optima by the torque of the motor, N m."""
    figure, go = _rows(2)
    for n, (limit, best) in enumerate(bounds.items()):
        line = {"color": _COLOURS[n % len(_COLOURS)], "width": 1.6}
        name = f"{limit:g} N m"
        held = {**line, "shape": "hv"}
        swing = go.Scatter(x=best.time, y=best.torsional_speed, name=name, mode="lines", line=line, legendgroup=name)
        torque = go.Scatter(
            x=best.motor_time,
            y=best.motor_torque,
            name=name,
            mode="lines",
            line=held,
            legendgroup=name,
            showlegend=False,
        )
        figure.add_trace(swing, row=1, col=1)
        figure.add_trace(torque, row=2, col=1)
    figure.update_yaxes(title_text="torsional speed, rad/s", row=1, col=1)
    figure.update_yaxes(title_text="motor torque, N m", row=2, col=1)
    return _finished(figure, "time from the step, s", 2)


def trend_figure(trends: Mapping[str, tuple[Sequence[int], Batch]]) -> Any:
    """Return a column of figures over the swept value per sweep, by its name."""
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    titles = [name.removeprefix("controller.").replace("_", " ") for name in trends]
    rows = len(_FIGURES)
    figure = library.make_subplots(rows=rows, cols=len(trends), column_titles=titles, vertical_spacing=0.06)
    for column, (values, found) in enumerate(trends.values(), 1):
        for row, (name, label) in enumerate(_FIGURES, 1):
            line = {"color": BLUE, "width": 1.6}
            trace = go.Scatter(x=list(values), y=found.metrics[name], mode="lines+markers", line=line, showlegend=False)
            figure.add_trace(trace, row=row, col=column)
            if column == 1:
                figure.update_yaxes(title_text=label, row=row, col=1)
    figure.update_layout(template="plotly_white", height=220 * rows, margin={"l": 70, "r": 30, "t": 60, "b": 50})
    return figure


def heat_figure(prediction: Sequence[int], control: Sequence[int], grid: Mapping[str, Floats]) -> Any:
    """Return heat maps over both horizons; figures have the shape (prediction horizons, control horizons)."""
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    drawn = [(name, label) for name, label in _FIGURES if name in grid]
    figure = library.make_subplots(rows=2, cols=2, subplot_titles=[label for _, label in drawn], vertical_spacing=0.14)
    for n, (name, _) in enumerate(drawn):
        row, column = divmod(n, 2)
        bar = {"x": 0.45 + 0.55 * column, "y": 0.79 - 0.57 * row, "len": 0.44}
        heat = go.Heatmap(x=list(control), y=list(prediction), z=grid[name], colorscale="Viridis", colorbar=bar)
        figure.add_trace(heat, row=row + 1, col=column + 1)
        figure.update_xaxes(title_text="control horizon, steps", row=row + 1, col=column + 1)
        figure.update_yaxes(title_text="prediction horizon, steps", row=row + 1, col=column + 1)
    figure.update_layout(template="plotly_white", height=800, margin={"l": 70, "r": 30, "t": 60, "b": 50})
    return figure


def _rows(rows: int) -> tuple[Any, Any]:
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    return library.make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.04), go


def _finished(figure: Any, label: str, rows: int) -> Any:
    figure.update_xaxes(title_text=label, row=rows, col=1)
    figure.update_layout(
        template="plotly_white", height=210 * rows, margin={"l": 70, "r": 30, "t": 40, "b": 50},
        legend={"orientation": "h", "y": 1.08},
    )  # fmt: skip
    return figure
