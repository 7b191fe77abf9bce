"""The command line: one file per verb, each parses and delegates."""

from __future__ import annotations

import contextlib
import signal
import sys
from typing import NoReturn

import typer

from bitepoint.cli import export
from bitepoint.cli.identify import identify
from bitepoint.cli.list import list_parts
from bitepoint.cli.reproduce import reproduce
from bitepoint.cli.run import run
from bitepoint.cli.show import show
from bitepoint.cli.sweep import sweep
from bitepoint.cli.warmup import warmup
from bitepoint.errors import BitepointError
from bitepoint.version import __version__

app = typer.Typer(
    name="bitepoint",
    help="Open bench for vehicle launch and driveline torque control.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("run")(run)
app.command("identify")(identify)
app.command("list")(list_parts)
app.command("reproduce")(reproduce)
app.command("show")(show)
app.command("sweep")(sweep)
app.command("warmup")(warmup)
app.add_typer(export.app, name="export")


@app.callback(invoke_without_command=True)
def _options(
    version: bool = typer.Option(False, "--version", help="Show the version and exit.", is_eager=True),
) -> None:  # pyright: ignore[reportUnusedFunction]
    if version:
        typer.echo(f"bitepoint {__version__}")
        raise typer.Exit


def _refuse(text: str) -> NoReturn:
    print("error:", " ".join(text.split()), file=sys.stderr)
    sys.exit(2)


def _terminate(signum: int, frame: object) -> NoReturn:  # noqa: ARG001
    sys.exit(143)


def main() -> None:
    """Run the command line: exit 0 when it was carried out, 2 on bad input, 1 on a fault of ours."""
    with contextlib.suppress(ValueError):  # not in the main thread
        signal.signal(signal.SIGTERM, _terminate)  # so that what is half done is cleared away
    try:
        sys.exit(app(prog_name="bitepoint", standalone_mode=False) or 0)
    except BitepointError as error:
        _refuse(str(error))
    except typer.Abort:
        sys.exit(1)
    except OSError as error:
        print(f"error: {error.strerror or error}", file=sys.stderr)
        sys.exit(1)
    except Exception as error:
        told = getattr(error, "format_message", None)  # what typer raises for a command line that is none
        if told is None:
            raise
        text = told().rstrip(".")
        if text:
            _refuse(f"{text}; see bitepoint --help")
        sys.exit(2)
