"""Filters over whole signals."""

from __future__ import annotations

import math

from bitepoint.kernels import kernel
from bitepoint.records import FloatArray

PADDING = 9
"""Samples by which a signal is extended at each end before it is filtered (three times the filter's length)."""


@kernel(trusted=True)
def biquad(signal: FloatArray, first: int, count: int, step: int, k: float) -> None:
    """Filter `count` samples from `first` on in place, with stride `step`: order-2 Butterworth, k = tan(pi f / fs).

    It starts in the steady state of its first sample, so that a constant passes unchanged.
    """
    root = math.sqrt(2.0)
    norm = 1.0 / (1.0 + root * k + k * k)
    b = k * k * norm
    a1 = 2.0 * (k * k - 1.0) * norm
    a2 = (1.0 - root * k + k * k) * norm
    z1 = (1.0 - b) * signal[first]
    z2 = (b - a2) * signal[first]
    for n in range(count):
        x = signal[first + n * step]
        y = b * x + z1
        z1 = 2.0 * b * x - a1 * y + z2
        z2 = b * x - a2 * y
        signal[first + n * step] = y


@kernel(trusted=True)
def butterworth_forward_backward(samples: FloatArray, count: int, ratio: float, work: FloatArray) -> None:
    """Filter `count` samples in place without phase shift: order-2 Butterworth, forward and backward.

    Args:
        ratio: cut-off frequency over sampling frequency, 0 < ratio < 0.5.
        work: scratch for count + 18 samples.

    The signal is extended at both ends by its point reflection, and each pass starts in its steady state; this is
    what scipy.signal.filtfilt does by default, and a test holds it to that.
    """
    pad = min(PADDING, count - 1)
    for n in range(pad):
        work[n] = 2.0 * samples[0] - samples[pad - n]
        work[pad + count + n] = 2.0 * samples[count - 1] - samples[count - 2 - n]
    for n in range(count):
        work[pad + n] = samples[n]
    length = count + 2 * pad
    k = math.tan(math.pi * ratio)
    biquad(work, 0, length, 1, k)
    biquad(work, length - 1, length, -1, k)
    for n in range(count):
        samples[n] = work[pad + n]
