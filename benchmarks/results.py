"""What is measured: figures, written to results.json and as a table into the page of the documentation."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding as llvm

RESULTS = Path(__file__).parent / "results.json"
PAGE = Path(__file__).parent.parent / "docs" / "benchmarks.md"
BEGIN, END = "<!-- results -->", "<!-- /results -->"


@dataclass(frozen=True)
class Figure:
    """One figure.

    Attributes:
        value: in `unit`, of bitepoint.
        ratio: value over the same quantity of `against`: below 1 a time is shorter, above 1 a rate is higher.
        against: what ran beside it in the same session, with its own value.
    """

    name: str
    value: float
    unit: str
    ratio: float | None
    against: str | None


def save(figures: Sequence[Figure]) -> None:
    """Write results.json and, where the page exists, its table."""
    RESULTS.write_text(json.dumps([asdict(rounded(figure)) for figure in figures], indent=2, ensure_ascii=False) + "\n")
    if PAGE.exists():
        text = PAGE.read_text()
        if text.count(BEGIN) != 1 or text.count(END) != 1:
            raise ValueError(f"{PAGE.name} must have {BEGIN} and {END} once each")
        head, _, rest = text.partition(BEGIN)
        PAGE.write_text(f"{head}{BEGIN}\n{markdown(figures)}\n{END}{rest.partition(END)[2]}")


def rounded(figure: Figure) -> Figure:
    """Return the figure with four digits."""
    ratio = None if figure.ratio is None else _round(figure.ratio)
    return Figure(figure.name, _round(figure.value), figure.unit, ratio, figure.against)


def _round(number: float) -> float:
    return float(f"{number:.4g}")


def markdown(figures: Sequence[Figure]) -> str:
    """Return the table, below a line that says where it was measured."""
    rows = [f"{machine()}.", "", "| figure | value | ratio | against |", "| --- | ---: | ---: | --- |"]
    rows += [f"| `{f.name}` | {number(f.value)} {f.unit} | {_ratio(f)} | {f.against or '–'} |" for f in figures]
    return "\n".join(rows)


def table(figures: Sequence[Figure]) -> str:
    """Return the table for a terminal."""
    rows = [f"{f.name:<36} {number(f.value):>8} {f.unit:<10} {_ratio(f):>8}  {f.against or '–'}" for f in figures]
    heading = f"{'figure':<36} {'value':>8} {'unit':<10} {'ratio':>8}  against"
    return "\n".join([machine(), "", heading, *rows])


def number(value: float) -> str:
    """Return a value with three digits, without an exponent."""
    digits = max(0, 2 - int(f"{value:.2e}".partition("e")[2]))
    return f"{value:.{digits}f}"


def _ratio(figure: Figure) -> str:
    return "–" if figure.ratio is None else number(figure.ratio)


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def machine() -> str:
    """Return what it was measured on and with."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "llvmlite"))
    processor = f"{cores()} cores of a {platform.machine()} processor ({llvm.get_host_cpu_name()})"
    return f"{processor}, {platform.system()}, Python {platform.python_version()}, {packages}"
