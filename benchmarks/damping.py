"""Predictive damping of a hybrid: one step in a compiled loop and from Python, its programmes beside other solvers, a
closed loop and a sweep beside real time.

The programmes are those of `p2-tip-in`, 62 s with 30 steps of horizon and 5 moves. From Python each solver gets them in
the form that it wants, set up before where it can be: only what changes from step to step is handed over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import clarabel
import daqp
import numpy as np
import osqp
import quadprog
from scipy import sparse
from tests.controllers.damping_programmes import DampingProgramme, programmes

import bitepoint
from benchmarks.damping_do_mpc import do_mpc_solver
from benchmarks.launches import DisagreementError
from benchmarks.results import Figure, cores
from benchmarks.timing import side_by_side
from bitepoint.assembly import assemble
from bitepoint.controllers.damping_mpc_records import TORQUE_SCALE
from bitepoint.kernels.kernel import ENTRY, addresses_of
from bitepoint.numerics.dense_qp import DenseQp
from bitepoint.numerics.interior_point import interior_solver, programme_of
from bitepoint.recording import Floats
from bitepoint.simulation.run import Simulation
from bitepoint.simulation.step_times import step_times

SCENARIO = "p2-tip-in"
EVERY = 6
"""Every how many-th programme is solved from Python."""

WHOLE = 200
"""Every how many-th step is solved by do-mpc."""

FIRST_MOVE = 0.01
"""How far the first move of another solver may be from the kernel's, N m."""

HORIZONS = {"controller.prediction_horizon": range(10, 101, 10), "controller.control_horizon": range(1, 11)}
"""The sweep: 100 cells."""


@dataclass
class Steps:
    """All steps of a run in one call of the compiled entry; the memory goes on from step to step."""

    def __post_init__(self) -> None:
        self.part = assemble(SCENARIO, {}).system.controllers[-1]
        part = self.part
        assert part.work is not None
        self.recording = bitepoint.run(SCENARIO).recording
        every = round(part.period / float(self.recording.time[1]))
        self.count = len(self.recording.time[::every])
        self.seen, self.shown = part.inputs.zeros(self.count), part.outputs.zeros(self.count)
        for name in part.inputs.fields:
            self.seen[name] = self.recording[name][::every]
        self.state, self.work = part.state.zeros(), part.work.zeros()
        self.period, self.status = np.array([part.period]), np.zeros(1, np.int64)
        arrays = [part.parameters, self.state, self.seen, self.shown, self.work, self.period, self.status]
        self.addresses = addresses_of(arrays)
        self.strides = np.array([0, 0, self.seen.itemsize, self.shown.itemsize, 0, 0, 0])
        self.entry = ENTRY(part.step.entry())
        self.run()
        for name in part.outputs.fields:
            if not np.array_equal(self.shown[name], self.recording[name][::every]):
                raise DisagreementError(f"steps of {part.name}: {name} is not that of the run")

    def run(self) -> None:
        """Take them."""
        self.part.init.run(self.part.parameters, self.state, self.seen[:1], self.shown[:1].copy(), self.work)
        self.entry(self.addresses.ctypes.data, self.strides.ctypes.data, self.count)


def _ways(lanes: Iterable[DampingProgramme]) -> dict[str, Callable[[], Floats]]:
    """Return what solves all programmes, of one Hessian and one set of rows, by calls from Python, into first moves."""
    given = list(lanes)
    hessian, _, rows, _, _ = programme_of(given[0].matrices, given[0].data)
    changing = [(f, low, high) for _, f, _, low, high in (programme_of(one.matrices, one.data) for one in given)]
    ours = DenseQp(*rows.shape[::-1])
    ours.factorise(hessian, rows)
    interior = interior_solver(given[0].matrices, given[0].data)
    splitting = osqp.OSQP()
    _, low, high = changing[0]
    options = {"verbose": False, "eps_abs": 1e-7, "eps_rel": 1e-7, "max_iter": 20_000}
    splitting.setup(sparse.csc_matrix(np.triu(hessian)), changing[0][0], sparse.csc_matrix(rows), low, high, **options)
    both = np.hstack([rows.T, -rows.T])

    def by_interior(f: Floats, low: Floats, high: Floats) -> float:
        interior.update(c=f, h_l=low, h_u=high)
        interior.solve()
        return interior.result.x[0]

    def by_splitting(f: Floats, low: Floats, high: Floats) -> float:
        splitting.update(q=f, l=low, u=high)
        return splitting.solve().x[0]

    def all_of(solve: Callable[[Floats, Floats, Floats], float]) -> Callable[[], Floats]:
        return lambda: np.array([solve(*one) for one in changing])

    return {
        "ours": all_of(lambda f, low, high: ours.solve_again(f, low, high).x[0]),
        "PIQP": all_of(by_interior),
        "OSQP": all_of(by_splitting),
        "DAQP": all_of(lambda f, low, high: daqp.solve(hessian, f, rows, high, low)[0][0]),
        "quadprog": all_of(
            lambda f, low, high: quadprog.solve_qp(hessian, -f, both, np.concatenate([low, -high]))[0][0]
        ),
        "Clarabel": all_of(_by_clarabel(hessian, rows)),
    }


