"""The log of a launch: what a test car with torque sensors would have written while its clutch slipped."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from bitepoint.recording import Channel, Recording

CHANNELS = (
    Channel("engine_speed", "rad/s", "engine speed, with noise"),
    Channel("wheel_speed", "rad/s", "speed of the driven wheels, with noise"),
    Channel("slip", "rad/s", "engine speed minus overall ratio times wheel speed, both as logged"),
    Channel("clutch_torque", "N*m", "torque of clutch 1 from this row on"),
    Channel("engine_torque", "N*m", "engine torque from this row on"),
    Channel("load_torque", "N*m", "road torque at the wheels from this row on: grade, rolling and air resistance"),
)
"""What a log holds beside time."""

LEAST_ROWS = 20
"""A run with fewer rows is no log."""


def slip_rows(recording: Recording, every: int) -> npt.NDArray[np.intp]:
    """Return the rows of a recording that are logged, indices of every `every`-th row.

    They run from where the vehicle first moves until the clutch locks, without a break, and while the engine is not
    slower than at the beginning of the recording, its idle speed.
    """
    moving = (recording["vehicle_held"] < 0.5) & (recording["wheel_speed"] > 0.0)
    slipping = moving & (recording["clutch_locked"] < 0.5)
    slipping &= recording["engine_speed"] >= recording["engine_speed"][0] - 1e-6
    rows = np.arange(0, len(recording.time) - 1, every)
    good = slipping[rows] & slipping[rows + 1]
    if not good.any():
        return rows[:0]
    first = int(np.argmax(good))
    length = int(np.argmin(good[first:])) if not good[first:].all() else len(good) - first
    return rows[first : first + length]


def slip_log(recording: Recording, ratio: float, period: float, noise: float, seed: tuple[int, int]) -> Recording:
    """Return the log of a recorded launch, `CHANNELS` on a raster of `period`; empty where the clutch never slipped.

    A row holds the speeds at its time, and the torques that act from then on (one tick later, so that a torque that
    the controller changes at this time counts for the step that it acts in).

    Args:
        recording: of one run, on the raster of the plant.
        ratio: overall ratio of the engaged gear.
        period: raster, s, a multiple of that of the recording.
        noise: standard deviation of the noise, rad/s, on the engine speed, and on the wheel speed times the ratio.
        seed: of the noise.
    """
    every = max(round(period / float(recording.time[1] - recording.time[0])), 1)
    rows = slip_rows(recording, every)
    rng = np.random.default_rng([*seed, 2])
    errors = noise * rng.standard_normal((2, len(rows)))
    engine = recording["engine_speed"][rows] + errors[0]
    wheel = recording["wheel_speed"][rows] + errors[1] / ratio
    torques = [recording[name][rows + 1] for name in ("clutch_torque", "engine_torque", "road_torque")]
    data = np.array([engine, wheel, engine - ratio * wheel, *torques])
    return Recording(recording.time[rows], CHANNELS, data, {**recording.about, "ratio": f"{ratio:.9g}"})
