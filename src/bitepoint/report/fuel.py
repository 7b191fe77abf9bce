"""The report of an identified fuel model: outliers by specific power, the filter over time, measured against model."""

from __future__ import annotations

from typing import Any

import numpy as np

from bitepoint.identification.fuel import FuelIdentified
from bitepoint.identification.fuel.drives import ASKED, SIGMAS, VSP_BIN, Drive
from bitepoint.identification.fuel.models import modelled
from bitepoint.numerics.tables import lookup_map
from bitepoint.recording import Floats
from bitepoint.report.page import BLUE, GREEN, GREY, ORANGE, RED, bullets, page, pictures, table

_GRAMS = 1e3
_LEGEND = {"orientation": "h", "y": 1.08}


def fuel_page(found: FuelIdentified) -> str:
    """Return a self-contained HTML page."""
    parts = [
        ("Specific power: rows of training, three standard deviations of each bin, and what is left out", _bins(found)),
        ("Before and after the filter", _filtered(found)),
        ("Measured and modelled" + (", validation" if found.checked is not None else ", training"), fit_figure(found)),
        ("Each row: measured against modelled", _scatter(found)),
        ("Fuel of the model over speed and acceleration", _surface(found)),
    ]
    if found.model.vehicle is not None:
        parts.append(("Engine: specific consumption over speed and torque", _engine(found)))
    about = found.model.about
    dropped, rows = int(found.outliers.sum()), len(found.drive)
    summary = (
        f"{about['kind']}, {about['method']}; raster {about['period']:g} s, {rows} rows for training, "
        f"{dropped} left out; fuel {found.delay:g} s before the motion"
    )
    body = error_table(found) + bullets(found.warnings, "Warnings") + pictures(parts)
    for part, files in about["files"].items():
        body += bullets([f"{file['name']}, SHA-256 {file['sha256'][:16]}…" for file in files], f"Logs, {part}")
    footer = (
        f"bitepoint {about['versions']['bitepoint']}. The score is that of cross-validation within the training logs; "
        "nothing is chosen by the validation."
    )
    return page("Fuel of a vehicle", summary, body, footer)


def error_table(found: FuelIdentified) -> str:
    """Return the errors of all models that were tried as an HTML table."""
    head = ["model", "score"]
    for part in found.errors:
        head += [f"{part}, total", f"{part}, R²", f"{part}, rms"]
    rows: list[list[str]] = []
    for each in found.tried:
        mark = " (chosen)" if (each.kind, each.name) == _chosen(found) else ""
        cells = [f"{each.kind}, {each.name}{mark}", f"{each.score:.4f}"]
        for error in each.errors.values():
            cells += [f"{error.total_percent:+.2f} %", f"{error.r2:.4f}", f"{error.rms * _GRAMS:.3f} g/s"]
        rows.append(cells)
    return table(head, rows)


def _chosen(found: FuelIdentified) -> tuple[str, str]:
    return found.model.about["kind"], found.model.about["method"]


def _bins(found: FuelIdentified) -> Any:
    import plotly.graph_objects as go

    drive, out = found.drive, found.outliers
    power, fuel = drive.specific_power, drive.fuel * _GRAMS
    figure = go.Figure()
    for name, rows, colour, size in (("kept", ~out, GREY, 3), ("left out", out, RED, 7)):
        mark = {"color": colour, "size": size}
        figure.add_trace(go.Scatter(x=power[rows], y=fuel[rows], mode="markers", marker=mark, name=name))
    centre = [each.edge + 0.5 * VSP_BIN for each in found.bins]
    text = [f"{each.rows} rows{'' if each.rows >= ASKED else ', too few'}" for each in found.bins]
    band = {"type": "data", "array": [SIGMAS * each.deviation * _GRAMS for each in found.bins]}
    mean = go.Scatter(
        x=centre, y=[each.mean * _GRAMS for each in found.bins], error_y=band, mode="markers", hovertext=text,
        marker={"color": [BLUE if each.rows >= ASKED else ORANGE for each in found.bins], "size": 8},
        name=f"mean and 3 standard deviations (orange: fewer than {ASKED} rows)",
    )  # fmt: skip
    figure.add_trace(mean)
    figure.update_xaxes(title_text="vehicle specific power, kW/t")
    figure.update_yaxes(title_text="fuel, g/s")
    return _laid_out(figure, 460)


def _filtered(found: FuelIdentified) -> Any:
    import plotly.graph_objects as go

    time = _running(found.drive)
    fuel = found.drive.fuel * _GRAMS
    kept = np.where(found.outliers, np.nan, fuel)
    figure = go.Figure()
    figure.add_trace(go.Scatter(x=time, y=fuel, name="before", line={"color": RED, "width": 1.2}))
    figure.add_trace(go.Scatter(x=time, y=kept, name="after", line={"color": BLUE, "width": 1.2}))
    figure.update_xaxes(title_text="time, s; the runs one after the other")
    figure.update_yaxes(title_text="fuel, g/s")
    return _laid_out(figure, 360)


