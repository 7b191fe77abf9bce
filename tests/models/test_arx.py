"""Difference models: what they predict, their files, and what is refused."""

import json

import numpy as np
import pytest

from bitepoint.errors import InputError
from bitepoint.models.arx import ArxModel

RNG = np.random.default_rng(1)


def model(errors: int = 0) -> ArxModel:
    return ArxModel(
        ("engine_speed", "slip"), ("clutch_torque",), ("engine_torque", "load_torque"), 0.01,
        np.array([[[0.9, 0.02], [0.01, 0.8]], [[0.05, 0.0], [0.0, 0.1]]]), RNG.normal(size=(1, 2, 1)),
        RNG.normal(size=(1, 2, 2)), RNG.normal(size=(errors, 2, 2)) * 0.1, {"data": "none"},
    )  # fmt: skip


def signals(rows: int = 50) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return RNG.normal(size=(rows, 2)), RNG.normal(size=(rows, 1)), RNG.normal(size=(rows, 2))


def test_one_step_prediction_is_the_equation() -> None:
    m = model()
    y, u, d = signals()
    by_hand = (
        y[1:-1] @ m.past_outputs[0].T + y[:-2] @ m.past_outputs[1].T
        + u[1:-1] @ m.past_inputs[0].T + d[1:-1] @ m.past_disturbances[0].T
    )  # fmt: skip
    assert np.allclose(m.one_step(y, u, d)[2:], by_hand, atol=1e-13)


@pytest.mark.parametrize("errors", [0, 1])
def test_free_run_from_data_of_the_model_itself_reproduces_them(errors: int) -> None:
    m = model(errors)
    y, u, d = signals()
    run = m.free_run(y, u, d)
    assert np.allclose(m.free_run(run, u, d), run, atol=1e-12)
    assert np.allclose(m.one_step(run, u, d), run, atol=1e-12)


def test_poles_are_those_of_the_matrix_polynomial() -> None:
    m = model()
    for pole in m.poles():
        polynomial = pole**2 * np.eye(2) - pole * m.past_outputs[0] - m.past_outputs[1]
        assert abs(np.linalg.det(polynomial)) < 1e-9
    assert (np.diff(np.abs(m.poles())) <= 1e-12).all()


@pytest.mark.parametrize("errors", [0, 2])
def test_file_round_trip(errors: int, tmp_path) -> None:
    m = model(errors)
    m.save(tmp_path / "model.json")
    again = ArxModel.load(tmp_path / "model.json")
    assert again.to_json() == m.to_json()
    assert again.orders == m.orders == (2, 1, 1, errors)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"model": "fuel"}, "model"),
        ({"past_outputs": [[[1.0]]]}, "complete"),
        ({"past_inputs": [[[float("nan")], [1.0]]]}, "finite"),
        ({"period": 0.0}, "period"),
    ],
)
def test_broken_file_is_refused_in_one_line(change, problem, tmp_path) -> None:
    path = tmp_path / "model.json"
    path.write_text(json.dumps(model().to_json() | change))
    with pytest.raises(InputError, match=problem) as caught:
        ArxModel.load(path)
    assert "\n" not in str(caught.value)


def test_missing_file_and_no_json(tmp_path) -> None:
    with pytest.raises(InputError, match="no such file"):
        ArxModel.load(tmp_path / "none.json")
    (tmp_path / "text.json").write_text("text")
    with pytest.raises(InputError, match="JSON"):
        ArxModel.load(tmp_path / "text.json")


def test_shapes_must_fit() -> None:
    with pytest.raises(ValueError, match="past_inputs"):
        ArxModel(
            ("a",), ("b",), (), 0.1, np.zeros((1, 1, 1)), np.zeros((1, 1, 2)), np.zeros((0, 1, 0)), np.zeros((0, 1, 1))
        )
