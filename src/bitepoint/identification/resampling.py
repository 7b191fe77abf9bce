"""Signals with times of their own, to pieces between gaps on one raster.

A log that is finer than the raster is averaged first: what is faster than the raster would otherwise show as slow
motion that never was. A speed becomes its mean over the period around a time. A torque that acts from its row on
becomes the mean of that same mean over the period that follows: what a model with held inputs multiplies. All signals
pass the same filter, so that what is linear between them stays so, and none is late.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bitepoint.identification.readers import FileError
from bitepoint.recording import Floats

GAP = 3.0
"""A step of time longer than this many usual ones is a gap."""

LEAST_ROWS = 10
"""A piece between gaps with fewer rows is left out."""

MOST_ROWS = 20_000_000
"""Most rows of one run."""

FINER = 2.5
"""A signal with this many rows in a period of the raster, or more, is finer than it (chosen)."""

MOST_INVENTED = 20.0
"""Where even the finest signal has a step of more periods than this, its time is not what it says."""

PARTS = 20
"""Places in a period at which the mean of a mean is taken."""


@dataclass(frozen=True)
class Signal:
    """A signal on times of its own, s, rising; both of shape (n,). `held`: a value acts until the next row."""

    time: Floats
    values: Floats
    held: bool

    @property
    def step(self) -> float:
        """The usual step of time, s."""
        return float(np.median(np.diff(self.time)))


def is_finer(signals: Sequence[Signal], period: float) -> bool:
    """Return whether a signal is finer than the raster, so that all are averaged."""
    return any(signal.step * FINER <= period for signal in signals)


def pieces(signals: Sequence[Signal], period: float, where: str) -> list[tuple[Floats, Floats]]:
    """Return raster and data, shape (signals, rows), of each piece between gaps.

    Raises:
        FileError: the signals have no time in common, or too much of it, or are far too coarse for the raster.
    """
    finest = min(each.step for each in signals)
    if finest > MOST_INVENTED * period:
        mend = "a time in ms is named by --column time='NAME ms'"
        raise FileError(where, f"its rows are {finest:g} s apart, on a raster of {period:g} s", mend)
    start, end = max(float(each.time[0]) for each in signals), min(float(each.time[-1]) for each in signals)
    if end <= start:
        raise FileError(where, "its channels have no time in common", "expected channels that overlap")
    if (end - start) / period > MOST_ROWS:
        raise FileError(where, f"{end - start:g} s of log", f"expected at most {MOST_ROWS} rows")
    cuts = [(start, end)]
    for signal in signals:
        gaps = np.flatnonzero(np.diff(signal.time) > GAP * max(signal.step, period))
        cuts = [piece for cut in cuts for piece in _without(cut, signal.time[gaps], signal.time[gaps + 1])]
    finer, found = is_finer(signals, period), list[tuple[Floats, Floats]]()
    for first, last in cuts:
        if finer:  # what the means need beside the raster
            first, last = first + 0.5 * period, last - 1.5 * period
        raster = _raster(signals[0].time, first, last, period)
        if len(raster) >= LEAST_ROWS:
            rows = [averaged(s, raster, period) if finer else np.interp(raster, s.time, s.values) for s in signals]
            found.append((raster, np.array(rows)))
    return found


def averaged(signal: Signal, raster: Floats, period: float) -> Floats:
    """Return the means of a signal at the times of the raster, as said above, shape (rows,).

    Args:
        raster: times, s; the signal reaches half a period further back, and one and a half further on.
    """
    time, values = signal.time, signal.values
    step = np.diff(time)
    slope = np.zeros(len(step)) if signal.held else np.diff(values) / step
    integral = np.concatenate([[0.0], np.cumsum(step * (values[:-1] + 0.5 * slope * step))])

    def until(at: Floats) -> Floats:
        row = np.clip(np.searchsorted(time, at, "right") - 1, 0, len(step) - 1)
        since = at - time[row]
        return integral[row] + since * (values[row] + 0.5 * slope[row] * since)

    def around(at: Floats) -> Floats:
        return (until(at + 0.5 * period) - until(at - 0.5 * period)) / period

    if not signal.held:
        return around(raster)
    return sum((around(raster + (n + 0.5) / PARTS * period) for n in range(PARTS)), np.zeros(len(raster))) / PARTS


def _without(cut: tuple[float, float], begins: Floats, ends: Floats) -> list[tuple[float, float]]:
    """Return what is left of a span of time without the gaps."""
    left: list[tuple[float, float]] = []
    first, last = cut
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        if begin < last and end > first:
            left.append((first, min(begin, last)))
            first = end
    left.append((first, last))
    return [(a, b) for a, b in left if b > a]


def _raster(time: Floats, first: float, last: float, period: float) -> Floats:
    """Return the raster of a piece; it begins at a row of the first channel, so that rows on the raster stay rows."""
    inside = time[(time >= first - 1e-9) & (time <= last + 1e-9)]
    start = max(float(inside[0]), first) if inside.size else first
    rows = int(np.floor((last - start) / period + 1e-6)) + 1
    return start + period * np.arange(max(rows, 0), dtype=np.float64)
