"""The observer of a hybrid's driveline: what it observes is what is there, within the noise."""

from __future__ import annotations

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import PLANTS
from bitepoint.estimation.driveline import (
    DrivelineEstimate,
    design_driveline_observer,
    driveline_correct,
    driveline_predict,
)
from bitepoint.estimation.motor_delay import (
    DELAYS,
    MotorDelayState,
    motor_delay_command,
    motor_delay_measure,
    motor_delay_reset,
)
from bitepoint.kernels import Life
from bitepoint.models.driveline import DrivelineModel
from tests.conftest import OTHER_LIVES
from tests.contracts.harness import nominal


@pytest.fixture(scope="module")
def model() -> DrivelineModel:
    return DrivelineModel.of(nominal(PLANTS["p2_hybrid"], "p2-suv"), 2)


def test_modes_are_those_of_the_specification(model: DrivelineModel) -> None:
    rates = np.linalg.eigvals(model.differential()[0])
    swinging = sorted((r for r in rates if r.imag > 0.0), key=abs)
    assert [abs(r) / (2 * np.pi) for r in swinging] == pytest.approx([2.2, 19.7], rel=0.01)
    assert [-r.real / abs(r) for r in swinging] == pytest.approx([0.09, 0.28], rel=0.03)
    assert model.euler_limit() == pytest.approx(0.0045, rel=0.01)


def test_a_difference_is_the_differential_equation_integrated(model: DrivelineModel) -> None:
    a, b = model.difference(0.01)
    fine, effect = model.difference(1e-5, euler=True)
    x = coarse = np.random.default_rng(1).normal(size=8)
    for _ in range(1000):
        x = fine @ x + effect @ np.array([100.0, -50.0])
    assert a @ coarse + b @ np.array([100.0, -50.0]) == pytest.approx(x, rel=2e-3, abs=0.05)


def test_twists_and_load_are_observed_in_a_tip_in() -> None:
    noise = {"noise.engine_speed": 0.1, "noise.motor_speed": 0.1, "noise.wheel_speed": 0.02}
    seen = bitepoint.run("p2-tip-in", {**noise, "road.grade": "6 %"}, seed=2).recording
    late = seen.time > 0.5
    swing = seen["torsional_speed_estimate"] - seen["torsional_speed"]
    assert np.sqrt(np.mean(swing[late] ** 2)) < 0.05
    load = 2000.0 * 9.81 * 0.32 * (0.06 + 0.012)  # and air, 15 N m at most
    driving = (seen.time > 8.0) & (seen.time < 19.0)  # later its governor keeps the engine from stalling
    assert seen["road_torque_estimate"][driving].mean() == pytest.approx(load + 12.0, rel=0.03)


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_agree(model: DrivelineModel, life: Life) -> None:
    observer = design_driveline_observer(model, 0.01, (0.1, 0.1, 0.02))
    estimates = []
    for other in ("compiled", life):
        x, work = DrivelineEstimate.zeros(), DrivelineEstimate.zeros()
        for k in range(20):
            driveline_predict.run(observer, x, work, 100.0, -30.0, life=other)  # pyright: ignore
            driveline_correct.run(observer, x, 160.0 + k, 161.0 + k, 15.3, life=other)  # pyright: ignore
        estimates.append(x["x"].copy())
    assert np.array_equal(*estimates)


def follow(delay: int, commands: np.ndarray, noise: float = 0.0) -> MotorDelayState:
    """The estimator after a motor has followed commands with a dead time, in steps."""
    share, rng = 1.0 - np.exp(-1.0), np.random.default_rng(4)
    state, torque, past = MotorDelayState.zeros(), 0.0, [0.0] * (delay + 1)
    motor_delay_reset.run(state, 0.0, 0)
    for command in commands:
        torque += share * (past[delay] - torque)
        motor_delay_measure.run(state, share, torque + noise * rng.standard_normal())
        motor_delay_command.run(state, command)
        past = [command, *past[:-1]]
    return state[0]  # pyright: ignore


@pytest.mark.parametrize("delay", range(DELAYS))
def test_a_dead_time_is_found_from_one_step(delay: int) -> None:
    commands = np.concatenate([np.zeros(10), np.full(15, 200.0)])
    assert follow(delay, commands)["delay"] == delay  # pyright: ignore


def test_a_motor_at_rest_teaches_nothing() -> None:
    assert follow(4, np.zeros(200), noise=1.0)["delay"] == 0  # pyright: ignore
