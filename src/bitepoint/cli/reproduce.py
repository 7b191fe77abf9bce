"""`bitepoint reproduce`: a paper's figures beside ours."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer


def reproduce(
    paper: Annotated[str, typer.Argument(help="Name of the paper; without one, all that there are are listed.")] = "",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Write rows.json and reproduction.html there.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run what a paper ran and print its figures beside ours."""
    from rich.console import Console

    from bitepoint.studies.papers import PAPERS, made, reproduce, save

    if not paper:
        for name, entry in PAPERS.items():
            typer.echo(f"{name:<16} {entry.source}")
        return
    if out is not None and paper in PAPERS:
        made(out)
    console = Console(stderr=True)
    with console.status("running") as status:
        found = reproduce(paper, lambda text: status.update(text) if console.is_terminal else None)
    paths = [] if out is None else save(found, out)
    if as_json:
        typer.echo(json.dumps(found.to_json(), allow_nan=False))
        return
    typer.echo(f"{found.name}: {found.source}")
    for line in found.table():
        typer.echo(line)
    for note in found.notes:
        typer.echo(f"- {note}")
    for path in paths:
        typer.echo(f"wrote {path}")