def fit_figure(found: FuelIdentified) -> Any:
    """Return the picture of speed, fuel and its total over time, measured and modelled: of validation, if any."""
    import plotly.graph_objects as go
    from plotly import subplots

    library: Any = subplots
    drive = _shown(found)
    time, fuel = _running(drive), modelled(found.model, drive)
    figure = library.make_subplots(rows=3, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    step = float(np.median(np.diff(time))) if len(time) > 1 else 1.0
    lines = (
        ("speed", drive.speed * 3.6, GREEN, 1), ("measured", drive.fuel * _GRAMS, GREY, 2),
        ("model", fuel * _GRAMS, BLUE, 2), ("measured, in total", np.cumsum(drive.fuel) * step * _GRAMS, GREY, 3),
        ("model, in total", np.cumsum(fuel) * step * _GRAMS, BLUE, 3),
    )  # fmt: skip
    for name, values, colour, row in lines:
        line = {"color": colour, "width": 2.2 if name == "measured" else 1.3}
        figure.add_trace(go.Scatter(x=time, y=values, name=name, line=line), row=row, col=1)
    for row, title in enumerate(("speed, km/h", "fuel, g/s", "fuel, g"), 1):
        figure.update_yaxes(title_text=title, row=row, col=1)
    figure.update_xaxes(title_text="time, s; the runs one after the other", row=3, col=1)
    return _laid_out(figure, 720)


def _scatter(found: FuelIdentified) -> Any:
    import plotly.graph_objects as go

    drive = _shown(found)
    fuel = modelled(found.model, drive) * _GRAMS
    top = float(max(fuel.max(), drive.fuel.max() * _GRAMS))
    figure = go.Figure()
    mark = {"color": drive.acceleration, "size": 5, "colorscale": "RdBu", "cmid": 0.0, "colorbar": {"title": "m/s²"}}
    figure.add_trace(go.Scatter(x=drive.fuel * _GRAMS, y=fuel, mode="markers", marker=mark, name="row"))
    figure.add_trace(go.Scatter(x=[0, top], y=[0, top], name="equal", line={"color": GREY, "dash": "dash"}))
    figure.update_xaxes(title_text="measured, g/s")
    figure.update_yaxes(title_text="model, g/s")
    return _laid_out(figure, 460)


def _surface(found: FuelIdentified) -> Any:
    import plotly.graph_objects as go

    top = 1.2 * float(found.drive.speed.max())
    highest = 1.5 * float(np.abs(found.drive.acceleration).max())
    speed, acceleration = np.linspace(0.0, top, 60), np.linspace(-highest, highest, 60)
    v, a = (each.ravel() for each in np.meshgrid(speed, acceleration))
    flow = (found.model.flow(v, a) * _GRAMS).reshape(len(acceleration), len(speed))
    figure = go.Figure(go.Contour(x=speed * 3.6, y=acceleration, z=flow, colorbar={"title": "g/s"}, ncontours=16))
    mark = {"color": "black", "size": 2, "opacity": 0.4}
    drive = found.drive
    figure.add_trace(
        go.Scatter(x=drive.speed * 3.6, y=drive.acceleration, mode="markers", marker=mark, name="rows of training")
    )
    figure.update_xaxes(title_text="speed, km/h")
    figure.update_yaxes(title_text="acceleration, m/s²")
    return _laid_out(figure, 460)


def _shown(found: FuelIdentified) -> Drive:
    return found.drive if found.checked is None else found.checked


def _running(drive: Drive) -> Floats:
    """Return a time that runs on from one run to the next, s, shape (n,)."""
    result, start = np.zeros(len(drive)), 0.0
    for each in np.unique(drive.run):
        rows = drive.run == each
        result[rows] = start + drive.time[rows] - drive.time[rows][0]
        start = float(result[rows][-1]) + 1.0
    return result


def _laid_out(figure: Any, height: int) -> Any:
    margin = {"l": 70, "r": 20, "t": 40, "b": 50}
    figure.update_layout(template="plotly_white", height=height, margin=margin, legend=_LEGEND)
    return figure


def _engine(found: FuelIdentified) -> Any:
    import plotly.graph_objects as go

    assert found.model.vehicle is not None
    engine = found.model.vehicle["engine"][0]
    fuel, load = engine["fuel"], engine["full_load"]
    speeds = np.linspace(float(fuel["x"].min()), float(fuel["x"].max()), 80)
    torques = np.linspace(0.02, 1.0, 80) * float(fuel["y"].max())
    w, t = (each.ravel() for each in np.meshgrid(speeds, torques))
    flow = lookup_map.run(np.repeat(np.atleast_1d(fuel), w.size), w, t)
    above: Floats = np.asarray(t - np.interp(w, load["x"], load["y"]), np.float64)
    specific = np.where(above <= 0.0, flow / (w * t) * _GRAMS * 3.6e6, np.nan)
    z = specific.reshape(len(torques), len(speeds))
    lowest = float(np.nanmin(z))
    levels = {"start": 5.0 * np.ceil(lowest / 5.0), "end": 2.0 * lowest, "size": 0.05 * lowest}
    rpm = 30.0 / np.pi
    bar = {"title": "g/kWh"}
    figure = go.Figure(go.Contour(x=speeds * rpm, y=torques, z=z, contours=levels, colorbar=bar, reversescale=True))
    line = {"color": "black", "width": 2}
    figure.add_trace(go.Scatter(x=load["x"] * rpm, y=load["y"], name="full load", line=line))
    figure.update_xaxes(title_text="engine speed, r/min")
    figure.update_yaxes(title_text="engine torque, N m", range=[0.0, 1.05 * float(load["y"].max())])
    return _laid_out(figure, 460)
