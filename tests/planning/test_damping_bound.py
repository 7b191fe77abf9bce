"""The least swing of a driveline: known bounds, monotone limits, and nothing that breaks them."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from bitepoint.models.driveline import DrivelineModel
from bitepoint.planning.damping_bound import PERIOD, least_torsional_speed
from tests.conftest import Refused
from tests.contracts.harness import nominal


@pytest.fixture(scope="module")
def model() -> DrivelineModel:
    return DrivelineModel.of(nominal(PLANTS["p2_hybrid"], "p2-suv"), 2)


@pytest.mark.parametrize(("limit", "reduction"), [(60, 0.15), (120, 0.30), (200, 0.49), (300, 0.72), (480, 0.89)])
def test_reduction_over_the_limit_of_the_motor(model: DrivelineModel, limit: float, reduction: float) -> None:
    assert least_torsional_speed(model, -40.0, 440.0, limit, 1e4).reduction == pytest.approx(reduction, abs=0.01)


def test_a_slow_motor_cannot_use_its_torque(model: DrivelineModel) -> None:
    found = [least_torsional_speed(model, -40.0, 440.0, limit, 2e3).reduction for limit in (300.0, 480.0)]
    assert found[0] == pytest.approx(found[1], abs=0.01)
    assert found[0] < 0.5


def test_limits_hold_and_the_motor_lets_go(model: DrivelineModel) -> None:
    found = least_torsional_speed(model, 440.0, -40.0, 200.0, 1e4)
    assert np.abs(found.motor_torque).max() <= 200.0 + 1e-6
    assert np.abs(np.diff(found.motor_torque, prepend=0.0, append=0.0)).max() <= 1e4 * PERIOD + 1e-6
    assert found.peak == pytest.approx(np.abs(found.torsional_speed).max())


def test_no_motor_is_no_reduction_and_dead_time_costs(model: DrivelineModel) -> None:
    assert least_torsional_speed(model, -40.0, 440.0, 0.0, 1e4).reduction == pytest.approx(0.0, abs=1e-9)
    prompt, late = (least_torsional_speed(model, -40.0, 440.0, 300.0, 1e4, delay=delay).peak for delay in (0.0, 0.02))
    assert late >= prompt


def test_no_torque_that_keeps_the_limits_does_better(model: DrivelineModel) -> None:
    """Random torques within the limits, on the model integrated in other steps, never swing less."""
    best = least_torsional_speed(model, -40.0, 440.0, 200.0, 1e4)
    a, b = model.difference(0.005)
    rng = np.random.default_rng(3)
    for _ in range(100):
        torque = best.motor_torque + rng.normal(0.0, 30.0) * np.sin(rng.uniform(1, 20) * np.arange(80) * PERIOD)
        torque = np.clip(torque, -200.0, 200.0)
        if np.abs(np.diff(torque, prepend=0.0, append=0.0)).max() > 1e4 * PERIOD:
            continue
        x, peak = _start(model), 0.0
        for k in range(320):
            u = torque[k // 2] if k // 2 < len(torque) else 0.0
            x = a @ x + b @ np.array([440.0, u])
            peak = max(peak, abs(float(model.output @ x)))
        assert peak >= best.peak * 0.995


def _start(model: DrivelineModel) -> np.ndarray:
    """Long under -40 N m: simulated until the swing is gone."""
    a, b = model.difference(0.05)
    x = np.zeros(8)
    for _ in range(400):
        x = a @ x + b @ np.array([-40.0, 0.0])
    return x


def test_a_step_of_nothing_is_refused(model: DrivelineModel, refused: Refused) -> None:
    refused(lambda: least_torsional_speed(model, 40.0, 40.0, 200.0, 1e4), "bounds", "a step from 40 to 40")
