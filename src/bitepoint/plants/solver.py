"""How a plant is integrated."""

from __future__ import annotations

from bitepoint.records import Record, quantity


class Solver(Record):
    """How the plant is integrated."""

    substep: float = quantity(
        "s", 1e-6, 0.002, "longest step of the Runge-Kutta rule; shorter where the plant needs it", default=0.0005
    )
