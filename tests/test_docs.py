"""The documentation is run: its commands and sessions give what it shows, and it leaves no record out.

A page is carried out from top to bottom in an empty folder. A fenced block with a title is written to the file of that
name; of a `console` block the commands `bitepoint ...` and `python examples/...` are run, and a `pycon` block is a
session. What is shown below them must be what they print, numbers to 1 %; a line `...` stands for any lines. A block
below the line `<!-- not run -->` is left alone.

`python -m tests.test_docs` writes what the commands print now into the pages, and shows the difference.
"""

from __future__ import annotations

import contextlib
import difflib
import doctest
import importlib
import io
import math
import pkgutil
import re
import runpy
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import bitepoint
from bitepoint.metrics import LAUNCH_UNITS
from bitepoint.records import Record
from tests.conftest import REPOSITORY, Command

DOCS = REPOSITORY / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
TOLERANCE = 1e-2
"""Relative: the pages show how large a figure is; that it is right to the digit is tested elsewhere."""

FENCE = re.compile(r"^(?P<skip><!-- not run -->\n+)?```(?P<info>[^\n`]*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
INCLUDE = re.compile(r'^\{% *include "([^"]+)".*%\}\n', re.MULTILINE)
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")
MARK = re.compile(r"^\{\{ record ([\w.]+) \}\}$", re.MULTILINE)


Run = Callable[[list[str]], str]
"""Runs a command, given as words, in the present folder; returns what it printed."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the file that it is the content of, and its text."""

    language: str
    title: str
    body: str


def blocks(page: Path) -> Iterator[Block]:
    """Yield the blocks of a page that are to be run or written."""
    for match in FENCE.finditer(page.read_text("utf-8")):
        title = re.search(r'title="([^"]*)"', match["info"])
        included = INCLUDE.sub(lambda found: (page.parent / found[1]).read_text("utf-8"), match["body"])
        if match["skip"] is None and match["info"].strip():
            yield Block(match["info"].split()[0], title[1] if title else "", included)


def replay(body: str, run: Run) -> str:
    """Return a console block with what its commands print now wherever it shows something else."""
    first, *parts = re.split(r"^(?=\$ )", body, flags=re.MULTILINE)
    return first + "".join(replay_command(part, run) for part in parts)


def replay_command(text: str, run: Run) -> str:
    match = re.match(r"\$ ((?:.*\\\n)*.*\n?)", text)
    assert match is not None
    shown = text[match.end() :]
    words = shlex.split(match[1].replace("\\\n", " "), comments=True)
    if words[:1] != ["bitepoint"] and not (words[:1] == ["python"] and words[1].startswith("examples/")):
        return text
    printed = run(words)
    return text if not shown.strip() or same(shown, printed) else match[0] + like(shown, printed)


def like(shown: str, printed: str) -> str:
    """Return what was printed, with its middle left out where the page leaves lines out."""
    lines, wanted = printed.splitlines(keepends=True), shown.splitlines()
    if "..." not in wanted:
        return printed
    head, tail = wanted.index("..."), len(wanted) - wanted.index("...") - 1
    return "".join([*lines[:head], "...\n", *lines[len(lines) - tail :]])


def same(shown: str, printed: str) -> bool:
    """Return whether a page shows what was printed."""
    words = printed.split()
    head, *tail = (part.split() for part in re.split(r"^\.\.\.$", shown, maxsplit=1, flags=re.MULTILINE))
    if not tail:
        return len(head) == len(words) and all(map(same_word, head, words))
    ends = all(map(same_word, head, words)) and all(map(same_word, reversed(tail[0]), reversed(words)))
    return ends and len(words) >= len(head) + len(tail[0])


def same_word(shown: str, printed: str) -> bool:
    if NUMBER.sub("", shown) != NUMBER.sub("", printed):
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=TOLERANCE, abs_tol=1e-6) for a, b in pairs)


