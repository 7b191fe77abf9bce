"""`bitepoint identify`: logs in, a model with its errors and its picture out."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bitepoint.errors import InputError

if TYPE_CHECKING:
    from bitepoint.api import FuelIdentification, Identification

Files = Annotated[list[Path], typer.Argument(help="Logs to train on, or folders of them: CSV, Parquet, MF4, CAN.")]
Validate = Annotated[
    list[Path] | None, typer.Option("--validate", metavar="FILE", help="Log to validate on, or a folder.")
]
Model = Annotated[str, typer.Option("--model", metavar="MODEL", help="arx or armax, of a launch; fuel, of a drive.")]
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
Density = Annotated[
    str | None, typer.Option("--density", metavar="DENSITY", help="Of the fuel, for volumes in files: '0.743 g/mL'.")
]
VehicleName = Annotated[
    str | None,
    typer.Option("--vehicle", metavar="VEHICLE", help="Of fuel: name or file, for a steady map and a correction."),
]
EngineMap = Annotated[
    Path | None,
    typer.Option(
        "--engine-map", metavar="FILE", help="Of fuel: measured points of engine speed, torque and fuel flow."
    ),
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
    density: Density = None,
    vehicle: VehicleName = None,
    engine_map: EngineMap = None,
    out: Out = None,
    report: Report = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Identify the model of a launch, or the fuel of a vehicle, from logs."""
    from rich.console import Console

    from bitepoint import api

    if model == "fuel":
        _hold_unset("fuel", {"--orders": orders != "2,1,1", "--method": method != "auto", "--ratio": ratio is not None})
        with Console(stderr=True).status("identifying"):
            fuel = api.identify_fuel(
                files,
                validate=validate or (),
                columns=_pairs("--column", column),
                delays=_pairs("--delay", delay),
                dbc=dbc or (),
                period=period,
                density=density,
                vehicle=vehicle,
                engine_map=engine_map,
            )
            saved = fuel.save(out, report)
        _tell(fuel, saved, as_json)
        return
    of_fuel = {"--density": density, "--vehicle": vehicle, "--engine-map": engine_map}
    _hold_unset(model, {option: value is not None for option, value in of_fuel.items()})
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
    _tell(found, written, as_json)


def _hold_unset(model: str, options: Mapping[str, bool]) -> None:
    """Hold that no option is given that the model has not."""
    for option, given in options.items():
        if given:
            raise InputError(option, f"not an option of {model}", "leave it out")


def _tell(found: Identification | FuelIdentification, written: Sequence[Path], as_json: bool) -> None:
    if as_json:
        typer.echo(json.dumps(found.to_json(), allow_nan=False))
        return
    from bitepoint.api import Identification

    if isinstance(found, Identification):
        _print(found)
    else:
        _print_fuel(found)
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


def _print_fuel(found: FuelIdentification) -> None:
    about = found.model.about
    typer.echo(f"fuel, {about['kind']}: {about['method']}; fuel {found.delay:g} s before the motion")
    typer.echo(f"{'':<42} {'training':>16} {'validation':>18}")
    typer.echo(f"{'':<33} {'score':>8} {'total':>9} {'R2':>6} {'total':>11} {'R2':>6}")
    for each in found.tried:
        cells = [f"{error.total_percent:>+8.2f}% {error.r2:>6.3f}" for error in each.errors.values()]
        typer.echo(f"{each.kind + ', ' + each.name:<33} {each.score:>8.3f} " + "   ".join(cells))
    for warning in found.warnings:
        typer.echo(f"warning: {warning}")
