"""What every controller must do, with every calibration that ships. A new controller is in by existing."""

from __future__ import annotations

import numpy as np
import pytest

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
each_controller = pytest.mark.parametrize(
    ("controller", "calibration"), CASES, ids=[f"{c.name}-{calibration}" for c, calibration in CASES]
)


def sequence(controller: Controller, lanes: int, steps: int, seed: int = 1) -> list[dict[str, np.ndarray]]:
    """Measurements over the declared ranges, half of them a plausible launch."""
    rng = np.random.default_rng(seed)
    wild = [random_signals(controller.measurement, rng, (lanes,)) for _ in range(steps)]
    for k, values in enumerate(wild):
        for name in values:
            plausible = {"pedal": 0.3, "engine_speed": 120.0 + rng.normal(), "clutch_speed": 1.2 * k}.get(name, 0.0)
            values[name][: lanes // 2] = plausible
    return wild


@each_controller
def test_commands_stay_in_their_declared_ranges(controller: Controller, calibration: str) -> None:
    bench = ControllerBench(controller, np.repeat(designed(controller, calibration), 64))
    for values in sequence(controller, 64, 300):
        assert not bench.step(**values).any()
        for name, field in controller.command.fields.items():
            assert (bench.c[name] >= field.low).all(), name
            assert (bench.c[name] <= field.high).all(), name


@each_controller
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
    from bitepoint.assembly import PLANTS

    return nominal(PLANTS["dct"], "dct-t240")["clutch"][0]


@each_controller
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
    used.m["pedal"] = 0.0
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
            values = {**values, "pedal": np.array([np.nan])}
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
