"""Dead time in whole steps, against a plain list of the past."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.numerics.dead_time import MOST_STEPS, DeadTime, delayed, start_dead_time
from tests.conftest import OTHER_LIVES


@pytest.mark.parametrize("life", ["compiled", *OTHER_LIVES])
@pytest.mark.parametrize("steps", [0, 1, 7, MOST_STEPS])
def test_gives_back_the_value_of_so_many_steps_before(steps: int, life: str) -> None:
    memory = DeadTime.zeros()
    start_dead_time.run(memory, -1.0, life=life)  # pyright: ignore
    values = np.random.default_rng(1).normal(size=600)
    past = [-1.0] * steps + values.tolist()
    for k, value in enumerate(values):
        assert delayed.run(memory, value, steps * 0.002, 0.002, life=life)[0] == past[k]  # pyright: ignore


def test_is_rounded_to_whole_steps_and_ends_at_the_longest() -> None:
    for delay, steps in ((0.0029, 1), (0.0031, 2), (5.0, MOST_STEPS), (np.nan, 0)):
        memory = DeadTime.zeros()
        start_dead_time.run(memory, 0.0)
        seen = [delayed.run(memory, 1.0, delay, 0.002)[0] for _ in range(MOST_STEPS + 2)]
        assert seen.index(1.0) == steps
