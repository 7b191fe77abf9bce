"""The quadratic programmes of the active-set kernel by an interior point: PIQP, on the desktop.

Another method for the same programme, so that neither is its own witness. It takes the records of a solver of any size,
as a controller has them in its parameters and its scratch, and what is in use of them.

Reference: R. Schwan, Y. Jiang, D. Kuhn, C. N. Jones, PIQP: a proximal interior-point quadratic programming solver, IEEE
CDC 2023.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bitepoint.errors import InputError
from bitepoint.numerics.dense_qp import QpAnswer
from bitepoint.numerics.qp_records import INFEASIBLE, ITERATION_CAP, NOT_FINITE, SOLVED
from bitepoint.recording import Floats

TOLERANCE = 1e-10
"""Residuals at which PIQP stops, absolute and relative; its default, 1e-8, is seen in the torques of a controller."""


def load_piqp() -> Any:
    """Return the module piqp.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module("piqp")
    except ImportError:
        raise InputError("interior point", "needs PIQP", "pip install 'bitepoint[interior]'") from None


def programme_of(matrices: np.void, data: np.void) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return H, f, G, low and high of what is in use of two records, of type `QpMatrices` and `QpData`, as copies."""
    n, m = int(matrices["variables"]), int(matrices["rows"])
    parts = (
        matrices["hessian"][:n, :n], data["gradient"][:n], matrices["constraints"][:m, :n], data["low"][:m],
        data["high"][:m],
    )  # fmt: skip
    hessian, gradient, rows, low, high = (np.array(part, np.float64) for part in parts)
    return hessian, gradient, rows, low, high


def interior_solver(matrices: np.void, data: np.void) -> Any:
    """Return a `piqp.DenseSolver` that is set up for a programme.

    Raises:
        InputError: PIQP is not installed.
    """
    hessian, gradient, rows, low, high = programme_of(matrices, data)
    solver = load_piqp().DenseSolver()
    settings = solver.settings
    settings.eps_abs = settings.eps_rel = TOLERANCE
    settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = TOLERANCE
    order: NDArray[np.float64] = np.asfortranarray(rows)
    solver.setup(np.asfortranarray(hessian), gradient, None, None, order, low, high)
    return solver


def solve_interior(matrices: np.void, data: np.void) -> QpAnswer:
    """Return the answer to a programme by an interior point, in the terms of `DenseQp`.

    Args:
        matrices, data: one record each, as of `QpMatrices` and `QpData`; they need not be factorised.

    Raises:
        InputError: PIQP is not installed.
    """
    solver, piqp = interior_solver(matrices, data), load_piqp()
    outcome = solver.solve()
    status = {
        piqp.PIQP_SOLVED: SOLVED, piqp.PIQP_PRIMAL_INFEASIBLE: INFEASIBLE, piqp.PIQP_MAX_ITER_REACHED: ITERATION_CAP
    }.get(outcome, NOT_FINITE)  # fmt: skip
    found, info = solver.result, solver.result.info
    residual = float(max(info.primal_res, info.dual_res)) if status == SOLVED else -1.0
    x, multipliers = np.array(found.x), np.array(found.z_u) - np.array(found.z_l)
    if status != SOLVED:
        x, multipliers = np.zeros_like(x), np.zeros_like(multipliers)
    return QpAnswer(status, x, multipliers, int(info.iter), residual)
