"""Published driving cycles and a day of real trips: their files are read as they are, and driven.

Files: FASTSim (NREL, Apache-2.0), with and without a byte-order mark; ADVISOR (NREL) for NEDC and NYCC.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bitepoint.scenarios import SpeedLog, cycle_trace, read_speed_log
from tests.conftest import Command

pytestmark = pytest.mark.real_data

CYCLES = [
    pytest.param("udds", "cycMps", 1369.0, 11_990.0, id="udds"),
    pytest.param("hwfet", "cycMps", 765.0, 16_507.0, id="hwfet"),
    pytest.param("us06", "cycMps", 600.0, 12_888.0, id="us06"),
    pytest.param("wltc_3b", "cycMps", 1800.0, 23_266.0, id="wltc, with a byte-order mark"),
    pytest.param("nedc", "speed_mps", 1180.0, 10_931.0, id="nedc"),
    pytest.param("nycc", "speed_mps", 598.0, 1_898.0, id="nycc"),
    pytest.param("gps_1hz_trip_4116728_1", "speed_mph", 8970.0, 56_800.0, id="a day of trips, in mph"),
]
"""File, column, duration in s, and distance in m as published, to 0.1 %; NEDC and trips: as the files have it."""


def cycle(folder: Path, name: str) -> Path:
    """The file of a cycle."""
    path = folder / "drive_cycles" / f"{name}.csv"
    if not path.is_file():
        pytest.skip(f"no {path.parent.name}/{path.name} in the folder of measured data")
    return path


@pytest.mark.parametrize(("name", "column", "duration", "distance"), CYCLES)
def test_a_cycle_has_its_published_length(
    data_folder: Path, name: str, column: str, duration: float, distance: float
) -> None:
    time, speed = read_speed_log(SpeedLog(cycle(data_folder, name), column))
    assert (time[0], time[-1]) == (0.0, duration)
    assert np.trapezoid(speed, time) == pytest.approx(distance, rel=1e-3)


def test_the_nedc_of_the_file_is_that_of_the_regulation(data_folder: Path) -> None:
    time, speed = read_speed_log(SpeedLog(cycle(data_folder, "nedc"), "speed_mps"))
    error = speed - np.interp(time, *cycle_trace("nedc"))
    assert np.sqrt(np.mean(error**2)) < 0.3


@pytest.mark.parametrize(("name", "column"), [("wltc_3b", "cycMps"), ("nedc", "speed_mps")])
def test_a_whole_cycle_is_driven(bitepoint: Command, data_folder: Path, name: str, column: str) -> None:
    options = [f"speed={cycle(data_folder, name)}", f"speed.column={column}"]
    done = bitepoint("run", "p2-nedc", "--json", *(part for each in options for part in ("--set", each)))
    assert done.status == 0, done.err
    said = json.loads(done.out)
    assert said["status"] == "completed"
    assert 0.0 < said["metrics"]["speed_error_rms"]["value"] < 0.25, said["metrics"]