def _by_clarabel(hessian: Floats, rows: Floats) -> Callable[[Floats, Floats, Floats], float]:
    library: Any = clarabel
    quadratic, both = sparse.csc_matrix(np.triu(hessian)), sparse.csc_matrix(np.vstack([rows, -rows]))
    settings, cones = library.DefaultSettings(), [library.NonnegativeConeT(2 * len(rows))]
    settings.verbose = False

    def solve(f: Floats, low: Floats, high: Floats) -> float:
        limits = np.concatenate([high, -low])
        return library.DefaultSolver(quadratic, f, both, limits, cones, settings).solve().x[0]

    return solve


def _solvers() -> list[Figure]:
    lanes = list(programmes(SCENARIO))[::EVERY]
    ways, wanted = _ways(lanes), np.array([one.move for one in lanes])
    for name, way in ways.items():
        difference = np.abs(TORQUE_SCALE * way() - wanted).max()
        if difference > FIRST_MOVE:
            raise DisagreementError(f"programmes of {SCENARIO}, {name}: first moves differ by {difference:.1e} N m")
    samples = side_by_side(ways, rounds=9)
    each = {name: 1e6 * samples.median(name) / len(lanes) for name in ways}
    return [
        Figure(f"damping_qp_vs_{name.lower()}", each["ours"], "µs", samples.ratio("ours", name), f"{name}: {us:.3g} µs")
        for name, us in each.items()
        if name != "ours"
    ]


def _steps() -> list[Figure]:
    steps = Steps()
    inside = side_by_side({"inside": steps.run}, rounds=30).median("inside") / steps.count
    times = np.concatenate([step_times(steps.part, steps.recording).seconds for _ in range(5)])
    median, rare = float(np.median(times)), float(np.quantile(times, 0.999, method="higher"))
    of_loop = f"the same in a loop: {1e9 * inside:.3g} ns"
    return [
        Figure("damping_step_in_loop", 1e9 * inside, "ns", None, None),
        Figure("damping_step_from_python", 1e6 * median, "µs", median / inside, of_loop),
        Figure("damping_step_from_python_p999", 1e6 * rare, "µs", rare / inside, of_loop),
    ]


def _whole_steps() -> list[Figure]:
    """Return a step of the controller, called from Python, beside its programme by do-mpc; nothing without that."""
    solve = do_mpc_solver(SCENARIO)
    if solve is None:
        return []
    lanes = list(programmes(SCENARIO))[::WHOLE]
    difference = max(abs(solve(one.past) - one.move) for one in lanes)
    if difference > FIRST_MOVE:
        raise DisagreementError(f"programmes of {SCENARIO}, do-mpc: first moves differ by {difference:.1e} N m")
    steps = Steps()
    ours = float(np.median(step_times(steps.part, steps.recording).seconds))
    theirs = side_by_side({"do-mpc": lambda: [solve(one.past) for one in lanes]}, rounds=3).median("do-mpc") / len(
        lanes
    )
    return [Figure("damping_step_vs_do_mpc", 1e6 * ours, "µs", ours / theirs, f"do-mpc: {1e3 * theirs:.3g} ms")]


def _loops() -> list[Figure]:
    assembly = assemble(SCENARIO, {})
    simulation, duration = Simulation(assembly.system), assembly.system.duration
    cells = len(HORIZONS["controller.prediction_horizon"]) * len(HORIZONS["controller.control_horizon"])
    ways: Mapping[str, Callable[[], object]] = {
        "one": lambda: simulation.run(assembly.figures),
        "bare": lambda: simulation.run(lambda _: None),
        "sweep": lambda: bitepoint.sweep(SCENARIO, {key: list(values) for key, values in HORIZONS.items()}),
    }
    samples = side_by_side(ways, rounds=3)
    one, bare, sweep = (samples.median(name) for name in ways)
    per_core = cells * duration / (sweep * cores())
    return [
        Figure("damping_run", 1e3 * one, "ms", one / duration, f"the {duration:g} s that it simulates"),
        Figure("damping_run_without_figures", 1e3 * bare, "ms", bare / duration, f"the {duration:g} s"),
        Figure("damping_sweep", sweep, "s", 1.0 / per_core, f"{cells} runs of {duration:g} s, by {cores()} cores"),
        Figure("damping_sweep_per_core", per_core, "s/s", per_core, "real time, each core"),
    ]


def measure() -> list[Figure]:
    """Return the figures of a step, of its programme, and of runs."""
    return [*_steps(), *_solvers(), *_whole_steps(), *_loops()]
