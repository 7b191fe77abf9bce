"""Observer of the engine torque: lag and error of a simulated engine, noise, bad input, lives."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.assembly import assemble
from bitepoint.estimation.engine_torque import (
    EngineObserverState,
    design_engine_observer,
    engine_observer_reset,
    engine_observer_step,
)
from bitepoint.kernels import Life
from bitepoint.models.launch import LaunchModel
from tests.conftest import OTHER_LIVES

PERIOD = 0.01


def watched(lag: float, error: float, noise: float = 0.0, life: Life = "compiled") -> np.ndarray:
    """The state of the observer beside an engine whose command rises, falls and rises again; (steps,)."""
    model = LaunchModel.of(assemble("dct-launch", {}).system.plant.parameters)
    observer, state = design_engine_observer(model, PERIOD), EngineObserverState.zeros()
    engine_observer_reset.run(state, 2.0, 100.0, life=life)
    rng = np.random.default_rng(5)
    torque, speed, clutch = 2.0, 100.0, 0.0
    seen = []
    for k in range(150):
        command = 2.0 + 100.0 * np.interp(k, [0, 30, 60, 100, 150], [0, 0.8, 0.3, 1.0, 1.0])
        clutch = command - 5.0 * np.sin(0.1 * k)
        for _ in range(20):  # the engine, finely
            torque += (command - torque) * (1.0 - np.exp(-PERIOD / 20 / lag)) if lag > 0.0 else command - torque
            net = torque + error - clutch - model.engine_friction * speed
            speed += PERIOD / 20 * net / model.engine_inertia
        engine_observer_step.run(observer, state, command, clutch, speed + noise * rng.normal(), life=life)
        seen.append(state.copy())
    return np.concatenate(seen)


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("lag", [0.0, 0.05, 0.1, 0.15])
def test_lag_is_found(lag: float, noise: float) -> None:
    assert watched(lag, 0.0, noise)["mean_lag"][-60:].mean() == pytest.approx(lag, abs=0.03)


@pytest.mark.parametrize("error", [-10.0, 0.0, 10.0])
def test_error_of_the_torque_is_found(error: float) -> None:
    state = watched(0.05, error)
    assert state["mean_error"][-30:].mean() == pytest.approx(error, abs=1.5)


def test_what_is_not_finite_leaves_the_state() -> None:
    model = LaunchModel.of(assemble("dct-launch", {}).system.plant.parameters)
    observer, state = design_engine_observer(model, PERIOD), EngineObserverState.zeros()
    engine_observer_reset.run(state, 2.0, 100.0)
    engine_observer_step.run(observer, state, 10.0, 5.0, 101.0)
    before = state.copy()
    for bad in (np.nan, np.inf):
        for place in range(3):
            numbers = [10.0, 5.0, 101.0]
            numbers[place] = bad
            engine_observer_step.run(observer, state, *numbers)
            assert state.tobytes() == before.tobytes()


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_agree(life: Life) -> None:
    assert watched(0.1, 3.0, 0.1, life).tobytes() == watched(0.1, 3.0, 0.1).tobytes()
