"""What every controller must do, with every calibration that ships. A new controller is in by existing."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from bitepoint.controllers.controller import Controller
from bitepoint.kernels import Life
from tests.conftest import OTHER_LIVES, needs_c
from tests.contracts.harness import (
    ControllerBench,
    controllers_with_calibrations,
    designed,
    nominal,
    random_signals,
    same_bits,
)

CASES = list(controllers_with_calibrations())


def cases(plant: str = "", signal: str = "") -> pytest.MarkDecorator:
    """Parametrize a test by controllers and calibrations: all, or those of a plant that see or command a signal."""

    def wanted(controller: Controller) -> bool:
        signals = {**controller.measurement.fields, **controller.command.fields}
        return (not plant or plant in controller.plants) and (not signal or signal in signals)

    chosen = [(controller, calibration) for controller, calibration in CASES if wanted(controller)]
    short = {"dct": "", "p2_hybrid": ".p2", "conventional": ".conventional"}
    ids = [f"{c.name}{short[c.plants[0]]}-{calibration}" for c, calibration in chosen]
    return pytest.mark.parametrize(("controller", "calibration"), chosen, ids=ids)


each_controller = cases()


def plausible(controller: Controller, k: int, rng: np.random.Generator) -> dict[str, float]:
    """What might be measured in step k; 0 for what is not named."""
    if "dct" in controller.plants:
        return {"pedal": 0.3, "engine_speed": 120.0 + rng.normal(), "clutch_speed": 1.2 * k}
    if "conventional" in controller.plants:
        return conventional_plausible(k, rng)
    asked = 440.0 if k // 40 % 2 else -40.0  # steps of the driver, in 2nd gear of the hybrid
    speed = 160.0 + 0.5 * k + rng.normal()
    return {
        "torque_request": asked, "engine_torque_base": 0.7 * asked, "motor_torque_base": 0.3 * asked, "gear": 2.0,
        "clutch_torque_command": 0.0 if k // 70 % 3 == 2 else 600.0, "engine_speed": speed, "motor_speed": speed,
        "wheel_speed": speed / 10.5, "vehicle_speed": 0.3 * speed / 10.5, "motor_torque_limit": 300.0,
        "gear_ratio": 10.5, "speed_target": 5.0 + 3.0 * (k // 50 % 2),
    }  # fmt: skip


def conventional_plausible(k: int, rng: np.random.Generator) -> dict[str, float]:
    """A car that gathers speed and loses it again, asked for torque and other gears, in neutral at times."""
    turn = k % 300
    input_speed = 1.5 * min(turn, 300 - turn)
    gear = float(1 + turn // 75)
    return {
        "engine_torque_wanted": 120.0 if k // 60 % 3 else -30.0, "gear_wanted": gear, "engine_torque": 60.0,
        "gear": 0.0 if turn % 75 < 10 else gear, "clutch_speed": input_speed, "distance": 0.5 * k,
        "engine_speed": max(input_speed, 120.0) + (rng.normal() if turn % 75 > 15 else 40.0),
        "vehicle_speed": 0.03 * input_speed, "speed_target": 12.0 if k // 90 % 3 else 0.0,
    }  # fmt: skip


def sequence(controller: Controller, lanes: int, steps: int, seed: int = 1) -> list[dict[str, np.ndarray]]:
    """Measurements over the declared ranges, half of them plausible."""
    rng = np.random.default_rng(seed)
    wild = [random_signals(controller.measurement, rng, (lanes,)) for _ in range(steps)]
    for k, values in enumerate(wild):
        chosen = plausible(controller, k, rng)
        for name in values:
            values[name][: lanes // 2] = chosen.get(name, 0.0)
    return wild


@each_controller
def test_commands_stay_in_their_declared_ranges(controller: Controller, calibration: str) -> None:
    bench = ControllerBench(controller, np.repeat(designed(controller, calibration), 64))
    for values in sequence(controller, 64, 300):
        assert not bench.step(**values).any()
        for name, field in controller.command.fields.items():
            assert (bench.c[name] >= field.low).all(), name
            assert (bench.c[name] <= field.high).all(), name


@cases("dct")
def test_clutch_torque_keeps_limit_and_rate(controller: Controller, calibration: str) -> None:
    bench = ControllerBench(controller, np.repeat(designed(controller, calibration), 64))
    clutch = nominal_clutch()
    last = bench.c["clutch_torque_command"].copy()
    for values in sequence(controller, 64, 300):
        bench.step(**values)
        now = bench.c["clutch_torque_command"]
        assert now.max() <= clutch["torque_limit"]
        assert np.abs(now - last).max() <= clutch["torque_rate_limit"] * controller.period + 1e-9
        last = now.copy()


def nominal_clutch() -> np.void:
    return nominal(PLANTS["dct"], "dct-t240")["clutch"][0]


@cases("p2_hybrid", "motor_torque_limit")
def test_motor_torque_keeps_limit_and_rate(controller: Controller, calibration: str) -> None:
    if (
        "correction_torque" not in controller.command.fields
        or "motor_torque_limit" not in controller.measurement.fields
    ):
        pytest.skip("passes on what it is asked for")
    bench = ControllerBench(controller, np.repeat(designed(controller, calibration), 64))
    motor = nominal(PLANTS["p2_hybrid"], "p2-suv")["motor"][0]
    last = bench.c["motor_torque_command"].copy()
    for values in sequence(controller, 64, 300):
        bench.step(**values)
        now = bench.c["motor_torque_command"]
        assert np.abs(now).max() <= motor["torque_limit"]
        assert np.abs(now - last).max() <= motor["torque_rate_limit"] * controller.period + 1e-9
        last = now.copy()


@cases("p2_hybrid", "correction_torque")
def test_a_driveline_that_does_not_swing_is_left_alone(controller: Controller, calibration: str) -> None:
    bench = ControllerBench(controller, designed(controller, calibration))
    still = {
        "engine_torque_base": 10.0, "motor_torque_base": 0.0, "gear": 2.0, "clutch_torque_command": 600.0,
        "engine_speed": 210.0, "motor_speed": 210.0, "wheel_speed": 20.0, "vehicle_speed": 6.4,
        "motor_torque": 0.0, "motor_torque_limit": 300.0,
    }  # fmt: skip
    chosen = {name: still[name] for name in controller.measurement.fields}
    for name, value in chosen.items():
        bench.m[name] = value
    bench.init()
    for _ in range(300):
        bench.step(**chosen)
    assert abs(bench.c["correction_torque"][0]) < 2.0


@cases("dct")
def test_does_nothing_while_the_driver_does_nothing(controller: Controller, calibration: str) -> None:
    bench = ControllerBench(controller, designed(controller, calibration))
    first = bench.c["throttle"][0]
    for _ in range(100):
        bench.step(**{name: {"engine_speed": 83.0}.get(name, 0.0) for name in controller.measurement.fields})
        assert bench.c["clutch_torque_command"][0] == 0.0
    assert bench.c["throttle"][0] == pytest.approx(first, abs=1e-9)  # a bumpless entry: idle stays idle


@each_controller
def test_init_forgets_the_past(controller: Controller, calibration: str) -> None:
    used = ControllerBench(controller, designed(controller, calibration))
    for values in sequence(controller, 1, 200):
        used.step(**values)
    used.m.view(np.float64)[...] = 0.0
    used.init()
    fresh = ControllerBench(controller, designed(controller, calibration))
    for values in sequence(controller, 1, 100, seed=2):
        used.step(**values)
        fresh.step(**values)
    assert same_bits(used.c, fresh.c)
    assert same_bits(used.s, fresh.s)


@each_controller
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_measurement_that_is_no_number_is_a_status_and_keeps_the_commands(
    controller: Controller, calibration: str, bad: float
) -> None:
    for name in controller.measurement.fields:
        bench = ControllerBench(controller, designed(controller, calibration))
        for values in sequence(controller, 1, 60):
            bench.step(**values)
        commands, state = bench.c.copy(), bench.s.copy()
        assert bench.step(**{name: bad})[0] != 0
        assert same_bits(bench.c, commands)
        assert same_bits(bench.s, state)
        assert bench.step(**values)[0] == 0  # and the next good one is taken again


@each_controller
def test_measurements_far_out_of_range_are_survived(controller: Controller, calibration: str) -> None:
    bench = ControllerBench(controller, designed(controller, calibration))
    for value in (1e300, -1e300, 1e9, -1e9, 0.0):
        for _ in range(20):
            bench.step(**dict.fromkeys(controller.measurement.fields, value))
            assert np.isfinite(bench.c.view(np.float64)).all()
            for name, field in controller.command.fields.items():
                assert field.low <= bench.c[name][0] <= field.high, name


@pytest.mark.parametrize("life", OTHER_LIVES)
@each_controller
def test_lives_agree_to_the_bit(controller: Controller, calibration: str, life: Life) -> None:
    lives = [ControllerBench(controller, designed(controller, calibration), other) for other in ("compiled", life)]
    for number, values in enumerate(sequence(controller, 1, 1000)):
        if number % 97 == 0:
            values = {**values, next(iter(values)): np.array([np.nan])}
        statuses = [bench.step(**values)[0] for bench in lives]
        assert statuses[0] == statuses[1]
        assert same_bits(lives[0].c, lives[1].c)
    assert same_bits(lives[0].s, lives[1].s)


@needs_c
@each_controller
def test_c_agrees_to_the_bit_over_a_hundred_thousand_steps(controller: Controller, calibration: str) -> None:
    rng = np.random.default_rng(11)
    lanes, steps = 200, 500
    p = np.repeat(designed(controller, calibration), lanes)
    benches = [ControllerBench(controller, p, "compiled"), ControllerBench(controller, p, "c")]
    for values in sequence(controller, lanes, steps, seed=12):
        for column in values.values():
            broken = rng.random(lanes) < 0.01
            column[broken] = rng.choice([np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-310], int(broken.sum()))
        statuses = [bench.step(**values) for bench in benches]
        assert np.array_equal(*statuses)
        assert same_bits(benches[0].c, benches[1].c)
        assert same_bits(benches[0].s, benches[1].s)


@each_controller
def test_calibrations_name_their_source(controller: Controller, calibration: str) -> None:
    values = controller.calibrations()[calibration]
    assert not values or values["source"]
