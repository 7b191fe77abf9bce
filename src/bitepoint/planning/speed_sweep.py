"""Dynamic programming backwards over the stations of a road: the least cost from each speed and gear to the end.

    V_k(q, g) = min over q' and g' of:  drive in g to q' at the next station
                                        shift to g', roll in neutral for the shift time, and drive on in g' to q' at
                                        the first station that leaves room for it

Nodes of a station lie on a grid of its own in v^2. Every step goes from node to node, so no cost is interpolated: what
is found can be driven as it is, and costs what it says. Where a stage is like the one after it (length, grade, nodes),
its costs are kept.

Memory is flat, with G gears (0 is the first here) and W the most nodes of a station:

    road     3 a stage: length (m), grade, lowest acceleration (m/s^2)
    grids    3 a station: lowest v^2, step of v^2 (m^2/s^2), and nodes
    flags    2 a station: 1 where the vehicle stands, 1 where the costs of its stage are those of the one after it;
             then G a stage: 1 where the gear may be driven in
    value, policy    a cost to go of NEVER: there is no way on; (k G + g) W + i
    edge     rows of W: driving in g from node i, row g W + i; driving on in g after a shift, rows G W + g W + i;
             fuel of a shift from gear o to g, from 2 G W W on at (o G + g) W + i
    reach    2 a row: first and last node that can be reached; from 4 G W on, by node: stages of a shift, 0: none
"""

from __future__ import annotations

import math

from bitepoint.kernels import kernel, to_index
from bitepoint.models.longitudinal import driving_force
from bitepoint.numerics.tables import highest
from bitepoint.parts.amt import gear_ratio
from bitepoint.planning.speed_stage import (
    NEVER,
    SpeedTask,
    Stage,
    coast_end,
    coast_length,
    drive_stage,
    launch_square,
    shift_fuel,
)
from bitepoint.records import FloatArray, IntArray, Record, count, quantity

ROOM = 0.25
"""Least share of a stage that is left to drive on after a shift."""

NEAR = 1e-6
"""Part of a step of the grid by which a node may lie beyond the limits of the acceleration."""


class Sweep(Record):
    """Sizes of a sweep, and the row of steps at hand: from one v^2 to the nodes of a station."""

    stations: int = count(2, 100_000, "stations")
    gears: int = count(1, 8, "gears")
    width: int = count(1, 100_000, "most nodes of a station")
    before: float = quantity("m^2/s^2", 0, 1e5, "v^2 at the start of the row")
    length: float = quantity("m", 0, 1e5, "distance to the station")
    least: float = quantity("m/s^2", -100, 100, "lowest acceleration")
    extra: float = quantity("kg", 0, 1e3, "added to every cost of the row")
    cost: float = quantity("kg", 0, 1e9, "cost of the best step of the row, and of all after it")
    node: int = count(0, 100_000, "node that it leads to")


@kernel
def highest_acceleration(t: SpeedTask, gear: int, locked: int) -> float:
    """Return an acceleration, m/s^2, that the vehicle stays below in a gear, whatever its speed."""
    lever = gear_ratio(t.model.gearbox, gear) / t.model.vehicle.wheel_radius
    efficiency = t.model.gearbox.efficiency
    rest = driving_force(t.model, t.road, 0.0, 0.0)
    mass = driving_force(t.model, t.road, 0.0, 1.0) - rest
    if locked > 0:
        mass = mass + t.model.engine.inertia * lever * lever * efficiency
    return min((highest(t.model.engine.full_load) * lever * efficiency - rest) / mass, t.acceleration_limit)


@kernel(trusted=True)
def fill_row(
    p: Sweep, t: SpeedTask, s: Stage, row: int, gear: int, grids: FloatArray, to: int, edge: FloatArray, reach: IntArray
) -> None:
    """Fill the costs, kg, of driving in a gear from p.before over p.length to the nodes of station `to`."""
    base, step, nodes = grids[3 * to], grids[3 * to + 1], int(grids[3 * to + 2])
    low = p.before + 2.0 * p.least * p.length - base
    locked = 1 if p.before >= launch_square(t, gear) else 0
    high = p.before + 2.0 * highest_acceleration(t, gear, locked) * p.length - base
    first, last = 0, nodes - 1
    if step > 0.0:
        first = to_index(low / step - NEAR + 1.0, 0, nodes)
        last = to_index(high / step + NEAR + 1.0, 0, nodes) - 1
    elif low > NEAR or high < -NEAR:
        last = -1
    end = first - 1
    for j in range(first, last + 1):
        fuel = drive_stage(t, gear, p.before, base + step * j, p.length, s)
        edge[row * p.width + j] = fuel + t.time_price * s.time + p.extra
        if fuel < NEVER:
            end = j
        elif end < first:
            first = j + 1
    reach[2 * row] = first
    reach[2 * row + 1] = end


@kernel(trusted=True)
def landing(p: Sweep, k: int, rolled: float, road: FloatArray, flags: IntArray) -> int:
    """Return the station to which a vehicle drives on that has rolled so far (m) from station k; k: there is none."""
    found = k
    gone = 0.0
    for m in range(k + 1, p.stations):
        gone = gone + road[3 * (m - 1)]
        if gone - rolled >= ROOM * road[3 * (m - 1)]:
            found = m
            p.length = gone - rolled
        if found > k or flags[2 * m] > 0:
            break
    return found


