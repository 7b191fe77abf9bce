"""What a paper published beside what comes out here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bitepoint.units import display


@dataclass(frozen=True)
class Row:
    """One figure.

    Attributes:
        case: what was run; quantity: name of the figure; unit: SI, in pint's spelling.
        published: what the paper says, or None where it says nothing.
        ours: what came out here, or None where the figure does not exist.
        tolerance: share of the published figure that ours may differ by, or None where none is claimed.
        bound: "about": within the tolerance of the published figure; "most": at most the published figure; "least": at
            least that; "magnitude": the magnitude is at most that.
        reason: why there is no figure of ours, where that is known; nothing is claimed then.
    """

    case: str
    quantity: str
    published: float | None
    ours: float | None
    unit: str
    tolerance: float | None = None
    bound: str = "about"
    reason: str = ""

    @property
    def within(self) -> bool | None:
        """Whether ours is within the tolerance; None where none is claimed, or where ours could not be had."""
        if self.published is None or self.tolerance is None:
            return None
        if self.ours is None:
            return None if self.reason else False
        if self.bound == "least":
            return self.ours >= self.published * (1.0 - self.tolerance)
        if self.bound in ("most", "magnitude"):
            ours = abs(self.ours) if self.bound == "magnitude" else self.ours
            return ours <= self.published * (1.0 + self.tolerance)
        return abs(self.ours - self.published) <= self.tolerance * abs(self.published)

    @property
    def cells(self) -> tuple[str, ...]:
        """Case, quantity, published, ours, unit, tolerance, verdict, as a person reads them."""
        tolerance = "" if self.tolerance is None else f"{self.tolerance:.0%}"
        tolerance = _BOUNDS.get(self.bound, tolerance)
        verdict = {True: "yes", False: "no", None: ""}[self.within]
        published, ours = _digits(self.published), _digits(self.ours)
        if self.ours is None and self.reason:
            ours += f" ({self.reason})"
        return self.case, self.quantity, published, ours, display(self.unit), tolerance, verdict

    def to_json(self) -> dict[str, Any]:
        """Return what `bitepoint reproduce --json` prints of it."""
        return {
            "case": self.case,
            "quantity": self.quantity,
            "published": self.published,
            "ours": self.ours,
            "unit": self.unit,
            "tolerance": self.tolerance,
            "within": self.within,
            **({"reason": self.reason} if self.ours is None and self.reason else {}),
        }


@dataclass(frozen=True)
class Reproduction:
    """A paper, reproduced.

    Attributes:
        name: as the command line takes it; source: the paper.
        rows: in the order of the paper; notes: sentences on what cannot be as published, and why.
        figures: Plotly figures by title.
    """

    name: str
    source: str
    rows: Sequence[Row]
    notes: Sequence[str]
    figures: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def to_json(self) -> dict[str, Any]:
        """Return what `bitepoint reproduce --json` prints."""
        rows = [row.to_json() for row in self.rows]
        return {"paper": self.name, "source": self.source, "rows": rows, "notes": list(self.notes)}

    def table(self) -> Iterator[str]:
        """Yield the rows as lines of text, under a header."""
        rows = [("case", "quantity", "published", "ours", "unit", "tolerance", "within"), *(r.cells for r in self.rows)]
        widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
        left = (0, 1, 4)
        for row in rows:
            cells = zip(row, widths, strict=True)
            aligned = [f"{cell:<{width}}" if n in left else f"{cell:>{width}}" for n, (cell, width) in enumerate(cells)]
            yield "  ".join(aligned).rstrip()


_BOUNDS = {"most": "at most", "least": "at least", "magnitude": "at most, ±"}


def _digits(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
