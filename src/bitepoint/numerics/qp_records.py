"""Records of the quadratic programme: what is fixed, what changes from step to step, scratch, and the result.

They are written here for 5 variables and 20 rows; `resized` makes those of another size. A record is as large as the
size says, and `variables` and `rows` say how much of it is in use: horizons are data, not a reason to compile.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from bitepoint.records import FloatArray, IntArray, Record, count, quantity

VARIABLES = 5
ROWS = 20

ITERATIONS = 10 * VARIABLES + ROWS
"""Cap of the iterations.

10 per variable and one per row. Of a million programmes of 5 variables and 20 rows without structure the longest took
41, and each 2 iterations more are three times as rare; of a million of predictive control the longest took 21. Larger
ones stay as far below: 68 of 112 for 8 variables and 32 rows, 238 of 448 for 32 and 128.
"""

SOLVED, INFEASIBLE, ITERATION_CAP, NOT_FINITE, INACCURATE = 0, 1, 2, 3, 4

SENTENCES = {
    SOLVED: "solved",
    INFEASIBLE: "no point satisfies all rows",
    ITERATION_CAP: "not solved within the cap of iterations",
    NOT_FINITE: "a number is not finite, or the Hessian is not positive definite",
    INACCURATE: "the solution does not satisfy the optimality conditions well enough",
}
"""What the statuses mean."""

ANY = math.inf

GENERATED = "bitepoint generated"
"""Module of the record types of other sizes: none that could be imported."""


class QpMatrices(Record):
    """Hessian and rows of the programme, and what `factorise` makes of them."""

    variables: int = count(1, VARIABLES, "variables in use")
    rows: int = count(0, ROWS, "rows in use")
    usable: int = count(0, 1, "1 when factorised: all finite, the Hessian positive definite")
    hessian: FloatArray = quantity("1", -ANY, ANY, "H, symmetric", shape=(VARIABLES, VARIABLES))
    constraints: FloatArray = quantity("1", -ANY, ANY, "G, a row per limit", shape=(ROWS, VARIABLES))
    inverse_factor: FloatArray = quantity("1", -ANY, ANY, "inverse of L, H = L L'", shape=(VARIABLES, VARIABLES))
    slabs: int = count(0, ROWS, "rows that are not zeros, those equal or opposite in terms of y counted once")
    normals: FloatArray = quantity("1", -1, 1, "of the slabs: rows of G over L', of length 1", shape=(ROWS, VARIABLES))
    slab: IntArray = count(0, ROWS - 1, "slab of each row", shape=(ROWS,))
    scales: FloatArray = quantity(
        "1",
        -ANY,
        ANY,
        "what makes a row the normal of its slab: < 0 turns it round, 0 for a row of zeros",
        shape=(ROWS,),
    )


class QpData(Record):
    """What changes from one step to the next."""

    gradient: FloatArray = quantity("1", -ANY, ANY, "f", shape=(VARIABLES,))
    low: FloatArray = quantity("1", -ANY, ANY, "lower limits of G x; minus infinity for none", shape=(ROWS,))
    high: FloatArray = quantity("1", -ANY, ANY, "upper limits of G x; infinity for none", shape=(ROWS,))


class QpWork(Record):
    """Scratch. Its content before a call does not matter."""

    members: int = count(0, VARIABLES, "active slabs")
    watched: int = count(0, ROWS, "slabs that are not active")
    place: int = count(0, ROWS - 1, "place of the entering slab among these")
    entering: int = count(0, ROWS - 1, "slab that becomes active")
    leaving: int = count(0, VARIABLES - 1, "place of the active slab whose force first falls to 0")
    gap: float = quantity("1", -ANY, ANY, "entering slab: how far above its upper limit, or below (< 0) its lower one")
    force: float = quantity("1", -ANY, ANY, "entering slab: its multiplier so far")
    limit: float = quantity("1", -1, ANY, "longest step of the multiplier; -1 for any")
    square: float = quantity("1", 0, 1, "squared length of the direction")
    size: float = quantity("1", 0, ANY, "length of the way to the point, from 0: what rounding is relative to")
    low: FloatArray = quantity("1", -ANY, ANY, "lower limits of the slabs", shape=(ROWS,))
    high: FloatArray = quantity("1", -ANY, ANY, "upper limits of the slabs", shape=(ROWS,))
    lowest: IntArray = count(0, ROWS - 1, "rows that set the lower limits", shape=(ROWS,))
    highest: IntArray = count(0, ROWS - 1, "rows that set the upper limits", shape=(ROWS,))
    point: FloatArray = quantity("1", -ANY, ANY, "y = L' x", shape=(VARIABLES,))
    basis: FloatArray = quantity(
        "1", -1, 1, "orthonormal rows, of which the first span the active normals", shape=(VARIABLES, VARIABLES)
    )
    triangle: FloatArray = quantity("1", -1, 1, "active normals in that basis", shape=(VARIABLES, VARIABLES))
    pivots: FloatArray = quantity("1", -ANY, ANY, "1 over the diagonal of the triangle", shape=(VARIABLES,))
    parts: FloatArray = quantity("1", -1, 1, "entering normal in that basis", shape=(VARIABLES,))
    direction: FloatArray = quantity("1", -1, 1, "entering normal less what active ones span", shape=(VARIABLES,))
    ratios: FloatArray = quantity("1", -ANY, ANY, "what active normals span of the entering one", shape=(VARIABLES,))
    forces: FloatArray = quantity("1", -ANY, ANY, "multipliers of the active normals", shape=(VARIABLES,))
    sides: FloatArray = quantity("1", -1, 1, "1 active at high, -1 at low, 0 with both equal", shape=(VARIABLES,))
    active: IntArray = count(0, ROWS - 1, "active slabs; at the end their rows", shape=(VARIABLES,))
    watch: IntArray = count(0, ROWS - 1, "slabs that are not active", shape=(ROWS,))


class QpSolution(Record):
    """The result. With any status but SOLVED, x and the multipliers are 0 and the residual is -1."""

    x: FloatArray = quantity("1", -ANY, ANY, "minimiser", shape=(VARIABLES,))
    multipliers: FloatArray = quantity("1", -ANY, ANY, "of the rows: > 0 at high, < 0 at low", shape=(ROWS,))
    residual: float = quantity("1", -1, ANY, "of the optimality conditions, relative")
    iterations: int = count(0, ITERATIONS, "slabs that became active or inactive")


def resized(record: type[Record], variables: int, rows: int) -> type[Record]:
    """Return the record type for another size; `record` is one of the above."""
    sizes = {VARIABLES: variables, VARIABLES - 1: variables - 1, ROWS: rows, ROWS - 1: rows - 1}
    sizes[ITERATIONS] = 10 * variables + rows
    fields: dict[str, Any] = {}
    for name, field in record.fields.items():
        high = sizes.get(int(field.high), field.high) if field.kind == "int" else field.high
        fields[name] = replace(field, high=high, shape=tuple(sizes[length] for length in field.shape))
    name = record.__name__.replace("Qp", f"Qp{variables}x{rows}")
    members = {"__annotations__": record.__annotations__, "__doc__": record.__doc__, "__module__": GENERATED, **fields}
    return type(name, (Record,), members)
