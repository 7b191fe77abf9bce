"""Generated drivers, and what network and rule make of drivers that neither has seen."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

from bitepoint.controllers.launch_intent import NORMAL, SLOW, URGENT
from bitepoint.files import library_yaml
from bitepoint.identification.intent import train
from bitepoint.identification.intent.assessment import DRIVERS, EACH, SEEDS, assess, draw_lot
from bitepoint.identification.intent.baselines import discriminant, tune_rule
from bitepoint.identification.intent.decisions import calibration, windows
from bitepoint.identification.intent.drivers import (
    DEPTH,
    DEPTH_CHANCE,
    DEPTH_HABIT,
    RISE,
    RISE_CHANCE,
    RISE_HABIT,
    VERSION,
    draw_driver,
    press,
    reach,
)
from bitepoint.identification.intent.figures import confusion, figures
from bitepoint.identification.intent.launches import SAMPLES, Launches, draw_launches
from bitepoint.report.intent import intent_figure
from tests.conftest import Refused

TRAINED = library_yaml("controllers", "launch_intent_trained.yaml")

LEAST_RIGHT, LEAST_GAIN = 0.85, 0.03
"""Floors: share of samples that the network decides rightly, and how far above the rule that is."""


@pytest.fixture(scope="module")
def launches() -> Launches:
    return draw_launches(41, 60, 20)


def test_same_seed_same_launches(launches: Launches) -> None:
    again, other = draw_launches(41, 60, 20), draw_launches(42, 60, 20)
    for name in ("driver", "intention", "plain", "pedal", "speed"):
        assert np.array_equal(getattr(launches, name), getattr(again, name))
    assert not np.array_equal(launches.pedal, other.pedal)
    fewer = draw_launches(41, 10, 20)  # a driver does not depend on how many follow
    assert np.array_equal(fewer.pedal, launches.pedal[:200])


def test_lots_share_no_driver() -> None:
    assert len(set(SEEDS.values())) == len(SEEDS) == len(DRIVERS)
    first = [draw_driver(np.random.default_rng([seed, 0])) for seed in SEEDS.values()]
    assert len({driver.depth for driver in first}) == len(first)


def test_traces_are_those_of_sensors(launches: Launches) -> None:
    assert launches.pedal.shape == launches.speed.shape == (1200, SAMPLES)
    assert launches.pedal.min() >= 0.0
    assert launches.pedal.max() <= 1.0
    assert (launches.pedal[:, :10] <= 0.01).all()  # they begin with the pedal released
    assert (launches.pedal[:, -1] > 0.02).all()  # and end with it pressed
    for trace in launches.pedal[::100]:
        steps = np.unique(np.round(np.abs(np.diff(np.unique(trace))), 9))
        assert steps[0] >= 0.001 - 1e-9  # quantised


def test_intention_sets_depth_and_rate_but_they_overlap(launches: Launches) -> None:
    depth = launches.pedal[:, -50:].mean(axis=1)
    medians = [np.median(depth[launches.intention == k]) for k in (SLOW, NORMAL, URGENT)]
    assert medians == pytest.approx([0.15, 0.235, 0.31], rel=0.08)
    for low, high in ((SLOW, NORMAL), (NORMAL, URGENT)):
        border = np.sqrt(medians[low] * medians[high])
        above = (depth[launches.intention == low] > border).mean()
        below = (depth[launches.intention == high] < border).mean()
        assert 0.03 < above < 0.3
        assert 0.03 < below < 0.3


def test_drivers_have_habits(launches: Launches) -> None:
    """Between drivers depths of one intention differ more than within one: their means would else be nearly equal."""
    depth = np.log(launches.pedal[:, -50:].mean(axis=1))
    for intention in (SLOW, NORMAL, URGENT):
        chosen = launches.intention == intention
        means = [depth[chosen & (launches.driver == n)].mean() for n in np.unique(launches.driver[chosen])]
        spread = depth[chosen].std()
        assert np.std(means) > 2.0 * spread / np.sqrt(20 / 3) * 0.8


def test_presses_come_in_stages_too(launches: Launches) -> None:
    assert 0.5 < launches.plain.mean() < 0.75
    rng = np.random.default_rng(0)
    driver = draw_driver(rng)
    time = 0.01 * np.arange(SAMPLES)
    for _ in range(20):
        pedal, plain = press(driver, NORMAL, 0.0, time, rng)
        if plain:
            peak = int(np.argmax(pedal))
            rising = pedal[:peak]
            assert (np.diff(rising[rising > 0.03]) > -0.01).all()


def test_reach_is_the_movement_of_least_jerk() -> None:
    time = np.linspace(0.0, 1.0, 1001)
    moved = reach(time, 0.2, 0.5)
    assert moved[time <= 0.2].max() == 0.0
    assert moved[time >= 0.7] == pytest.approx(1.0)
    assert np.gradient(moved, time).max() == pytest.approx(1.875 / 0.5, rel=1e-3)  # peak speed of least jerk


def test_a_rolling_driver_presses_less() -> None:
    time = 0.01 * np.arange(SAMPLES)
    driver = draw_driver(np.random.default_rng(1))
    depths = [press(driver, URGENT, v, time, np.random.default_rng(2))[0][-1] for v in (0.0, 1.5)]
    assert depths[1] == pytest.approx(0.85 * depths[0], rel=0.02)


def test_windows_begin_with_the_last_onset() -> None:
    pedal = np.zeros((1, 300))
    pedal[0, 20:40] = 0.05
    pedal[0, 60:] = 0.2
    found = windows(calibration(), pedal, np.zeros((1, 300)))
    assert found.intention.shape == (1, 200)
    assert found.inputs[0, 0, 0] == 0.2
    assert found.highest_pedal[0, 0] == 0.2
    assert found.inputs[0, 0, 1] == pytest.approx(20.0 * 0.01 / 0.04, rel=1e-2)
    with pytest.raises(ValueError, match="trace 0 ends with the pedal released"):
        windows(calibration(), np.zeros((1, 300)), np.zeros((1, 300)))


def test_rule_is_tuned_to_the_best_of_its_kind() -> None:
    rng = np.random.default_rng(5)
    truth = rng.integers(0, 3, 3000)
    pedal = 0.1 + 0.1 * truth + rng.uniform(-0.04, 0.04, 3000)
    rate = rng.uniform(0.0, 3.0, 3000)
    rule = tune_rule(pedal, rate, truth)  # the rate says nothing here
    assert (rule.lead, rule.accuracy) == (0.0, 1.0)
    assert 0.14 <= rule.normal <= 0.16
    assert 0.24 <= rule.urgent <= 0.26
    hidden = tune_rule(pedal - 0.2 * rate, rate, truth)  # here it says what the pedal hides
    assert hidden.lead == pytest.approx(0.2)
    assert np.array_equal(hidden.decide(pedal - 0.2 * rate, rate), truth)


def test_figures_count() -> None:
    launches = Launches(np.zeros(3), np.array([0, 1, 2]), np.array([True, False, True]), np.zeros(3), np.zeros(3))
    decided = np.array([[0, 0, 0, 0], [0, 0, 1, 1], [2, 2, 1, 1]])
    found = figures(decided, launches, first=1, opening=0)
    assert found.accuracy == pytest.approx(6 / 9)
    assert found.accuracy_at == pytest.approx([2 / 3, 2 / 3, 2 / 3, 2 / 3])
    assert found.plain_at.tolist() == [1.0, 1.0, 0.5, 0.5]
    assert found.settled == pytest.approx([0.01, 0.03, 0.03])
    assert found.last.tolist() == [[1, 0, 0], [0, 1, 0], [0, 1, 0]]
    assert confusion(np.array([2, 2]), np.array([1, 2])).tolist() == [[0, 0, 0], [0, 0, 1], [0, 0, 1]]


def test_kernel_scores_are_those_of_pytorch() -> None:
    """The file has what PyTorch made, in float64, of the shipped weights and of the first launches of the test."""
    reference = TRAINED["reference"]
    wanted = np.array(reference["scores"])
    launches = draw_launches(SEEDS["test"], 1, EACH)
    count = len(wanted)
    found = windows(calibration(), launches.pedal[:count], launches.speed[:count])
    assert np.abs(found.scores[:, reference["samples"]] - wanted).max() < 1e-6
    assert np.abs(wanted).max() > 1.0


@pytest.fixture(scope="module")
def assessed() -> dict[str, Any]:
    return assess(calibration("trained"), calibration("rule"))


def test_unseen_drivers_are_understood(assessed: dict[str, Any]) -> None:
    network, rule = assessed["network"], assessed["rule"]
    assert network["accuracy"] > LEAST_RIGHT
    assert network["accuracy"] > rule["accuracy"] + LEAST_GAIN
    assert np.sum(network["last"]) == DRIVERS["test"] * EACH
    last = np.array(network["last"])
    assert last[SLOW, URGENT] == last[URGENT, SLOW] == 0  # the far ends are not confused in the end


def test_no_more_can_be_told_in_the_end(assessed: dict[str, Any]) -> None:
    """Depth and rise time, known exactly, decide no better than the network at the end of its window.

    Their logarithms are normal with one covariance for all intentions, so the nearest median is the best decision.
    """
    spread = np.hypot([DEPTH_HABIT, RISE_HABIT], [DEPTH_CHANCE, RISE_CHANCE])
    medians = np.log([DEPTH, RISE]).T / spread
    truth = np.arange(300_000) % 3
    drawn = medians[truth] + np.random.default_rng(6).normal(size=(len(truth), 2))
    nearest = np.argmin([((drawn - median) ** 2).sum(axis=1) for median in medians], axis=0)
    best = (nearest == truth).mean()
    assert best == pytest.approx(0.89, abs=0.01)
    assert assessed["network"]["accuracy_at"][-1] == pytest.approx(best, abs=0.015)


def test_figures_that_ship_are_measured(assessed: dict[str, Any]) -> None:
    shipped = TRAINED["figures"]
    assert TRAINED["provenance"]["generator"].endswith(f"version {VERSION}")
    assert TRAINED["provenance"]["drivers"] == DRIVERS
    assert assessed["instants"] == shipped["instants"]
    for who in ("network", "rule"):
        for name, value in assessed[who].items():
            slack = 5.0 if name in ("first", "last") else 0.01  # launches; shares; s
            assert np.abs(np.array(value) - np.array(shipped[who][name])).max() <= slack, (who, name)


def test_network_beats_a_discriminant_without_memory(assessed: dict[str, Any]) -> None:
    training = draw_launches(SEEDS["training"], 100, EACH)
    known = windows(calibration(), training.pedal, training.speed)
    test = draw_lot("test", calibration())
    for place, sample in ((0, 27), (2, 79)):
        decided = discriminant(known, training.intention, test.windows, sample)
        assert 0.68 < (decided == test.launches.intention).mean() < assessed["network"]["accuracy_at"][place]


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--epochs", "0"], ["--epochs: got 0"]),
        (["--out", "no/such/file.yaml"], ["no/such/file.yaml", "folder is not there"]),
        ([], ["PyTorch is not installed", "pip install 'bitepoint[intent]'"]),
    ],
)
def test_training_refuses_before_it_begins(
    arguments: list[str], parts: list[str], refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["train", *arguments])
    monkeypatch.setitem(sys.modules, "torch", None)
    refused(train.main, *parts)


def test_picture_shows_shares_and_what_is_told(launches: Launches) -> None:
    network, rule = (windows(calibration(name), launches.pedal, launches.speed) for name in ("trained", "rule"))
    figure = intent_figure(launches, network, rule, [0, 1, 2])
    lines = {trace.name: trace for trace in figure.data if trace.name}
    assert set(lines) == {
        "network, one press", "network, others", "rule, one press", "rule, others", "slow", "normal", "urgent",
    }  # fmt: skip
    right = (network.intention == launches.intention[:, None])[launches.plain].mean(axis=0)
    assert lines["network, one press"].y == pytest.approx(100.0 * right)
    bands = [trace for trace in figure.data if trace.line.width == 9]
    told = sum(np.isfinite(trace.y).sum() for trace in bands)
    assert told == 3 * 2 * 200  # three launches, two bands, each sample told once
