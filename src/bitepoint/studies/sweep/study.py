"""A sweep: a scenario over the grid of some keys, in batches, kept so that it can go on after it was killed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain, islice
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy.typing as npt

from bitepoint.errors import InputError, brief
from bitepoint.studies.sweep.folder import SweepFolder
from bitepoint.studies.sweep.grid import Grid, axis, plain
from bitepoint.studies.sweep.pareto import read_objectives
from bitepoint.studies.sweep.plan import Plan
from bitepoint.studies.sweep.result import SweepResult
from bitepoint.studies.sweep.rows import first_row, run_rows
from bitepoint.studies.sweep.table import merged, names, table_of

FIRST_PART, LARGEST_PART = 16, 1024
"""Rows of the first part, and most rows of one: above that, parameters fill the memory and nothing is gained."""

PART_TIME = 2.0
"""About how long a part is to take, s: what is lost when a sweep is killed."""

Over = Mapping[str, str | Sequence[Any] | npt.NDArray[Any]]


def sweep(
    scenario: str,
    over: Over,
    settings: Mapping[str, Any] | None = None,
    /,
    *,
    out: str | Path | None = None,
    fresh: bool = False,
    pareto: str | None = None,
    statuses: Collection[str] = (),
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
    **more: Any,
) -> SweepResult:
    """Run a scenario for all combinations of the values of some keys.

    A row is what `bitepoint.run` gives with its settings and its seed, or has the status "refused" and the reason.

    Args:
        scenario: name in the library, or path of a scenario file; one of a single run.
        over: values by key, as a text ("0:20:5 %", "launch_pid,launch_mpc") or a sequence; the last changes fastest.
        settings: what all rows share, as in `run`.
        out: folder to keep the sweep in: what is there already is not run again.
        fresh: begin anew, whatever the folder holds of an earlier sweep.
        pareto: two figures whose trade-off is drawn, "friction_work,engine_speed_min:max"; by default the first two.
        statuses: of the rows that may be on the front; by default the one that most rows with both figures have.
        seed: of the noise, the same for all rows; swept where `over` has the key "seed".
        threads: how many run at once; by default as many as there are processors.
        progress: called with the number of rows that are done, and of all.
        more: settings too, a dot written as two underscores.

    Raises:
        InputError: no such scenario or key, no row that can be run, or a folder with another sweep.
    """
    if threads is not None and threads < 1:
        raise InputError("threads", f"got {brief(threads)}", "expected a whole number of 1 or more")
    grid = Grid(tuple(axis(key, values) for key, values in over.items()))
    dotted = {key.replace("__", "."): value for key, value in more.items()}
    shared = {key: plain(value) for key, value in {**(settings or {}), **dotted}.items()}
    plan = Plan(scenario, grid, shared, seed)
    folder = None if out is None else SweepFolder(Path(out), plan.identity())
    with _written(out):
        kept = [] if folder is None or fresh else folder.tables()
        figures = {name: None for table in kept for name in names(table, "figure")}
        if pareto is not None and figures:
            read_objectives(pareto, figures)
        left = plan.grid.rows - sum(table.num_rows for table in kept)
        parts = _parts(plan, kept, pareto, threads, progress or _silent) if left else ()
        table = _collected(plan, kept, parts, folder, fresh)
    objectives = None if pareto is None else read_objectives(pareto, names(table, "figure"))
    return SweepResult(plan.scenario.name, table, left, None if out is None else Path(out), objectives, tuple(statuses))


def _collected(plan: Plan, kept: list[Any], parts: Iterable[Any], folder: SweepFolder | None, fresh: bool) -> Any:
    """Return the whole table, of what was kept and of the parts that are run for it."""
    if folder is None:
        return merged([*kept, *parts], plan.identity())
    running = iter(parts)
    first = list(islice(running, 1))  # the first mistake is told before anything is written
    if not first and folder.finished:
        folder.clear()
        return kept[0]
    with folder.held():
        folder.begin(fresh)
        for table in chain(first, running):
            folder.add(table)
            kept.append(table)
        whole = merged(kept, plan.identity())
        folder.finish(whole)
    return whole


def _parts(
    plan: Plan, kept: Iterable[Any], pareto: str | None, threads: int | None, progress: Callable[[int, int], object]
) -> Iterator[Any]:
    """Yield the rows that are not kept as tables, each of about as many as can be run in PART_TIME.

    Where nothing is kept, the first is of one row that is not refused, to find mistakes that all rows share.
    """
    done = {int(number) for table in kept for number in table["row"].to_numpy()}
    progress(len(done), plan.grid.rows)
    if not done:
        row = first_row(plan)
        first = table_of(plan, [row])
        if pareto is not None:
            read_objectives(pareto, names(first, "figure"))
        yield first
        done.add(row.number)
    left = [row for group in plan.groups(range(plan.grid.rows)) for row in group if row not in done]
    size, start = FIRST_PART, 0
    while start < len(left):
        begun = perf_counter()
        part = table_of(plan, run_rows(plan, left[start : start + size], threads))
        took = perf_counter() - begun
        yield part
        start += part.num_rows
        progress(len(done) + start, plan.grid.rows)
        size = _next_size(size, took)


def _next_size(size: int, took: float) -> int:
    """Return how many rows the next part has, after one of `size` rows took a time, s."""
    if took > 2.0 * PART_TIME:
        return max(size // 2, 1)
    return min(2 * size, LARGEST_PART) if took < 0.5 * PART_TIME else size


@contextmanager
def _written(out: str | Path | None) -> Generator[None]:
    try:
        yield
    except OSError as error:
        if out is None:
            raise
        raise InputError(str(out), f"cannot be written ({error.strerror})", "choose another folder") from None


def _silent(_done: int, _rows: int) -> None:
    pass
