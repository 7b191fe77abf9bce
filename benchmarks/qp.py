"""Quadratic programmes of 5 variables and 20 rows: in a compiled loop beside DAQP in C, from Python beside its peers.

The programmes are those of a predictive controller that runs into its limits: 40 plants, each with one Hessian and one
set of rows, 50 gradients each. All solve each of them from a cold start.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import daqp
import numpy as np
import quadprog
from tests.numerics.qp_families import Programmes, mpc, solve

from benchmarks.launches import DisagreementError
from benchmarks.results import Figure
from benchmarks.timing import Samples, side_by_side
from benchmarks.yardstick import FAST, NoCompilerError
from bitepoint.kernels.kernel import ENTRY, addresses_of
from bitepoint.numerics.dense_qp import DenseQp
from bitepoint.numerics.qp import qp_solver
from bitepoint.recording import Floats

PLANTS, EACH = 40, 50
TOLERANCE = 1e-6
_LOOP = Path(__file__).parent / "daqp" / "loop.c"


def programmes() -> Programmes:
    """Return the programmes, those of one plant next to each other."""
    rng = np.random.default_rng(5)
    plants = mpc(rng, PLANTS, two_sided=False)
    arrays = (plants.hessian, plants.gradient, plants.constraints, plants.low, plants.high)
    lanes = Programmes(*(np.repeat(array, EACH, axis=0) for array in arrays))
    return replace(lanes, gradient=lanes.gradient * rng.uniform(-2.0, 2.0, (PLANTS * EACH, 1)))


def sources(folder: Path) -> Path:
    """Fetch the source distribution of the installed DAQP into `folder`; return where its C lies.

    Raises:
        NoCompilerError: it is not to be had.
    """
    package = f"daqp=={version('daqp')}"
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", "daqp", package]
    done = subprocess.run([*command, "--dest", str(folder)], capture_output=True, text=True, check=False)
    archives = sorted(folder.glob("daqp-*.tar.gz"))
    if done.returncode != 0 or not archives:
        raise NoCompilerError(f"no sources of {package} from the package index")
    shutil.unpack_archive(archives[0], folder, filter="data")
    return archives[0].with_name(archives[0].name.removesuffix(".tar.gz")) / "csrc"


def build(folder: Path) -> ctypes.CDLL:
    """Compile DAQP and the loop around it.

    Raises:
        NoCompilerError: with the reason.
    """
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        raise NoCompilerError("no gcc or cc on the path")
    code, target = sources(folder), folder / "daqp_loop.so"
    files = [str(_LOOP), *sorted(str(file) for file in (code / "src").glob("*.c"))]
    include = f"-I{code / 'include'}"
    command = [compiler, "-std=gnu11", *FAST, include, "-shared", "-fPIC", "-o", str(target), *files, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise NoCompilerError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "the compiler failed")
    library = ctypes.CDLL(str(target))
    library.loop_new.restype = ctypes.c_void_p
    return library


@dataclass
class DaqpLoops:
    """DAQP in C, set up for each plant."""

    given: Programmes
    library: ctypes.CDLL

    def __post_init__(self) -> None:
        p = self.given
        self.x, self.multipliers = np.zeros_like(p.gradient), np.zeros(p.size[1])
        self.arrays = [np.ascontiguousarray(a) for a in (p.hessian, p.gradient, p.constraints, p.low, p.high)]
        n, m = (ctypes.c_int(size) for size in p.size)
        self.calls: list[tuple[Any, ...]] = []
        for first in range(0, len(p), EACH):
            handle = self.library.loop_new(n, m, *(_pointer(array[first:]) for array in self.arrays))
            if handle is None:
                raise DisagreementError("DAQP refuses to set up")
            _, gradient, _, low, high = self.arrays
            series = [_pointer(array[first:]) for array in (gradient, low, high, self.x)]
            call = (ctypes.c_void_p(handle), ctypes.c_int(EACH), *series, _pointer(self.multipliers))
            self.calls.append(call)

    def run(self) -> None:
        """Solve all."""
        failed = [self.library.loop_run(*call) for call in self.calls]
        if any(failed):
            raise DisagreementError(f"DAQP did not solve {sum(failed)} programmes")


@dataclass
class CompiledLoops:
    """The kernel over the programmes of each plant, one call per plant."""

    given: Programmes

    def __post_init__(self) -> None:
        solver = qp_solver(*self.given.size)
        self.matrices, self.data = self.given.records(solver)
        solver.factorise.run(self.matrices)
        self.work, self.solution = solver.work.zeros(), solver.solution.zeros(len(self.given))
        self.status = np.zeros(len(self.given), np.int64)
        lanes = [self.data, self.work, self.solution, self.status]
        self.steps = np.array([0, self.data.itemsize, 0, self.solution.itemsize, 8])
        self.rows: list[Any] = []
        for first in range(0, len(self.given), EACH):
            views = [array if array is self.work else array[first:] for array in lanes]
            self.rows.append(addresses_of([self.matrices[first:], *views]))
        self.entry: Callable[..., Any] = ENTRY(solver.solve.entry())

    def run(self) -> None:
        """Solve all."""
        for row in self.rows:
            self.entry(row.ctypes.data, self.steps.ctypes.data, EACH)


def _from_python(given: Programmes) -> dict[str, Callable[[], Floats]]:
    """Return what solves all programmes by calls from Python, each in the form that its solver wants."""
    qp, lanes = DenseQp(*given.size), [tuple(np.array(array) for array in one) for one in given]
    for_quadprog = [(h, -f, -g.T.copy(), -high) for h, f, g, _, high in lanes]
    for_daqp = [(h, f, g, high, low) for h, f, g, low, high in lanes]

    def again() -> Floats:
        found: list[Floats] = []
        for k, (hessian, gradient, rows, low, high) in enumerate(lanes):
            if k % EACH == 0:
                qp.factorise(hessian, rows)
            found.append(qp.solve_again(gradient, low, high).x)
        return np.array(found)

    return {
        "solve": lambda: np.array([qp.solve(*one).x for one in lanes]),
        "again": again,
        "quadprog": lambda: np.array([quadprog.solve_qp(*one)[0] for one in for_quadprog]),
        "daqp": lambda: np.array([daqp.solve(*one)[0] for one in for_daqp]),
    }


def measure(folder: Path) -> list[Figure]:
    """Return the figures; without the sources of DAQP, or a compiler, the loop stands alone."""
    given = programmes()
    wanted = solve(given).x
    ours, ways = CompiledLoops(given), _from_python(given)
    for name, way in ways.items():
        _hold(name, way(), wanted)
    ours.run()
    _hold("compiled loop", ours.solution["x"], wanted)
    loops: dict[str, Callable[[], object]] = {"ours": ours.run}
    try:
        theirs = DaqpLoops(given, build(folder))
        theirs.run()
        _hold("DAQP in C", theirs.x, wanted)
        loops["daqp c"] = theirs.run
    except NoCompilerError as reason:
        print(f"benchmarks: without DAQP in C: {reason}", file=sys.stderr, flush=True)
    return _figures(side_by_side(loops, rounds=60, calls=5), side_by_side(ways, rounds=40))


def _figures(loops: Samples, ways: Samples) -> list[Figure]:
    def of(name: str, samples: Samples, one: str, other: str, what: str) -> Figure:
        value = 1e6 * samples.median(one) / (PLANTS * EACH)
        if other not in samples.seconds:
            return Figure(name, value, "µs", None, None)
        against = f"{what}: {1e6 * samples.median(other) / (PLANTS * EACH):.3g} µs"
        return Figure(name, value, "µs", samples.ratio(one, other), against)

    return [
        of("qp_in_loop", loops, "ours", "daqp c", "DAQP in a loop in C"),
        of("qp_solve", ways, "solve", "quadprog", "quadprog.solve_qp"),
        of("qp_solve_vs_daqp", ways, "solve", "daqp", "daqp.solve"),
        of("qp_solve_again", ways, "again", "quadprog", "quadprog.solve_qp"),
    ]


def _hold(name: str, x: Floats, wanted: Floats) -> None:
    difference = np.abs(x - wanted).max(axis=1) / np.maximum(np.abs(wanted).max(axis=1), TOLERANCE)
    if not (difference <= TOLERANCE).all():
        raise DisagreementError(f"quadratic programmes, {name}: x differs by {difference.max():.1e}, relative")


def _pointer(array: Floats) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
