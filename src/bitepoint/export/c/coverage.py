"""Which lines and branches of generated C have been reached: by gcov, on this machine."""

from __future__ import annotations

import _ctypes
import gzip
import json
import os
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from bitepoint.export.c.driving import Sequence
from bitepoint.export.c.probe import UNLIMITED, BlockCounter
from bitepoint.export.c.sources import Sources

EXPLAINED = "never:"
"""Word in a comment of a kernel, carried into the C, that says why a branch below it is never taken."""

CANDIDATES = 500
"""Most random sequences that are tried for what is still missing and not explained."""


@dataclass(frozen=True)
class Missing:
    """A line, or a branch of a line, that no vector reached, with the reason that its source gives."""

    line: int
    text: str
    reason: str


@dataclass(frozen=True)
class Coverage:
    """What the vectors reached of one source."""

    lines: int
    lines_reached: int
    branches: int
    branches_reached: int
    missing: tuple[Missing, ...]

    @property
    def reached(self) -> int:
        """Lines and branches that were reached."""
        return self.lines_reached + self.branches_reached


def available() -> bool:
    """Whether gcc and its gcov are here, whatever else compiles."""
    return os.name == "posix" and shutil.which("gcc") is not None and shutil.which("gcov") is not None


def choose(sources: Sources, recorded: Iterable[Sequence], random: Iterator[Sequence], folder: Path) -> list[Sequence]:
    """Return all recorded sequences and those random ones that reach something new, none of which takes too long."""
    chosen = list(recorded)
    if not available():
        return [*chosen, *(next(random) for _ in range(16))]
    with Probe(sources, folder) as probe:
        most = LONGER * max(probe.run(sequence)[1] for sequence in chosen)
        found = probe.reached()
        for _ in range(CANDIDATES):
            if all(missing.reason for missing in found.missing):
                break
            sequence, _ = probe.run(next(random), most)
            now = probe.reached()
            if now.reached > found.reached:
                chosen.append(sequence)
                found = now
    return chosen


LONGER = 3
"""Basic blocks that a random sequence may take, in those of the recorded one with most of them: random parameters of a
plant may ask for a hundred times as many substeps. Those of controllers seldom take more than two."""


_DUMP = """\
extern void __gcov_dump(void);
extern void __gcov_reset(void);
void probe_dump(void);
void probe_dump(void)
{
    __gcov_dump();
    __gcov_reset();
}
"""
"""Writes what was counted; without the reset a second dump would write nothing."""


class Probe:
    """A part in C, built so that it counts its branches, driven in this process."""

    def __init__(self, sources: Sources, folder: Path) -> None:
        self.folder = folder
        self.counter = BlockCounter(sources, folder, ["-O0", "--coverage"], _DUMP)

    def __enter__(self) -> Self:
        """Return the probe."""
        return self

    def __exit__(self, *_: object) -> None:
        """Unload it: gcov writes when a library goes, and would make the folder again when the process ends."""
        _ctypes.dlclose(self.counter.library._handle)

    def run(self, sequence: Sequence, most: int = UNLIMITED) -> tuple[Sequence, int]:
        """Step through a sequence; what it reaches adds to what was reached before.

        Returns:
            the sequence up to the step that goes beyond `most` basic blocks, and the blocks that it took.
        """
        counts = self.counter.count(sequence, most)
        return replace(sequence, inputs=sequence.inputs[: len(counts) + 1]), int(counts.sum())

    def reached(self) -> Coverage:
        """Return what was reached so far."""
        self.counter.library.probe_dump()
        command = ["gcov", "--branch-probabilities", "--json-format", "--stdout", "probe.so-probe.gcda"]
        done = subprocess.run(command, cwd=self.folder, check=True, capture_output=True)
        lines = [line for file in json.loads(done.stdout)["files"] for line in file["lines"]]
        return _coverage([line for line in lines if line["line_number"] in self.counter.own], self.counter.texts)


def read(file: Path, source: Path) -> Coverage:
    """Return the coverage that gcov wrote into its JSON `file`; `source` is the C that it is about."""
    data = json.loads(gzip.decompress(file.read_bytes()))
    texts = source.read_text("utf-8").splitlines()
    return _coverage(next(f["lines"] for f in data["files"] if Path(f["file"]).name == source.name), texts)


def _coverage(lines: list[dict[str, Any]], texts: list[str]) -> Coverage:
    branches = [branch for line in lines for branch in line["branches"]]
    partly = [line for line in lines if line["count"] == 0 or any(b["count"] == 0 for b in line["branches"])]
    counts = {int(line["line_number"]): int(line["count"]) for line in lines}
    missing = tuple(
        Missing(number, texts[number - 1].strip(), _reason(texts, number) or _reason_around(texts, number, counts))
        for number in (int(line["line_number"]) for line in partly)
    )
    return Coverage(
        len(lines),
        sum(line["count"] > 0 for line in lines),
        len(branches),
        sum(branch["count"] > 0 for branch in branches),
        missing,
    )


def _reason_around(texts: list[str], number: int, counts: dict[int, int]) -> str:
    """Return why a line was not reached at all: the reason of the test that leads into its block."""
    reason = ""
    while not reason and number and counts.get(number, 0) == 0:
        number = _test_of_block(texts, number)
        reason = _reason(texts, number) if number else ""
    return reason


def _test_of_block(texts: list[str], number: int) -> int:
    """Return the number of the line with the test that leads into the block around a line; 0 for none."""
    inside = _indentation(texts[number - 1])
    brace = next((n for n in range(number - 1, 0, -1) if texts[n - 1] and _indentation(texts[n - 1]) < inside), 0)
    head = _statement_of(texts, brace) if brace else 0
    while head and texts[head - 1].strip() == "else":
        same = _indentation(texts[head - 1])
        tests = (n for n in range(head - 1, 0, -1) if _indentation(texts[n - 1]) == same)
        head = next((n for n in tests if texts[n - 1].lstrip().startswith(("if (", "else if ("))), 0)
    return head


def _statement_of(texts: list[str], number: int) -> int:
    """Return the number of the first line of the statement that a line belongs to."""
    while number > 1 and texts[number - 2] and not texts[number - 2].endswith((";", "{", "}", "*/")):
        number -= 1
    return number


def _indentation(text: str) -> int:
    return len(text) - len(text.lstrip())


def _reason(texts: list[str], number: int) -> str:
    """Return what the comment above the statement on a line says after `never:`."""
    last = _statement_of(texts, number) - 1
    if not texts[last - 1].endswith("*/"):
        return ""
    first = next(n for n in range(last, 0, -1) if texts[n - 1].lstrip().startswith("/*"))
    words = " ".join(text.strip().removeprefix("*").strip() for text in texts[first - 1 : last])
    return words.partition(EXPLAINED)[2].removesuffix("*/").strip()
