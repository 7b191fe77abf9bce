"""The report of an identified model: orders, fit and error in training and validation, residuals, coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.identification.diagnostics import CONFIDENCE, cross_correlations, whiteness
from bitepoint.identification.identify import LAUNCH, UNITS, Identified
from bitepoint.identification.regression import Run
from bitepoint.recording import Floats, Recording
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED, bullets, page, pictures, table
from bitepoint.units import display

MOST_RUNS = 6
"""Runs that are drawn of each set, those with the largest free-run errors."""

_COLOURS = (BLUE, ORANGE, GREEN, RED)


def identification_page(found: Identified) -> str:
    """Return a self-contained HTML page."""
    parts = [("Training: free run and its error", training_figure(found))]
    if found.validation:
        parts.append(("Validation: free run and its error", validation_figure(found)))
    parts.append(
        ("Residuals one step ahead: autocorrelation, and correlation with past signals", residual_figure(found))
    )
    parts.append(("Poles", pole_figure(found)))
    if found.candidates:
        parts.insert(0, ("Information criteria over the orders, least squares", order_figure(found)))
    about = found.model.about
    orders = ", ".join(map(str, found.to_json()["orders"]))
    summary = f"{about['method']}, raster {found.model.period:g} s, {about['rows']['train']} rows for training"
    body = error_table(found) + bullets(found.warnings, "Warnings") + pictures(parts) + coefficient_table(found)
    for part, files in about.get("files", {}).items():
        body += bullets([f"{file['name']}, SHA-256 {file['sha256'][:16]}…" for file in files], f"Logs, {part}")
    footer = (
        f"bitepoint {about['versions']['bitepoint']}. A free run begins with measured rows and then feeds on itself."
    )
    return page(f"{found.model.kind.upper()} ({orders}) of a launch", summary, body, footer)


def error_table(found: Identified) -> str:
    """Return the errors as an HTML table."""
    rows: list[list[str]] = []
    for part, errors in found.errors.items():
        for name, error in errors.items():
            values = (error.one_step_rms, error.one_step_max, error.free_run_rms, error.free_run_max)
            rows.append([f"{part}, {_words(name)}", *(f"{value:.3g} {display(UNITS[name])}" for value in values)])
    return table(("", "one step, rms", "one step, max", "free run, rms", "free run, max"), rows)


def coefficient_table(found: Identified) -> str:
    """Return the coefficients with their 95 % confidence intervals as an HTML table."""
    columns = LAUNCH.columns(found.model.orders[:3])
    rows: list[list[str]] = []
    for m, (name, lag) in enumerate(columns):
        cells = [
            f"{value:.5g} ± {CONFIDENCE * error:.2g}"
            for value, error in zip(found.fit.coefficients[:, m], found.fit.standard_errors[:, m], strict=True)
        ]
        rows.append([f"{_words(name)} (k-{lag})", *cells])
    for lag, matrix in enumerate(found.model.past_errors, 1):
        for name, column in zip(found.model.outputs, matrix.T, strict=True):
            rows.append([f"error of {_words(name)} (k-{lag})", *(f"{value:.5g}" for value in column)])
    head = ("coefficient, SI", *(f"{_words(name)} (k)" for name in found.model.outputs))
    return "<h2>Coefficients with 95 % confidence</h2>" + table(head, rows)


def order_figure(found: Identified) -> Any:
    """Return the criteria over n_a, a line for each n_b and n_g."""
    import plotly.graph_objects as go

    figure = go.Figure()
    tails = sorted({candidate.orders[1:] for candidate in found.candidates})
    for n, tail in enumerate(tails):
        mine = sorted((c for c in found.candidates if c.orders[1:] == tail), key=lambda c: c.orders)
        n_a, name = [c.orders[0] for c in mine], f"n_b {tail[0]}, n_g {tail[1]}"
        shade = f"hsl({40 * n}, 60%, 45%)"
        marks = ["circle" if c.stable else "x" for c in mine]
        line, marker = {"color": shade}, {"symbol": marks, "size": 8}
        figure.add_trace(go.Scatter(x=n_a, y=[c.aic for c in mine], name=f"AIC, {name}", line=line, marker=marker))
        dash = {"color": shade, "dash": "dot"}
        hidden = None if n == 0 else "legendonly"
        bic = go.Scatter(x=n_a, y=[c.bic for c in mine], name=f"BIC, {name}", line=dash, visible=hidden)
        figure.add_trace(bic)
    figure.update_xaxes(title_text="order n_a of the outputs (a cross marks an unstable model)", dtick=1)
    figure.update_yaxes(title_text="criterion, 1")
    return _laid_out(figure, 420)


def training_figure(found: Identified) -> Any:
    """Return measured and simulated outputs over the training runs that are simulated worst."""
    return _fit_figure(found, found.training)


def validation_figure(found: Identified) -> Any:
    """Return measured and simulated outputs over the validation runs that are simulated worst."""
    return _fit_figure(found, found.validation)


def _fit_figure(found: Identified, recordings: Sequence[Recording]) -> Any:
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    model = found.model
    figure = library.make_subplots(rows=2 * len(model.outputs), cols=1, shared_xaxes=True, vertical_spacing=0.035)
    runs = [(recording, Run.of(recording, LAUNCH)) for recording in recordings]
    simulated = [model.free_run(run.y, run.u, run.d) for _, run in runs]
    worst = sorted(range(len(runs)), key=lambda n: -_largest(runs[n][1].y - simulated[n]))[:MOST_RUNS]
    start = 0.0
    for place, n in enumerate(sorted(worst)):
        recording, run = runs[n]
        time = (start + recording.time - recording.time[0]).round(6)
        start = float(time[-1]) + 0.2
        one = model.one_step(run.y, run.u, run.d)
        for row, name in enumerate(model.outputs):
            lines = (
                ("measured", run.y[:, row], GREY, 2 * row + 1),
                ("free run", simulated[n][:, row], BLUE, 2 * row + 1),
                ("error, free run", run.y[:, row] - simulated[n][:, row], BLUE, 2 * row + 2),
                ("error, one step", run.y[:, row] - one[:, row], ORANGE, 2 * row + 2),
            )  # fmt: skip
            for text, values, colour, panel in lines:
                first = place == 0 and row == 0
                trace = go.Scatter(
                    x=time,
                    y=_finite(values),
                    name=text,
                    line={"color": colour, "width": 3 if text == "measured" else 1.3},
                    legendgroup=text,
                    showlegend=first,
                    hovertext=Path(recording.about.get("file", "")).name,
                )
                figure.add_trace(trace, row=panel, col=1)
            figure.update_yaxes(title_text=f"{_words(name)}, {display(UNITS[name])}", row=2 * row + 1, col=1)
            figure.update_yaxes(title_text=f"error, {display(UNITS[name])}", row=2 * row + 2, col=1)
    shown = (
        f"{len(worst)} of {len(runs)} runs, those that are simulated worst" if len(worst) < len(runs) else "all runs"
    )
    figure.update_xaxes(title_text=f"time, s; {shown}, one after the other", row=2 * len(model.outputs), col=1)
    return _laid_out(figure, 900)


def residual_figure(found: Identified) -> Any:
    """Return autocorrelations of the residuals, and their correlations with past inputs and disturbances."""
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    fit = found.fit
    runs = [Run.of(recording, LAUNCH) for recording in found.training]
    runs = [run for run in runs if len(run) > found.model.warm_up]
    checks, crossed = whiteness(fit), cross_correlations(fit, runs, LAUNCH)
    titles = [
        f"{_words(each.output)}: Ljung-Box {each.ljung_box:.3g}, p = {each.probability:.2g}" for each in checks
    ] + [f"{_words(each.output)} with signals" for each in checks]
    figure = library.make_subplots(rows=2, cols=len(checks), subplot_titles=titles, vertical_spacing=0.16)
    for column, check in enumerate(checks, 1):
        lags = np.arange(1, len(check.correlation) + 1)
        bars = go.Bar(x=lags, y=check.correlation, marker={"color": BLUE}, name="autocorrelation", showlegend=False)
        figure.add_trace(bars, row=1, col=column)
        mine = [each for each in crossed if each.output == check.output]
        for colour, each in zip(_COLOURS, mine, strict=False):
            line = go.Scatter(
                y=each.correlation, name=_words(each.signal), line={"color": colour}, legendgroup=each.signal,
                showlegend=column == 1,
            )  # fmt: skip
            figure.add_trace(line, row=2, col=column)
        for row in (1, 2):
            for side in (-check.band, check.band):
                figure.add_hline(y=side, line={"color": RED, "dash": "dash", "width": 1}, row=row, col=column)
            figure.update_yaxes(title_text="correlation, 1", row=row, col=column)
            figure.update_xaxes(title_text="lag, rows", row=row, col=column)
    return _laid_out(figure, 620)


def pole_figure(found: Identified) -> Any:
    """Return the poles in the complex plane with the unit circle."""
    import plotly.graph_objects as go

    poles, angle = found.model.poles(), np.linspace(0.0, 2.0 * np.pi, 361)
    text = [f"magnitude {abs(pole):.5f}" for pole in poles]
    figure = go.Figure()
    figure.add_trace(go.Scatter(x=np.cos(angle), y=np.sin(angle), name="unit circle", line={"color": GREY}))
    marks = {"symbol": "x", "size": 10, "color": RED}
    figure.add_trace(go.Scatter(x=poles.real, y=poles.imag, mode="markers", name="poles", marker=marks, hovertext=text))
    figure.update_xaxes(title_text="real part, 1", range=[-1.3, 1.3])
    figure.update_yaxes(title_text="imaginary part, 1", scaleanchor="x", range=[-1.3, 1.3])
    return _laid_out(figure, 420)


def _laid_out(figure: Any, height: int) -> Any:
    figure.update_layout(template="plotly_white", height=height, margin={"l": 70, "r": 20, "t": 40, "b": 50})
    return figure


def _largest(values: Floats) -> float:
    return float(np.nan_to_num(np.abs(values), nan=np.inf).max())


def _finite(values: Floats) -> Floats:
    """Return values with what no picture can show left out."""
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(values) < 1e6, values, np.nan)


def _words(name: str) -> str:
    return name.replace("_", " ")
