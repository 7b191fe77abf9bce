"""The intention block by hand: when it decides by what, what it holds, and that all lives tell the same."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.controllers.launch_intent import (
    BY_NETWORK,
    CONTROLLER,
    INCOMPLETE,
    NORMAL,
    SLOW,
    UNUSABLE,
    URGENT,
    LaunchIntentCommand,
)
from bitepoint.identification.intent.decisions import calibration
from bitepoint.identification.intent.drivers import reach
from bitepoint.identification.intent.launches import draw_launches
from bitepoint.kernels import Life
from tests.conftest import OTHER_LIVES
from tests.contracts.harness import ControllerBench, same_bits

ONSET = 20
FIRST = 28
"""Samples: pedal onset in a trace, and the network's first decision counted from there."""


def bench(life: Life = "compiled", lanes: int = 1, name: str = "trained") -> ControllerBench:
    settings = np.repeat(calibration(name), lanes)
    return ControllerBench(CONTROLLER, CONTROLLER.design(settings, settings), life)


def press(depth: float, rise: float, samples: int = 120) -> np.ndarray:
    """A clean press that passes 1 % in sample ONSET."""
    time = 0.01 * np.arange(1, samples + 1)
    pedal = depth * reach(time, 0.0, rise)
    return np.concatenate([np.zeros(ONSET), pedal[np.argmax(pedal > 0.01) :]])


def tell(unit: ControllerBench, pedal: float, speed: float = 0.0) -> tuple[float, int, int]:
    """Step once; return slip decay, intention and status."""
    assert unit.step(pedal=pedal, vehicle_speed=speed)[0] == 0
    return float(unit.c["slip_decay"][0]), int(unit.c["launch_intention"][0]), int(unit.c["intention_status"][0])


@pytest.mark.parametrize(
    ("depth", "rise", "intention", "decay"),
    [(0.12, 0.7, SLOW, 0.20), (0.235, 0.4, NORMAL, 0.45), (0.36, 0.2, URGENT, 0.70)],
)
def test_a_clear_press_is_what_it_looks_like(depth: float, rise: float, intention: int, decay: float) -> None:
    for name, status in (("trained", BY_NETWORK), ("rule", INCOMPLETE)):
        unit = bench(name=name)
        told = [tell(unit, pedal) for pedal in press(depth, rise)]
        assert told[-1] == (decay, intention, status)


def test_the_network_decides_when_its_window_is_complete() -> None:
    unit = bench()
    statuses = [tell(unit, pedal)[2] for pedal in press(0.235, 0.3)]
    first = statuses.index(BY_NETWORK)
    assert first == ONSET + FIRST - 1
    assert set(statuses[:first]) == {INCOMPLETE}
    assert set(statuses[first:]) == {BY_NETWORK}


def test_until_then_it_is_the_rule_alone() -> None:
    both, rule = bench(), bench(name="rule")
    for pedal in press(0.31, 0.2)[: ONSET + FIRST - 1]:
        assert tell(both, pedal) == tell(rule, pedal)


def test_what_is_decided_at_the_end_of_the_window_is_held_until_the_pedal_is_released() -> None:
    unit = bench()
    for pedal in press(0.36, 0.2, 230):
        held = tell(unit, pedal)
    assert held[1:] == (URGENT, BY_NETWORK)
    for pedal in np.linspace(0.36, 0.02, 100):
        assert tell(unit, pedal) == held
    assert tell(unit, 0.0) == (0.20, SLOW, INCOMPLETE)
    assert [tell(unit, pedal) for pedal in press(0.12, 0.7)][-1][1:] == (SLOW, BY_NETWORK)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_without_a_pedal_the_intention_is_held_and_the_window_left_to_the_rule(bad: float) -> None:
    unit, rule = bench(), bench(name="rule")
    pedals = press(0.36, 0.2)
    for pedal in pedals[:60]:
        last, by_rule = tell(unit, pedal), tell(rule, pedal)
    assert last[2] == BY_NETWORK
    for _ in range(5):
        assert tell(unit, bad) == (*last[:2], UNUSABLE)
    for pedal in pedals[60:]:
        told, by_rule = tell(unit, pedal), tell(rule, pedal)
        assert told == (*by_rule[:2], UNUSABLE)
    tell(unit, 0.0)
    assert [tell(unit, pedal) for pedal in pedals][-1][2] == BY_NETWORK


def test_a_pedal_that_comes_back_is_no_jerk_of_the_foot() -> None:
    unit = bench()
    for pedal in (0.0, 0.02, 0.04, np.nan, np.nan, np.nan, 0.15, 0.15, 0.15):
        tell(unit, pedal)
    assert unit.s["highest_rate"][0] < 2.0  # 0.11 in one step would be 11/s
    assert unit.s["highest_pedal"][0] == 0.15


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_without_a_speed_the_rule_decides(bad: float) -> None:
    unit, rule = bench(), bench(name="rule")
    for number, pedal in enumerate(press(0.31, 0.25)):
        told, by_rule = tell(unit, pedal, bad if number == ONSET + 5 else 0.0), tell(rule, pedal)
        if number >= ONSET + 5:
            assert told == (*by_rule[:2], UNUSABLE)
    waiting = bench()
    assert tell(waiting, 0.0, bad) == (0.20, SLOW, INCOMPLETE)  # the window has not begun: nothing is lost


def test_a_start_faster_than_in_training_is_left_to_the_rule() -> None:
    for start, status in ((2.5, BY_NETWORK), (2.7, UNUSABLE)):
        unit = bench()
        for number, pedal in enumerate(press(0.235, 0.3)):
            told = tell(unit, pedal, start + 0.03 * max(number - ONSET, 0))  # faster later on is what a launch is for
        assert told[2] == status


def test_what_it_tells_stays_in_its_ranges_whatever_comes() -> None:
    rng = np.random.default_rng(3)
    unit = bench(lanes=200)
    for number in range(300):
        scale = 10.0 ** rng.uniform(-2, 300 if number % 50 == 0 else 0, (2, 200))
        pedal, speed = rng.normal(0.2, 0.2, (2, 200)) * scale
        pedal[rng.random(200) < 0.01] = rng.choice([np.nan, np.inf, -np.inf])
        assert not unit.step(pedal=pedal, vehicle_speed=speed).any()
        for name, field in LaunchIntentCommand.fields.items():
            assert (unit.c[name] >= field.low).all()
            assert (unit.c[name] <= field.high).all()
        for name in ("gates", "cells", "outputs", "scores"):
            assert np.isfinite(unit.s["network"][name]).all()


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_agree_to_the_bit(life: Life) -> None:
    drivers, each = (2, 1) if life == "interpreted" else (40, 5)
    launches = draw_launches(99, drivers, each)
    pedal, speed = launches.pedal.copy(), launches.speed.copy()
    pedal[::2, 90], speed[1::2, 70] = np.nan, np.inf
    units = [bench(other, drivers * each) for other in ("compiled", life)]
    for k in range(150 if life == "interpreted" else pedal.shape[1]):
        for unit in units:
            unit.step(pedal=pedal[:, k], vehicle_speed=speed[:, k])
        assert same_bits(units[0].c, units[1].c)
        assert same_bits(units[0].s, units[1].s)


def test_calibrations_name_their_source_and_parse() -> None:
    for name, values in CONTROLLER.calibrations().items():
        assert values["source"]
        assert calibration(name)["slip_decay"][0].tolist() == [0.20, 0.45, 0.70]
