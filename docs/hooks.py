"""What the pages take from the package itself, so that no table goes stale.

A line that holds only one of these is replaced when the site is built:

    {{ record bitepoint.parts.engine.Engine }}   fields of a record
    {{ signals }}     signals that parts are wired by
    {{ cli run }}     arguments and options of a verb of the command line; {{ cli export.c }} of a verb's own verb
    {{ rooms }}       order of the rooms, as the import linter holds it
    {{ maths }}       functions of `math` that kernels may call
    {{ intent }}      launch intention: network and baselines on unseen drivers, as measured after the training
    {{ launches }}    published launches beside those of the shipped calibrations
    {{ reproduction dct-launch }}   figures of a paper beside ours, as `bitepoint reproduce` prints them
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import typer
import yaml

REPOSITORY = Path(__file__).parents[1]

_LINE = re.compile(r"^\{\{ (\w+)(?: ([\w.-]+))? \}\}$", re.MULTILINE)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the page with every line of the kinds above replaced; mkdocs calls this for each page."""
    return _LINE.sub(lambda match: _TABLES[match[1]](*filter(None, [match[2]])), markdown)


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)


def record(path: str) -> str:
    """Return the table of the record at the dotted path `path`."""
    module, _, name = path.rpartition(".")
    return getattr(import_module(module), name).markdown()


def reproduction(paper: str) -> str:
    """Return the figures of a paper beside ours, run now, and the notes."""
    from bitepoint.studies.papers import reproduce

    found = reproduce(paper)
    header = ("case", "quantity", "published", "ours", "unit", "tolerance", "within")
    rows = table(header, [row.cells for row in found.rows])
    return "\n".join([rows, "", *(f"- {note}" for note in found.notes)])


def signals() -> str:
    """Return the table of all signals."""
    from bitepoint.assembly import signals as all_signals
    from bitepoint.units import display

    rows = [[f"`{channel.name}`", display(channel.unit) or "–", channel.meaning] for channel in all_signals()]
    return table(["signal", "unit", "meaning"], rows)


def cli(verb: str) -> str:
    """Return the table of the arguments and options of a verb of the command line."""
    from bitepoint.cli import app

    command: Any = typer.main.get_command(app)
    for name in verb.split("."):
        command = command.commands[name]
    rows = [[_spelling(parameter), parameter.help or ""] for parameter in command.params]
    return table(["argument or option", "meaning"], rows)


def _spelling(parameter: Any) -> str:
    if parameter.param_type_name == "argument":
        return f"`{parameter.name.upper()}`" if parameter.required else f"`[{parameter.name.upper()}]`"
    flag = ", ".join(parameter.opts)
    if parameter.is_flag:
        return f"`{flag}`"
    repeat = ", may be repeated" if parameter.multiple else ""
    return f"`{flag} {parameter.metavar or 'N'}`{repeat}"


def rooms() -> str:
    """Return the rooms, the highest first, from the contract of the import linter; those in brackets are to come."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
    layers: list[str] = project["tool"]["importlinter"]["contracts"][0]["layers"]
    shelves = [[room.strip() for room in layer.split("|") if "(" not in room] for layer in layers]  # (room): not yet
    rows = [[", ".join(f"`{room}`" for room in shelf), _purposes(shelf)] for shelf in shelves]
    return table(["room", "what it says of itself"], rows)


def _purposes(shelf: Sequence[str]) -> str:
    docs = [import_module(room).__doc__ or "" for room in shelf]
    return "<br>".join(" ".join(doc.split("\n\n")[0].split()) for doc in docs)


def maths() -> str:
    """Return the list of functions of `math` that kernels may call."""
    from bitepoint.kernels.interpreted import MATHS

    return ", ".join(f"`{name}`" for name in sorted(MATHS))


@cache
def launches() -> str:
    """Return the published launches, and those of the two calibrations of launch_pid, run now."""
    import bitepoint

    published = yaml.safe_load((REPOSITORY / "tests" / "closed_loop" / "published.yaml").read_text(encoding="utf-8"))
    figures = ("launch_time", "friction_work", "jerk_peak", "jerk_peak_settled")
    rows: list[list[str]] = []
    for intent in ("slow", "normal", "urgent"):
        rows.append([intent, "published", *(f"{published[intent][name]:g}" for name in figures[:3]), "–"])
        for calibration in ("paper", "tuned"):
            found = bitepoint.run("dct-launch", intent=intent, controller__calibration=calibration).metrics
            values = [found[name].value for name in figures]
            time, work, jerk, settled = (float("nan") if value is None else value for value in values)
            rows.append([intent, f"`{calibration}`", f"{time:.2f}", f"{work:.0f}", f"{jerk:.1f}", f"{settled:.1f}"])
    header = ["intent", "", "launch time, s", "friction work, J", "jerk peak, m/s³", "jerk peak settled, m/s³"]
    return table(header, rows)


def intent() -> str:
    """Return the tables of launch intention: rightness over time, confusion, and time until settled."""
    from bitepoint.files import library_yaml

    found = library_yaml("controllers", "launch_intent_trained.yaml")["figures"]
    network, rule, other = (found[name] for name in ("network", "rule", "discriminant"))
    rows = [
        ["all", "network", *_percent(network["accuracy_at"])],
        ["", "pedal rule", *_percent(rule["accuracy_at"])],
        ["", "discriminant without memory", *_percent(other["accuracy_at"])],
        ["one plain press", "network", *_percent(network["plain_at"])],
        ["", "pedal rule", *_percent(rule["plain_at"])],
        ["in stages, or creeping before", "network", *_percent(network["other_at"])],
        ["", "pedal rule", *_percent(rule["other_at"])],
    ]
    over_time = table(["launches", "decided by", *(f"{instant:g} s" for instant in found["instants"])], rows)
    header = ["truth", *(f"{who}: {told}" for who in ("network", "rule") for told in ("slow", "normal", "urgent"))]
    both = zip(("slow", "normal", "urgent"), network["last"], rule["last"], strict=True)
    confusion = table(header, [[name, *map(str, [*one, *two])] for name, one, two in both])
    settled = [[who, *(f"{time:.2f} s" for time in found[who]["settled"])] for who in ("network", "rule")]
    delays = table(["decided by", "half of the launches", "three quarters", "nine tenths"], settled)
    return (
        f"Share of launches decided rightly, by time from pedal onset:\n\n{over_time}\n\n"
        f"Launches by truth and by what is told 2 s after pedal onset:\n\n{confusion}\n\n"
        f"Time from pedal onset after which the intention no longer changes:\n\n{delays}"
    )


def _percent(shares: Iterable[float]) -> list[str]:
    return [f"{100.0 * share:.1f} %" for share in shares]


_TABLES: dict[str, Callable[..., str]] = {
    "record": record, "signals": signals, "cli": cli, "rooms": rooms, "maths": maths, "launches": launches,
    "intent": intent, "reproduction": reproduction,
}  # fmt: skip
