"""A drive of the conventional vehicle integrated by scipy, written from the equations alone.

Numbers are those of hatchback-2l, its fuel map apart, which is read from the file. Nothing of bitepoint is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator

JE, JP, JW, M, R, F, CDA, RHO, G = 0.18, 0.015, 3.6, 1474.0, 0.317, 0.0095, 0.295 * 2.26, 1.206, 9.80665
K1, C1, K2, C2, KB, CB = 1200.0, 6.0, 7500.0, 120.0, 3e4, 2000.0
RATIOS, FINAL, ETA = (3.917, 2.429, 1.436, 1.021, 0.867, 0.702), 4.06, 0.92
ENGINE_LAG, BRAKE_LAG, SHIFT_TIME, SYNCHRONISER = 0.1, 0.05, 0.2, 60.0
RPM = np.pi / 30.0
FULL = (np.array([0, 700, 1000, 1500, 2000, 3000, 4450, 5500, 6500]) * RPM, [0, 100, 140, 160, 172, 185, 198, 188, 165])
IDLE, IDLE_GAIN, D0, D1 = 800 * RPM, 2.5, 14.26, 0.0192
LAUNCH = 1200 * RPM

WAY = np.arange(0.0, 101.0, 2.0)
GRADE = 0.04 * np.sin(WAY / 15.0)
"""The road: grade over distance."""

PROGRAMME = [
    # from, engine, clutch, brake, gear
    (0.0, 120.0, 110.0, 0.0, 1), (2.5, 100.0, 300.0, 0.0, 1), (4.0, 5.0, 0.0, 0.0, 1), (4.2, 5.0, 0.0, 0.0, 2),
    (4.5, 130.0, 110.0, 0.0, 2), (5.5, 130.0, 300.0, 0.0, 2), (8.0, -30.0, 300.0, 800.0, 2), (10.0, 0.0, 0.0, 0.0, 2),
]  # fmt: skip
"""What is commanded from when on; a second gear is engaged SHIFT_TIME after it is asked for."""

START_SPEED, START_TORQUE = 5.0 / 3.6, 15.0
NAMES = (
    "engine_speed", "clutch_speed", "wheel_speed", "clutch_twist", "halfshaft_twist", "brake_twist", "engine_torque",
    "brake_torque", "distance", "elevation", "fuel_used",
)  # fmt: skip


def fuel_map() -> RegularGridInterpolator:
    """Fuel, kg/s, over engine speed, rad/s, and torque, N m."""
    here = Path(__file__).parents[2] / "src/bitepoint/vehicles/hatchback-2l.yaml"
    table: Mapping[str, Any] = yaml.safe_load(here.read_text("utf-8"))["engine"]["fuel"]
    grid = (np.array(table["speed"]["values"]) * RPM, np.array(table["torque"]["values"], float))
    return RegularGridInterpolator(grid, np.array(table["flow"]["values"]) * 1e-3)


FUEL = fuel_map()


def fuel(speed: float, torque: float) -> float:
    """Fuel, kg/s: that of the map, and below no torque a share that falls to 0 at the drag torque."""
    (w, t) = (np.clip(value, axis[0], axis[-1]) for value, axis in zip((speed, torque), FUEL.grid, strict=True))
    return float(FUEL((w, t))) * float(np.clip(1.0 + torque / (D0 + D1 * speed), 0.0, 1.0))


def slider(k: float, c: float, capacity: float, twist: float, speed: float) -> tuple[float, float]:
    """Torque and rate of the twist of a Coulomb slider in series with a spring and a damper."""
    torque = float(np.clip(k * twist + c * speed, -capacity, capacity))
    return torque, (torque - k * twist) / c


def derivative(_t: float, x: np.ndarray, u: tuple[float, float, float], gear: int, neutral: bool) -> list[float]:
    """dx/dt for the quantities of NAMES; u: commands of engine, clutch and brake."""
    w1, w2, w3, th, phi, psi, t1, tb, s, _, _ = x
    request, capacity, brake_command = u
    i = RATIOS[gear - 1] * FINAL
    drag = -(D0 + D1 * w1)
    governed = IDLE_GAIN * (IDLE - w1)
    wanted = governed if capacity <= 0.0 and request <= 0.0 else max(request, governed)
    wanted = float(np.clip(wanted, drag, np.interp(w1, *FULL)))
    clutch, clutch_rate = slider(K1, C1, capacity, th, w1 - w2)
    brake, brake_rate = slider(KB, CB, tb, psi, w3)
    y = w2 / i - w3
    shaft = 0.0 if neutral else K2 * phi + C2 * y
    loss = (1.0 / ETA - 1.0 if shaft > 0.0 else 1.0 - ETA) * abs(shaft)
    sync = SYNCHRONISER * float(np.clip((i * w3 - w2) / 5.0, -1.0, 1.0)) if neutral else 0.0
    angle = np.arctan(np.interp(s, WAY, GRADE))
    v = R * w3
    road = R * (M * G * (np.sin(angle) + F * np.cos(angle)) + 0.5 * RHO * CDA * v * v)
    return [
        (t1 - clutch) / JE,
        (clutch + sync - (shaft + loss) / i) / JP,
        (shaft - i * sync - brake - road) / (M * R * R + JW),
        clutch_rate,
        -phi / 0.01 if neutral else y,
        brake_rate,
        (wanted - t1) / ENGINE_LAG,
        (brake_command - tb) / BRAKE_LAG,
        v,
        v * np.sin(angle),
        fuel(w1, t1),
    ]


def integrate(end: float, raster: float = 0.01) -> np.ndarray:
    """The states on a raster up to `end`, shape (11, times)."""
    i = RATIOS[0] * FINAL
    wheel = START_SPEED / R
    x = np.array([LAUNCH, i * wheel, wheel, START_TORQUE / K1, START_TORQUE * i / K2, 0, START_TORQUE, 0, 0, 0, 0])
    phases = [(a, *rest, False) for a, *rest in PROGRAMME]
    shift = next(a for a, *_, gear in PROGRAMME if gear == 2)
    phases = [(*row[:-1], row[0] == shift) for row in phases]
    asked = next(row for row in phases if row[-1])
    phases.append((shift + SHIFT_TIME, *asked[1:-1], False))
    phases.sort(key=lambda row: row[0])
    states = [x[:, None]]
    for number, (a, *u, gear, neutral) in enumerate(phases):
        b = min(phases[number + 1][0] if number + 1 < len(phases) else end, end)
        if a >= end:
            break
        grid = np.arange(round(a / raster) + 1, round(b / raster) + 1) * raster
        exact = {"rtol": 1e-8, "atol": 1e-10, "max_step": 0.01}
        span = (a, max(b, grid[-1]))
        found = solve_ivp(derivative, span, x, "LSODA", t_eval=grid, args=(tuple(u), gear, neutral), **exact)
        states.append(found.y)
        x = found.y[:, -1]
    return np.hstack(states)
