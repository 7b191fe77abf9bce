"""What a sweep gives: its rows, how they ended, which are on the front, and its pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError
from bitepoint.recording import Floats
from bitepoint.studies.sweep.folder import PAGE, TABLE, parquet
from bitepoint.studies.sweep.pareto import Objective, front
from bitepoint.studies.sweep.rows import REFUSED
from bitepoint.studies.sweep.table import names, numbers
from bitepoint.studies.sweep.text import lines

FAILED = (REFUSED, "not finite")
"""Statuses of rows that could not be run, or left the finite numbers."""


@dataclass(frozen=True)
class SweepResult:
    """A sweep.

    Attributes:
        scenario: its name.
        rows: a pyarrow Table: a row per combination; unit and meaning in the metadata of each column.
        ran: how many of the rows were run by this call; the others were there.
        out: the folder that it is kept in, or None.
        pareto: the two figures of the front; None: the first two.
        statuses: of the rows that may be on the front; (): the one that most rows with both figures have.
    """

    scenario: str
    rows: Any
    ran: int
    out: Path | None = None
    pareto: tuple[Objective, Objective] | None = None
    statuses: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return one line: how many rows ended how."""
        return f"<SweepResult of {self.scenario}: {', '.join(f'{n} {word}' for word, n in self.counts.items())}>"

    @property
    def counts(self) -> Mapping[str, int]:
        """How many rows ended how, the most frequent first."""
        return dict(Counter(self._statuses()).most_common())

    @property
    def failures(self) -> tuple[str, ...]:
        """Statuses of rows that were refused, or left the finite numbers, where there are such."""
        return tuple(status for status in FAILED if status in self.counts)

    @property
    def failed(self) -> int:
        """How many rows were refused, or are not finite."""
        return sum(self.counts[status] for status in self.failures)

    @property
    def objectives(self) -> tuple[Objective, ...]:
        """The figures of the front; none where there are not two figures."""
        if self.pareto is not None:
            return self.pareto
        figures = names(self.rows, "figure")[:2]
        return tuple(Objective(name) for name in figures) if len(figures) == 2 else ()

    @property
    def counted(self) -> npt.NDArray[np.bool_]:
        """Which rows may be on the front, shape (rows,): both figures exist, and the run ended as it should."""
        exists: npt.NDArray[np.bool_] = np.logical_and.reduce(np.isfinite(self._points()), axis=1)
        status = self._statuses()
        usual = Counter(status[int(n)] for n in np.flatnonzero(exists)).most_common(1)
        wanted = self.statuses or [word for word, _ in usual]
        return exists & np.array([word in wanted for word in status], bool)

    def _statuses(self) -> list[str]:
        return self.rows["status"].to_pylist()

    def front(self) -> Any:
        """Return the rows that no other row beats in both figures, a pyarrow Table, sorted by the first of them."""
        points = self._points()
        points[~self.counted] = np.nan
        kept = np.flatnonzero(front(points))
        return self.rows.take(kept[np.lexsort((points[kept, 1], points[kept, 0]))])

    def _points(self) -> Floats:
        columns = [each.sign * numbers(self.rows, each.figure) for each in self.objectives]
        return np.array(columns).T if columns else np.full((self.rows.num_rows, 2), np.nan)

    def figure(self, metric: str | None = None) -> Any:
        """Return the picture of the figures over what is swept, a plotly Figure; `metric`: the one shown first."""
        from bitepoint.report.sweep_overview import overview_figure

        known = names(self.rows, "figure")
        if metric is not None and metric not in known:
            raise InputError("metric", f"got {metric}", f"expected one of {', '.join(known)}")
        return overview_figure(self.rows, metric)

    def front_figure(self) -> Any:
        """Return the picture of the Pareto front, a plotly Figure."""
        from bitepoint.report.sweep import front_figure

        return front_figure(self)

    def table(self) -> Iterator[str]:
        """Yield lines of text: how the rows ended, and the rows where they are few, else those on the front."""
        return lines(self)

    def to_json(self) -> dict[str, Any]:
        """Return what `bitepoint sweep --json` prints."""
        shown = ["row", *names(self.rows, "swept"), *(each.figure for each in self.objectives)]
        return {
            "scenario": self.scenario,
            "rows": self.rows.num_rows,
            "ran": self.ran,
            "failed": self.failed,
            "statuses": dict(self.counts),
            "front": self.front().select(shown).to_pylist(),
            "out": None if self.out is None else str(self.out),
        }

    def save(self, folder: str | Path | None = None) -> list[Path]:
        """Write sweep.parquet and the page sweep.html into `folder`, by default its own; return their paths.

        Raises:
            InputError: the folder cannot be written.
        """
        from bitepoint.report.sweep import sweep_page

        target = self.out if folder is None else Path(folder)
        if target is None:
            raise InputError("folder", "none given", "name a folder")
        page = sweep_page(self)
        try:
            target.mkdir(parents=True, exist_ok=True)
            if target != self.out:
                write_atomically(target / TABLE, parquet(self.rows))
            write_atomically(target / PAGE, page.encode(errors="backslashreplace"))
        except OSError as error:
            raise InputError(str(target), f"cannot be written ({error.strerror})", "choose another folder") from None
        return [target / TABLE, target / PAGE]