class Checker(doctest.OutputChecker):
    """Compares as `same` does."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        return super().check_output(want, got, optionflags) or same(want, got)


def run_example(file: str) -> str:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        runpy.run_path(str(REPOSITORY / file), run_name="__main__")
    return printed.getvalue()


def run_session(body: str, names: dict[str, Any]) -> str:
    """Run a pycon block; return what went wrong, or nothing."""
    report: list[str] = []
    test = doctest.DocTestParser().get_doctest(body, names, "session", None, 0)
    doctest.DocTestRunner(Checker()).run(test, out=report.append, clear_globs=False)
    names.update(test.globs)
    return "".join(report)


def carry_out(page: Path, run: Run) -> Iterator[tuple[str, str]]:
    """Do what a page says in the present folder; yield each block with what it should be."""
    names: dict[str, Any] = {}
    for block in blocks(page):
        if block.title:
            Path(block.title).write_text(block.body, encoding="utf-8")
        elif block.language == "console":
            yield block.body, replay(block.body, run)
        elif block.language == "pycon":
            yield "", run_session(block.body, names)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_a_page_shows_what_its_commands_print(
    page: Path, bitepoint: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(words: list[str]) -> str:
        if words[0] == "python":
            return run_example(words[1])
        outcome = bitepoint(*words[1:])
        assert outcome.status == (2 if outcome.err.startswith("error: ") else 0), outcome
        return outcome.out + outcome.err

    monkeypatch.chdir(tmp_path)
    for shown, printed in carry_out(page, run):
        assert shown == printed, "if what is printed is right: python -m tests.test_docs"


@pytest.mark.parametrize(
    ("shown", "printed", "wanted"),
    [
        ("time 1.24 s", "time  1.245 s\n", True),
        ("time 1.24 s", "time 1.3 s", False),
        ("time 1.24 s", "time 1.24 ms", False),
        ("time 1.24 s", "time 1.24 s more", False),
        ("residual 3e-08", "residual 5e-09", True),
        ("a\n...\nz", "a\nb\nc\nz", True),
        ("a\n...\nz", "a\nb\nc\ny", False),
        ("a\n...\nz", "a", False),
    ],
)
def test_what_counts_as_the_same(shown: str, printed: str, wanted: bool) -> None:
    assert same(shown, printed) is wanted


def record_types() -> set[type[Record]]:
    for module in pkgutil.walk_packages(bitepoint.__path__, "bitepoint."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    return {record for record in Record.__subclasses__() if record.__module__.startswith("bitepoint.")}


def with_nested(record: type[Record]) -> Iterator[type[Record]]:
    yield record
    for field in record.fields.values():
        if field.record is not None:
            yield from with_nested(field.record)


def test_every_record_has_its_table() -> None:
    types = {f"{record.__module__}.{record.__qualname__}": record for record in record_types()}
    mentioned = {name for page in PAGES for name in MARK.findall(page.read_text("utf-8"))}
    assert mentioned <= set(types), "no such record"
    shown = {record for name in mentioned for record in with_nested(types[name])}
    assert not [name for name, record in types.items() if record not in shown]


def test_every_figure_of_merit_is_explained() -> None:
    text = (DOCS / "rooms" / "metrics.md").read_text("utf-8")
    assert not [name for name in LAUNCH_UNITS if f"`{name}`" not in text]


def run_outside(words: list[str]) -> str:
    arguments = ["-m", *words] if words[0] == "bitepoint" else [str(REPOSITORY / words[1]), *words[2:]]
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == (2 if done.stderr.startswith("error: ") else 0), done.stderr
    return done.stdout + (done.stderr if done.returncode else "")


def refresh(page: Path) -> None:
    """Write into a page what its commands print now, and show the difference."""
    before = after = page.read_text("utf-8")
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for shown, printed in carry_out(page, run_outside):
            if shown:
                after = after.replace(shown, printed, 1)
            elif printed:
                print(f"{page.name}: to be mended by hand:\n{printed}")
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), page.name, page.name, lineterm="")
    print(*lines, sep="\n", end="")
    page.write_text(after, "utf-8")


if __name__ == "__main__":
    for each in PAGES:
        refresh(each)
