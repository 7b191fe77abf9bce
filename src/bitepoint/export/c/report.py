"""What an export says of itself: report.json for programs, REPORT.md for people."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from bitepoint.export.c.coverage import Coverage
from bitepoint.export.c.sources import Sources
from bitepoint.export.c.toolchain import PACKAGES, Build, TargetRun
from bitepoint.units import display

DEVIATIONS: Mapping[str, str] = {
    "2.3": "bitepoint_types.h serves both precisions; each export uses one of its two floats",
    "2.5": "period and id of the parameters are macros for the caller",
    "12.1": "false: cppcheck drops the parentheses of (a / b) in front of a colon before it looks for them",
    "15.4": "a search ends where it has found, and where its data end",
    "8.7": "functions, parameters and version are for the caller, who is not here",
}
"""Rules of MISRA C:2012 that generated code departs from, and why."""


@dataclass(frozen=True)
class Difference:
    """Largest distance of an output in float32 from float64 over the recorded launches."""

    output: str
    unit: str
    largest: float


@dataclass(frozen=True)
class Findings:
    """All that was measured; None where the tools are missing.

    Attributes:
        data_bytes: of all its records in float32.
        builds: for the Cortex-M7; the first is in float32.
        runs: self-tests on emulated processors; the first is the Cortex-M7 in float32.
        solver: most iterations seen in the vectors, and the cap.
    """

    sources: Sources
    steps: int
    sequences: int
    data_bytes: int
    builds: Sequence[Build]
    runs: Sequence[TargetRun]
    misra: Mapping[str, int] | None
    coverage: Coverage | None
    differences: Sequence[Difference]
    solver: tuple[int, int] | None

    @property
    def stack_bytes(self) -> int | None:
        """Deepest stack: counted along the calls, or what was measured if more: the library takes some, too."""
        return self._stack(self.builds[0]) if self.builds else None

    def _stack(self, build: Build) -> int:
        runs = [r for r in self.runs if (r.cpu, r.precision) == (build.cpu, build.precision)]
        return max([build.stack_bytes, *(r.stack_measured for r in runs if r.stack_measured > r.stack_floor)])

    def to_json(self) -> dict[str, Any]:
        """Return the report as plain data."""
        sources = self.sources
        return {
            "name": sources.part.name,
            "precision": sources.precision.name,
            "version": sources.version,
            "origin": sources.origin,
            "parameters_id": sources.parameters_id,
            "code_bytes": self.builds[0].code_bytes if self.builds else None,
            "data_bytes": self.data_bytes,
            "stack_bytes": self.stack_bytes,
            "instructions_worst": self.runs[0].instructions_worst if self.runs else None,
            "instructions_mean": self.runs[0].instructions_mean if self.runs else None,
            "misra": None if self.misra is None else dict(self.misra),
            "maths": sorted(sources.translation.maths),
            "selftest": {"steps": self.steps, "sequences": self.sequences},
            "builds": [{**asdict(build), "stack_bytes": self._stack(build)} for build in self.builds],
            "targets": [asdict(run) for run in self.runs],
            "coverage": None if self.coverage is None else asdict(self.coverage),
            "absorbed_in_float32": [asdict(found) for found in sources.translation.absorbed],
            "float32_against_float64": {d.output: {"largest": d.largest, "unit": d.unit} for d in self.differences},
            "solver": None if self.solver is None else {"iterations_worst": self.solver[0], "cap": self.solver[1]},
        }

    def to_markdown(self) -> str:
        """Return the report for people."""
        return "\n".join(self._markdown()) + "\n"

    def _markdown(self) -> Iterator[str]:
        sources = self.sources
        yield from (f"# {sources.part.name}, {sources.precision.name}", "", f"{_sentence(sources.meaning)}")
        yield f"Version {sources.version}. Parameters: {sources.origin}; their id is {sources.parameters_id}."
        yield from self._target()
        yield from self._solver()
        yield from self._selftest()
        yield from self._precision()
        yield from self._coverage()
        yield from self._misra()

    def _target(self) -> Iterator[str]:
        yield from ("", "## On a Cortex-M7, at -O2", "")
        if not self.builds or not self.runs:
            yield from (f"Not measured in full: the tool chain is missing (Debian: {PACKAGES}).", "")
        rows: list[Sequence[object]] = []
        for build in self.builds:
            run = next((r for r in self.runs if (r.cpu, r.precision) == (build.cpu, build.precision)), None)
            counts = (None, None) if run is None else (run.instructions_worst, run.instructions_mean)
            sizes = (build.code_bytes, build.data_bytes, self._stack(build))
            rows.append((build.precision, *sizes, *(_shown(count) for count in counts)))
        header = ("precision", "code and constants, bytes", "records, bytes", "deepest stack, bytes")
        yield from _table((*header, "worst step, instructions", "mean step, instructions"), rows)
        yield from (
            "",
            f"A step is due every {self.sources.part.period:g} s. Records are parameters, state and signals. "
            "The worst step is one with these parameters, all points of curves and maps in use, "
            "searched for among thousands of random sequences: others may take somewhat more.",
        )
        yield from self._other_steps()

    def _other_steps(self) -> Iterator[str]:
        if self.runs and self.runs[0].instructions_worst_of_random is not None:
            most = self.runs[0].instructions_worst_of_random
            yield f"With random parameters, which need not make sense together, it was {most} instructions in float32."
        if any(run.steps_too_long for run in self.runs):
            yield "Not counted: steps of more than 10 million instructions, see target/main.c."

    def _solver(self) -> Iterator[str]:
        if self.solver is not None:
            worst, cap = self.solver
            yield from ("", f"The solver took {worst} iterations at most with these parameters; it stops at {cap}.")

    def _selftest(self) -> Iterator[str]:
        exact = "to the bit" if self.sources.translation.exact else "within the tolerance of test/selftest.c"
        yield from ("", "## Self-test", "")
        yield f"{self.steps} recorded steps in {self.sequences} sequences, compared {exact}."
        yield "Run it by `make test` on a computer, by `make target` in an emulated processor."
        used = sorted(self.sources.translation.maths)
        yield f"Functions of the maths library in use: {', '.join(used) or 'none'}."
        if self.runs:
            yield ""
            yield from _table(
                ("processor (emulated)", "precision", "steps", "differences", "worst step, instructions", "mean"),
                [
                    (
                        r.cpu,
                        r.precision,
                        r.steps,
                        r.differences,
                        _shown(r.instructions_worst),
                        _shown(r.instructions_mean),
                    )
                    for r in self.runs
                ],
            )

    def _precision(self) -> Iterator[str]:
        yield from ("", "## float32 against float64", "", "Largest distance over the recorded launches.", "")
        yield from _table(
            ("output", "distance"), [(d.output, f"{d.largest:.3g} {display(d.unit)}".strip()) for d in self.differences]
        )
        found = self.sources.translation.absorbed
        if found:
            yield from ("", "Constants that float32 absorbs: there they are one of their own operands.", "")
            yield from _table(("file", "line", "expression"), [(a.file, a.line, f"`{a.expression}`") for a in found])

    def _coverage(self) -> Iterator[str]:
        yield from ("", "## What the vectors reach", "")
        found = self.coverage
        if found is None:
            yield "Not measured: it takes gcc with its gcov, and make."
            return
        yield f"{found.lines_reached} of {found.lines} lines, {found.branches_reached} of {found.branches} branches."
        if found.missing:
            yield ""
            rows = [(m.line, f"`{m.text}`", m.reason or "not explained") for m in found.missing]
            yield from _table(("line", "not reached in full", "why"), rows)

    def _misra(self) -> Iterator[str]:
        yield from ("", "## MISRA C:2012", "")
        if self.misra is None:
            yield "Not checked: cppcheck is missing."
            return
        yield "Checked by cppcheck's addon; this is a check, not a statement of compliance."
        yield ""
        if not self.misra:
            yield "No findings."
            return
        rows = [(rule, count, DEVIATIONS.get(rule, "not explained")) for rule, count in self.misra.items()]
        yield from _table(("rule", "findings", "why"), rows)


def _shown(count: int | None) -> object:
    return "–" if count is None else count


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."


def _table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> Iterator[str]:
    for row in (header, ["---"] * len(header), *rows):
        yield f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in row)} |"
