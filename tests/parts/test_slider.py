"""Coulomb slider with spring and damper: continuity, signs of the losses, limits."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.parts.slider import slider_torque, twist_rate

STIFFNESS, DAMPING = 1400.0, 6.0
twists, speeds = st.floats(-1.0, 1.0), st.floats(-500.0, 500.0)


def law(capacity: float, twist: float, speed: float) -> tuple[float, float]:
    torque = float(slider_torque.run(STIFFNESS, DAMPING, capacity, twist, speed)[0])
    return torque, float(twist_rate.run(STIFFNESS, DAMPING, torque, twist)[0])


@given(st.floats(0.0, 1e3), twists, speeds)
def test_never_gives_energy(capacity: float, twist: float, speed: float) -> None:
    torque, rate = law(capacity, twist, speed)
    assert abs(torque) <= capacity
    slider, damper = torque * (speed - rate), DAMPING * rate**2
    stored = STIFFNESS * twist * rate
    assert slider >= -1e-6
    assert torque * speed == pytest.approx(slider + damper + stored, rel=1e-9, abs=1e-6)


@given(twists, speeds)
def test_sticks_below_its_capacity(twist: float, speed: float) -> None:
    torque, rate = law(1e4, twist, speed)
    assert torque == pytest.approx(STIFFNESS * twist + DAMPING * speed)
    assert rate == pytest.approx(speed, abs=1e-9)


def test_slides_at_its_capacity_either_way() -> None:
    assert law(100.0, 100.0 / STIFFNESS, 50.0) == pytest.approx((100.0, 0.0))
    assert law(100.0, 100.0 / STIFFNESS, -50.0) == pytest.approx((-100.0, -200.0 / DAMPING))


def test_open_lets_the_spring_relax() -> None:
    assert law(0.0, 0.3, 40.0) == pytest.approx((0.0, -STIFFNESS * 0.3 / DAMPING))
