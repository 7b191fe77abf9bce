"""Families of quadratic programmes for tests and benchmarks, and an optimality certificate of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bitepoint.numerics.qp import QpSolver, qp_solver
from bitepoint.records import RecordArray

Floats = NDArray[np.float64]
MOVES = 5


@dataclass(frozen=True)
class Programmes:
    """Many programmes of one size: H (lanes, n, n), f (lanes, n), G (lanes, m, n), low and high (lanes, m)."""

    hessian: Floats
    gradient: Floats
    constraints: Floats
    low: Floats
    high: Floats

    def __len__(self) -> int:
        return len(self.gradient)

    @property
    def size(self) -> tuple[int, int]:
        """Variables and rows."""
        return self.gradient.shape[1], self.low.shape[1]

    def __iter__(self) -> Iterator[tuple[Floats, Floats, Floats, Floats, Floats]]:
        return zip(self.hessian, self.gradient, self.constraints, self.low, self.high, strict=True)

    def records(self, solver: QpSolver, fill: float = 0.0) -> tuple[RecordArray, RecordArray]:
        """Return matrices and data for `solver`, the places that are not in use set to `fill`."""
        (n, m), lanes = self.size, len(self)
        matrices, data = solver.matrices.zeros(lanes), solver.data.zeros(lanes)
        for record, names in (
            (matrices, ("hessian", "constraints", "inverse_factor", "normals", "scales")),
            (data, ("gradient", "low", "high")),
        ):
            for name in names:
                record[name] = fill
        matrices["variables"], matrices["rows"] = n, m
        matrices["hessian"][:, :n, :n], matrices["constraints"][:, :m, :n] = self.hessian, self.constraints
        data["gradient"][:, :n], data["low"][:, :m], data["high"][:, :m] = self.gradient, self.low, self.high
        return matrices, data


@dataclass(frozen=True)
class Solutions:
    """What became of them: statuses (lanes,), x (lanes, n), multipliers (lanes, m), iterations, residuals (lanes,)."""

    status: NDArray[np.int64]
    x: Floats
    multipliers: Floats
    iterations: NDArray[np.int64]
    residual: Floats


def solve(
    programmes: Programmes, solver: QpSolver | None = None, life: str = "compiled", fill: float = 0.0
) -> Solutions:
    """Factorise and solve all; a Hessian that cannot be factorised shows in the status of solve."""
    n, m = programmes.size
    solver = solver or qp_solver(n, m)
    matrices, data = programmes.records(solver, fill)
    work, solution = solver.work.zeros(), solver.solution.zeros(len(data))
    solver.factorise.run(matrices, life=life)  # pyright: ignore[reportArgumentType]
    status = solver.solve.run(matrices, data, work, solution, life=life)  # pyright: ignore[reportArgumentType]
    x, multipliers = solution["x"][:, :n], solution["multipliers"][:, :m]
    return Solutions(status, x, multipliers, solution["iterations"], solution["residual"])


def shortfall(programmes: Programmes, x: Floats, multipliers: Floats) -> Floats:
    """Return how far x and multipliers are from optimal, shape (lanes,): 0 for a perfect certificate.

    The largest of: H x + f + G' multipliers over the largest of its terms; violation of a row, and distance of a row
    from the limit that its multiplier points to, both as a distance in the metric of H over the size of the problem.
    """
    hessian, gradient, rows = programmes.hessian, programmes.gradient, programmes.constraints
    terms = [np.einsum("lij,lj->lij", hessian, x), gradient[:, :, None], np.einsum("lij,li->lji", rows, multipliers)]
    stacked = np.concatenate(terms, axis=2)
    stationarity = np.abs(stacked.sum(2)).max(1) / np.maximum(np.abs(stacked).sum(2).max(1), 1e-300)
    lower = np.linalg.cholesky(hessian)
    free = np.linalg.solve(lower, gradient[:, :, None])[:, :, 0]
    point = np.einsum("lij,li->lj", lower, x)
    lengths = np.linalg.norm(np.linalg.solve(lower, rows.transpose(0, 2, 1)), axis=1)
    value = np.einsum("lij,lj->li", rows, x)
    off = np.maximum(np.maximum(value - programmes.high, programmes.low - value), 0.0)
    off = np.where(multipliers > 0, np.abs(value - programmes.high), off)
    off = np.where(multipliers < 0, np.abs(value - programmes.low), off)
    size = np.linalg.norm(free, axis=1) + np.linalg.norm(point, axis=1)
    distance = np.divide(off, lengths, out=off.copy(), where=lengths > 0)
    return np.maximum(stationarity, distance.max(1, initial=0.0) / np.maximum(size, 1e-300))


def expm(matrices: Floats) -> Floats:
    """Return the exponentials of many small matrices, shape (lanes, n, n): scaling, a series, squaring."""
    scaled = matrices / 2.0**12
    term = total = np.broadcast_to(np.eye(matrices.shape[1]), matrices.shape)
    for k in range(1, 8):
        term = term @ scaled / k
        total = total + term
    for _ in range(12):
        total = total @ total
    return total


def mpc(rng: np.random.Generator, lanes: int, *, two_sided: bool) -> Programmes:
    """Return programmes of a predictive controller: 5 moves, their amplitudes and rates limited, always feasible.

    Plants are oscillators or integrators with lag, seen over 20 steps; states, references and the last move lie from
    well inside the limits to a hundred times outside what these allow. 10 two-sided rows, or 20 one-sided ones.
    """
    steps = 20
    period, frequency = 10 ** rng.uniform(-2, -0.5, lanes), 10 ** rng.uniform(-0.5, 1, lanes)
    block = np.zeros((lanes, 3, 3))
    block[:, 0, 1] = 1.0
    block[:, 1, 0] = np.where(rng.random(lanes) < 0.3, 0.0, -(frequency**2))
    block[:, 1, 1] = -2 * rng.uniform(0.05, 1.5, lanes) * frequency
    block[:, 1, 2] = frequency**2
    moved = expm(block * period[:, None, None])
    state, forced = rng.normal(size=(lanes, 2)) * 10 ** rng.uniform(-1, 1, (lanes, 1)), np.zeros((lanes, 2, MOVES))
    reference = rng.normal(size=lanes) * 10 ** rng.uniform(-1, 1, lanes)
    response, error = np.zeros((lanes, steps, MOVES)), np.zeros((lanes, steps))
    for k in range(steps):
        forced = moved[:, :2, :2] @ forced
        forced[:, :, min(k, MOVES - 1)] += moved[:, :2, 2]
        state = (moved[:, :2, :2] @ state[:, :, None])[:, :, 0]
        response[:, k], error[:, k] = forced[:, 0], state[:, 0] - reference
    amplitude = 10 ** rng.uniform(-0.5, 1, lanes)
    rate, last = amplitude * 10 ** rng.uniform(-1.5, 0, lanes), amplitude * rng.uniform(-1, 1, lanes)
    changes, weight = np.eye(MOVES) - np.eye(MOVES, k=-1), 10 ** rng.uniform(-4, 0, lanes)
    ridge = (10 ** rng.uniform(-6, -2, lanes))[:, None, None] * np.eye(MOVES)
    hessian = response.transpose(0, 2, 1) @ response + weight[:, None, None] * (changes.T @ changes) + ridge
    gradient = (response.transpose(0, 2, 1) @ error[:, :, None])[:, :, 0]
    gradient[:, 0] -= weight * last
    constraints = np.broadcast_to(np.vstack([np.eye(MOVES), changes]), (lanes, 2 * MOVES, MOVES))
    high = np.repeat(np.stack([amplitude, rate], 1), MOVES, axis=1)
    low = -high
    low[:, MOVES], high[:, MOVES] = low[:, MOVES] + last, high[:, MOVES] + last
    if not two_sided:
        constraints, high = np.concatenate([constraints, -constraints], 1), np.concatenate([high, -low], 1)
        low = np.full_like(high, -np.inf)
    return Programmes(hessian, gradient, constraints, low, high)


def dense(rng: np.random.Generator, lanes: int, variables: int, rows: int, *, condition: float = 1e2) -> Programmes:
    """Return programmes without structure, feasible at a random point, of up to the given condition of H."""
    orthogonal = np.linalg.qr(rng.normal(size=(lanes, variables, variables)))[0]
    spread = condition ** rng.uniform(0, 1, (lanes, variables))
    hessian = np.einsum("lij,lj,lkj->lik", orthogonal, spread, orthogonal)
    hessian = 0.5 * (hessian + hessian.transpose(0, 2, 1)) * 10 ** rng.uniform(-3, 3, (lanes, 1, 1))
    inside = rng.normal(size=(lanes, variables))
    wanted = inside + rng.normal(size=(lanes, variables)) * 10 ** rng.uniform(-2, 2, (lanes, 1))
    gradient = -np.einsum("lij,lj->li", hessian, wanted)
    constraints = rng.normal(size=(lanes, rows, variables))
    value = np.einsum("lij,lj->li", constraints, inside)
    room = 10 ** rng.uniform(-2, 1, (lanes, 1))
    low = value - room * rng.exponential(size=(lanes, rows))
    return Programmes(hessian, gradient, constraints, low, value + room * rng.exponential(size=(lanes, rows)))


def scaled(programmes: Programmes, factors: Floats) -> Programmes:
    """Return the same programmes with every row, shape (lanes, rows), multiplied by a factor that is not 0."""
    ends = programmes.low * factors, programmes.high * factors
    rows = programmes.constraints * factors[:, :, None]
    return replace(programmes, constraints=rows, low=np.minimum(*ends), high=np.maximum(*ends))


def badly_scaled(rng: np.random.Generator, lanes: int) -> Programmes:
    """Return programmes whose rows differ in length by up to 1e6."""
    return scaled(dense(rng, lanes, 5, 20), 10 ** rng.uniform(-3, 3, (lanes, 20)))


def redundant(rng: np.random.Generator, lanes: int, *, apart: float = 0.0) -> Programmes:
    """Return programmes each of whose rows is there twice: as it is, and as a multiple turned by about `apart`."""
    once, factors = dense(rng, lanes, 5, 20), np.ones((lanes, 20))
    constraints, low, high = once.constraints.copy(), once.low.copy(), once.high.copy()
    constraints[:, 10:], low[:, 10:], high[:, 10:] = constraints[:, :10], low[:, :10], high[:, :10]
    constraints += apart * rng.normal(size=constraints.shape)
    factors[:, 10:] = 10 ** rng.uniform(-3, 3, (lanes, 10)) * rng.choice([-1.0, 1.0], (lanes, 10))
    return scaled(replace(once, constraints=constraints, low=low, high=high), factors)


def parallel(rng: np.random.Generator, lanes: int) -> Programmes:
    """Return programmes of 5 slabs with 4 rows each, equal or opposite to the last bit in terms of y.

    Half the rows lack a limit, and in every third programme the limits of different rows make slabs of no thickness.
    """
    once = dense(rng, lanes, 5, 20)
    source, factors = np.arange(20) % 5, 2.0 ** rng.integers(-3, 4, (lanes, 20)) * rng.choice([-1.0, 1.0], (lanes, 20))
    inside = 0.5 * (once.low + once.high)[:, source]
    low, high = np.minimum(once.low, inside), np.maximum(once.high, inside)
    thin = (np.arange(lanes) % 3 == 0)[:, None]
    low, high = np.where(thin & (np.arange(20) < 5), inside, low), np.where(thin & (np.arange(20) >= 15), inside, high)
    lacks = rng.random((lanes, 20))
    keep = thin & ((np.arange(20) < 5) | (np.arange(20) >= 15))
    low, high = np.where((lacks < 0.25) & ~keep, -np.inf, low), np.where((lacks > 0.75) & ~keep, np.inf, high)
    return scaled(replace(once, constraints=once.constraints[:, source], low=low, high=high), factors)


def vertices(rng: np.random.Generator, lanes: int) -> Programmes:
    """Return programmes of whole numbers, all of whose 20 limits in 5 variables meet in one point or are next to it."""
    constraints = rng.integers(-1, 2, (lanes, 20, 5)).astype(float)
    meeting = np.einsum("lij,lj->li", constraints, rng.integers(-2, 3, (lanes, 5)).astype(float))
    low, high = meeting - rng.integers(0, 3, meeting.shape), meeting + rng.integers(0, 2, meeting.shape)
    whole = dense(rng, lanes, 5, 20)
    hessian = np.where((np.arange(lanes) % 2 == 0)[:, None, None], np.eye(5), whole.hessian)
    return replace(
        whole, hessian=hessian, constraints=constraints, low=np.where(low < meeting, -np.inf, low), high=high
    )


def equalities(rng: np.random.Generator, lanes: int, *, equal: int = 3, room: float = 0.0) -> Programmes:
    """Return programmes in which some rows have both limits equal, or `room` apart; more than 5 of them agree."""
    free = dense(rng, lanes, 5, 20)
    value = np.einsum("lij,lj->li", free.constraints, rng.normal(size=(lanes, 5)))
    low, high = np.minimum(free.low, value), np.maximum(free.high, value)
    low[:, :equal], high[:, :equal] = value[:, :equal] - room, value[:, :equal] + room
    return replace(free, low=low, high=high)


def wedges(rng: np.random.Generator, lanes: int) -> Programmes:
    """Return programmes whose solutions lie far out, where wedges of nearly parallel rows end."""
    free = dense(rng, lanes, 5, 20)
    angle = 10 ** rng.uniform(-7, -4, (lanes, 1, 1))
    constraints = free.constraints.copy()
    constraints[:, 10:] = constraints[:, :10] + angle * rng.normal(size=(lanes, 10, 5))
    ends = 10 ** rng.uniform(3, 6, (lanes, 1)) * rng.normal(size=(lanes, 5))
    value = np.einsum("lij,lj->li", constraints, ends)
    low, high = np.full_like(value, -np.inf), np.full_like(value, np.inf)
    high[:, :3], low[:, 10:13] = value[:, :3], value[:, 10:13]
    return replace(free, constraints=constraints, low=low, high=high)


def partly_unlimited(rng: np.random.Generator, lanes: int) -> Programmes:
    """Return programmes some of whose rows are zeros, or lack one or both limits."""
    full = dense(rng, lanes, 5, 20)
    constraints, low, high = full.constraints.copy(), full.low.copy(), full.high.copy()
    zero = rng.random(low.shape) < 0.1
    constraints[zero], low[zero], high[zero] = 0.0, np.minimum(low[zero], 0.0), np.maximum(high[zero], 0.0)
    low[rng.random(low.shape) < 0.4], high[rng.random(low.shape) < 0.4] = -np.inf, np.inf
    return replace(full, constraints=constraints, low=low, high=high)


FEASIBLE: dict[str, Callable[[np.random.Generator, int], Programmes]] = {
    "predictive control, 10 two-sided rows": lambda rng, lanes: mpc(rng, lanes, two_sided=True),
    "predictive control, 20 one-sided rows": lambda rng, lanes: mpc(rng, lanes, two_sided=False),
    "dense": lambda rng, lanes: dense(rng, lanes, 5, 20),
    "few variables, many rows": lambda rng, lanes: dense(rng, lanes, 2, 20),
    "condition 1e8": lambda rng, lanes: dense(rng, lanes, 5, 20, condition=1e8),
    "badly scaled rows": badly_scaled,
    "rows twice": redundant,
    "parallel rows": parallel,
    "rows nearly twice": lambda rng, lanes: redundant(rng, lanes, apart=1e-7),
    "vertices": vertices,
    "equal limits": equalities,
    "more equal limits than variables": lambda rng, lanes: equalities(rng, lanes, equal=10),
    "nearly equal limits": lambda rng, lanes: equalities(rng, lanes, equal=10, room=1e-9),
    "far ends of wedges": wedges,
    "zero rows and missing limits": partly_unlimited,
}
"""Families of programmes that have a solution, for records of 5 variables and 20 rows."""
