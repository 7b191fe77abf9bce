"""The actuator of a clutch: torque from pressure and back, friction over slip and temperature, in every life."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.kernels import Life
from bitepoint.parts.clutch_actuator import (
    LEAST_FADE,
    ClutchActuator,
    clutch_friction,
    clutch_temperature,
    fill_rate,
    friction_steepness,
    pressure_for_torque,
    torque_from_pressure,
)
from tests.conftest import OTHER_LIVES

DEFAULT = ClutchActuator.parse({}, "test")


def actuator(**values: object) -> np.ndarray:
    return ClutchActuator.parse(values, "test")


@given(
    torque=st.floats(0, 1e4),
    friction=st.floats(0.01, 1),
    area=st.floats(1e-4, 1),
    spring=st.floats(0, 1e5),
    faces=st.integers(1, 100),
)
def test_pressure_for_a_torque_gives_that_torque(
    torque: float, friction: float, area: float, spring: float, faces: int
) -> None:
    a = actuator(piston_area=area, spring_force=spring, faces=faces)
    pressure = pressure_for_torque.run(a, friction, torque)
    leverage = faces * friction * 0.07
    assert torque_from_pressure.run(a, friction, pressure)[0] == pytest.approx(
        torque, rel=1e-12, abs=1e-14 * leverage * spring + 1e-12
    )


def test_torque_is_that_of_the_formula_and_none_below_the_kiss_point() -> None:
    assert torque_from_pressure.run(DEFAULT, 0.13, 1e6)[0] == pytest.approx(8 * 0.13 * 0.07 * (1e6 * 0.0042 - 800))
    kiss = 800 / 0.0042
    assert torque_from_pressure.run(DEFAULT, 0.13, np.array([0.0, 0.5 * kiss, -1e6])).tolist() == [0.0, 0.0, 0.0]
    idle = pressure_for_torque.run(DEFAULT, 0.13, np.array([0.0, -50.0, np.nan]))
    assert idle == pytest.approx(np.full(3, kiss))


def test_friction_goes_from_static_to_sliding_and_fades_with_temperature() -> None:
    reference = float(DEFAULT["reference_temperature"][0])
    slip = np.array([0.0, 5.0, -5.0, 1e6, -1e6])
    expected = [0.115, 0.13 - 0.015 / np.e, 0.13 - 0.015 / np.e, 0.13, 0.13]
    assert clutch_friction.run(DEFAULT, reference, slip) == pytest.approx(expected)
    assert clutch_friction.run(DEFAULT, reference + 50.0, 1e6)[0] == pytest.approx(0.13 * 0.95)
    assert clutch_friction.run(DEFAULT, 1e9, 1e6)[0] == pytest.approx(0.13 * LEAST_FADE)
    assert clutch_temperature.run(DEFAULT, 6000.0)[0] == pytest.approx(363.15 + 6.0)


def test_the_bound_of_the_steepness_holds_and_is_not_far() -> None:
    slip = np.linspace(0.0, 30.0, 3001)
    reference = float(DEFAULT["reference_temperature"][0])
    friction = clutch_friction.run(DEFAULT, reference, slip)
    steepest = np.abs(np.diff(friction) / np.diff(slip)).max() / 0.13
    bound = friction_steepness.run(DEFAULT)[0]
    assert steepest <= bound <= 2.1 * steepest


def test_pressure_moves_towards_its_command() -> None:
    rates = fill_rate.run(actuator(fill_time="100 ms"), 5e5, np.array([0.0, 5e5, 9e5]))
    assert rates == pytest.approx([5e6, 0.0, -4e6])


def test_a_file_gives_it_in_any_unit() -> None:
    a = actuator(active=1, temperature="120 degC", piston_area="40 cm^2", fill_time="80 ms")
    assert a["temperature"][0] == pytest.approx(393.15)
    assert a["piston_area"][0] == pytest.approx(0.004)


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_lives_agree_to_the_bit(life: Life) -> None:
    rng = np.random.default_rng(3)
    lanes = 200
    a = np.repeat(DEFAULT, lanes)
    a["slip_scale"] = rng.uniform(0.1, 20, lanes)
    a["temperature_slope"] = rng.uniform(-0.02, 0.02, lanes)
    edges = [np.nan, np.inf, -np.inf, 0.0, -0.0, 1e300]
    slip, temperature, pressure = rng.normal(0, 50, lanes), rng.uniform(250, 700, lanes), rng.uniform(0, 2e6, lanes)
    for values in (slip, temperature, pressure):
        values[rng.integers(0, lanes, len(edges))] = edges
    for kernel, arguments in (
        (clutch_friction, (a, temperature, slip)),
        (torque_from_pressure, (a, 0.12, pressure)),
        (pressure_for_torque, (a, 0.12, slip)),
        (fill_rate, (a, pressure, slip)),
        (friction_steepness, (a,)),
    ):
        one, other = kernel.run(*arguments), kernel.run(*arguments, life=life)
        assert np.array_equal(one, other, equal_nan=True), kernel.name
