"""The controller `ddpc` with the particle swarm of [1] in place of the exact solution of its programme.

A swarm of 30 moves for 50 generations towards the best that each and all have found; the inertia falls from 0.9 to 0.4,
and what leaves the limits of the clutch torque and of its rate is put back onto them. The paper calls its swarm
improved without saying how; this is the usual form. It is here to be compared: it costs hundreds of times as much.

The random numbers are those of an additive lagged Fibonacci generator with lags 5 and 17, restarted in each step: sums
of fractions with 20 bits, exact in every life.

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014
"""

from __future__ import annotations

from dataclasses import replace

from bitepoint.controllers import ddpc
from bitepoint.controllers.ddpc import (
    MOVES,
    DdpcParameters,
    DdpcState,
    Qp4x12Data,
    Qp4x12Solution,
)
from bitepoint.kernels import Kernel, clamp, kernel
from bitepoint.numerics.qp_records import SOLVED
from bitepoint.records import FloatArray, Record, count, nested, quantity

PARTICLES = 30
GENERATIONS = 50
INERTIA_FIRST, INERTIA_LAST = 0.9, 0.4
ATTRACTION = 1.5
"""Pull towards the best of a particle, and towards the best of all."""

PENALTY = 1e3
"""Weight of the square by which a row is violated that cannot be repaired move by move."""

LAG = 17
_ANY = 1e12


class Swarm(Record):
    """The swarm, and its random numbers."""

    turn: int = count(0, LAG - 1, "place of the next random number")
    random: FloatArray = quantity("1", 0, 1, "the last random numbers", shape=(LAG,))
    place: FloatArray = quantity("N*m", -_ANY, _ANY, "moves of each particle", shape=(PARTICLES, MOVES))
    velocity: FloatArray = quantity("N*m", -_ANY, _ANY, "their change per generation", shape=(PARTICLES, MOVES))
    best: FloatArray = quantity("N*m", -_ANY, _ANY, "best moves of each so far", shape=(PARTICLES, MOVES))
    best_cost: FloatArray = quantity("1", -_ANY, _ANY, "their cost", shape=(PARTICLES,))
    leader: int = count(0, PARTICLES - 1, "the particle whose best is the best of all")


class DdpcPsoWork(Record):
    """The programme of a step, and the swarm that solves it."""

    safest: FloatArray = quantity("N*m", -1e6, 0, "moves that open the clutch as fast as it can", shape=(MOVES,))
    data: Qp4x12Data = nested(Qp4x12Data, "the programme of this step")
    solution: Qp4x12Solution = nested(Qp4x12Solution, "the result")
    swarm: Swarm = nested(Swarm, "the swarm")


@kernel
def uniform(w: Swarm) -> float:
    """Return a random number in 0..1."""
    w.turn = LAG - 1 if w.turn == 0 else max(w.turn - 1, 0)
    ahead = w.turn + 5
    other = min(max(ahead - LAG if ahead >= LAG else ahead, 0), LAG - 1)
    total = w.random[w.turn] + w.random[other]
    w.random[w.turn] = total - 1.0 if total >= 1.0 else total
    return w.random[w.turn]


@kernel
def seed_random(w: Swarm) -> None:
    """Start the random numbers; some hundred are thrown away, since the first ones still show the seed."""
    w.turn = 0
    value = 0.0
    for n in range(LAG):
        value = value + 648_055.0 / 1_048_576.0  # near the golden section, in 20 bits
        value = value - 1.0 if value >= 1.0 else value
        w.random[n] = value
    for _n in range(200):
        value = uniform(w)


@kernel
def swarm_repair(p: DdpcParameters, d: Qp4x12Data, w: Swarm, n: int) -> None:
    """Put the moves of particle n onto the limits of the clutch torque and of its rate that they leave."""
    particle = min(max(n, 0), PARTICLES - 1)
    total = 0.0
    for j in range(MOVES):
        move = clamp(w.place[particle, j], d.low[j], d.high[j])
        move = clamp(move, d.low[MOVES + j] - total, d.high[MOVES + j] - total)
        w.place[particle, j] = move
        total += move


