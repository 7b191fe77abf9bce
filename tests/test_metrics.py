"""Every figure against a closed form or an independent reference, for simulated and for measured recordings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from bitepoint.metrics import (
    LAUNCH_UNITS,
    Metric,
    energy_residual,
    friction_work,
    jerk,
    jerk_peak,
    launch,
    pedal_onset,
    sync_time,
)
from bitepoint.recording import Channel, Recording
from tests.tolerances import ROUNDING

REFERENCE_JERK = 1e-9
"""Relative to the largest jerk: scipy's filter solves for its steady state by elimination; measured 1e-12."""

CROSSING = 1e-9
"""s: where a straight line between two samples crosses 0, from numbers of 1e2 with rounding 1e-16; measured 1e-13."""


def recording(time: np.ndarray, **channels: object) -> Recording:
    """A recording of the given channels; a number stands for a constant."""
    data = np.array([np.broadcast_to(np.asarray(values, float), time.shape) for values in channels.values()])
    rows = tuple(Channel(name, "1") for name in channels)
    return Recording(np.asarray(time, float), rows, data.reshape(len(rows), len(time)))


def raster(end: float, tick: float) -> np.ndarray:
    """Times from 0 to `end`, every `tick`."""
    return np.arange(round(end / tick) + 1) * tick


def slipping(time: np.ndarray, slip: np.ndarray, torque: object = 100.0) -> Recording:
    """A clutch with the given slip over a plate that speeds up."""
    plate = 30.0 * time
    return recording(time, engine_speed=plate + slip, clutch_speed=plate, clutch_torque=torque)


def locked_at(time: np.ndarray, start: float, rate: float) -> np.ndarray:
    """A slip that falls at `rate` from `start`, and is exactly 0 from the first sample after its zero."""
    slip = start - rate * time
    return np.where(slip > 0.0, slip, 0.0)


def jerk_by_scipy(time: np.ndarray, speed: np.ndarray, end: float) -> np.ndarray:
    """The definition of jerk, word for word."""
    samples = np.arange(time[0], end + 1e-9, 0.01)
    differenced = np.diff(np.diff(np.interp(samples, time, speed))) / 0.01**2
    if len(differenced) < 2:
        return differenced
    b, a = butter(2, 10, fs=100)
    padding = 3 * max(len(a), len(b)) if len(differenced) > 9 else len(differenced) - 1
    return filtfilt(b, a, differenced, padlen=padding)


@pytest.mark.parametrize("samples", [3, 4, 5, 9, 10, 11, 12, 13, 25, 100, 301])
@pytest.mark.parametrize("tick", [0.002, 0.01, 0.013])
def test_jerk_is_what_scipy_makes_of_its_definition(samples: int, tick: float) -> None:
    end = (samples - 1) * 0.01
    time = 2.5 + raster(end + 0.3, tick)
    speed = np.random.default_rng(samples).normal(0.0, 1.0, len(time)).cumsum()
    result, expected = jerk(recording(time, vehicle_speed=speed), 2.5 + end), jerk_by_scipy(time, speed, 2.5 + end)
    assert len(result) == samples - 2
    assert np.abs(result - expected).max() <= REFERENCE_JERK * np.abs(expected).max()


@pytest.mark.parametrize("end", [0.0, 0.005, 0.01, 0.019])
def test_there_is_no_jerk_in_less_than_three_samples(end: float) -> None:
    run = recording(raster(1.0, 0.002), vehicle_speed=1.0)
    assert jerk(run, end).size == 0
    assert jerk_peak(run, end) is None


def test_a_jerk_that_is_constant_passes_the_filter() -> None:
    time = raster(2.0, 0.002)
    run = recording(time, vehicle_speed=1.0 + 3.0 * time - 0.5 * 7.0 * time**2)
    assert jerk(run, 1.5) == pytest.approx(np.full(149, -7.0), rel=1e-7)
    assert jerk_peak(run, 1.5) == pytest.approx(7.0, rel=1e-7)


def test_jerk_after_the_end_of_the_window_does_not_count() -> None:
    time = raster(2.0, 0.002)
    calm = np.minimum(time, 1.0)
    wild = np.where(time > 1.0, 50.0 * np.sin(40.0 * time), time)
    jerks = [jerk(recording(time, vehicle_speed=speed), 1.0) for speed in (calm, wild)]
    assert jerks[0].tolist() == jerks[1].tolist()


