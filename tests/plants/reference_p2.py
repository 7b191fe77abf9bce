"""The tip-in of a P2 hybrid integrated by scipy, written from the equations alone: nothing of bitepoint is used."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

J1, J2, JW, K1, C1, K2, C2 = 0.28, 0.14, 4.0, 1400.0, 6.0, 7500.0, 100.0
RATIO, M, R, F, CDA, RHO, G = 10.5, 2000.0, 0.32, 0.012, 0.75, 1.2, 9.80665
B, C, E = 14.0, 1.6, 0.3
ENGINE_LAG = 0.05

PROFILE = [
    (0.0, 15.0), (1.0, 440.0), (2.2, -40.0), (6.0, 440.0), (6.5, 100.0), (9.6, 15.0), (19.6, -40.0), (34.0, 440.0),
    (35.0, -40.0), (39.0, 440.0), (42.0, -40.0),
]  # fmt: skip
RAMP = 39.0
"""From here to the next level the request falls by 160 N m/s."""


def request(t: float) -> float:
    """The driver's torque, N m: tip-ins and tip-outs."""
    start, level = [(time, value) for time, value in PROFILE if time <= t + 1e-9][-1]
    return max(-40.0, level - 160.0 * (t - start)) if start == RAMP else level


def tyre(slip: np.ndarray | float, mu: float) -> np.ndarray | float:
    """Force of the tyres, N."""
    z = B * slip
    return mu * M * G * np.sin(C * np.arctan(z - E * (z - np.arctan(z))))


def slip(wheel: np.ndarray | float, speed: np.ndarray | float) -> np.ndarray | float:
    return (R * wheel - speed) / np.maximum(np.abs(speed), 1.0)


def derivative(_t: float, x: np.ndarray, torque: Callable[[float], float], mu: float) -> list[float]:
    """dx/dt for x = [engine, motor, wheel speed, speed, clutch twist, half-shaft twist, engine torque]."""
    w1, w2, w3, v, th, phi, t1 = x
    clutch = K1 * th + C1 * (w1 - w2)
    y = w2 / RATIO - w3
    shaft = K2 * phi + C2 * y
    force = tyre(slip(w3, v), mu)
    return [
        (t1 - clutch) / J1,
        (clutch - shaft / RATIO) / J2,
        (shaft - R * (force + F * M * G)) / JW,
        (force - 0.5 * RHO * CDA * v * v) / M,
        w1 - w2,
        y,
        (torque(_t) - t1) / ENGINE_LAG,
    ]


def start(speed: float = 5.0, torque: float = 15.0) -> np.ndarray:
    wheel = speed / R
    return np.array([RATIO * wheel, RATIO * wheel, wheel, speed, torque / K1, torque * RATIO / K2, torque])


def integrate(end: float, mu: float = 1.05, raster: float = 0.002) -> tuple[np.ndarray, np.ndarray]:
    """Return the times on a raster and the states, shape (7, times), of the manoeuvre up to `end`, s."""
    edges = [*(time for time, _ in PROFILE if time < end), end]
    times, states, x = [np.zeros(1)], [start()[:, None]], start()
    for a, b in pairwise(edges):
        grid = np.arange(round(a / raster) + 1, round(b / raster) + 1) * raster
        inside = lambda t, a=a, b=b: request(min(max(t, a), b - 1e-6))  # noqa: E731
        exact = {"rtol": 1e-8, "atol": 1e-9, "max_step": 0.05}
        found = solve_ivp(derivative, (a, b), x, "Radau", t_eval=grid, args=(inside, mu), **exact)
        times.append(found.t)
        states.append(found.y)
        x = found.y[:, -1]
    return np.concatenate(times), np.hstack(states)


def acceleration(states: np.ndarray, mu: float = 1.05) -> np.ndarray:
    """Of the vehicle, m/s^2."""
    return (tyre(slip(states[2], states[3]), mu) - 0.5 * RHO * CDA * states[3] ** 2) / M


def torsional_speed(states: np.ndarray) -> np.ndarray:
    """w2 / i - w3, rad/s."""
    return states[1] / RATIO - states[2]


def modes() -> list[tuple[float, float]]:
    """Frequency, Hz, and damping of the two modes of engine, motor and vehicle, the tyres without slip."""
    inertia = JW + M * R**2
    a = np.zeros((5, 5))  # w1, th, w2, phi, w3
    a[0] = [-C1 / J1, -K1 / J1, C1 / J1, 0.0, 0.0]
    a[1] = [1.0, 0.0, -1.0, 0.0, 0.0]
    a[2] = [C1 / J2, K1 / J2, -(C1 + C2 / RATIO**2) / J2, -K2 / RATIO / J2, C2 / RATIO / J2]
    a[3] = [0.0, 0.0, 1.0 / RATIO, 0.0, -1.0]
    a[4] = [0.0, 0.0, C2 / RATIO / inertia, K2 / inertia, -C2 / inertia]
    return oscillations(a)


def oscillations(a: np.ndarray) -> list[tuple[float, float]]:
    """Frequency, Hz, and damping of each pair of eigenvalues of dx/dt = a x, the slowest first."""
    pairs = sorted((value for value in np.linalg.eigvals(a) if value.imag > 1e-6), key=abs)
    return [(abs(value) / (2.0 * np.pi), -value.real / abs(value)) for value in pairs]