@kernel
def swarm_cost(p: DdpcParameters, d: Qp4x12Data, w: Swarm, n: int) -> float:
    """Return the cost of the moves of particle n: that of the programme, and the penalty of engine-speed rows."""
    particle = min(max(n, 0), PARTICLES - 1)
    cost = 0.0
    for i in range(MOVES):
        part = 0.0
        speed = 0.0
        for j in range(MOVES):
            part += p.matrices.hessian[i, j] * w.place[particle, j]
            speed += p.matrices.constraints[2 * MOVES + i, j] * w.place[particle, j]
        beyond = speed - clamp(speed, d.low[2 * MOVES + i], d.high[2 * MOVES + i])
        cost += w.place[particle, i] * (0.5 * part + d.gradient[i]) + PENALTY * beyond**2
    return cost


@kernel
def swarm_begin(p: DdpcParameters, d: Qp4x12Data, w: Swarm) -> None:
    """Spread the swarm over the moves that the rate allows; the first particle stays where it is."""
    seed_random(w)
    w.leader = 0
    for n in range(PARTICLES):
        for j in range(MOVES):
            span = d.high[j] - d.low[j]
            where = uniform(w)
            heading = uniform(w)
            w.place[n, j] = d.low[j] + span * where if n > 0 else 0.0
            w.velocity[n, j] = 0.1 * span * (heading - 0.5)
        swarm_repair(p, d, w, n)
        w.best_cost[n] = swarm_cost(p, d, w, n)
        for j in range(MOVES):
            w.best[n, j] = w.place[n, j]
        if w.best_cost[n] < w.best_cost[w.leader]:
            w.leader = n


@kernel
def swarm_move(p: DdpcParameters, d: Qp4x12Data, w: Swarm, inertia: float) -> None:
    """Move every particle by one generation."""
    for n in range(PARTICLES):
        for j in range(MOVES):
            own = uniform(w)
            common = uniform(w)
            to_own = own * (w.best[n, j] - w.place[n, j])
            to_common = common * (w.best[w.leader, j] - w.place[n, j])
            w.velocity[n, j] = inertia * w.velocity[n, j] + ATTRACTION * (to_own + to_common)
            w.place[n, j] = w.place[n, j] + w.velocity[n, j]
        swarm_repair(p, d, w, n)
        cost = swarm_cost(p, d, w, n)
        if cost < w.best_cost[n]:
            w.best_cost[n] = cost
            for j in range(MOVES):
                w.best[n, j] = w.place[n, j]
            if cost < w.best_cost[w.leader]:
                w.leader = n


@kernel
def first_move(p: DdpcParameters, s: DdpcState, w: DdpcPsoWork) -> int:
    """Let the swarm search; the first of its moves, N m, is `w.solution.x[0]`. Return SOLVED: it always has one."""
    swarm_begin(p, w.data, w.swarm)
    for generation in range(GENERATIONS):
        inertia = INERTIA_FIRST - (INERTIA_FIRST - INERTIA_LAST) * (float(generation) / (GENERATIONS - 1.0))
        swarm_move(p, w.data, w.swarm, inertia)
    for j in range(MOVES):
        w.solution.x[j] = w.swarm.best[w.swarm.leader, j]
    return SOLVED


def _swarmed(name: str, kernels: dict[str, object]) -> Kernel[..., object]:
    source = getattr(ddpc, name)
    return source.specialise(f"pso_{name}", {"DdpcWork": DdpcPsoWork, **kernels})


_state_programme = _swarmed("state_programme", {})
_slipping_torque = _swarmed("slipping_torque", {"state_programme": _state_programme, "first_move": first_move})
init = _swarmed("init", {})
step = _swarmed("step", {"slipping_torque": _slipping_torque})

CONTROLLER = replace(
    ddpc.CONTROLLER,
    name="ddpc_pso",
    meaning="the same as ddpc with a particle swarm for a solver, to be compared with it",
    init=init,
    step=step,
    work=DdpcPsoWork,
    desktop=True,
)
