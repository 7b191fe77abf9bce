"""`bitepoint run`: one scenario, its figures, and its picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from bitepoint.cli.settings import read_settings


def run(
    scenario: Annotated[str, typer.Argument(help="Name in the library (see `bitepoint list`), or a YAML file.")],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change something: intent=urgent, vehicle.mass='1900 kg'."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Write recordings, metrics.json and a page there."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the noise.")] = 0,
) -> None:
    """Run a scenario and print its figures of merit."""
    from bitepoint import api

    result = api.run(scenario, read_settings(settings or []), seed=seed)
    paths = [] if out is None else result.save(out)
    if as_json:
        typer.echo(json.dumps(result.to_json(), allow_nan=False))
        return
    about = result.recording.about
    typer.echo(f"{result.scenario}: {about['vehicle']}, controller {about['controller']}")
    typer.echo(f"{result.status}: {result.reason}")
    width = max([20, *map(len, result.metrics)])
    for name, metric in result.metrics.items():
        typer.echo(f"  {name:<{width}} {metric}")
    if result.logs:
        if paths:
            typer.echo(f"wrote {len(result.logs)} logs, metrics.json and excitation.html into {out}")
        return
    for path in paths:
        typer.echo(f"wrote {path}")
