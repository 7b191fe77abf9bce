"""`bitepoint sweep`: a scenario for all combinations of the values of some keys."""

from __future__ import annotations

import json
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bitepoint.cli.settings import read_settings

if TYPE_CHECKING:
    from bitepoint.studies.sweep import SweepResult

INTERRUPTED = 130
"""Exit status after Ctrl-C, that of shells."""


def sweep(
    scenario: Annotated[str, typer.Argument(help="Name in the library (see `bitepoint list`), or a YAML file.")],
    over: Annotated[
        list[str],
        typer.Option("--over", metavar="KEY=VALUES", help="What varies: road.grade='0:20:5 %', intent=slow,urgent."),
    ],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change something in all rows, as in `bitepoint run`."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Keep the sweep there: sweep.parquet, and sweep.html to look at it."),
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Begin anew, whatever sweep is kept in DIR.")] = False,
    pareto: Annotated[
        str | None,
        typer.Option("--pareto", metavar="A,B", help="Two figures to trade off; the largest counts with NAME:max."),
    ] = None,
    status: Annotated[
        list[str] | None,
        typer.Option("--status", metavar="STATUS", help="Of rows that may be on the front; the usual one by default."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the noise.")] = 0,
    threads: Annotated[
        int | None, typer.Option("--threads", min=1, help="How many run at once; all processors by default.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run a scenario for all combinations of values; what was killed goes on where it was."""
    from bitepoint.studies.sweep import sweep as study
    from bitepoint.studies.sweep.folder import PAGE
    from bitepoint.studies.sweep.grid import read_over

    done = 0
    try:
        with _bar() as show:

            def progress(ended: int, rows: int) -> None:
                nonlocal done
                done = ended
                show(ended, rows)

            found = study(
                scenario, read_over(over), read_settings(settings or []),
                out=out, fresh=fresh, pareto=pareto, statuses=status or (), seed=seed, threads=threads,
                progress=progress,
            )  # fmt: skip
            redrawn = found.ran or pareto is not None or status
            paths = found.save() if out is not None and (redrawn or not (out / PAGE).exists()) else []
    except KeyboardInterrupt:
        kept = f"{done} rows are kept; the same command goes on from there" if out else "nothing is kept without --out"
        typer.echo(f"interrupted: {kept}", err=True)
        raise typer.Exit(INTERRUPTED) from None
    if as_json:
        typer.echo(json.dumps(found.to_json(), allow_nan=False))
        return
    _print(found)
    for path in paths:
        typer.echo(f"wrote {path}")


@contextmanager
def _bar() -> Generator[Callable[[int, int], None]]:
    """Show a bar over the rows on a terminal, and nothing elsewhere."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("rows", total=None)
        yield lambda ended, rows: progress.update(task, completed=ended, total=rows)


def _print(found: SweepResult) -> None:
    rows = found.rows.num_rows
    kept = f", {rows - found.ran} of them there already" if found.ran else ", all there already: nothing to run"
    typer.echo(f"{found.scenario}: {rows} rows{kept if found.ran < rows else ''}")
    for line in found.table():
        typer.echo(line)
