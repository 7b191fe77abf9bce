"""Rows to fit on: the motion of a run beside its fuel, and the outliers of all runs found by their specific power."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from bitepoint.identification.fuel.logs import ENGINE, FUEL, GRADE, SPEED
from bitepoint.recording import Floats, Recording
from bitepoint.units import STANDARD_GRAVITY

SPAN = 1.0
"""Time over which the speed is differenced, s."""

VSP_BIN = 2.0
"""Width of a bin of specific power, kW/t."""

SIGMAS = 3.0
"""A row farther from the mean of its bin than this many standard deviations is dropped."""

REACH = 10
"""In a bin of so many rows or fewer no row can be farther off than three standard deviations, (n - 1)/sqrt(n)."""

ASKED = 30
"""Rows of a bin from which on the rule is worth something."""

Rows = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Drive:
    """Rows of one or more runs.

    Attributes:
        fuel: kg/s, shape (n,); speed: m/s; acceleration: m/s^2; grade: rise over run.
        engine: speed (rad/s) and torque (N m) where they are logged.
        run: number of the run of each row; time: s, in the time of its log.
    """

    fuel: Floats
    speed: Floats
    acceleration: Floats
    grade: Floats
    engine: tuple[Floats, Floats] | None
    run: npt.NDArray[np.int64]
    time: Floats

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.fuel)

    def rows(self, which: Rows) -> Drive:
        """Return some of the rows."""
        engine = None if self.engine is None else (self.engine[0][which], self.engine[1][which])
        return Drive(
            self.fuel[which], self.speed[which], self.acceleration[which], self.grade[which], engine, self.run[which],
            self.time[which],
        )  # fmt: skip

    @property
    def specific_power(self) -> Floats:
        """Vehicle specific power, kW/t: v (1.1 a + 9.81 grade + 0.132) + 0.000302 v^3, shape (n,)."""
        v = self.speed
        return v * (1.1 * self.acceleration + STANDARD_GRAVITY * self.grade + 0.132) + 0.000302 * v**3


def motion(recording: Recording, delay: float) -> tuple[Floats, Floats]:
    """Return speed, m/s, and acceleration, m/s^2, shape (n,), `delay` (s) after the time of each row.

    The speed is linear between its rows; the acceleration is its centred difference over a second. Fuel that precedes
    the motion, as a throttle does, has a positive delay.
    """
    time = recording.time + delay

    def speed(at: Floats) -> Floats:
        return np.interp(at, recording.time, recording[SPEED.name])

    return speed(time), (speed(time + 0.5 * SPAN) - speed(time - 0.5 * SPAN)) / SPAN


def joined(recordings: Sequence[Recording], delay: float) -> Drive:
    """Return the rows of all runs; nothing is differenced across two of them."""
    moved = [motion(recording, delay) for recording in recordings]
    names = recordings[0]
    parts: dict[str, Floats] = {
        name: np.concatenate([recording[name] for recording in recordings])
        for name in (FUEL.name, GRADE.name, *(channel.name for channel in ENGINE))
        if name in names
    }
    fuel = parts[FUEL.name]
    engine = tuple(parts[channel.name] for channel in ENGINE if channel.name in parts)
    return Drive(
        fuel,
        np.concatenate([speed for speed, _ in moved]),
        np.concatenate([acceleration for _, acceleration in moved]),
        parts.get(GRADE.name, np.zeros(len(fuel))),
        (engine[0], engine[1]) if len(engine) == len(ENGINE) else None,
        np.repeat(np.arange(len(recordings)), [len(recording.time) for recording in recordings]),
        np.concatenate([recording.time for recording in recordings]),
    )


@dataclass(frozen=True)
class Bin:
    """A bin of specific power: its lower edge, kW/t, its rows, mean and standard deviation of their fuel, kg/s."""

    edge: float
    rows: int
    mean: float
    deviation: float


def vsp_outliers(drive: Drive) -> tuple[Rows, list[Bin]]:
    """Return which rows are farther from the mean of their bin than three standard deviations, and the bins.

    The standard deviation has n - 1 in its denominator and counts the row itself: in a bin of 10 rows or fewer the rule
    cannot fire, whatever the row is.
    """
    number = np.floor(drive.specific_power / VSP_BIN)
    out = np.zeros(len(drive), bool)
    bins: list[Bin] = []
    for each in np.unique(number):
        inside = number == each
        fuel = drive.fuel[inside]
        deviation = float(fuel.std(ddof=1)) if len(fuel) > 1 else 0.0
        bins.append(Bin(float(each) * VSP_BIN, len(fuel), float(fuel.mean()), deviation))
        if len(fuel) > REACH:
            out[inside] = np.abs(fuel - fuel.mean()) > SIGMAS * deviation
    return out, bins
