"""`bitepoint identify`: logs in, a model with its errors and its picture out."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bitepoint.errors import InputError

if TYPE_CHECKING:
    from bitepoint.api import Identification

Files = Annotated[list[Path], typer.Argument(help="Logs to train on, or folders of them: CSV, Parquet, MF4, CAN.")]
Validate = Annotated[
    list[Path] | None, typer.Option("--validate", metavar="FILE", help="Log to validate on, or a folder.")
]
Model = Annotated[str, typer.Option("--model", metavar="MODEL", help="arx or armax.")]
OrdersText = Annotated[
    str, typer.Option("--orders", metavar="ORDERS", help="n_a,n_b,n_g, for armax n_c may follow; auto: by AIC.")
]
Method = Annotated[
    str, typer.Option("--method", metavar="METHOD", help="Of arx: 'least squares', instruments, or auto: the better.")
]
Columns = Annotated[
    list[str] | None,
    typer.Option("--column", metavar="CHANNEL=NAME", help="Name in the logs, a unit may follow: 'EngSpd rpm'."),
]
Delays = Annotated[
    list[str] | None, typer.Option("--delay", metavar="CHANNEL=TIME", help="How late a channel is: '20 ms'.")
]
Databases = Annotated[list[Path] | None, typer.Option("--dbc", metavar="FILE", help="Database of CAN frames.")]
Period = Annotated[
    str | None, typer.Option("--period", metavar="TIME", help="Raster of the model; that of the first log by default.")
]
Ratio = Annotated[
    float | None, typer.Option("--ratio", metavar="RATIO", help="Of the gear: slip from engine_speed and wheel_speed.")
]
Out = Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Model to write, JSON; a report beside it.")]
Report = Annotated[Path | None, typer.Option("--report", metavar="FILE", help="Report to write, HTML.")]


def identify(
    files: Files,
    validate: Validate = None,
    model: Model = "arx",
    orders: OrdersText = "2,1,1",
    method: Method = "auto",
    column: Columns = None,
    delay: Delays = None,
    dbc: Databases = None,
    period: Period = None,
    ratio: Ratio = None,
    out: Out = None,
    report: Report = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Identify the model of a launch from logs."""
    from rich.console import Console

    from bitepoint import api

    with Console(stderr=True).status("identifying"):
        found = api.identify(
            files,
            validate=validate or (),
            model=model,
            orders=orders,
            method=method,
            columns=_pairs("--column", column),
            delays=_pairs("--delay", delay),
            dbc=dbc or (),
            period=period,
            ratio=ratio,
        )
        written = found.save(out, report)
    if as_json:
        typer.echo(json.dumps(found.to_json(), allow_nan=False))
        return
    _print(found)
    for path in written:
        typer.echo(f"wrote {path}")


def _pairs(option: str, texts: Sequence[str] | None) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        name, value = name.strip(), value.strip()
        if not equals or not name or not value:
            raise InputError(option, f"got {text!r}", "expected CHANNEL=VALUE")
        if name in pairs:
            raise InputError(option, f"{name}: given twice", "leave one of them out")
        pairs[name] = value
    return pairs


def _print(found: Identification) -> None:
    said = found.to_json()
    about = found.model.about
    orders = ", ".join(map(str, said["orders"]))
    typer.echo(f"{said['model']} ({orders}) by {about['method']}, raster {found.model.period:g} s")
    typer.echo(f"{'':<24} {'one step, rms':>14} {'free run, rms':>14} {'free run, max':>14}")
    for part, errors in found.errors.items():
        for name, error in errors.items():
            numbers = (error.one_step_rms, error.free_run_rms, error.free_run_max)
            cells = " ".join(f"{number:>8.3g} rad/s" for number in numbers)
            typer.echo(f"{part + ', ' + name:<24} {cells}")
    for warning in found.warnings:
        typer.echo(f"warning: {warning}")
