"""`bitepoint export`: a controller or a plant as what an ECU or a calibration tool takes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bitepoint.cli.settings import read_settings

app = typer.Typer(no_args_is_help=True, help="Write a controller or a plant as C99 or ASAP2.")

Name = Annotated[str, typer.Argument(help="A controller or a plant, as `bitepoint list` has it, or launch_intent.")]
Vehicle = Annotated[
    str | None,
    typer.Option("--vehicle", metavar="NAME", help="Library vehicle or vehicle file that it is designed for."),
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change something: controller.calibration=paper."),
]
Floats = Annotated[str, typer.Option("--precision", metavar="PRECISION", help="float64, as simulated, or float32.")]


@app.command("c")
def export_c(
    name: Name,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder to write, new or empty.")],
    vehicle: Vehicle = None,
    settings: Settings = None,
    precision: Floats = "float64",
    as_json: Annotated[bool, typer.Option("--json", help="Print report.json.")] = False,
) -> None:
    """Write C99 with calibration, builds, self-test, bare-metal image and report."""
    from rich.console import Console

    from bitepoint.export.c import export_c
    from bitepoint.export.subject import Options

    console = Console(stderr=True)
    with console.status("exporting") as status:
        options = Options(name, vehicle, read_settings(settings or []), precision)
        findings = export_c(options, out, lambda text: status.update(text) if console.is_terminal else None)
    report = findings.to_json()
    if as_json:
        typer.echo(json.dumps(report, allow_nan=False))
        return
    typer.echo(f"{name}, {precision}: {report['selftest']['steps']} recorded steps, no difference")
    for build in report["builds"]:
        typer.echo(f"on a {build['cpu']}, in {build['precision']}:")
        runs = [r for r in report["targets"] if (r["cpu"], r["precision"]) == (build["cpu"], build["precision"])]
        for key in ("code_bytes", "data_bytes", "stack_bytes"):
            typer.echo(f"  {key:<20} {build[key]} bytes")
        for run in runs:
            typer.echo(f"  {'instructions_worst':<20} {run['instructions_worst']} instructions")
    if not report["targets"]:
        typer.echo("not measured in full: the target's tool chain is missing")
    typer.echo(f"wrote {out}; see {out / 'REPORT.md'}")


@app.command("a2l")
def export_a2l(
    name: Name,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="File to write.")],
    elf: Annotated[
        Path | None, typer.Option("--elf", metavar="FILE", help="Linked program that the addresses are taken from.")
    ] = None,
    vehicle: Vehicle = None,
    settings: Settings = None,
    precision: Floats = "float64",
) -> None:
    """Write an ASAP2 description for measurement and calibration tools."""
    from bitepoint.export.a2l_file import write_a2l
    from bitepoint.export.subject import Options

    write_a2l(Options(name, vehicle, read_settings(settings or []), precision), out, elf)
    typer.echo(f"wrote {out}" + ("" if elf is not None else "; without --elf all addresses in it are 0"))
