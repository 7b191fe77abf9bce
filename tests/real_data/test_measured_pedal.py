"""Measured drives: a recorded pedal launches the simulated car, and the figures take measured recordings.

Logs: Automotive OBD-II Dataset, doi:10.35097/1130 (CC BY 4.0); OpenACC, European Commission JRC (CC BY 4.0).
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pyarrow import csv

from bitepoint.metrics import LAUNCH_UNITS, jerk, jerk_peak, launch
from bitepoint.recording import Channel, Recording
from bitepoint.scenarios import PedalLog, read_pedal_log
from tests.conftest import Command

pytestmark = pytest.mark.real_data

REST = 14.1
"""Pedal position with the pedal released, percent, as both logs have it."""

OVERALL_RATIO = 15.0
"""Engine speed over wheel speed in first gear (chosen: typical; the log does not tell)."""

WHEEL_RADIUS = 0.31
"""m (chosen: typical)."""

FREE = "seat_leon_20180423_ka_ka_frei.csv"
HARD = "seat_leon_20180223_rt_rt_frei_beschleunigung.csv"

STARTS = [
    pytest.param(FREE, 241.0, 249.0, id="firm, after an engine stop"),
    pytest.param(FREE, 56.0, 62.0, id="brisk, second push while moving"),
    pytest.param(FREE, 732.0, 738.0, id="gentle, engine idling"),
    pytest.param(FREE, 378.0, 384.0, id="gentle, then firm"),
    pytest.param(HARD, 750.0, 758.0, id="creeping"),
]
"""Standing starts: the car stands, the driver presses the pedal, the car moves off."""

Floats = npt.NDArray[np.float64]


def columns(path: Path, *names: str) -> list[Floats]:
    """Columns of a CSV file, empty cells as NaN."""
    if not path.is_file():
        pytest.skip(f"no {path.parent.name}/{path.name} in the folder of measured data")
    table = csv.read_csv(path)
    return [table[name].to_numpy(zero_copy_only=False).astype(float) for name in names]


def options(path: Path, start: float, end: float) -> list[str]:
    """The settings that take the pedal from a log."""
    settings = {"column": "pedal_d_pct", "rest": REST, "start": start, "end": end}
    texts = [f"pedal={path}", *(f"pedal.{key}={value}" for key, value in settings.items())]
    return [option for text in texts for option in ("--set", text)]


@pytest.mark.parametrize(("file", "start", "end"), STARTS)
def test_the_cut_is_a_standing_start(data_folder: Path, file: str, start: float, end: float) -> None:
    time, speed, pedal = columns(data_folder / "obd_log" / file, "time_s", "speed_kph", "pedal_d_pct")
    pressed = time[(time >= start) & (pedal > REST + 1.0)][0]
    assert speed[(time >= start) & (time <= pressed)].max() == 0.0
    assert start + 1.0 < pressed < end
    assert speed[time <= end][-1] > 10.0


@pytest.mark.parametrize(("file", "start", "end"), STARTS)
def test_a_measured_pedal_launches_the_car(
    bitepoint: Command, data_folder: Path, tmp_path: Path, file: str, start: float, end: float
) -> None:
    path = data_folder / "obd_log" / file
    time, pedal = columns(path, "time_s", "pedal_d_pct")
    done = bitepoint("run", "dct-launch", "--json", "--out", str(tmp_path), *options(path, start, end))
    assert (done.status, done.err) == (0, "")
    said = json.loads(done.out)
    assert said["status"] == "launched"
    assert set(said["metrics"]) == set(LAUNCH_UNITS)
    figures = {name: figure["value"] for name, figure in said["metrics"].items()}
    assert all(math.isfinite(value) for value in figures.values())
    assert 1.0 < figures["launch_time"] < 6.0
    assert 1.0 < figures["end_speed"] < 6.0
    assert figures["energy_residual"] < 1e-3
    recording = Recording.from_parquet(tmp_path / "recording.parquet")
    cut = (time >= start) & (time <= end)
    expected = np.interp(recording.time, time[cut] - time[cut][0], pedal[cut] - REST) / 100.0
    assert recording["pedal"] == pytest.approx(expected, abs=1e-12)


def test_a_firmer_driver_starts_faster(bitepoint: Command, data_folder: Path) -> None:
    def launch_time(start: float, end: float) -> float:
        path = data_folder / "obd_log" / FREE
        done = bitepoint("run", "dct-launch", "--json", *options(path, start, end))
        return json.loads(done.out)["metrics"]["launch_time"]["value"]

    columns(data_folder / "obd_log" / FREE, "time_s")
    assert launch_time(241.0, 249.0) < launch_time(732.0, 738.0)


def test_a_gap_in_the_log_is_named(data_folder: Path) -> None:
    path = data_folder / "obd_log" / FREE
    columns(path, "time_s")
    time, pedal = read_pedal_log(PedalLog(path, "pedal_d_pct", rest=REST, start=1.0))
    assert time[0] == 0.0
    assert (pedal.min(), pedal.max()) == (0.0, pytest.approx(0.483, abs=1e-3))
    with pytest.raises(Exception, match=r"pedal_d_pct has no value at 0 s; choose pedal\.start"):
        read_pedal_log(PedalLog(path, "pedal_d_pct"))


@pytest.mark.parametrize("file", ["short_setting_handling_part14.csv", "no_ACC_handling_part26.csv"])
def test_jerk_of_measured_speeds_is_finite_and_that_of_a_car(data_folder: Path, file: str) -> None:
    path = data_folder / "acc_platoon" / file
    (time,) = columns(path, "time_s")
    cars = [name for name in csv.read_csv(path).column_names if name.startswith("speed_")]
    assert len(cars) >= 7
    for car, speed in zip(cars, columns(path, *cars), strict=True):
        known = np.isfinite(speed)
        first = int(np.flatnonzero(known & (speed > 0.5))[0])
        window = known & (time >= time[max(first - 20, 0)]) & (time <= time[first] + 10.0)
        recording = Recording(time[window], (Channel("vehicle_speed", "m/s"),), speed[window][None])
        end = float(recording.time[-1])
        values = jerk(recording, end)
        assert len(values) == round((end - recording.time[0]) * 100) - 1
        assert np.isfinite(values).all(), car
        peak = jerk_peak(recording, end)
        assert peak is not None
        assert 1.0 < peak < 60.0, car


def test_the_figures_of_a_measured_launch(data_folder: Path) -> None:
    names = ("time_s", "engine_rpm", "speed_kph", "pedal_d_pct", "maf_g_per_s")
    time, rpm, kph, pedal, air = columns(data_folder / "obd_log" / FREE, *names)
    window = (time >= 732.0) & (time <= 738.0)
    speed = np.interp(time[window], *_knots(time[window], kph[window] / 3.6))
    channels = {
        "engine_speed": rpm[window] * math.pi / 30.0,
        "clutch_speed": OVERALL_RATIO / WHEEL_RADIUS * speed,
        "clutch_torque": 5.0 * air[window],  # about 70 N m per 14 g/s: the log has no torque
        "vehicle_speed": speed,
        "pedal": (pedal[window] - REST) / 100.0,
    }
    rows = tuple(Channel(name, "1") for name in channels)
    figures = launch(Recording(time[window] - 732.0, rows, np.array(list(channels.values()))))
    assert figures["energy_residual"].value is None
    known = {name: metric.value for name, metric in figures.items() if name != "energy_residual"}
    assert all(value is not None and math.isfinite(value) for value in known.values())
    assert 1.0 < (figures["launch_time"].value or 0.0) < 4.0
    assert 1.0 < (figures["end_speed"].value or 0.0) < 5.0
    assert (figures["friction_work"].value or 0.0) > 0.0
    assert 70.0 < (figures["engine_speed_min"].value or 0.0) < 110.0


def _knots(time: Floats, held: Floats) -> tuple[Floats, Floats]:
    """The rows at which a held value is new: between them a speed changes steadily."""
    new = np.flatnonzero(np.diff(held, prepend=np.nan) != 0.0)
    return time[new], held[new]
