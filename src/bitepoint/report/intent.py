"""The picture of launch intention: how often network and rule are right over time, and single launches."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.controllers.launch_intent import INTENTIONS
from bitepoint.identification.intent.assessment import draw_lot
from bitepoint.identification.intent.decisions import Windows, calibration
from bitepoint.identification.intent.launches import PERIOD, Integers, Launches
from bitepoint.recording import Floats

_BLUE, _GREY = "#1f6fb4", "#8a8f98"
_COLOURS = ("#2a8f4b", "#e07b00", "#c0392b")
"""Of slow, normal and urgent."""

_PLACES = ((1, 2), (2, 1), (2, 2))


def intent_figure(launches: Launches, network: Windows, rule: Windows, chosen: Sequence[int]) -> Any:
    """Return the Plotly figure.

    Args:
        launches: with their true intentions.
        network, rule: their windows as network and rule decide them.
        chosen: three launches to be shown.
    """
    from plotly import subplots

    library: Any = subplots
    titles = ["share of launches decided rightly", *(_title(launches, number) for number in chosen)]
    figure = library.make_subplots(rows=2, cols=2, subplot_titles=titles, vertical_spacing=0.14)
    time: Floats = PERIOD * np.arange(1.0, network.intention.shape[1] + 1.0)
    _add_accuracy(figure, time, launches, network, rule)
    for (row, col), number in zip(_PLACES, chosen, strict=True):
        _add_launch(figure, row, col, time, network, rule, number)
    figure.update_xaxes(title_text="time from pedal onset, s")
    figure.update_layout(
        template="plotly_white", height=800, width=1100, margin={"l": 60, "r": 30, "t": 60, "b": 110},
        legend={"orientation": "h", "y": -0.1},
    )  # fmt: skip
    return figure


def _title(launches: Launches, number: int) -> str:
    kind = "one press" if launches.plain[number] else "a press in stages, or creeping before it"
    return f"{INTENTIONS[launches.intention[number]]}: {kind}"


def _add_accuracy(figure: Any, time: Floats, launches: Launches, network: Windows, rule: Windows) -> None:
    for name, found, colour in (("network", network, _BLUE), ("rule", rule, _GREY)):
        right = found.intention == launches.intention[:, None]
        for kind, chosen, dash in (("one press", launches.plain, "solid"), ("others", ~launches.plain, "dot")):
            shares = 100.0 * right[chosen].mean(axis=0)
            _line(figure, 1, 1, time, shares, f"{name}, {kind}", {"color": colour, "dash": dash, "width": 2})
    figure.update_yaxes(title_text="%", range=[30, 100], row=1, col=1)
    figure.add_vline(x=0.28, line={"color": _GREY, "width": 1, "dash": "dash"}, row=1, col=1)


def _add_launch(figure: Any, row: int, col: int, time: Floats, network: Windows, rule: Windows, number: int) -> None:
    """Draw the pedal, and below it what network (upper band) and rule (lower band) tell."""
    pedal = 100.0 * network.inputs[number, :, 0]
    _line(figure, row, col, time, pedal, "", {"color": "#222", "width": 2})
    for level, found in ((-3.0, network), (-6.0, rule)):
        _add_band(figure, row, col, time, found.intention[number], level)
    figure.update_yaxes(title_text="pedal, %", range=[-8, 45], row=row, col=col)
    for level, name in ((-3.0, "network"), (-6.0, "rule")):
        place = {"x": float(time[-1]), "y": level, "xanchor": "left", "showarrow": False, "font": {"size": 10}}
        figure.add_annotation(text=name, row=row, col=col, **place)


def _add_band(figure: Any, row: int, col: int, time: Floats, told: Integers, level: float) -> None:
    for intention, colour in enumerate(_COLOURS):
        heights = np.where(told == intention, level, np.nan)
        first = (row, col) == _PLACES[0] and level == -3.0
        line = {"color": colour, "width": 9}
        _line(figure, row, col, time, heights, INTENTIONS[intention] if first else "", line)


def _line(figure: Any, row: int, col: int, x: Floats, y: Floats, name: str, line: dict[str, Any]) -> None:
    import plotly.graph_objects as go

    trace = go.Scatter(x=x.round(3), y=y, name=name, mode="lines", line=line, showlegend=bool(name))
    figure.add_trace(trace, row=row, col=col)


def main() -> None:
    """Write the page for the test drivers: a plain press, one in stages, and one that the network gets wrong."""
    from plotly import io

    parser = argparse.ArgumentParser(prog="python -m bitepoint.report.intent", description=__doc__)
    parser.add_argument("out", type=Path, help="HTML file to write")
    out: Path = parser.parse_args().out
    library: Any = io
    lot, rule = draw_lot("test", calibration("trained")), draw_lot("test", calibration("rule")).windows
    truth, told = lot.launches.intention, lot.windows.intention[:, -1]
    early, early_rule = lot.windows.intention[:, 49], rule.intention[:, 49]
    plain = np.flatnonzero(lot.launches.plain & (truth == 2) & (told == 2))[0]
    staged = np.flatnonzero(~lot.launches.plain & (truth == 2) & (early == 2) & (early_rule != 2))[0]
    wrong = np.flatnonzero(lot.launches.plain & (truth == 2) & (told == 1))[0]
    figure = intent_figure(lot.launches, lot.windows, rule, [int(plain), int(staged), int(wrong)])
    out.write_text(library.to_html(figure, include_plotlyjs=True, config={"displayModeBar": False}), encoding="utf-8")


if __name__ == "__main__":
    main()