@given(st.floats(5.0, 300.0), st.floats(20.0, 500.0), st.sampled_from([0.001, 0.002, 0.01]))
@example(100.0, 100.0, 0.002)
def test_sync_is_where_a_straight_slip_crosses_zero(start: float, rate: float, tick: float) -> None:
    assume(0.05 < start / rate < 2.0)
    time = raster(3.0, tick)
    assert sync_time(slipping(time, start - rate * time), 0.0) == pytest.approx(start / rate, abs=CROSSING)


@given(st.floats(5.0, 300.0), st.floats(20.0, 500.0), st.sampled_from([0.001, 0.002, 0.01]))
@example(100.0, 100.0, 0.002)
def test_sync_is_inside_the_step_in_which_the_clutch_locks(start: float, rate: float, tick: float) -> None:
    assume(0.05 < start / rate < 2.0)
    time = raster(3.0, tick)
    assert sync_time(slipping(time, locked_at(time, start, rate)), 0.0) == pytest.approx(start / rate, abs=CROSSING)


def test_sync_needs_no_even_raster() -> None:
    time = np.cumsum(np.random.default_rng(5).uniform(0.001, 0.1, 60)) - 0.001
    for slip in (50.0 - 40.0 * time, locked_at(time, 50.0, 40.0)):
        assert sync_time(slipping(time, slip), time[0]) == pytest.approx(1.25, abs=CROSSING)


def test_sync_is_never_after_the_sample_that_shows_it() -> None:
    time = raster(0.08, 0.01)
    slip = np.array([10.0, 9.9, 9.8, 9.7, 9.6, 0.0, 0.0, 0.0, 0.0])
    assert sync_time(slipping(time, slip), 0.0) == pytest.approx(0.05, rel=ROUNDING)


def test_a_clutch_that_locks_in_the_first_step_locks_at_its_end() -> None:
    assert sync_time(slipping(raster(0.02, 0.01), np.array([5.0, 0.0, 0.0])), 0.0) == 0.01


@pytest.mark.parametrize(
    ("slip", "onset"),
    [
        (lambda time: 100.0 - 10.0 * time, 0.0),
        (lambda time: 0.0 * time, 0.0),
        (lambda time: -1.0 - time, 0.0),
        (lambda time: 100.0 - 100.0 * time, 1.5),
    ],
    ids=["never closed", "always locked", "always negative", "closed before the onset"],
)
def test_without_a_crossing_there_is_no_sync(slip: object, onset: float) -> None:
    time = raster(3.0, 0.002)
    assert callable(slip)
    assert sync_time(slipping(time, slip(time)), onset) is None


def test_only_the_first_sync_counts() -> None:
    time = raster(4.0, 0.002)
    assert sync_time(slipping(time, 10.0 * np.cos(np.pi * time)), 0.0) == pytest.approx(0.5, abs=1e-6)


@given(st.floats(0.0, 0.9), st.floats(1.0, 2.0))
@example(0.0, 2.0)
@example(0.5, 1.5)
@example(0.5011, 0.5017)
def test_friction_work_of_a_constant_torque_is_exact(start: float, end: float) -> None:
    time = raster(2.0, 0.01)
    work = friction_work(slipping(time, 100.0 - 40.0 * time, 80.0), start, end)
    assert work == pytest.approx(80.0 * (100.0 * (end - start) - 20.0 * (end**2 - start**2)), rel=ROUNDING)


@pytest.mark.parametrize(("start", "end"), [(0.0, 2.0), (0.2, 1.9), (0.1234, 1.2345)])
def test_friction_work_of_a_rising_torque_is_exact_to_second_order(start: float, end: float) -> None:
    def antiderivative(t: float) -> float:  # of (20 + 90 t)(100 - 40 t)
        return 2000.0 * t + 4100.0 * t**2 - 1200.0 * t**3

    exact, bend = antiderivative(end) - antiderivative(start), 2 * 90.0 * 40.0
    for tick in (0.02, 0.01, 0.005):
        time = raster(2.0, tick)
        error = friction_work(slipping(time, 100.0 - 40.0 * time, 20.0 + 90.0 * time), start, end) - exact
        assert -bend * tick**2 / 12.0 * (end - start + 3.0 * tick) <= error <= 0.0
        assert error <= -bend * tick**2 / 12.0 * (end - start - 3.0 * tick)


def test_heat_that_was_recorded_is_taken_as_it_is() -> None:
    time = raster(2.0, 0.01)
    run = recording(time, friction_heat=7.0 * time, clutch_torque=90.0, engine_speed=100.0, clutch_speed=0.0)
    assert friction_work(run, 0.1234, 1.2345) == pytest.approx(7.0 * 1.1111, rel=ROUNDING)


