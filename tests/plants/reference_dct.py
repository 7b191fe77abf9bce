"""The launch of docs/plants.md integrated by scipy, written from the equations alone: nothing of bitepoint is used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

M, R, F, CD, A, ETA, RHO, G = 1600.0, 0.289, 0.018, 0.32, 2.04, 0.93, 1.206, 9.80665
IE, LAMBDA, I1, CE = 0.25, 0.03, 0.0056, 0.02
I3, I4, I5, I6 = 0.006, 0.006, 0.008, 1.6
G1, G2, GA = 3.2562, 1.7064, 4.4705
K1, C1, KO, CO = 4000.0, 13.6, 16300.0, 311.0
RATIO = G1 * GA
JE = IE + LAMBDA
J6 = I6 + RATIO**2 * (I3 + I5 / G1**2 + I4 * (G2 / G1) ** 2)
JV = M * R**2
RPM = np.array([0, 600, 800, 1000, 1200, 1600, 2000, 3500, 4000, 4500, 5000, 6000, 7000.0]) * np.pi / 30
WOT = np.array([0, 90, 120, 145, 170, 225, 240, 240, 238, 225, 205, 170, 120.0])
LOSS_FADE = 0.05  # the gears' loss fades below this axle speed, rad/s


def engine(throttle: float, w: float) -> float:
    """T' of page 1."""
    drag = 10.0 + 0.04 * w
    filling = 1.0 - np.exp(-4.5 * throttle**1.2 * (200.0 / max(w, 30.0)) ** 0.8)
    return (np.interp(w, RPM, WOT) + drag) * filling - drag


def road(grade: float) -> tuple[float, float]:
    """Grade and rolling torque at the wheel."""
    angle = np.arctan(grade)
    return M * G * np.sin(angle) * R, F * M * G * np.cos(angle) * R


@dataclass
class Input:
    """Constant over its duration."""

    duration: float
    throttle: float
    capacity: float


def axle_torques(x: np.ndarray) -> tuple[float, float, float]:
    """Damper torque, half-shaft torque, and what reaches the axle from the gears."""
    _, w1, w6, wv, th1, tho = x
    damper = K1 * th1 + C1 * (w1 - RATIO * w6)
    shaft = KO * tho + CO * (w6 - wv)
    lossless = RATIO * damper
    share = 1.0 - ETA if lossless * w6 > 0.0 else 1.0 / ETA - 1.0
    loss = share * abs(lossless) * np.clip(w6 / LOSS_FADE, -1.0, 1.0)
    return damper, shaft, lossless - loss


def derivative(x: np.ndarray, u: Input, grade: float, locked: bool, held: bool) -> np.ndarray:
    """dx/dt for x = [engine, plate, axle, wheel speed, damper twist, half-shaft twist]."""
    we, w1, w6, wv, _, _ = x
    damper, shaft, driven = axle_torques(x)
    climb, rolling = road(grade)
    drive = engine(u.throttle, we) - CE * we
    if locked:
        dwe = dw1 = (drive - damper) / (JE + I1)
    else:
        dwe, dw1 = (drive - u.capacity) / JE, (u.capacity - damper) / I1
    air = 0.5 * RHO * CD * A * (R * wv) ** 2 * R
    dwv = 0.0 if held else (shaft - climb - rolling - air) / JV
    return np.array([dwe, dw1, (driven - shaft) / J6, dwv, w1 - RATIO * w6, w6 - wv])


def integrate(inputs: Sequence[Input], grade: float) -> tuple[np.ndarray, float | None, float | None]:
    """Return the state at the end, the time of release and the time of lock; events are located by the integrator."""
    x, t, locked, held = np.array([83.0, 0, 0, 0, 0, 0]), 0.0, False, True
    release: float | None = None
    lock: float | None = None
    climb, rolling = road(grade)
    for u in inputs:
        end = t + u.duration
        while t < end - 1e-12:
            slip = lambda _t, x: x[0] - x[1]  # noqa: E731
            pull = lambda _t, x: axle_torques(x)[1] - climb - rolling  # noqa: E731
            slip.direction, pull.direction = -1, 1  # type: ignore[attr-defined]
            slip.terminal = pull.terminal = True  # type: ignore[attr-defined]
            if held and pull(t, x) > 0.0:  # released before it starts: a road that falls by more than it holds
                held, release = False, t
            events = ([] if locked else [slip]) + ([pull] if held else [])
            rhs = lambda _t, x, u=u, a=locked, b=held: derivative(x, u, grade, a, b)  # noqa: E731
            result = solve_ivp(rhs, (t, end), x, "DOP853", rtol=1e-9, atol=1e-10, events=events, max_step=0.01)
            t, x = float(result.t[-1]), result.y[:, -1]
            if result.status == 1 and held and abs(pull(t, x)) < 1e-3:
                held, release = False, t
            elif result.status == 1:
                locked, lock = True, t
                x[0] = x[1] = (JE * x[0] + I1 * x[1]) / (JE + I1)
    return x, release, lock
