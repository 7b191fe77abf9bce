"""`python -m benchmarks`: measure, write results.json and the table of docs/benchmarks.md, print the table."""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from benchmarks import damping, launches, planning, predictive, processes, qp, results, steps, yardstick


def main() -> None:
    """Measure everything."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        try:
            compiled = launches.libraries(Path(folder))
        except yardstick.NoCompilerError as reason:
            compiled = None
            _say(f"without the C yardstick: {reason}")
        figures: list[results.Figure] = []
        for what, measure in (
            ("one run", launches.measure_one_run), ("1000 runs", launches.measure_batch), ("steps", steps.measure)
        ):  # fmt: skip
            _say(f"measuring: {what}")
            figures += measure(compiled)
        _say("measuring: quadratic programmes")
        figures += qp.measure(Path(folder))
        _say("measuring: predictive controllers")
        figures += predictive.measure()
        _say("measuring: damping of a hybrid")
        figures += damping.measure()
        _say("measuring: plans of speed and gear")
        figures += planning.measure()
        _say("measuring: whole processes")
        figures += processes.measure()
    results.save(figures)
    print(results.table(figures))
    _say(f"took {time.perf_counter() - begun:.0f} s; wrote {results.RESULTS.name} and the table of {results.PAGE.name}")


def _say(text: str) -> None:
    print(f"benchmarks: {text}", file=sys.stderr, flush=True)


main()
