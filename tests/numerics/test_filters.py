"""The forward-backward filter is scipy's, in every life, and has the properties that make it worth using."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from bitepoint.kernels import Life
from bitepoint.numerics.filters import PADDING, butterworth_forward_backward

REFERENCE = 1e-11
"""Relative to the largest sample: scipy solves for the steady state by elimination, this in closed form."""

RUNG_OUT = 1e-9
"""Share of the steady state that is left far from the ends, where the transients have died away."""

LIVES: tuple[Life, ...] = ("interpreted", "compiled")


def filtered(samples: np.ndarray, ratio: float = 0.1, life: Life = "compiled") -> np.ndarray:
    """Filter a copy of `samples`; what the scratch held before does not matter."""
    result = np.array(samples, float)
    work = np.full((*result.shape[:-1], result.shape[-1] + 2 * PADDING), np.nan)
    butterworth_forward_backward.run(result, result.shape[-1], ratio, work, life=life)
    return result


def reference(samples: np.ndarray, ratio: float = 0.1) -> np.ndarray:
    """What scipy does, by default where the signal is long enough for its padding."""
    b, a = butter(2, 2 * ratio)
    if len(samples) > PADDING:
        return filtfilt(b, a, samples)
    return filtfilt(b, a, samples, padlen=len(samples) - 1)


def assert_close(result: np.ndarray, expected: np.ndarray, scale: np.ndarray) -> None:
    assert np.abs(result - expected).max() <= REFERENCE * np.abs(scale).max()


@pytest.mark.parametrize("life", LIVES)
@pytest.mark.parametrize("length", [2, 3, 5, 9, 10, 11, 18, 19, 20, 57, 137, 500])
def test_it_is_scipys(life: Life, length: int) -> None:
    samples = np.random.default_rng(length).normal(0.0, 100.0, length)
    assert_close(filtered(samples, life=life), reference(samples), samples)


@pytest.mark.parametrize("ratio", [0.005, 0.02, 0.1, 0.25, 0.4, 0.49])
def test_it_is_scipys_at_every_cut_off(ratio: float) -> None:
    samples = np.random.default_rng(1).normal(5.0, 1.0, 200)
    tolerance = REFERENCE * max(1.0, (0.02 / ratio) ** 2)  # its poles come together at 1: each digit of ratio costs two
    assert np.abs(filtered(samples, ratio) - reference(samples, ratio)).max() <= tolerance * np.abs(samples).max()


@given(st.integers(10, 500), st.integers(0, 2**32 - 1))
def test_it_is_scipys_for_any_signal(length: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    samples = rng.normal(rng.normal(0.0, 100.0), rng.exponential(10.0), length) + rng.normal() * np.arange(length)
    assert_close(filtered(samples), reference(samples), samples)


def test_both_lives_give_the_same_bits() -> None:
    samples = np.random.default_rng(2).normal(0.0, 1.0, 300)
    assert filtered(samples, life="interpreted").tobytes() == filtered(samples, life="compiled").tobytes()


@pytest.mark.parametrize("life", LIVES)
@pytest.mark.parametrize("length", [1, 2, 9, 10, 100])
@pytest.mark.parametrize("level", [0.0, -3.25, 1e6])
def test_a_constant_passes_unchanged(life: Life, length: int, level: float) -> None:
    samples = np.full(length, level)
    assert_close(filtered(samples, life=life), samples, samples)


def test_a_ramp_passes_unchanged_far_from_the_ends() -> None:
    ramp = np.linspace(-1.0, 2.0, 400)
    assert filtered(ramp)[100:300] == pytest.approx(ramp[100:300], abs=RUNG_OUT)


@pytest.mark.parametrize("frequency", [1.0, 10.0, 40.0])
def test_a_wave_keeps_its_phase_and_is_damped_twice(frequency: float) -> None:
    time = np.arange(1000) / 100.0
    wave = np.cos(2 * math.pi * frequency * time + 0.7)
    warped = math.tan(math.pi * frequency / 100.0) / math.tan(math.pi * 0.1)  # 1 at the cut-off: a half passes there
    assert filtered(wave)[300:700] == pytest.approx(wave[300:700] / (1.0 + warped**4), abs=RUNG_OUT)


def test_a_pulse_stays_where_it_is() -> None:
    pulse = np.exp(-(((np.arange(401) - 200) / 6.0) ** 2))
    result = filtered(pulse)
    assert int(result.argmax()) == 200
    assert result == pytest.approx(result[::-1], abs=RUNG_OUT)
    assert result.sum() == pytest.approx(pulse.sum(), rel=RUNG_OUT)


def test_only_the_counted_samples_are_touched() -> None:
    samples = np.random.default_rng(3).normal(0.0, 1.0, 60)
    part = samples.copy()
    butterworth_forward_backward.run(part, 40, 0.1, np.empty(40 + 2 * PADDING))
    assert part[:40].tobytes() == filtered(samples[:40]).tobytes()
    assert part[40:].tobytes() == samples[40:].tobytes()


@pytest.mark.parametrize("life", LIVES)
def test_every_lane_is_filtered_for_itself(life: Life) -> None:
    lanes = np.random.default_rng(4).normal(0.0, 1.0, (5, 80))
    result = filtered(lanes, life=life)
    for lane, row in zip(lanes, result, strict=True):
        assert row.tobytes() == filtered(lane).tobytes()
