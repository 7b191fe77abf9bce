"""Launches of synthetic drivers: intention, pedal and vehicle speed at 100 Hz, as sensors give them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bitepoint.identification.intent.drivers import Driver, draw_driver, pedal_sensor, press
from bitepoint.recording import Floats

Integers = npt.NDArray[np.int64]

PERIOD = 0.01
SAMPLES = 400
"""Of a trace: 4 s, of which the first tenths are rest and the last 2 s belong to the held pedal."""

ROLLING_SHARE, FASTEST_ROLLING = 0.3, 2.5
"""Share of launches from a rolling car, and its highest speed, m/s."""

TOUCH = 0.28
"""Time from the pedal to the car's answer, s."""

SPEED_NOISE, SPEED_STEP, SLOWEST_SEEN = 0.015, 0.016, 0.25
"""Standard deviation, step and blind range of the wheel-speed sensors, m/s; chosen."""


@dataclass(frozen=True)
class Launches:
    """Launches of many drivers.

    Attributes:
        driver: number of the driver, shape (n,).
        intention: 0 slow, 1 normal, 2 urgent, shape (n,).
        plain: whether the press is in one stage and out of a released pedal, shape (n,).
        pedal: as its sensor says, ratio, shape (n, SAMPLES).
        speed: of the vehicle, m/s, shape (n, SAMPLES).
    """

    driver: Integers
    intention: Integers
    plain: npt.NDArray[np.bool_]
    pedal: Floats
    speed: Floats


def draw_launches(seed: int, drivers: int, each: int) -> Launches:
    """Return `each` launches of each of `drivers` drivers, intentions equally likely.

    The same seed gives the same launches; different seeds share no driver.
    """
    chance = [np.random.default_rng([seed, number]) for number in range(drivers)]
    traces = [_launches_of(draw_driver(rng), each, rng) for rng in chance]
    columns: list[Any] = [np.concatenate(column) for column in zip(*traces, strict=True)]
    return Launches(np.repeat(np.arange(drivers), each), *columns)


def _launches_of(driver: Driver, each: int, rng: np.random.Generator) -> tuple[Any, ...]:
    """Return intention, plain, pedal and speed."""
    time: Floats = PERIOD * np.arange(SAMPLES, dtype=np.float64)
    intentions = rng.integers(0, 3, each)
    rolling = np.where(rng.random(each) < ROLLING_SHARE, rng.uniform(0.2, FASTEST_ROLLING, each), 0.0)
    presses = [press(driver, int(intention), v, time, rng) for intention, v in zip(intentions, rolling, strict=True)]
    pedals, plain = np.array([pedal for pedal, _ in presses]), np.array([plain for _, plain in presses])
    seen = np.array([pedal_sensor(driver, pedal, rng) for pedal in pedals])
    return intentions, plain, seen, _speed_sensor(_speed(pedals, rolling, rng), rng)


def _speed(pedals: Floats, rolling: Floats, rng: np.random.Generator) -> Floats:
    """Return the vehicle speed, m/s: the car answers to the pedal of `TOUCH` ago, never backwards.

    Its gain (11 m/s^2 for a full pedal, as the library's launches have it, by mass and gear more or less) and the
    grade differ from launch to launch.
    """
    gain, grade = 11.0 * rng.lognormal(0.0, 0.15, len(pedals)), rng.normal(0.0, 0.3, len(pedals))
    delay = round(TOUCH / PERIOD)
    late = np.concatenate([np.zeros((len(pedals), delay)), pedals[:, :-delay]], axis=1)
    pull = gain[:, None] * late - np.where(late > 0.0, grade[:, None], 0.0)
    speed = np.zeros_like(pedals)
    speed[:, 0] = rolling
    for k in range(1, SAMPLES):
        speed[:, k] = np.maximum(speed[:, k - 1] + PERIOD * pull[:, k - 1], 0.0)
    return speed


def _speed_sensor(speed: Floats, rng: np.random.Generator) -> Floats:
    value = speed + rng.normal(0.0, SPEED_NOISE, speed.shape)
    value = np.round(value / SPEED_STEP) * SPEED_STEP
    return np.where(value < SLOWEST_SEEN, 0.0, value)
