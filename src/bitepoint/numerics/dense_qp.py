"""Quadratic programmes from Python, at the cost of a call."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bitepoint.errors import InputError
from bitepoint.kernels.kernel import ENTRY, addresses_of
from bitepoint.numerics.qp import qp_solver
from bitepoint.numerics.qp_records import NOT_FINITE, SENTENCES, SOLVED

Floats = NDArray[np.float64]


class QpAnswer(NamedTuple):
    """How a programme ended.

    Attributes:
        status: SOLVED, INFEASIBLE or ITERATION_CAP of `qp_records`; with the last two, x is 0.
        x: the minimiser, shape (variables,).
        multipliers: of the rows, shape (rows,): > 0 at the upper limit, < 0 at the lower one.
        iterations: how often a row became active or inactive.
        residual: of the optimality conditions, see `qp_solve`; -1 without a solution.
    """

    status: int
    x: Floats
    multipliers: Floats
    iterations: int
    residual: float

    @property
    def reason(self) -> str:
        """The status as a sentence."""
        return SENTENCES[self.status]


class DenseQp:
    """Solves programmes of one size, minimise 1/2 x' H x + f' x subject to low <= G x <= high, one after the other.

    Its memory is made once, so one object serves one thread. Many programmes at once: `qp_solver(...).solve.run`.

    Args:
        variables: 1 to 32.
        rows: 0 to 128.

    Raises:
        InputError: another size; and in its methods, an array of another shape, a number that is NaN, an infinite
            one where it is no limit, or a Hessian that is not positive definite.
    """

    def __init__(self, variables: int, rows: int) -> None:
        solver = qp_solver(variables, rows)
        memory = [t.zeros() for t in (solver.matrices, solver.data, solver.work, solver.solution)]
        self._memory = memory  # what the addresses below point at
        matrices, data, _, solution = (array[0] for array in memory)
        matrices["variables"], matrices["rows"] = variables, rows
        self._status = np.zeros(1, np.int64)
        addresses, status = addresses_of([*memory, self._status]), addresses_of([self._status])
        self._factorise_arguments = np.array([addresses[0], status[0]])
        self._solve_arguments = addresses
        self._steps = np.zeros(5, np.int64)  # one lane
        self._factorise = ENTRY(solver.factorise.entry())
        self._solve = ENTRY(solver.solve.entry())
        self._factorise_call: tuple[int, int, int] = self._call(self._factorise_arguments)
        self._solve_call: tuple[int, int, int] = self._call(self._solve_arguments)
        self._hessian: Floats = matrices["hessian"][:variables, :variables]
        self._constraints: Floats = matrices["constraints"][:rows, :variables]
        self._gradient: Floats = data["gradient"][:variables]
        self._low: Floats = data["low"][:rows]
        self._high: Floats = data["high"][:rows]
        self._x: Floats = solution["x"][:variables]
        self._multipliers: Floats = solution["multipliers"][:rows]
        self._iterations, self._residual = memory[3]["iterations"], memory[3]["residual"]

    def solve(
        self, hessian: ArrayLike, gradient: ArrayLike, constraints: ArrayLike, low: ArrayLike, high: ArrayLike
    ) -> QpAnswer:
        """Return the answer to a programme.

        Args:
            hessian: H, shape (variables, variables), symmetric; only its lower triangle is factorised.
            gradient: f, shape (variables,).
            constraints: G, shape (rows, variables).
            low, high: shape (rows,); infinite for no limit.
        """
        self.factorise(hessian, constraints)
        return self.solve_again(gradient, low, high)

    def factorise(self, hessian: ArrayLike, constraints: ArrayLike) -> None:
        """Prepare for programmes with this Hessian and these rows."""
        _fill(self._hessian, hessian, "hessian")
        _fill(self._constraints, constraints, "constraints")
        self._factorise(*self._factorise_call)
        if self._status.item() != SOLVED:
            raise InputError("quadratic programme", SENTENCES[NOT_FINITE], "check hessian and constraints")

    def solve_again(self, gradient: ArrayLike, low: ArrayLike, high: ArrayLike) -> QpAnswer:
        """Return the answer to a programme with the Hessian and the rows that were given last."""
        _fill(self._gradient, gradient, "gradient")
        _fill(self._low, low, "low")
        _fill(self._high, high, "high")
        self._solve(*self._solve_call)
        status = self._status.item()
        if status == NOT_FINITE:
            mend = "check gradient, low and high, and factorise a positive definite Hessian first"
            raise InputError("quadratic programme", "a number is not finite", mend)
        x, multipliers = self._x.copy(), self._multipliers.copy()
        return QpAnswer(status, x, multipliers, self._iterations.item(), self._residual.item())

    def _call(self, arguments: NDArray[np.int64]) -> tuple[int, int, int]:
        return arguments.ctypes.data, self._steps.ctypes.data, 1


def _fill(target: Floats, values: ArrayLike, what: str) -> None:
    array = np.asarray(values, np.float64)
    if array.shape != target.shape:
        raise InputError("quadratic programme", f"{what} has shape {array.shape}", f"expected {target.shape}")
    target[...] = array
