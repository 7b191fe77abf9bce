"""The page of a paper that was reproduced."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from bitepoint.metrics import pedal_onset
from bitepoint.recording import Recording
from bitepoint.report.page import BLUE, GREEN, ORANGE, bullets, page, pictures, table
from bitepoint.version import __version__

_COLOURS = (ORANGE, BLUE, GREEN)


class Compared(Protocol):
    """A figure beside the published one, see `studies.reproduction.Row`."""

    @property
    def cells(self) -> Sequence[str]:
        """Case, quantity, published, ours, unit, tolerance, verdict."""
        ...


def reproduction_page(
    name: str, source: str, rows: Iterable[Compared], notes: Sequence[str], figures: Mapping[str, Any]
) -> str:
    """Return a self-contained HTML page: the table, the notes, the pictures."""
    header = ("case", "quantity", "published", "ours", "unit", "tolerance", "within")
    body = table(header, (row.cells for row in rows)) + bullets(notes, "Notes") + pictures(list(figures.items()))
    return page(f"Reproduction: {name}", source, body, f"bitepoint {__version__}")


def comparison_figure(launches: Mapping[str, Recording]) -> Any:
    """Return a figure with a column per intent: speeds, torques and vehicle speed of controllers over each other.

    Args:
        launches: recordings by "controller, intent"; the controllers in one order for all intents.
    """
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    intents = list(dict.fromkeys(name.rpartition(", ")[2] for name in launches))
    controllers = list(dict.fromkeys(name.rpartition(", ")[0] for name in launches))
    panels = (
        ("engine_speed", "engine speed, rad/s", "solid"),
        ("clutch_torque", "clutch torque, N m", "solid"),
        ("vehicle_acceleration", "acceleration, m/s²", "solid"),
        ("vehicle_speed", "vehicle speed, m/s", "solid"),
    )
    figure = library.make_subplots(
        rows=len(panels), cols=len(intents), subplot_titles=intents, shared_xaxes=True, vertical_spacing=0.04
    )
    for name, recording in launches.items():
        controller, _, intent = name.rpartition(", ")
        colour = _COLOURS[controllers.index(controller) % len(_COLOURS)]
        column = intents.index(intent) + 1
        onset = pedal_onset(recording) or 0.0
        for row, (signal, label, dash) in enumerate(panels, 1):
            line = {"color": colour, "width": 1.6, "dash": dash}
            first = row == 1 and column == 1
            trace = go.Scatter(
                x=(recording.time - onset).round(4), y=recording[signal], name=controller, mode="lines", line=line,
                showlegend=first, legendgroup=controller,
            )  # fmt: skip
            figure.add_trace(trace, row=row, col=column)
            if column == 1:
                figure.update_yaxes(title_text=label, row=row, col=1)
            if signal == "engine_speed":
                plate = {"color": colour, "width": 1.0, "dash": "dot"}
                figure.add_trace(
                    go.Scatter(
                        x=(recording.time - onset).round(4), y=recording["clutch_speed"], mode="lines", line=plate,
                        showlegend=False, name=f"{controller}, clutch",
                    ),
                    row=row, col=column,
                )  # fmt: skip
    figure.update_xaxes(title_text="time from pedal onset, s", row=len(panels))
    figure.update_layout(
        template="plotly_white", height=900, margin={"l": 70, "r": 30, "t": 60, "b": 60},
        legend={"orientation": "h", "y": 1.08},
    )  # fmt: skip
    return figure