def test_the_onset_is_where_the_pedal_passes_one_percent() -> None:
    time = raster(1.0, 0.1)
    assert pedal_onset(recording(time, pedal=np.where(time > 0.45, 0.5, 0.01))) == pytest.approx(0.4)
    assert pedal_onset(recording(time, pedal=np.where(time > 0.45, 0.02, 0.0))) == pytest.approx(0.45)
    assert pedal_onset(recording(time, pedal=0.5)) == 0.0
    assert pedal_onset(recording(time, pedal=0.01)) is None
    assert pedal_onset(recording(time + 3.0, speed=0.5)) == 3.0


def test_the_energy_residual_is_what_the_balance_misses() -> None:
    time = np.array([0.0, 1.0, 2.0])
    spent = {"friction_heat": [0, 1, 30], "losses": [5, 6, 25], "stored_energy": [1, 9, 50]}
    assert energy_residual(recording(time, engine_work=[10, 500, 110], **spent)) == pytest.approx(0.01, rel=ROUNDING)
    assert energy_residual(recording(time, engine_work=[10, 500, 10], **spent)) is None
    assert energy_residual(recording(time, engine_work=1.0)) is None


SYNC, TIME = 1.2507, raster(3.0, 0.002)


def heat_at(time: np.ndarray | float) -> np.ndarray | float:
    """Heat from 90 N m at a slip that falls at 100 rad/s^2 to 0 at SYNC, J."""
    return 90.0 * 100.0 * (SYNC * time - time**2 / 2)


def launching(time: np.ndarray = TIME, *without: str, **instead: object) -> Recording:
    """A launch by hand: pedal pressed after 0.1 s, slip straight to 0 at SYNC and locked from then on."""
    speed = 0.6 * time**2
    slip = locked_at(time, 100.0 * SYNC, 100.0)
    channels: dict[str, object] = {
        "engine_speed": 40.0 * speed + slip,
        "clutch_speed": 40.0 * speed,
        "clutch_torque": 90.0,
        "vehicle_speed": speed,
        "pedal": np.where(time > 0.1, 0.2, 0.0),
        "engine_work": 10_000.0 * time,
        "friction_heat": heat_at(np.minimum(time, SYNC)),
        "losses": 2000.0 * time,
        "stored_energy": 7000.0 * time - heat_at(np.minimum(time, SYNC)),
    }
    channels |= instead
    return recording(time, **{name: values for name, values in channels.items() if name not in without})


ENERGIES = ("engine_work", "friction_heat", "losses", "stored_energy")


ONSET = 0.1 + 0.05 * 0.002
"""s: where a straight line from 0 to 20 % of the pedal, over one step of TIME, passes 1 %."""

HEAT = heat_at(SYNC) - heat_at(ONSET)


def values(run: Recording) -> dict[str, float | None]:
    """The figures of a launch without their units."""
    return {name: metric.value for name, metric in launch(run).items()}


def test_the_figures_of_a_launch() -> None:
    figures = launch(launching())
    assert {name: metric.unit for name, metric in figures.items()} == LAUNCH_UNITS
    found = values(launching())
    assert found["launch_time"] == pytest.approx(SYNC - ONSET, abs=CROSSING)
    assert found["friction_work"] == pytest.approx(HEAT, rel=1e-6)
    assert found["end_speed"] == pytest.approx(0.6 * SYNC**2, rel=1e-6)
    assert found["jerk_peak"] == pytest.approx(1.2, rel=1e-6)
    assert found["jerk_peak_settled"] == pytest.approx(1.2, rel=1e-6)
    assert found["engine_speed_min"] == pytest.approx(min(launching()["engine_speed"][50:876]), rel=ROUNDING)
    assert found["energy_residual"] == pytest.approx(0.1, rel=ROUNDING)


def test_jerk_counts_to_sync_and_to_half_a_second_later() -> None:
    bump = np.where(TIME > SYNC + 0.2, 0.6 * TIME**2 + 0.1 * np.sin(20.0 * (TIME - SYNC - 0.2)), 0.6 * TIME**2)
    late = np.where(TIME > SYNC + 0.55, 9.0 * np.sin(99.0 * TIME), bump)
    found = values(launching(vehicle_speed=late))
    assert found["jerk_peak"] == pytest.approx(1.2, rel=1e-6)
    assert found["jerk_peak_settled"] == jerk_peak(launching(vehicle_speed=bump), SYNC + 0.5)
    assert found["jerk_peak_settled"] > 10.0


