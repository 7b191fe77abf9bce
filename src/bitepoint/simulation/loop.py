"""The loop itself, one kernel: every tick of every part of one lane, until a stop rule holds.

It knows parts only as entries (see `kernels`) and signals only as places in one vector of floats, so any plant meets
any controller without a new compile, and in any life: an entry may be compiled, interpreted, or another library's C.
"""

from __future__ import annotations

from bitepoint.kernels import invoke, is_finite, kernel
from bitepoint.records import FloatArray, IntArray, Record, RecordElements, count, nested, quantity

RUNNING = -1
TIMED_OUT = -2
NOT_FINITE = -3
FAULT = -4

MOST_BLOCKS = 8
MOST_WIRES = 64
MOST_RULES = 16


class Block(Record):
    """A part: what to call, how often, and where its arguments and outputs lie."""

    init: int = count(0, 1 << 62, "address of the entry of its init kernel")
    step: int = count(0, 1 << 62, "address of the entry of its step kernel")
    every: int = count(1, 1_000_000, "ticks between two steps")
    init_arguments: int = count(0, 1000, "first argument address of init, in the lane's row of addresses")
    step_arguments: int = count(0, 1000, "first argument address of step; the status is the last")
    first_output: int = count(0, 100_000, "place of its first output in the vector of signals")
    outputs: int = count(0, 1000, "number of outputs")


class Wire(Record):
    """A connection from one signal to another, brought up to date when its reader is about to step."""

    source: int = count(0, 100_000, "place of the signal that is read")
    target: int = count(0, 100_000, "place of the signal that is written")
    block: int = count(0, 8, "the reader")
    delay: int = count(0, 1_000_000, "dead time, ticks")
    buffer: int = count(0, 1 << 40, "first of its places in the delay buffer")
    noise: int = count(-1, 64, "its column of the noise; -1 for none")
    sigma: float = quantity("1", 0, 1e9, "standard deviation of the noise, in the signal's unit")
    memory: float = quantity("1", 0, 1, "share of the old value that a first-order lag keeps per step; 0 for no lag")


class Rule(Record):
    """Stop when a signal has been beyond a limit for some time."""

    signal: int = count(0, 100_000, "place of the signal")
    hold: int = count(0, 1_000_000_000, "ticks that it must last")
    direction: float = quantity("1", -1, 1, "1: beyond means above; -1: below")
    limit: float = quantity("1", -1e12, 1e12, "the limit, in the signal's unit")


class LoopPlan(Record):
    """What all lanes share."""

    ticks: int = count(1, 1_000_000_000, "ticks until the run times out")
    blocks: int = count(1, 8, "parts in use; the plant is the last")
    wires: int = count(0, 64, "wires in use")
    rules: int = count(0, 16, "stop rules in use")
    profiles: int = count(0, 1000, "signals that the scenario gives: the first of the vector")
    noisy: int = count(0, 64, "wires with noise")
    rows: int = count(0, 1_000_000_000, "rows that the recording has room for")
    channels: int = count(0, 1000, "signals that are recorded")
    block: RecordElements[Block] = nested(Block, "the parts", shape=(MOST_BLOCKS,))
    wire: RecordElements[Wire] = nested(Wire, "the wires", shape=(MOST_WIRES,))
    rule: RecordElements[Rule] = nested(Rule, "the stop rules", shape=(MOST_RULES,))


class Outcome(Record):
    """How a lane ended."""

    status: int = count(-10, 16, "number of the rule that stopped it, or a negative one of this module")
    block: int = count(-1, 8, "part that failed, or -1")
    ticks: int = count(0, 1_000_000_000, "ticks that were run")
    rows: int = count(0, 1_000_000_000, "rows that were recorded")


@kernel(trusted=True)
def start_lane(
    plan: LoopPlan, addresses: int, steps: int, profiles: FloatArray, signals: FloatArray, buffers: FloatArray
) -> None:
    """Initialise the parts, the plant first, and fill the delays with what the signals then are."""
    for n in range(plan.profiles):
        signals[n] = profiles[n]
    for turn in range(plan.blocks):
        b = plan.blocks - 1 if turn == 0 else turn - 1
        if turn > 0:  # the plant's init writes its own inputs; the others see what it shows
            for n in range(plan.wires):
                if plan.wire[n].block == b:
                    signals[plan.wire[n].target] = signals[plan.wire[n].source]
        invoke(plan.block[b].init, addresses + 8 * plan.block[b].init_arguments, steps, 1)
    for n in range(plan.wires):
        for m in range(plan.wire[n].delay):
            buffers[plan.wire[n].buffer + m] = signals[plan.wire[n].source]


