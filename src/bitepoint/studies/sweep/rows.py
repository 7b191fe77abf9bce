"""Running rows of a sweep: those of one group as lanes of one batch, those that are refused with their reason."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bitepoint.assembly import Assembly, assemble
from bitepoint.errors import InputError
from bitepoint.metrics import FAMILIES, Metric, Metrics
from bitepoint.simulation.run import Simulation
from bitepoint.simulation.system import System
from bitepoint.studies.sweep.grid import OVER
from bitepoint.studies.sweep.plan import Plan

LANES = "over"
"""The place that an error names where a key does not take a value of a lane, whatever the other keys have."""

REFUSED = "refused"
"""The status of a row whose parameters are refused."""


@dataclass(frozen=True)
class Row:
    """How one row went.

    Attributes:
        metrics: its figures; none where it was refused.
        parameters: digest of all that its run was made of; "" where it was refused.
        refusal: the error that refused it, or None.
    """

    number: int
    status: str
    reason: str
    metrics: Metrics = field(default_factory=dict[str, Metric])
    parameters: str = ""
    refusal: InputError | None = None


def run_rows(plan: Plan, rows: Sequence[int], threads: int | None = None) -> list[Row]:
    """Run rows of a sweep, and return them in order of their numbers."""
    found = [row for group in plan.groups(rows) for row in _run_group(plan, group, threads)]
    return sorted(found, key=lambda row: row.number)


def _run_group(plan: Plan, rows: Sequence[int], threads: int | None) -> list[Row]:
    """Run rows of one group. What is refused is found by halving: the others stay together."""
    try:
        assembly, simulation = _assemble(plan, rows)
    except InputError as error:
        parts = _halves(plan, rows, error)
        if len(parts) > 1:
            return [row for part in parts for row in _run_group(plan, part, threads)]
        refusal = named(plan, error)
        return [Row(number, REFUSED, str(refusal), refusal=refusal) for number in rows]
    seeds = plan.lanes(rows)[2]
    family = FAMILIES[assembly.scenario.metrics]
    lanes = simulation.run(family, lanes=len(rows), record=(), seed=seeds, threads=threads)
    digests = _digests(assembly.system, len(rows))
    return [
        Row(number, lane.status, lane.reason, lane.figures, digest)
        for number, lane, digest in zip(rows, lanes, digests, strict=True)
    ]


def _halves(plan: Plan, rows: Sequence[int], error: InputError) -> list[Sequence[int]]:
    """Return rows that were refused together in two parts, by the values of the key that the error names if it can be.

    They stay in one part where the error is that of them all: a single row, or one value that its key does not take.
    """
    key = next((axis.key for axis in plan.grid.axes if error.problem.startswith(f"{axis.key}:")), None)
    places = [0 if key is None else plan.grid.place(number, key) for number in rows]
    values = sorted(set(places))
    if len(values) > 1:
        middle = values[len(values) // 2]
        return [[n for n, place in zip(rows, places, strict=True) if (place < middle) == low] for low in (True, False)]
    if len(rows) == 1 or (key is not None and error.where == LANES):
        return [rows]
    return [rows[: len(rows) // 2], rows[len(rows) // 2 :]]


def _assemble(plan: Plan, rows: Sequence[int]) -> tuple[Assembly, Simulation]:
    shared, beside, _ = plan.lanes(rows)
    try:
        assembly = assemble(plan.name, shared, beside)
        return assembly, Simulation(assembly.system)
    except (ArithmeticError, np.linalg.LinAlgError) as error:  # a design that its numbers have no solution for
        text = " ".join(str(error).split()) or type(error).__name__
        raise InputError("controller", f"cannot be designed ({text})", "choose other values") from error


def named(plan: Plan, error: InputError) -> InputError:
    """Return an error with --over as its place where it is about a swept key."""
    swept = error.problem.startswith(tuple(axis.key for axis in plan.grid.axes))
    return InputError(OVER, error.problem, error.mend) if swept and error.where in (LANES, "--set") else error


def _digests(system: System, lanes: int) -> list[str]:
    """Return a digest for each lane: of the effective parameters of all parts, and of what else the loop is made of."""
    shared = hashlib.sha256(repr((system.rules, system.imperfections, system.duration, system.tick)).encode())
    for profile in system.profiles:
        shared.update(profile.channel.name.encode() + profile.time.tobytes() + profile.values.tobytes())
    found: list[str] = []
    for lane in range(lanes):
        digest = shared.copy()
        for part in system.parts:
            own = part.parameters[lane if len(part.parameters) > 1 else 0]
            digest.update(part.name.encode() + own.tobytes())
        found.append(digest.hexdigest()[:16])
    return found


def first_row(plan: Plan, tries: int = 64) -> Row:
    """Run one row that is not refused: the first, or else one of `tries` that are spread over the grid.

    Raises:
        InputError: all of them are refused; the error is that of the first.
    """
    rows = plan.grid.rows
    spread = dict.fromkeys(n * (rows - 1) // max(tries - 1, 1) for n in range(tries))
    refusals: list[InputError] = []
    for number in spread:
        row = run_rows(plan, [number], 1)[0]
        if row.refusal is None:
            return row
        refusals.append(row.refusal)
    first = refusals[0]
    if len({str(refusal) for refusal in refusals}) == 1:
        raise first
    many = "every row" if len(refusals) == rows else f"{len(refusals)} rows out of {rows}"
    raise InputError(first.where, f"{first.problem} (the first; {many} refused)", first.mend)
