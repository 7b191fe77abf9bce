"""Driving cycles: the segments are those of the regulation, by its own totals and by an independent table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bitepoint.scenarios.cycles import CYCLES, ECE_15, EUDC, Segment, accelerations, cycle_trace
from tests.conftest import Refused


@pytest.mark.parametrize(
    ("name", "duration", "distance", "highest"),
    [("ece-15", 195, 4052 / 4, 50), ("eudc", 400, 6955, 120), ("nedc", 1180, 11_007, 120)],
)
def test_totals_are_the_published_ones(name: str, duration: float, distance: float, highest: float) -> None:
    time, speed = cycle_trace(name)
    assert time[-1] == duration
    assert np.trapezoid(speed, time) == pytest.approx(distance, rel=0.002)
    assert 3.6 * speed.max() == pytest.approx(highest)
    assert speed[0] == speed[-1] == 0.0


def test_the_mean_speed_is_the_published_one() -> None:
    time, speed = cycle_trace("nedc")
    assert 3.6 * np.trapezoid(speed, time) / time[-1] == pytest.approx(33.6, abs=0.05)


def test_the_urban_cycle_breaks_down_as_published() -> None:
    def seconds(chosen: list[bool]) -> float:
        return sum(segment.duration for segment, wanted in zip(ECE_15, chosen, strict=True) if wanted)

    rates = accelerations(ECE_15)
    standing = [segment.speed_kmh == 0.0 and rate == 0.0 for segment, rate in zip(ECE_15, rates, strict=True)]
    geared = [segment.gear > 0 for segment in ECE_15]
    steady = [rate == 0.0 and gear for rate, gear in zip(rates, geared, strict=True)]
    assert seconds(standing) == 60
    assert seconds(steady) == 57
    assert seconds([rate > 0.0 for rate in rates]) == 36
    assert seconds([rate < 0.0 and gear for rate, gear in zip(rates, geared, strict=True)]) == 25
    assert [seconds([segment.gear == gear for segment in ECE_15]) for gear in (1, 2, 3)] == [24, 53, 41]


@pytest.mark.parametrize(("segments", "low", "high"), [(ECE_15, -0.93, 1.05), (EUDC, -1.39, 0.84)])
def test_accelerations_are_within_the_published_ones(segments: tuple[Segment, ...], low: float, high: float) -> None:
    rates = accelerations(segments)
    assert min(rates) == pytest.approx(low, abs=0.01)
    assert max(rates) == pytest.approx(high, abs=0.01)


def test_an_unknown_cycle_is_refused(refused: Refused) -> None:
    refused(lambda: cycle_trace("wltc"), "cycle: got wltc", f"expected one of {', '.join(CYCLES)}")


@pytest.mark.real_data
def test_it_is_the_cycle_of_an_independent_table(data_folder: Path) -> None:
    path = data_folder / "drive_cycles" / "nedc.csv"
    if not path.is_file():
        pytest.skip("no drive_cycles/nedc.csv in the folder of measured data")
    second, speed = np.loadtxt(path, delimiter=",", skiprows=1).T
    time, own = cycle_trace("nedc")
    error = 3.6 * np.abs(np.interp(second, time, own) - speed)
    # that table draws straight lines over the gear changes and over changes of deceleration
    assert np.mean(error < 0.3) > 0.8
    extra_urban = (second > 780 + 46) & (second < 1180)
    assert error[extra_urban].max() < 0.06
    assert np.trapezoid(speed, second) == pytest.approx(np.trapezoid(own, time), rel=0.01)