@kernel(trusted=True)
def fill_shift(
    p: Sweep,
    t: SpeedTask,
    s: Stage,
    k: int,
    i: int,
    road: FloatArray,
    grids: FloatArray,
    flags: IntArray,
    edge: FloatArray,
    reach: IntArray,
) -> None:
    """Fill the costs of all shifts from node i of station k."""
    rows = p.gears * p.width
    before = grids[3 * k] + grids[3 * k + 1] * i
    t.road.grade = road[3 * k + 1]
    rolled = coast_length(t, before)
    m = landing(p, k, rolled, road, flags) if rolled >= 0.0 else k
    reach[4 * rows + i] = m - k
    v = math.sqrt(before)
    p.before = coast_end(t, v) ** 2
    p.least = road[3 * max(m - 1, 0) + 2]
    p.extra = t.shift_price + t.time_price * t.shift_time
    t.road.grade = road[3 * max(m - 1, 0) + 1]
    for g in range(p.gears):
        row = rows + g * p.width + i
        reach[2 * row], reach[2 * row + 1] = 0, -1
        if m > k and flags[2 * p.stations + (m - 1) * p.gears + g] > 0:
            fill_row(p, t, s, row, g + 1, grids, m, edge, reach)
        if reach[2 * row + 1] >= reach[2 * row]:
            for old in range(p.gears):
                edge[2 * rows * p.width + (old * p.gears + g) * p.width + i] = shift_fuel(t, old + 1, g + 1, v)


@kernel(trusted=True)
def fill_stage(
    p: Sweep,
    t: SpeedTask,
    s: Stage,
    k: int,
    road: FloatArray,
    grids: FloatArray,
    flags: IntArray,
    edge: FloatArray,
    reach: IntArray,
) -> None:
    """Fill the costs of all steps from station k."""
    for i in range(int(grids[3 * k + 2])):
        t.road.grade = road[3 * k + 1]
        for g in range(p.gears):
            row = g * p.width + i
            reach[2 * row], reach[2 * row + 1] = 0, -1
            p.before = grids[3 * k] + grids[3 * k + 1] * i
            p.length, p.least, p.extra = road[3 * k], road[3 * k + 2], 0.0
            if flags[2 * p.stations + k * p.gears + g] > 0:
                fill_row(p, t, s, row, g + 1, grids, k + 1, edge, reach)
        fill_shift(p, t, s, k, i, road, grids, flags, edge, reach)


@kernel(trusted=True)
def best_node(p: Sweep, row: int, edge: FloatArray, reach: IntArray, value: FloatArray, at: int) -> None:
    """Find the cheapest step of a row; its nodes cost value[at + node] from there on."""
    p.cost = NEVER
    p.node = 0
    for j in range(reach[2 * row], reach[2 * row + 1] + 1):
        cost = edge[row * p.width + j] + value[at + j]
        if cost < p.cost:
            p.cost = cost
            p.node = j


@kernel(trusted=True)
def choose(
    p: Sweep,
    k: int,
    i: int,
    road: FloatArray,
    edge: FloatArray,
    reach: IntArray,
    value: FloatArray,
    policy: IntArray,
) -> None:
    """Find the best from node i of station k in every gear; where the vehicle has to gain speed, it only shifts up.

    A step with a shift to g over n stages counts ((2 G + 1) n + g + 1) W more.
    """
    rows = p.gears * p.width
    for g in range(p.gears):
        at = (k * p.gears + g) * p.width + i
        best_node(p, g * p.width + i, edge, reach, value, ((k + 1) * p.gears + g) * p.width)
        value[at] = p.cost
        policy[at] = p.node
    m = k + reach[4 * rows + i]
    for g in range(p.gears if m > k else 0):
        best_node(p, rows + g * p.width + i, edge, reach, value, (m * p.gears + g) * p.width)
        for old in range(p.gears if p.cost < NEVER else 0):
            at = (k * p.gears + old) * p.width + i
            cost = p.cost + edge[2 * rows * p.width + (old * p.gears + g) * p.width + i]
            if cost < value[at] and (g > old or (g < old and road[3 * k + 2] <= 0.0)):
                value[at] = cost
                policy[at] = p.node + ((2 * p.gears + 1) * (m - k) + g + 1) * p.width


@kernel(trusted=True)
def change_at_rest(p: Sweep, k: int, value: FloatArray, policy: IntArray) -> None:
    """Let a vehicle that stands at station k go on in any gear: such a step to gear g counts (G + 1 + g) W more."""
    best = 0
    for g in range(1, p.gears):
        if value[(k * p.gears + g) * p.width] < value[(k * p.gears + best) * p.width]:
            best = g
    for g in range(p.gears):
        at = (k * p.gears + g) * p.width
        if g != best:
            value[at] = value[(k * p.gears + best) * p.width]
            policy[at] = (p.gears + 1 + best) * p.width


@kernel(trusted=True)
def sweep(
    p: Sweep,
    t: SpeedTask,
    s: Stage,
    road: FloatArray,
    grids: FloatArray,
    flags: IntArray,
    edge: FloatArray,
    reach: IntArray,
    value: FloatArray,
    policy: IntArray,
) -> None:
    """Fill value (kg) and policy of all stations but the last, whose value is given; see the head of this file."""
    for back in range(p.stations - 1):
        k = p.stations - 2 - back
        if flags[2 * k + 1] == 0:
            fill_stage(p, t, s, k, road, grids, flags, edge, reach)
        for i in range(int(grids[3 * k + 2])):
            choose(p, k, i, road, edge, reach, value, policy)
        if flags[2 * k] > 0:
            change_at_rest(p, k, value, policy)
