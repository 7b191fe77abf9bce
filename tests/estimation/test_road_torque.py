"""The road torque observer on launches of the plant, whose road torque is the truth, and on its own reduced model."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.estimation.road_torque import (
    RoadObserver,
    RoadObserverState,
    design_road_observer,
    observer_reset,
    observer_step,
    torque_noise,
)
from bitepoint.kernels import Life
from bitepoint.kernels.c99 import FLOAT32
from bitepoint.kernels.c99.host import host_entry
from bitepoint.kernels.kernel import ENTRY, addresses_of
from bitepoint.parts.clutch_actuator import ClutchActuator, clutch_friction, torque_from_pressure
from tests.conftest import OTHER_LIVES, Refused, needs_c
from tests.estimation.launches import GRADES, MASSES, column, launch, observe, vehicles

CASES = [(grade, mass) for grade in GRADES for mass in MASSES]
ALL_MASSES = [mass for _, mass in CASES]


def rms(errors: list[np.ndarray]) -> np.ndarray:
    return np.array([np.sqrt(np.mean(error**2)) for error in errors])


def test_finds_the_road_torque_whatever_grade_and_mass() -> None:
    recordings = [launch(*case) for case in CASES]
    truth = column(recordings, "road_torque")
    held = column(recordings, "vehicle_held")
    steep = truth[np.argmin(held, axis=0) + 1, np.arange(len(CASES))]
    assert steep.min() < 80.0
    assert steep.max() > 1100.0
    observer = design_road_observer(vehicles(ALL_MASSES))
    known = observe(recordings, observer, steep)
    assert rms(known.slipping(recordings)).max() < 8.0
    assert rms(known.driving(recordings)).max() < 90.0  # the shafts swing after the lock
    unknown = observe(recordings, observer)
    assert rms(unknown.slipping(recordings)).max() < 40.0
    settled = [error[20:] for error in unknown.slipping(recordings) if len(error) > 30]
    assert len(settled) > 10
    assert rms(settled).max() < 15.0


def test_noise_makes_the_error_that_the_design_says() -> None:
    repeated = 20
    recordings = [launch(0.1, 1600.0)] * repeated
    observer = design_road_observer(vehicles([1600.0] * repeated))
    noisy, clean = observe(recordings, observer, 532.0, sigma=0.1), observe(recordings, observer, 532.0)
    rows = slice(len(clean.error) - 95, len(clean.error) - 70)
    assert not clean.locked[rows].any()
    spread = (noisy.error[rows] - clean.error[rows]).std()
    assert spread == pytest.approx(torque_noise(observer, 0.1)[0], rel=0.25)
    assert torque_noise(observer, 0.1)[0] == pytest.approx(21.8, rel=0.01)


def test_knows_when_the_clutch_has_locked_in_spite_of_noise_and_swinging_shafts() -> None:
    cases = [(0.0, 1900.0), (0.05, 1900.0), (0.05, 1600.0), (0.2, 1600.0)] * 10
    recordings = [launch(*case) for case in cases]
    noisy = observe(recordings, design_road_observer(vehicles([mass for _, mass in cases])), sigma=0.1)
    locked = np.argmax(column(recordings, "clutch_locked"), axis=0)
    assert np.abs(np.argmax(noisy.locked, axis=0) - locked).max() <= 4  # rows of 10 ms
    for k, row in enumerate(locked):
        assert noisy.locked[row + 4 :, k].all()
    assert rms(noisy.driving(recordings)).max() < 130.0


def test_a_friction_gain_error_is_a_bias_of_the_torque_that_is_not_there() -> None:
    recordings = [launch(grade, 1600.0, ("clutch.friction_gain", 0.9)) for grade in GRADES]
    observer = design_road_observer(vehicles([1600.0] * len(GRADES)))
    found = observe(recordings, observer).slipping(recordings)
    torque = column(recordings, "clutch_torque")
    for k, error in enumerate(found):
        carried = np.median(torque[column(recordings, "clutch_locked")[:, k] == 0.0, k][-20:])
        expected = 0.93 * 14.5568 * carried * (1.0 / 0.9 - 1.0)
        assert error[-20:].mean() == pytest.approx(expected, rel=0.1), GRADES[k]
        assert 150.0 < error[-20:].mean() < 260.0


def test_a_mass_error_is_a_bias_of_inertia_times_acceleration() -> None:
    recordings = [launch(0.0, mass) for mass in MASSES]
    found = observe(recordings, design_road_observer(vehicles([1600.0] * 3))).slipping(recordings)
    speed = column(recordings, "wheel_speed")
    locked = np.argmax(column(recordings, "clutch_locked"), axis=0)
    for k, mass in enumerate(MASSES):
        rows = locked[k] - np.array([45, 25])  # the estimate is behind by two time constants
        acceleration = np.diff(speed[rows, k])[0] / 0.2
        expected = (mass - 1600.0) * 0.289**2 * acceleration
        assert found[k][-20:].mean() == pytest.approx(expected, abs=25.0)


def test_with_an_actuator_the_pressure_tells_more_than_the_command() -> None:
    on = (("actuator.active", 1), ("actuator.temperature", "150 degC"))
    recordings = [launch(0.1, 1600.0, *on)]
    observer = design_road_observer(vehicles([1600.0]))
    a = ClutchActuator.parse({"temperature": 423.15}, "test")
    pressure, temperature, slip = (
        column(recordings, f"{n}")[:, 0] for n in ("clutch_pressure", "clutch_temperature", "slip_speed")
    )
    friction = clutch_friction.run(a, temperature.copy(), slip.copy())
    measured = torque_from_pressure.run(a, friction, pressure.copy())[:, None]
    by_command = observe(recordings, observer).slipping(recordings)[0]
    by_pressure = observe(recordings, observer, clutch=np.ascontiguousarray(measured)).slipping(recordings)[0]
    assert by_command[-20:].mean() > 60.0  # 6 % of a torque that friction, hot, no longer makes
    assert np.abs(by_pressure[-20:]).mean() < 20.0


def test_holds_the_prior_until_the_vehicle_moves() -> None:
    lanes = 64
    observer, state = design_road_observer(vehicles([1600.0])), RoadObserverState.zeros(lanes)
    rng = np.random.default_rng(5)
    observer_reset.run(state, np.linspace(0.0, 1000.0, lanes))
    prior = state["road_torque"].copy()
    for k in range(2000):  # 20 s of pulling at a brake
        speed = 0.1 * rng.standard_normal(lanes)
        found = observer_step.run(observer, state, 100.0 + speed, speed, min(0.1 * k, 60.0), 60.0)
        assert np.array_equal(found, prior)
    assert not state["moving"].any()
    for _ in range(30):
        observer_step.run(observer, state, 100.0, 0.5, 60.0, 60.0)
    assert state["moving"].all()
    observer_reset.run(state, np.nan)
    assert not state["moving"].any()
    assert not state["road_torque"].any()


@pytest.mark.parametrize("locked", [False, True])
def test_is_exact_on_its_own_model_and_settles_as_designed(locked: bool) -> None:
    observer = design_road_observer(vehicles([1600.0]), time_constant=0.1)
    p, state = observer[0], RoadObserverState.zeros()
    observer_reset.run(state, 0.0)
    state["moving"] = 1
    speed, errors = 0.0, []
    inertia = p["locked_inertia"] if locked else p["slipping_inertia"]
    for _ in range(100):
        engine_speed = p["ratio"] * speed if locked else 300.0
        friction = 0.02 * engine_speed
        speed += 0.01 * (p["efficiency"] * p["ratio"] * 100.0 - 500.0) / inertia
        clutch = 250.0 if locked else 100.0
        found = observer_step.run(observer, state, engine_speed, speed, clutch, 100.0 + friction)
        assert state["locked"][0] == locked
        errors.append(found[0] - 500.0)
    steps, pole = np.arange(1, 101), np.exp(-0.1)
    assert np.array(errors) == pytest.approx(-500.0 * (1.0 + steps * (1.0 - pole)) * pole**steps, abs=1e-9)
    assert abs(errors[-1]) < 0.3


def test_what_is_no_number_changes_nothing() -> None:
    observer, state = design_road_observer(vehicles([1600.0])), RoadObserverState.zeros()
    observer_reset.run(state, 200.0)
    for _ in range(30):
        observer_step.run(observer, state, 100.0, 1.0, 60.0, 60.0)
    good = [100.0, 1.0, 60.0, 60.0]
    before = state.copy()
    for place in range(4):
        for bad in (np.nan, np.inf, -np.inf):
            values = [*good[:place], bad, *good[place + 1 :]]
            assert observer_step.run(observer, state, *values)[0] == before["road_torque"][0]
            assert state.tobytes() == before.tobytes()


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_agree_to_the_bit(life: Life) -> None:
    recordings = [launch(0.0, 1900.0), launch(0.2, 1600.0)]
    observer = design_road_observer(vehicles([1900.0, 1600.0]))
    one, other = (observe(recordings, observer, sigma=0.1, life=each) for each in ("compiled", life))
    for name in ("estimate", "moving", "locked"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()


@needs_c
def test_float32_on_the_target_is_close() -> None:
    recording = launch(0.1, 1600.0)
    observer = design_road_observer(vehicles([1600.0]))
    double = observe([recording], observer).estimate[:, 0]
    p, s = (
        FLOAT32.convert(array, record)
        for array, record in ((observer, RoadObserver), (RoadObserverState.zeros(), RoadObserverState))
    )
    names = ("engine_speed", "wheel_speed", "clutch_torque_command", "engine_torque")
    columns = [column([recording], name)[:, 0].astype(np.float32) for name in names]
    arguments = [p, s, *(np.zeros(1, np.float32) for _ in range(5))]
    addresses, steps = addresses_of(arguments), np.zeros(7, np.int64)
    entry = ENTRY(host_entry(observer_step, FLOAT32))
    single = [0.0]
    for row in range(1, len(double)):
        for k, values in enumerate(columns):
            arguments[2 + k][0] = values[row - 1 if k == 2 else row]
        entry(addresses.ctypes.data, steps.ctypes.data, 1)
        single.append(float(arguments[6][0]))
    assert np.abs(np.array(single) - double).max() < 0.02  # N m; measured 0.0013


def test_a_design_that_cannot_be_is_refused(refused: Refused) -> None:
    for period, time_constant in ((0.01, 0.015), (0.0, 0.1), (-0.01, 0.1), (0.01, np.inf), (0.01, np.nan)):
        refused(lambda t=period, c=time_constant: design_road_observer(vehicles([1600.0]), t, c), "road observer")
