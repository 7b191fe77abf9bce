"""The reduced launch model against an independent integration, and against the plant."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.models.launch import LaunchModel


@pytest.fixture(scope="module")
def model() -> LaunchModel:
    return LaunchModel.of(assemble("dct-launch", {}).system.plant.parameters)


def test_difference_model_is_the_differential_one(model: LaunchModel) -> None:
    arx = model.arx(0.01)
    rng = np.random.default_rng(0)
    u, d = rng.uniform(20, 150, (40, 1)), rng.uniform(20, 150, (40, 2))
    start = np.array([[90.0, 85.0]])
    y = arx.free_run(np.vstack([start, np.zeros((39, 2))]), u, d)
    state = np.array([90.0, 5.0])  # engine and clutch speed
    for k in range(39):

        def rates(_t, x, k=k):
            engine = (d[k, 0] - u[k, 0] - model.engine_friction * x[0]) / model.engine_inertia
            return [engine, (model.efficiency * u[k, 0] - d[k, 1] / model.ratio) / model.inertia]

        state = solve_ivp(rates, (0, 0.01), state, rtol=1e-10, atol=1e-10).y[:, -1]
        assert y[k + 1] == pytest.approx([state[0], state[0] - state[1]], abs=1e-6)


def test_agrees_with_the_plant_over_a_launch(model: LaunchModel) -> None:
    recording = bitepoint.run("dct-launch", intent="normal", road__grade="5 %").recording
    moving = (recording["vehicle_held"] < 0.5) & (recording["clutch_locked"] < 0.5)
    rows = np.flatnonzero(moving)
    h = recording.time[1]
    capacity, load = recording["clutch_torque"][rows], recording["road_torque"][rows]
    engine = recording["engine_torque"][rows]
    speed = recording["engine_speed"][rows[0]] + h * np.cumsum(
        (engine - capacity - model.engine_friction * recording["engine_speed"][rows])
        / (model.engine_inertia - 0.03)  # the recorded torque holds the transient loss already
    )
    assert np.abs(speed - recording["engine_speed"][rows]).max() < 1.0
    clutch = model.ratio * recording["wheel_speed"][rows]
    after_swing = clutch[0] + h * np.cumsum((model.efficiency * capacity - load / model.ratio) / model.inertia)
    assert np.abs(after_swing - clutch)[-1] < 0.04 * clutch[-1]


def test_torque_rate_of_a_jerk_is_that_of_the_paper(model: LaunchModel) -> None:
    assert model.torque_rate(10.0) == pytest.approx(341, rel=0.06)  # 10 m/s3 of the paper's car
