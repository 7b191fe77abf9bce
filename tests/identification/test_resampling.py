"""Logs on rasters of their own, brought to one: gaps, delays, averages, and what is told of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bitepoint.identification.datasets import Request, read_dataset
from tests.identification.test_readers import BOTH, TIME, TRUE, good, write_csv


def test_a_gap_parts_a_run_and_is_not_bridged(tmp_path: Path) -> None:
    keep = (TIME < 0.6) | (TIME > 1.2)
    path = write_csv(tmp_path / "log.csv", {"time": TIME[keep], **{name: v[keep] for name, v in TRUE.items()}})
    data = read_dataset([path], Request(BOTH))
    assert [len(run.time) for run in data.runs] == [60, 79]
    assert data.warnings == (f"{path}: 1 gaps, so it counts as 2 runs",)
    times = np.concatenate([run.time for run in data.runs])
    assert not ((times > 0.6) & (times < 1.2)).any()
    for run in data.runs:
        assert run["clutch_torque"] == pytest.approx(50.0 + 10.0 * run.time)


def test_a_channel_that_comes_late_is_told(tmp_path: Path) -> None:
    torque = TRUE["clutch_torque"].copy()
    torque[:50] = np.nan
    data = read_dataset([good(tmp_path / "log.csv", clutch_torque=torque)], Request(BOTH))
    assert data.runs[0].time[0] == pytest.approx(0.5)
    assert "clutch_torque has values from 0.5 s to 1.99 s only" in data.warnings[0]


def test_a_delay_is_taken_out(tmp_path: Path) -> None:
    late = 50.0 + 10.0 * (TIME - 0.03)
    data = read_dataset([good(tmp_path / "log.csv", clutch_torque=late)], Request(BOTH, delays={"clutch_torque": 0.03}))
    run = data.runs[0]
    assert run["clutch_torque"] == pytest.approx(50.0 + 10.0 * run.time)
    assert run["engine_speed"] == pytest.approx(100.0 + 20.0 * np.sin(run.time))


def test_all_runs_come_to_one_raster(tmp_path: Path) -> None:
    time = np.arange(100) * 0.02 + 0.003
    slow = write_csv(tmp_path / "b.csv", {"time": time, "engine_speed": 2 * time, "clutch_torque": 3 * time})
    data = read_dataset([good(tmp_path / "a.csv"), slow], Request(BOTH))
    assert np.diff(data.runs[1].time) == pytest.approx(0.01)
    assert data.runs[1]["engine_speed"] == pytest.approx(2 * data.runs[1].time)
    assert len(read_dataset([slow], Request(BOTH, period=0.05)).runs[0].time) == 40


def fine_log(path: Path, tone: float = 0.0) -> Path:
    """A mass that a torque moves, logged every millisecond; the torque changes every 10 ms."""
    time = np.arange(2000) * 0.001
    torque = np.repeat(np.random.default_rng(2).normal(50.0, 8.0, 200), 10)
    speed = 100.0 + np.concatenate([[0.0], np.cumsum(0.001 * (torque - 50.0))[:-1]])
    return write_csv(
        path, {"time": time, "engine_speed": speed + tone * np.sin(198 * np.pi * time), "clutch_torque": torque}
    )


def test_means_of_a_finer_log_obey_the_equation_of_the_mass(tmp_path: Path) -> None:
    request = Request(BOTH, period=0.01, held=frozenset({"clutch_torque"}))
    data = read_dataset([fine_log(tmp_path / "a.csv")], request)
    (run,) = data.runs
    assert data.warnings == ("finer than the raster: 1 logs, all channels of them are means over 0.01 s",)
    assert (run.time[0], run.time[-1]) == pytest.approx((0.005, 1.975))
    gained = np.diff(run["engine_speed"])
    assert gained == pytest.approx(0.01 * (run["clutch_torque"][:-1] - 50.0), abs=1e-9)
    late = 0.01 * (run["clutch_torque"][1:] - 50.0)
    assert np.abs(gained - late).max() > 0.1


def test_what_is_faster_than_the_raster_does_not_show_as_slow_motion(tmp_path: Path) -> None:
    request = Request(BOTH, period=0.01, held=frozenset({"clutch_torque"}))
    with_tone, without = (
        read_dataset([fine_log(tmp_path / f"{tone}.csv", tone)], request).runs[0]["engine_speed"] for tone in (1.0, 0.0)
    )
    assert np.abs(with_tone - without).max() < 0.02  # 99 Hz on 100 Hz, which would be 1 Hz of amplitude 1


def test_a_steady_rise_stays_where_it_is(tmp_path: Path) -> None:
    time = np.sort(np.random.default_rng(4).uniform(0.0, 2.0, 4000))
    path = write_csv(tmp_path / "a.csv", {"time": time, "engine_speed": 30.0 * time, "clutch_torque": -9.0 * time})
    data = read_dataset([path], Request(BOTH, period=0.01))
    for name, slope in (("engine_speed", 30.0), ("clutch_torque", -9.0)):
        assert data.runs[0][name] == pytest.approx(slope * data.runs[0].time, abs=1e-6)


def test_a_channel_that_is_coarser_than_the_raster_is_told(tmp_path: Path) -> None:
    data = read_dataset([good(tmp_path / "log.csv")], Request(BOTH, period=0.005))
    assert data.warnings == (
        "coarser than the raster, up to 0.01 s: engine_speed, clutch_torque; the rows in between are interpolated",
    )


def test_a_time_in_milliseconds_among_seconds_is_left_out(tmp_path: Path) -> None:
    odd = write_csv(tmp_path / "b.csv", {"time": 1e3 * TIME, **TRUE})
    data = read_dataset([good(tmp_path / "a.csv"), odd], Request(BOTH))
    assert len(data.runs) == 1
    assert "b.csv: its rows are 10 s apart, on a raster of 0.01 s; the file is left out" in data.warnings[0]


def test_a_file_that_is_left_out_does_not_set_the_raster(tmp_path: Path) -> None:
    short = write_csv(tmp_path / "a.csv", {"time": 0.03 * np.arange(5), **{n: v[:5] for n, v in TRUE.items()}})
    assert read_dataset([short, good(tmp_path / "b.csv")], Request(BOTH)).period == pytest.approx(0.01)
