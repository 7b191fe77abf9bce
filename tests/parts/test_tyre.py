"""Magic Formula: peak, slope, symmetry, shifts."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.parts.tyre import Tyre, slip_stiffness, tyre_force, tyre_slip, weight_across, weight_along

LOAD = 19_613.0


def tyre(**values: float) -> np.ndarray:
    return Tyre.parse({"wheel_inertia": 4.0, **values}, "test")


def test_peak_slope_and_symmetry() -> None:
    slips = np.linspace(0.0, 3.0, 30_001)
    forces = tyre_force.run(tyre(), 0.8, LOAD, slips)
    assert forces.max() == pytest.approx(0.8 * LOAD, rel=1e-6)
    assert 0.05 < slips[forces.argmax()] < 0.2
    assert forces[1] / slips[1] == pytest.approx(slip_stiffness.run(tyre(), 0.8, LOAD)[0], rel=1e-3)
    assert np.diff(forces).max() / slips[1] <= slip_stiffness.run(tyre(), 0.8, LOAD)[0]
    assert forces[-1] < 0.75 * forces.max()
    assert tyre_force.run(tyre(), 0.8, LOAD, -slips) == pytest.approx(-forces)


def test_shifts_move_the_curve() -> None:
    plain = tyre_force.run(tyre(), 1.0, LOAD, np.array([0.03]))[0]
    shifted = tyre(horizontal_shift=0.01, vertical_shift=-0.02)
    assert tyre_force.run(shifted, 1.0, LOAD, np.array([0.02]))[0] == pytest.approx(plain - 0.02 * LOAD)


def test_slip_is_related_to_the_speed_or_to_1_metre_per_second() -> None:
    assert tyre_slip.run(np.array([11.0, 1.1, -11.0]), 1.0, np.array([10.0, 0.1, -10.0])) == pytest.approx(
        [0.1, 1, -0.1]
    )


def test_weight_on_a_grade() -> None:
    assert weight_along.run(2000.0, 0.75)[0] == pytest.approx(2000 * 9.80665 * 0.6)
    assert weight_across.run(2000.0, 0.75)[0] == pytest.approx(2000 * 9.80665 * 0.8)
