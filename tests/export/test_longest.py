"""The longest step: found where it can be known, kept in the vectors, and not counted where it is too long."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bitepoint.assembly import assemble
from bitepoint.export.c import coverage, toolchain, vectors
from bitepoint.export.c.driving import Sequence
from bitepoint.export.c.longest import BlockCounter, drawn, full, longest
from bitepoint.export.c.package import lay_down
from bitepoint.export.c.sources import Sources
from bitepoint.kernels import kernel, to_index
from bitepoint.kernels.c99 import FLOAT32
from bitepoint.numerics.tables import lookup, lookup_map
from bitepoint.records import Record, count, quantity
from bitepoint.simulation.system import Part
from tests.conftest import needs_target
from tests.export.test_map import part as fuel_part

MOST = 400
"""Rounds that the loop of the part below can make."""

needs_gcov = pytest.mark.skipif(not coverage.available(), reason="no gcov: install Debian's gcc")


class LoopParameters(Record):
    """How long its rounds take."""

    rounds: int = count(1, 1_000_000, "inner rounds")


class LoopState(Record):
    """Memory."""

    sum: float = quantity("1", -1e9, 1e9, "what the loop adds up")


class LoopInputs(Record):
    """What the loop is as long as: both must be high at once, for a while."""

    first: float = quantity("1", 0, 1, "half of it")
    second: float = quantity("1", 0, 1, "the other half")


class LoopOutputs(Record):
    """What it shows."""

    sum: float = quantity("1", -1e9, 1e9, "what the loop adds up")


@kernel
def init(p: LoopParameters, s: LoopState, u: LoopInputs, y: LoopOutputs) -> None:
    """Begin at nothing."""
    s.sum = 0.0
    y.sum = 0.0


@kernel
def step(p: LoopParameters, s: LoopState, u: LoopInputs, y: LoopOutputs, dt: float) -> int:
    """Add up as many terms as the inputs say."""
    last = to_index(400.0 * min(u.first, u.second), 0, 400)
    s.sum = 0.0
    for n in range(last):
        for k in range(p.rounds):
            s.sum = s.sum * 0.5 + 1.0 / (1.0 + float(n) + float(k))
    y.sum = s.sum
    return 0


def loop(rounds: int = 1) -> Part:
    parameters = LoopParameters.zeros()
    parameters["rounds"] = rounds
    return Part(
        "loop", init, step, parameters, LoopParameters, LoopState, LoopInputs, LoopOutputs, None, 0.01
    )  # fmt: skip


def sources(rounds: int = 1) -> Sources:
    return Sources(loop(rounds), FLOAT32, "a loop", "made up")


def ramp(top: float = 0.5) -> Sequence:
    return Sequence("ramp", loop().parameters, np.linspace([0.0, 0.0], [top, top], 50))


@needs_gcov
def test_blocks_grow_with_the_rounds(tmp_path: Path) -> None:
    counts = BlockCounter(sources(), tmp_path).count(ramp())
    assert counts.shape == (49,)
    assert (np.diff(counts) >= 0).all()
    assert counts[-1] > 10 * counts[0]


@needs_gcov
def test_a_sequence_that_takes_too_long_ends_with_the_step_that_does(tmp_path: Path) -> None:
    counter = BlockCounter(sources(), tmp_path)
    whole = counter.count(ramp())
    most = int(whole[:20].sum())
    assert (counter.count(ramp(), most) == whole[:20]).all()
    assert (counter.count(ramp(), most + 1) == whole[:21]).all()


@needs_gcov
def test_a_random_sequence_is_kept_as_far_as_three_of_the_longest_recorded_ones(tmp_path: Path) -> None:
    slow = replace(ramp(), parameters=loop(1000).parameters)
    quick = ramp(0.002)  # never enters the loop
    chosen = coverage.choose(sources(), [quick], itertools.repeat(slow), tmp_path)
    assert chosen[0] is quick
    assert 0 < len(chosen[1].inputs) < len(slow.inputs)
    assert (chosen[1].inputs == slow.inputs[: len(chosen[1].inputs)]).all()
    assert len(chosen) == 2


@needs_gcov
def test_the_search_ends_with_the_longest_step_and_is_the_same_again(tmp_path: Path) -> None:
    found: list[Sequence] = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        found.append(longest(sources(), drawn(loop(), [ramp()]), tmp_path / name))
    first, second = found
    assert first.inputs.tobytes() == second.inputs.tobytes()
    (tmp_path / "again").mkdir()
    counter = BlockCounter(sources(), tmp_path / "again")
    counts = counter.count(first)
    assert counts.argmax() == len(counts) - 1
    assert counts[-1] >= 0.99 * counter.count(ramp(1.0)).max()  # all rounds


def test_curves_get_all_points_and_stay_the_same() -> None:
    part = assemble("dct-launch", {"controller": "launch_pid"}).system.controllers[0]
    before, after = part.parameters[:1]["calibration"], full(part)["calibration"]
    pedal = np.linspace(-0.1, 1.1, 500)
    for name in ("engine_target", "clutch_torque", "clutch_rate"):
        assert before[name]["points"][0] < after[name]["points"][0] == 32
        values = (lookup.run(calibration[name].copy(), pedal) for calibration in (before, after))
        assert next(values) == pytest.approx(next(values), rel=1e-12)


def test_maps_get_all_points_and_stay_the_same() -> None:
    part = fuel_part(5, 3)
    before, after = part.parameters["fuel"].copy(), full(part)["fuel"].copy()
    assert (after["x_points"][0], after["y_points"][0]) == (16, 16)
    rng = np.random.default_rng(1)
    speed, torque = rng.uniform(0.0, 800.0, 500), rng.uniform(-100.0, 400.0, 500)
    assert lookup_map.run(after, speed, torque) == pytest.approx(lookup_map.run(before, speed, torque), rel=1e-12)


@needs_target
@pytest.mark.parametrize(("rounds", "too_long"), [(1, 0), (3000, 1)])
def test_a_step_that_is_too_long_is_not_counted(rounds: int, too_long: int, tmp_path: Path) -> None:
    chosen = [Sequence("two steps", loop(rounds).parameters, np.array([[0.0, 0.0], [0.002, 1.0], [1.0, 1.0]]))]
    (tmp_path / "work").mkdir()
    lay_down(sources(rounds), chosen, vectors.answers(sources(rounds), chosen), tmp_path / "loop")
    run = toolchain.run_target(sources(rounds), tmp_path / "loop", tmp_path / "work", "cortex-m7")
    assert run is not None
    assert (run.differences, run.steps, run.steps_too_long) == (0, 2, too_long)
    if too_long:
        assert (run.instructions_worst, run.instructions_mean) == (None, None)
    else:
        assert run.instructions_worst is not None
        assert MOST * 5 < run.instructions_worst < MOST * 50


@needs_target
def test_steps_with_random_parameters_are_counted_apart(tmp_path: Path) -> None:
    short, long = ramp(0.1), ramp(1.0)
    chosen = [short, Sequence("random", loop(5).parameters, long.inputs, designed=False)]
    (tmp_path / "work").mkdir()
    lay_down(sources(), chosen, vectors.answers(sources(), chosen), tmp_path / "loop")
    run = toolchain.run_target(sources(), tmp_path / "loop", tmp_path / "work", "cortex-m7")
    assert run is not None
    assert run.instructions_worst is not None
    assert run.instructions_worst_of_random is not None
    assert run.instructions_worst_of_random > 10 * run.instructions_worst
