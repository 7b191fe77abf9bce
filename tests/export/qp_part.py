"""A part that does nothing but solve a quadratic programme of 5 variables and 20 rows in each step."""

from __future__ import annotations

from typing import Any

import numpy as np

from bitepoint.export.c.driving import Sequence
from bitepoint.kernels import Kernel, kernel
from bitepoint.numerics.qp import qp_solver
from bitepoint.records import Record, count, nested, quantity
from bitepoint.simulation.system import Part
from tests.numerics.qp_families import Programmes

SOLVER = qp_solver(5, 20)
Qp5x20Matrices: Any = SOLVER.matrices
Qp5x20Data: Any = SOLVER.data
Qp5x20Work: Any = SOLVER.work
Qp5x20Solution: Any = SOLVER.solution

FIELDS = [f"gradient_{k}" for k in range(5)] + [f"{side}_{k}" for side in ("low", "high") for k in range(20)]


class QpParameters(Record):
    """What is fixed."""

    matrices: Qp5x20Matrices = nested(Qp5x20Matrices, "Hessian and rows, factorised")


class QpState(Record):
    """Scratch and result."""

    data: Qp5x20Data = nested(Qp5x20Data, "the programme of this step")
    work: Qp5x20Work = nested(Qp5x20Work, "scratch")
    solution: Qp5x20Solution = nested(Qp5x20Solution, "the result")
    steps: int = count(0, 1_000_000, "steps so far")


def _signals(name: str, fields: list[str]) -> type[Record]:
    declared = {field: quantity("1", -np.inf, np.inf, field) for field in fields}
    members = {"__annotations__": dict.fromkeys(fields, "float"), "__doc__": "Signals.", "__module__": __name__}
    return type(name, (Record,), {**members, **declared})


QpInputs: Any = _signals("QpInputs", FIELDS)
QpOutputs: Any = _signals("QpOutputs", [*(f"x_{k}" for k in range(5)), "residual"])


@kernel
def init(p: QpParameters, s: QpState, m: QpInputs, c: QpOutputs) -> None:
    """Show nothing yet."""
    s.steps = 0
    c.residual = 0.0


def _step_text() -> str:
    def place(field: str) -> str:
        name, _, index = field.rpartition("_")
        return f"s.data.{name}[{index}]"

    lines = ["def step(p: QpParameters, s: QpState, m: QpInputs, c: QpOutputs, dt: float) -> int:"]
    lines += ['    """Solve the programme that the inputs hold."""']
    lines += [f"    {place(field)} = m.{field}" for field in FIELDS]
    lines += ["    status = solve(p.matrices, s.data, s.work, s.solution)"]
    lines += ["    s.steps = min(s.steps + 1, 1000000)"]
    lines += [f"    c.x_{k} = s.solution.x[{k}]" for k in range(5)]
    lines += ["    c.residual = s.solution.residual", "    return status", ""]
    return "\n".join(lines)


NAMES = {"QpParameters": QpParameters, "QpState": QpState, "QpInputs": QpInputs, "QpOutputs": QpOutputs}
step: Kernel[..., int] = Kernel.generate("step", _step_text(), {**NAMES, "solve": SOLVER.solve})


def part() -> Part:
    """The part, with matrices that are the unit matrix and no rows."""
    parameters = QpParameters.zeros()
    parameters["matrices"]["variables"] = 5
    parameters["matrices"]["hessian"] = np.eye(5)
    factorised = parameters["matrices"].copy()
    SOLVER.factorise.run(factorised)
    parameters["matrices"] = factorised
    return Part("qp", init, step, parameters, QpParameters, QpState, QpInputs, QpOutputs, None, 0.01)


def sequences(programmes: Programmes, each: int = 1) -> list[Sequence]:
    """A sequence for each programme, in which it is solved; the first row is what init sees."""
    matrices, data = programmes.records(SOLVER)
    SOLVER.factorise.run(matrices)
    found: list[Sequence] = []
    for lane in range(len(programmes)):
        parameters = QpParameters.zeros()
        parameters["matrices"] = matrices[lane]
        row = np.concatenate([data[lane][name] for name in ("gradient", "low", "high")])
        found.append(Sequence(f"programme {lane}", parameters, np.vstack([row] * (each + 1))))
    return found
