"""The rational tanh against the library's, and the memory layer against its equations written with NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.kernels import Life
from bitepoint.numerics.activation import rational_logistic, rational_tanh
from bitepoint.numerics.lstm import (
    CLASSES,
    HIDDEN,
    INPUTS,
    LstmState,
    LstmWeights,
    highest_score,
    lstm_reset,
    lstm_step,
)
from bitepoint.records import RecordArray
from tests.conftest import OTHER_LIVES

EDGES = np.array([0.0, -0.0, 1e-300, -1e-9, 19.999, 20.0, 20.001, -700.0, 1e300, np.inf, -np.inf])
POINTS = np.concatenate([np.linspace(-25.0, 25.0, 20_001), EDGES])


def test_tanh_and_logistic_are_those_of_the_library() -> None:
    found = rational_tanh.run(POINTS)
    assert np.abs(found - np.tanh(POINTS)).max() < 1e-12
    assert np.abs(found).max() <= 1.0
    with np.errstate(over="ignore"):
        assert np.abs(rational_logistic.run(POINTS) - 1.0 / (1.0 + np.exp(-POINTS))).max() < 1e-12


def test_what_is_no_number_gives_the_lowest_value() -> None:
    assert rational_tanh.run(np.array([np.nan]))[0] == -1.0
    assert rational_logistic.run(np.array([np.nan]))[0] == 0.0


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_compute_the_same_bits(life: Life) -> None:
    points = POINTS[::10].copy() if life == "interpreted" else POINTS
    assert np.array_equal(rational_tanh.run(points), rational_tanh.run(points, life=life))


def random_weights(lanes: int) -> RecordArray:
    rng, weights = np.random.default_rng(8), LstmWeights.zeros(lanes)
    for name, field in LstmWeights.fields.items():
        weights[name] = rng.normal(0.0, 0.7, (lanes, *field.shape))
    return weights


def test_layer_follows_its_equations() -> None:
    weights, state = random_weights(20), LstmState.zeros(20)
    state["cells"], state["outputs"] = 5.0, 0.5  # reset must forget these
    lstm_reset.run(state)
    hidden, cells = np.zeros((20, HIDDEN)), np.zeros((20, HIDDEN))
    for inputs in np.random.default_rng(9).normal(0.0, 2.0, (30, 20, INPUTS)):
        state["inputs"] = inputs
        lstm_step.run(weights, state)
        gates = weights["biases"] + np.einsum("nij,nj->ni", weights["input_weights"], inputs)
        gates += np.einsum("nij,nj->ni", weights["recurrent_weights"], hidden)
        i, f, g, o = np.split(gates, 4, axis=1)
        cells = cells / (1.0 + np.exp(-f)) + np.tanh(g) / (1.0 + np.exp(-i))
        hidden = np.tanh(cells) / (1.0 + np.exp(-o))
        scores = weights["score_biases"] + np.einsum("nij,nj->ni", weights["score_weights"], hidden)
        assert state["scores"] == pytest.approx(scores, abs=1e-10)


def test_highest_score_is_the_first_of_the_highest() -> None:
    state = LstmState.zeros(5)
    state["scores"] = [[3.0, 1.0, 2.0], [1.0, 3.0, 2.0], [1.0, 2.0, 3.0], [2.0, 2.0, 2.0], [0.0, 1.0, 1.0]]
    assert highest_score.run(state).tolist() == [0, 1, 2, 0, 1]
    assert state["scores"].shape[1] == CLASSES