@kernel(trusted=True)
def read_wires(plan: LoopPlan, b: int, tick: int, signals: FloatArray, buffers: FloatArray, noise: FloatArray) -> None:
    """Bring the inputs of block b up to date: dead time, then noise, then lag."""
    turn = tick // plan.block[b].every
    for n in range(plan.wires):
        if plan.wire[n].block == b:
            value = signals[plan.wire[n].source]
            if plan.wire[n].delay > 0:
                value = buffers[plan.wire[n].buffer + tick % plan.wire[n].delay]
            if plan.wire[n].noise >= 0:
                value = value + plan.wire[n].sigma * noise[turn * plan.noisy + plan.wire[n].noise]
            if plan.wire[n].memory > 0.0:
                value = value + plan.wire[n].memory * (signals[plan.wire[n].target] - value)
            signals[plan.wire[n].target] = value


@kernel(trusted=True)
def fill_delays(plan: LoopPlan, tick: int, signals: FloatArray, buffers: FloatArray) -> None:
    """Keep the signals of this tick for the tick after the dead time."""
    for n in range(plan.wires):
        if plan.wire[n].delay > 0:
            buffers[plan.wire[n].buffer + tick % plan.wire[n].delay] = signals[plan.wire[n].source]


@kernel(trusted=True)
def step_block(
    plan: LoopPlan, b: int, addresses: int, steps: int, signals: FloatArray, statuses: IntArray, outcome: Outcome
) -> None:
    """Step block b; note where it fails, or shows what is no number."""
    invoke(plan.block[b].step, addresses + 8 * plan.block[b].step_arguments, steps, 1)
    total = 0.0
    for n in range(plan.block[b].outputs):
        total += abs(signals[plan.block[b].first_output + n])
    if not is_finite(total):
        outcome.status = NOT_FINITE
        outcome.block = b
    elif statuses[b] != 0:
        outcome.status = FAULT
        outcome.block = b


@kernel(trusted=True)
def broken_rule(plan: LoopPlan, signals: FloatArray, held: IntArray) -> int:
    """Return the first rule that has held long enough, or RUNNING; count the ticks of each."""
    found = RUNNING
    for n in range(plan.rules):
        beyond = (signals[plan.rule[n].signal] - plan.rule[n].limit) * plan.rule[n].direction
        held[n] = held[n] + 1 if beyond > 0.0 else 0
        if held[n] > plan.rule[n].hold and found == RUNNING:
            found = n
    return found


@kernel(trusted=True)
def record_row(
    plan: LoopPlan, signals: FloatArray, channels: IntArray, recording: FloatArray, outcome: Outcome
) -> None:
    """Append the recorded signals to the recording: one row of memory per channel."""
    for n in range(plan.channels):
        recording[n * plan.rows + outcome.rows] = signals[channels[n]]
    outcome.rows += 1


@kernel(trusted=True)
def run_lane(
    plan: LoopPlan,
    addresses: int,
    steps: int,
    profiles: FloatArray,
    noise: FloatArray,
    signals: FloatArray,
    buffers: FloatArray,
    statuses: IntArray,
    held: IntArray,
    channels: IntArray,
    recording: FloatArray,
    outcome: Outcome,
) -> None:
    """Run one lane. A tick is: profiles, controllers, recording, stop rules, plant.

    Args:
        addresses: address of the lane's row of argument addresses; `steps` of as many zeros.
        profiles: (ticks + 1) x profiles, row by row; noise: steps of the reader x noisy wires, standard normal.
        signals, buffers, statuses, held: memory of the run; what is in it does not matter.
        channels: places of the recorded signals; recording: channels x rows.
    """
    outcome.status = RUNNING
    outcome.block = -1
    outcome.rows = 0
    outcome.ticks = 0
    for n in range(plan.rules):
        held[n] = 0
    start_lane(plan, addresses, steps, profiles, signals, buffers)
    last = plan.blocks - 1
    for tick in range(plan.ticks + 1):
        for n in range(plan.profiles):
            signals[n] = profiles[tick * plan.profiles + n]
        for b in range(last):
            if tick % plan.block[b].every == 0 and outcome.status == RUNNING:
                read_wires(plan, b, tick, signals, buffers, noise)
                step_block(plan, b, addresses, steps, signals, statuses, outcome)
        if outcome.rows < plan.rows:
            record_row(plan, signals, channels, recording, outcome)
        if outcome.status == RUNNING:
            outcome.status = broken_rule(plan, signals, held)
        if outcome.status == RUNNING and tick == plan.ticks:
            outcome.status = TIMED_OUT
        if outcome.status != RUNNING:
            break
        read_wires(plan, last, tick, signals, buffers, noise)
        fill_delays(plan, tick, signals, buffers)
        step_block(plan, last, addresses, steps, signals, statuses, outcome)
        outcome.ticks = tick + 1
