"""Damping of the P2 hybrid: the figures that are claimed, with noise on all speeds, on and off nominal."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import bitepoint
from bitepoint import Result
from bitepoint.assembly import PLANTS, assemble
from bitepoint.controllers.damping_mpc import CONTROLLER
from bitepoint.controllers.damping_mpc_records import DampingMpcWork
from bitepoint.models.driveline import DrivelineModel
from bitepoint.planning.damping_bound import least_torsional_speed
from tests.conftest import Refused
from tests.contracts.harness import nominal

NOISE = {"noise.engine_speed": "0.1 rad/s", "noise.motor_speed": "0.1 rad/s", "noise.wheel_speed": "0.02 rad/s"}
SHAPED = {"controller.shape_engine": "true", "motor.torque_limit": "60 N*m"}


@cache
def run(scenario: str = "p2-tip-in", **settings: str) -> Result:
    chosen = {key.replace("__", "."): value for key, value in settings.items()}
    noise = NOISE if chosen.get("controller", "damping_mpc") == "damping_mpc" else {}
    return bitepoint.run(scenario, {**noise, **chosen}, seed=3)


def figure(result: Result, name: str) -> float:
    value = result.metrics[name].value
    assert value is not None, name
    return value


def reduction(damped: Result, undamped: Result, name: str = "torsional_speed_peak") -> float:
    return 1.0 - figure(damped, name) / figure(undamped, name)


def test_the_uncontrolled_run_shows_the_published_swing() -> None:
    result = run(controller="none")
    assert figure(result, "torsional_speed_peak") == pytest.approx(5.37, rel=0.03)
    assert figure(result, "acceleration_peak") == pytest.approx(8.84, rel=0.03)
    assert figure(result, "jerk_peak_raw") == pytest.approx(62.7, rel=0.03)
    assert figure(result, "energy_residual") < 1e-7


def test_the_motor_takes_two_thirds_of_the_swing_away_and_leaves_no_torque() -> None:
    damped, undamped = run(), run(controller="none")
    assert reduction(damped, undamped) > 0.65
    assert reduction(damped, undamped, "acceleration_peak") == pytest.approx(0.36, abs=0.02)
    kept = figure(damped, "mean_acceleration") - figure(undamped, "mean_acceleration")
    assert abs(kept) < 0.005
    time, torque = damped.recording.time, damped.recording["motor_torque"]
    assert np.abs(torque[(time > 29.0) & (time < 31.0)]).max() < 3.0  # of noise
    assert abs(torque[(time > 29.0) & (time < 31.0)].mean()) < 0.5
    assert np.abs(torque).max() <= 300.0


def test_without_noise_no_torque_is_left_at_30_s() -> None:
    recording = bitepoint.run("p2-tip-in").recording
    assert np.abs(recording["motor_torque"][np.abs(recording.time - 30.0) < 1.0]).max() < 0.1


def test_with_the_engine_shaped_the_published_figures_are_had_together() -> None:
    result = run(**SHAPED)
    assert figure(result, "torsional_speed_peak") <= 2.1
    assert figure(result, "acceleration_peak") <= 5.6
    assert figure(result, "correction_torque_rms") <= 17.0
    assert figure(result, "torque_response_time") < 1.0


@pytest.mark.parametrize("limit", [120.0, 200.0, 300.0])
def test_within_5_points_of_the_bound(limit: float) -> None:
    model = DrivelineModel.of(nominal(PLANTS["p2_hybrid"], "p2-suv"), 2)
    best = least_torsional_speed(model, -40.0, 440.0, limit, 1e4).reduction
    damped = run("p2-tip-step", motor__torque_limit=f"{limit} N*m")
    assert best - 0.05 < reduction(damped, run("p2-tip-step", controller="none")) < best + 0.03


def test_bound_ratio_tells_how_far_from_the_optimum_a_run_is() -> None:
    ratio = run("p2-tip-step", report__bound="true").metrics["bound_ratio"].value
    assert ratio is not None
    assert 1.0 < ratio < 1.2
    undamped = run("p2-tip-step", report__bound="true", controller="none").metrics["bound_ratio"].value
    assert undamped is not None
    assert undamped > 3.0


def test_dead_time_of_the_motor_is_found_and_made_good() -> None:
    prompt, undamped = reduction(run(), run(controller="none")), run(controller="none")
    for delay, lost in (("10 ms", 0.04), ("20 ms", 0.04), ("40 ms", 0.16)):  # 40 ms are a tenth of a swing, lost to all
        late = run(motor__delay=delay)
        assert reduction(late, undamped) > prompt - lost, delay
        found = late.recording["motor_delay_estimate"][-1]
        assert found == pytest.approx(float(delay.split()[0]) / 1000.0, abs=1e-9)


@pytest.mark.parametrize(
    "changed",
    [
        {"vehicle.mass": "1600 kg"},
        {"vehicle.mass": "2400 kg"},
        {"halfshaft.stiffness": "6000 N*m/rad"},
        {"gearbox.gear": "1"},
        {"gearbox.gear": "3"},
        {"torque_split.mode": "hybrid"},
        {"torque_split.mode": "generating"},
        {"torque_split.mode": "electric"},
        {"controller": "damping_shaping"},
    ],
    ids=lambda changed: ", ".join(f"{key}={value}" for key, value in changed.items()),
)
def test_off_nominal_it_damps_and_leaves_no_torque(changed: dict[str, str]) -> None:
    settings = {key.replace(".", "__"): value for key, value in changed.items()}
    damped, undamped = run(**settings), run(**{**settings, "controller": "none"})
    assert reduction(damped, undamped) > 0.55
    time = damped.recording.time
    late = (time > 29.0) & (time < 31.0)
    assert abs(damped.recording["correction_torque"][late].mean()) < 2.0
    assert np.abs(damped.recording["torsional_speed"][late]).max() < 0.1


def test_slip_is_held_by_motor_and_engine_on_a_slippery_road() -> None:
    damped, undamped = run(road__friction="0.45"), run(road__friction="0.45", controller="none")
    assert figure(undamped, "tyre_slip_peak") > 1.5
    assert figure(damped, "tyre_slip_peak") < 0.15
    assert figure(damped, "acceleration_peak") > 0.9 * 0.45 * 9.81  # what the road allows


def test_weights_do_what_they_say() -> None:
    paper = {"controller.calibration": "paper"}
    over = {"controller.q": [1.0, 3.0, 10.0, 1.0, 1.0], "controller.r": [1.0, 1.0, 1.0, 3.0, 10.0]}
    torque = bitepoint.run_batch("p2-tip-step", over, paper).metrics["correction_torque_rms"]
    assert torque[0] < torque[1] < torque[2]
    assert torque[0] > torque[3] > torque[4]


def test_euler_is_refused_with_its_limit(refused: Refused) -> None:
    settings = {"controller.discretisation": "euler"}
    refused(lambda: assemble("p2-tip-in", settings), "stable below 4.4 ms in gear 1", "expected zero_order_hold")
    assert assemble("p2-tip-in", {"controller.discretisation": "euler_unchecked"})


def test_weights_without_an_answer_are_refused(refused: Refused) -> None:
    settings = {"controller.q": "0", "controller.r": "0", "controller.rho": "0"}
    refused(lambda: assemble("p2-tip-in", settings), "no unique answer", "expected r or rho above 0")


def test_the_gradient_is_that_of_the_cost_stepped_through() -> None:
    """The condensed programme against the cost of the same moves, stepped through the model and the filters."""
    calibration = CONTROLLER.calibration.parse({"r": 0.01, "rho": 0.02, "prediction_horizon": 12}, "")
    vehicle = nominal(PLANTS["p2_hybrid"], "p2-suv")
    p = CONTROLLER.design(vehicle, calibration)
    gear, moves = p["gear"][0, 1], int(p["moves"][0])
    rng = np.random.default_rng(5)
    past = rng.normal(size=DampingMpcWork.fields["past"].shape[0]) * np.array([5, 0.1, 5, 0.1, 0.5] + [50.0] * 10)

    def cost(z: np.ndarray) -> float:
        return stepped_cost(vehicle, p, past, gear["feed_forward"][:moves] @ past[5:14], z)

    z, h = rng.normal(size=moves), 1e-3
    numeric = [(cost(z + h * e) - cost(z - h * e)) / (2 * h) for e in np.eye(moves)]
    condensed = gear["gradient"][:moves] @ past + gear["matrices"]["hessian"][:moves, :moves] @ z
    assert condensed == pytest.approx(numeric, rel=1e-6, abs=1e-6 * np.abs(numeric).max())


def stepped_cost(
    vehicle: np.ndarray, p: np.ndarray, past: np.ndarray, feed_forward: np.ndarray, z: np.ndarray
) -> float:
    """Half the cost of moves z (100 N m) over 12 steps: model, filters and feed forward, step by step."""
    c, model = p["calibration"][0], DrivelineModel.of(vehicle, 2)
    a, b = model.difference(0.01)
    x, (first, second, request), engine, before = past[:8].copy(), past[8:11], past[13], past[14]
    torque, share, lag = past[5], float(p["shaping_share"][0]), 1.0 - np.exp(-0.01 / model.engine_lag)
    total = 0.0
    for k in range(12):
        new_first = first + share * (request - first)
        new_second = second + share * (new_first - second)
        new_torque = torque + lag * (engine - torque)
        needed = 0.5 * (second + new_second - torque - new_torque)
        if k < len(z):
            assert needed == pytest.approx(feed_forward[k])
        correction = 100.0 * z[min(k, len(z) - 1)]
        motor = needed + correction
        x = a @ x + b @ np.array([engine, motor])
        first, second, torque = new_first, new_second, new_torque
        wanted = model.twist_speed * (first - second) / float(p["shaping_time"][0])
        total += 0.5 * float(c["q"]) * (model.output @ x - wanted) ** 2
        total += 0.5 * float(c["rho"]) * (correction / 3.0) ** 2
        if k < len(z):
            total += 0.5 * float(c["r"]) * ((motor - before) / 3.0) ** 2
            before = motor
    return total
