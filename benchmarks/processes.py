"""Whole processes: importing, a warm start, a cold start."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.results import Figure
from benchmarks.timing import side_by_side

ROUNDS = 9
COLD_ROUNDS = 3


def measure() -> list[Figure]:
    """Return the figures of importing and starting."""
    return [*_import_and_warm_start(), *_cold_start()]


def _import_and_warm_start() -> list[Figure]:
    commands = {
        "bare": _python("pass"), "numba": _python("import numba"), "bitepoint": _python("import bitepoint"),
        "run": _run(),
    }  # fmt: skip
    samples = side_by_side({name: _process(command) for name, command in commands.items()}, ROUNDS)
    seconds = samples.seconds
    ours, theirs = seconds["bitepoint"] - seconds["bare"], seconds["numba"] - seconds["bare"]
    numba, ratio = float(np.median(theirs)), float(np.median(ours / theirs))
    return [
        Figure("import", float(np.median(ours)), "s", ratio, f"import numba: {numba:.3f} s (both less bare Python)"),
        Figure(
            "warm_start", samples.median("run"), "s", samples.ratio("run", "numba"),
            f'python -c "import numba": {samples.median("numba"):.3f} s',
        ),
    ]  # fmt: skip


def _cold_start() -> list[Figure]:
    with tempfile.TemporaryDirectory() as folder:
        caches = iter(str(Path(folder) / str(n)) for n in range(COLD_ROUNDS + 1))
        candidates = {"cold": lambda: _process(_run(), {"BITEPOINT_CACHE": next(caches)})(), "warm": _process(_run())}
        samples = side_by_side(candidates, COLD_ROUNDS)
    against = f"the same with its cache: {samples.median('warm'):.3f} s"
    return [Figure("cold_start", samples.median("cold"), "s", samples.ratio("cold", "warm"), against)]


def _python(statement: str) -> Sequence[str]:
    return [sys.executable, "-c", statement]


def _run() -> Sequence[str]:
    return [sys.executable, "-m", "bitepoint", "run", "dct-launch", "--json"]


def _process(command: Sequence[str], extra: Mapping[str, str] | None = None) -> Callable[[], object]:
    environment = {**os.environ, **(extra or {})}
    return lambda: subprocess.run(command, env=environment, capture_output=True, check=True)
