"""The generated integrator against closed forms, and its measured order."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from bitepoint.kernels import kernel
from bitepoint.numerics.integration import clearer, copier, runge_kutta_4
from bitepoint.records import Record, nested, quantity


class Spring(Record):
    """Parameters of an oscillator."""

    stiffness: float = quantity("1/s^2", 0, 1e6, "stiffness over mass")


class Mode(Record):
    """What is constant over a step."""

    force: float = quantity("m/s^2", -10, 10, "force over mass")


class Motion(Record):
    """What is integrated."""

    position: float = quantity("m", -10, 10, "position")
    speed: float = quantity("m/s", -10, 10, "speed")


class Work(Record):
    """Scratch."""

    stage: Motion = nested(Motion, "stage")
    slope: Motion = nested(Motion, "slope")
    sum: Motion = nested(Motion, "sum")


@kernel
def rates(p: Spring, m: Mode, x: Motion, d: Motion) -> None:
    """An undamped oscillator."""
    d.position = x.speed
    d.speed = m.force - p.stiffness * x.position


integrate = runge_kutta_4("integrate_spring", rates, Motion, Work)
copy = copier("copy_motion", Motion)
clear = clearer("clear_motion", Motion)


def run(h: float, life: str = "compiled", steps: int | None = None) -> np.ndarray:
    p, m, x, w = Spring.zeros(), Mode.zeros(), Motion.zeros(), Work.zeros()
    p["stiffness"], m["force"], x["position"] = 25.0, 1.0, 1.0
    for _ in range(round(1.0 / h) if steps is None else steps):
        integrate.run(p, m, x, w, h, life=life)  # pyright: ignore
    return x


def exact() -> float:
    return 1.0 / 25.0 + (1.0 - 1.0 / 25.0) * math.cos(5.0)


def test_order_is_four() -> None:
    errors = [abs(run(h)["position"][0] - exact()) for h in (0.02, 0.01, 0.005)]
    orders = [math.log2(a / b) for a, b in pairwise(errors)]
    assert all(3.8 < order < 4.3 for order in orders)


def test_absolute_error() -> None:
    assert run(0.005)["position"][0] == pytest.approx(exact(), abs=2e-8)  # h^4 w^5 t / 120 = 2e-8


def test_lives_agree_to_the_bit() -> None:
    assert run(0.01, steps=20).tobytes() == run(0.01, "interpreted", steps=20).tobytes()


def test_copy_and_clear() -> None:
    a, b = Motion.zeros(2), Motion.zeros(2)
    a["position"], a["speed"] = [1, 2], [3, 4]
    copy.run(b, a)
    assert b.tobytes() == a.tobytes()
    clear.run(a)
    assert not a.view(np.float64).any()