def test_the_lowest_engine_speed_counts_from_the_onset_to_half_a_second_after_sync() -> None:
    speed = np.where((TIME < 0.09) | (TIME > SYNC + 0.51), 10.0, 200.0 - 100.0 * (TIME > SYNC + 0.4))
    plate = speed - locked_at(TIME, 100.0 * SYNC, 100.0)
    assert values(launching(engine_speed=speed, clutch_speed=plate))["engine_speed_min"] == 100.0


def test_without_sync_its_figures_do_not_exist() -> None:
    found = values(launching(engine_speed=500.0 - TIME))
    assert found["engine_speed_min"] == 497.0
    assert found["energy_residual"] == pytest.approx(0.1, rel=ROUNDING)
    assert {name for name, value in found.items() if value is None} == set(LAUNCH_UNITS) - {
        "engine_speed_min", "energy_residual"
    }  # fmt: skip


@pytest.mark.parametrize("last", [np.nan, np.inf, -np.inf])
def test_figures_of_a_run_that_left_the_numbers_do_not_exist(last: float) -> None:
    ending = np.where(TIME < 1.0, 0.0, last)
    found = values(launching(TIME[TIME < 1.2], engine_speed=(500.0 - ending)[TIME < 1.2]))
    assert found["engine_speed_min"] == (500.0 if last == -np.inf else None)
    assert values(launching(engine_work=100.0 * TIME + ending))["energy_residual"] is None
    assert values(launching(vehicle_speed=ending))["jerk_peak"] is None
    assert values(launching(friction_heat=ending))["friction_work"] is None


def test_without_a_pedal_channel_time_counts_from_the_first_sample() -> None:
    found = values(launching(TIME, "pedal"))
    assert found["launch_time"] == pytest.approx(SYNC, abs=CROSSING)
    assert found["friction_work"] == pytest.approx(heat_at(SYNC), rel=1e-6)


def test_a_pedal_that_is_never_pressed_makes_no_launch() -> None:
    found = values(launching(pedal=0.0))
    assert {name for name, value in found.items() if value is not None} == {"energy_residual"}


@pytest.mark.parametrize("missing", ["all", "stored_energy"])
def test_without_energies_there_is_no_residual(missing: str) -> None:
    found = values(launching(TIME, *(ENERGIES if missing == "all" else (missing,))))
    assert {name for name, value in found.items() if value is None} == {"energy_residual"}


@pytest.mark.parametrize(("after_sync", "settled"), [(0.4993, False), (0.4973, False), (0.5015, True), (0.6, True)])
def test_a_recording_that_ends_too_early_has_no_settled_jerk(after_sync: float, settled: bool) -> None:
    time = TIME[: np.searchsorted(TIME, SYNC + after_sync, side="right")]
    found = values(launching(time))
    assert (found.pop("jerk_peak_settled") is not None) == settled
    assert None not in found.values()


def test_a_measured_recording_has_every_figure_but_the_residual() -> None:
    time = np.cumsum(np.random.default_rng(6).uniform(0.008, 0.012, 300))
    measured = launching(time, *ENERGIES)
    assert len(measured.channels) == 5
    before = int(np.searchsorted(time, 0.1, side="right")) - 1
    found, onset = values(measured), float(time[before] + 0.05 * (time[before + 1] - time[before]))
    assert found["launch_time"] == pytest.approx(SYNC - onset, abs=CROSSING)
    assert found["friction_work"] == pytest.approx(heat_at(SYNC) - heat_at(onset), rel=1e-4)
    assert found["end_speed"] == pytest.approx(0.6 * SYNC**2, rel=1e-3)
    assert {name for name, value in found.items() if value is None} == {"energy_residual"}


@pytest.mark.parametrize(
    ("metric", "shown"),
    [
        (Metric(1.23456, "s"), "1.235 s"),
        (Metric(6384.4, "J"), "6384 J"),
        (Metric(22684.4, "J"), "22684 J"),
        (Metric(-7.04, "m/s^3"), "-7.04 m/s³"),
        (Metric(1e-8, "1"), "1e-08"),
        (Metric(11.0, "1"), "11"),
        (Metric(None, "J"), "–"),
        (Metric(0.0, "m/s"), "0 m/s"),
    ],
)
def test_a_figure_is_shown_with_its_unit(metric: Metric, shown: str) -> None:
    assert str(metric) == shown
