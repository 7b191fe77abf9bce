"""Synthetic drivers: what each does with the accelerator pedal when setting off slowly, normally or urgently.

No log of pedals with intentions is to be had, so drivers are drawn. A press is a movement of least jerk (Flash and
Hogan, doi:10.1523/JNEUROSCI.05-07-01688.1985) to a depth within a rise time; the intention sets the medians of both,
the driver's habit and chance from launch to launch spread them, so that intentions overlap. Depths are those of the
library scenario. Rise times are chosen such that they cover a measured drive (OpenXC "Short drive", Ford): its presses
out of a released pedal take 0.12 to 0.5 s from 10 to 90 % of the depth, half of the movement's time, and a third of
them come in two stages. All other numbers are chosen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.recording import Floats

VERSION = 1
"""Of the generator: a change of what it draws asks for another training."""

DEPTH = (0.15, 0.235, 0.31)
"""Median depth for slow, normal and urgent, ratio."""

RISE = (0.60, 0.40, 0.26)
"""Median time of the movement, s."""

DEPTH_HABIT, DEPTH_CHANCE = 0.13, 0.09
RISE_HABIT, RISE_CHANCE = 0.20, 0.15
"""Standard deviations of the logarithms, between drivers and between launches of one."""

ROLLING_RELIEF = 0.1
"""Share of the depth that a driver spares per m/s at which the car rolls already, s/m."""

SHALLOWEST, DEEPEST = 0.04, 0.9


@dataclass(frozen=True)
class Driver:
    """Habits of one driver, and the sensors of the car.

    Attributes:
        depth, rise: factors on depth and rise time.
        dead_time: mean time from the start of the trace to the first movement, s.
        overshoot: mean share of the depth by which a press goes too far.
        settling: time constant with which that is taken back, s.
        hesitating: probability of a press in two stages.
        creeping: probability of letting the car creep under a resting foot before the press.
        tremor, tremor_frequency: amplitude (ratio) and frequency (Hz) of the foot's tremor.
        free_play: pedal travel before the sensor moves, ratio.
        offset: of the sensor, ratio.
        noise: standard deviation of the sensor, ratio.
        resolution: step of the sensor, ratio.
    """

    depth: float
    rise: float
    dead_time: float
    overshoot: float
    settling: float
    hesitating: float
    creeping: float
    tremor: float
    tremor_frequency: float
    free_play: float
    offset: float
    noise: float
    resolution: float


def draw_driver(rng: np.random.Generator) -> Driver:
    """Return a driver with habits of their own."""
    return Driver(
        depth=float(rng.lognormal(0.0, DEPTH_HABIT)),
        rise=float(rng.lognormal(0.0, RISE_HABIT)),
        dead_time=float(rng.uniform(0.15, 0.35)),
        overshoot=float(rng.uniform(0.0, 0.15)),
        settling=float(rng.uniform(0.1, 0.4)),
        hesitating=float(rng.uniform(0.0, 0.5)),
        creeping=float(rng.uniform(0.0, 0.4)),
        tremor=float(rng.uniform(0.0, 0.004)),
        tremor_frequency=float(rng.uniform(4.0, 10.0)),
        free_play=float(rng.uniform(0.0, 0.01)),
        offset=float(rng.uniform(-0.003, 0.003)),
        noise=float(rng.uniform(0.0003, 0.0015)),
        resolution=float(rng.choice([0.001, 0.002, 0.004])),
    )


def press(
    driver: Driver, intention: int, rolling: float, time: Floats, rng: np.random.Generator
) -> tuple[Floats, bool]:
    """Return the pedal under the driver's foot, ratio, over `time` (s, shape (n,)), and whether it is a plain press.

    A plain press is in one stage, out of a released pedal.

    Args:
        driver: who presses.
        intention: 0 slow, 1 normal, 2 urgent.
        rolling: speed at which the car rolls already, m/s.
        time: rising; the trace begins at rest.
        rng: chance.
    """
    depth = DEPTH[intention] * driver.depth * (1.0 - ROLLING_RELIEF * rolling) * rng.lognormal(0.0, DEPTH_CHANCE)
    depth = float(np.clip(depth, SHALLOWEST, DEEPEST))
    rise = RISE[intention] * driver.rise * rng.lognormal(0.0, RISE_CHANCE)
    start = driver.dead_time * rng.uniform(0.7, 1.3)
    pedal = np.zeros_like(time)
    creeping = rng.random() < driver.creeping
    if creeping:
        level, length = rng.uniform(0.015, 0.05), rng.uniform(0.2, 0.8)
        pedal += level * reach(time, start, 0.15)
        start += length
        depth -= level
    goal = depth * (1.0 + driver.overshoot * rng.uniform(0.0, 2.0))
    hesitating = rng.random() < driver.hesitating
    if hesitating:
        first, pause = rng.uniform(0.35, 0.65), rng.uniform(0.15, 0.5)
        pedal += goal * in_stages(time, start, rise, first, pause)
        end = start + 1.4 * rise + pause
    else:
        pedal += goal * reach(time, start, rise)
        end = start + rise
    pedal -= (goal - depth) * (1.0 - np.exp(-np.maximum(time - end, 0.0) / driver.settling))
    phase = rng.uniform(0.0, 2.0 * np.pi)
    tremor = driver.tremor * np.sin(2.0 * np.pi * driver.tremor_frequency * time + phase)
    return np.clip(pedal + np.where(pedal > 0.0, tremor, 0.0), 0.0, 1.0), not (creeping or hesitating)


def reach(time: Floats, start: float, length: float) -> Floats:
    """Return the movement of least jerk from 0 to 1 that begins at `start` and takes `length` (s)."""
    share = np.clip((time - start) / length, 0.0, 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def in_stages(time: Floats, start: float, rise: float, first: float, pause: float) -> Floats:
    """Return a movement to `first`, a pause, and the rest of the way to 1; either stage takes 0.7 of the rise time."""
    second = start + 0.7 * rise + pause
    return first * reach(time, start, 0.7 * rise) + (1.0 - first) * reach(time, second, 0.7 * rise)


def pedal_sensor(driver: Driver, pedal: Floats, rng: np.random.Generator) -> Floats:
    """Return what the pedal's sensor says of the pedal, ratio, shape (n,)."""
    moved = np.maximum(pedal - driver.free_play, 0.0) / (1.0 - driver.free_play)
    value = moved + driver.offset + rng.normal(0.0, driver.noise, len(pedal))
    return np.clip(np.round(value / driver.resolution) * driver.resolution, 0.0, 1.0)
