"""Fuel, or what a steady map leaves of it, as a polynomial in speed and acceleration: a `TransientCorrection`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.identification.fuel.drives import Drive
from bitepoint.identification.fuel.regression import clipped_least_squares
from bitepoint.models.fuel import MEDIAN_SPEED, TERMS, TransientCorrection
from bitepoint.recording import Floats
from bitepoint.records import Curve, RecordArray

HULL_POINTS = 12
"""Speeds at which the fitted region of accelerations is kept."""

OPEN = 20.0
"""Acceleration that stands for none in an open region, m/s^2: the widest that a record holds."""

OPEN_SPEED = 1.5
"""An open region reaches to so many times the highest fitted speed (chosen)."""

RIDGE = 1.0
"""Weight of the coefficients of a correction, each scaled to its column, against the mean square error (chosen)."""


@dataclass(frozen=True)
class Family:
    """A family of polynomials.

    Attributes:
        terms: powers (i, j) of speed and acceleration.
        split: with coefficients of their own for a < 0.
        open_above: not held at the edge of the fitted region towards higher speeds and accelerations.
    """

    name: str
    terms: tuple[tuple[int, int], ...]
    split: bool = False
    open_above: bool = False


def _total(degree: int) -> tuple[tuple[int, int], ...]:
    return tuple((i, j) for i in range(degree + 1) for j in range(degree + 1 - i))


POWER = Family("power", ((0, 0), (1, 0), (2, 0), (3, 0), (1, 1), (2, 1), (1, 2)), open_above=True)
"""Idling, road load, m v a, and that fuel rises faster than power: bounded by what it is made of, so left open."""

PLAIN = (
    POWER,
    Family("quadratic", _total(2)),
    Family("quadratic, split at a = 0", _total(2), split=True),
    Family("cubic", _total(3)),
    Family("cubic, split at a = 0", _total(3), split=True),
)
"""What a plain model may be."""

CORRECTIONS = (
    Family("linear", _total(1), split=True),
    Family("quadratic", _total(2), split=True),
    Family("cubic", _total(3), split=True),
)
"""What a correction beside a steady map may be."""


def columns(family: Family, speed: Floats, acceleration: Floats) -> Floats:
    """Return the powers of the family, shape (n, terms), or (n, 2 terms) where it is split."""
    powers = np.stack([speed**i * acceleration**j for i, j in family.terms], axis=1)
    if not family.split:
        return powers
    rising = (acceleration >= 0.0)[:, None]
    return np.hstack([powers * rising, powers * ~rising])


def no_correction(drive: Drive) -> RecordArray:
    """Return the correction that is nothing."""
    return _region(TransientCorrection.zeros(), drive, Family("", ()))


def fit_plain(family: Family, drive: Drive) -> RecordArray:
    """Return the plain fuel of a family, least squares of max(0, polynomial)."""
    found = clipped_least_squares(columns(family, drive.speed, drive.acceleration), drive.fuel)
    return _record(family, found, drive)


def fit_correction(family: Family, drive: Drive, steady: Floats) -> RecordArray:
    """Return the correction of a family beside a steady fuel, kg/s, shape (n,), with its medians.

    The coefficients are pulled towards zero: see `RIDGE`.
    """
    left, low = drive.fuel - steady, drive.speed <= MEDIAN_SPEED
    medians = [float(np.median(left[where])) if where.any() else 0.0 for where in (low, ~low)]
    left = left - np.where(low, *medians)
    x = columns(family, drive.speed, drive.acceleration)
    scale = np.sqrt(np.mean(x**2, axis=0))
    scale[scale == 0.0] = 1.0
    x = x / scale
    squares = x.T @ x + RIDGE * len(x) * np.eye(x.shape[1])
    found = np.asarray(np.linalg.solve(squares, x.T @ left), np.float64) / scale
    record = _record(family, found, drive)
    record["low_median"], record["high_median"] = medians
    return record


def _record(family: Family, coefficients: Floats, drive: Drive) -> RecordArray:
    rising, falling = np.zeros((TERMS, TERMS)), np.zeros((TERMS, TERMS))
    half = len(family.terms) if family.split else 0
    for n, (i, j) in enumerate(family.terms):
        rising[i, j], falling[i, j] = coefficients[n], coefficients[n + half]
    record = TransientCorrection.zeros()
    record["rising"], record["falling"] = rising, falling
    return _region(record, drive, family)


def _region(record: RecordArray, drive: Drive, family: Family) -> RecordArray:
    """Write the fitted region: lowest and highest acceleration around some speeds."""
    top = float(drive.speed.max())
    speeds = np.linspace(0.0, top, HULL_POINTS)
    near = [np.abs(drive.speed - each) <= speeds[1] for each in speeds]
    lowest = np.array([drive.acceleration[each].min() if each.any() else 0.0 for each in near])
    highest = np.array([drive.acceleration[each].max() if each.any() else 0.0 for each in near])
    lowest, highest = np.minimum(lowest, 0.0), np.maximum(highest, 0.0)
    if family.open_above:
        speeds, lowest = np.append(speeds, OPEN_SPEED * top), np.append(lowest, lowest[-1])
        highest = np.full(len(speeds), OPEN)
    record["lowest"] = Curve.through(speeds.tolist(), lowest.tolist())[0]
    record["highest"] = Curve.through(speeds.tolist(), highest.tolist())[0]
    return record
