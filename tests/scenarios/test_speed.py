"""A speed to follow from a file: the right rows in m/s, or a sentence that says what is wrong with it."""

from __future__ import annotations

from pathlib import Path

import pytest

import bitepoint
from bitepoint.scenarios import SpeedLog, read_speed_log
from tests.conftest import Refused


def written(folder: Path, text: str) -> Path:
    """A CSV file of that text."""
    path = folder / "drive.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("header", "unit"),
    [
        ("speed_kmh", None),
        ("v [km/h]", None),
        ("vehicle_speed_kph", None),
        ("cycKmh", None),
        ("speed", "km/h"),
        ("speed_mph", "km/h"),
    ],
)
def test_a_unit_stands_in_the_header_or_is_said(tmp_path: Path, header: str, unit: str | None) -> None:
    path = written(tmp_path, f"t,{header}\n10,0\n12,36\n13,72\n")
    time, speed = read_speed_log(SpeedLog(path, header, unit))
    assert time.tolist() == [0.0, 2.0, 3.0]
    assert speed == pytest.approx([0.0, 10.0, 20.0])


def test_part_of_a_file_and_a_standstill_a_little_below_zero(tmp_path: Path) -> None:
    path = written(tmp_path, "t,v_mps\n0,9\n1,-0.05\n2,3\n3,\n")
    time, speed = read_speed_log(SpeedLog(path, "v_mps", start=1, end=2))
    assert (time.tolist(), speed.tolist()) == ([0.0, 1.0], [0.0, 3.0])


@pytest.mark.parametrize(
    ("text", "unit", "said"),
    [
        ("t,v\n0,1\n1,2\n", None, ["v: unit unknown", "add --set speed.unit=km/h"]),
        ("t,v\n0,1\n1,2\n", "kg", ["v: ", "expected a unit of a speed"]),
        ("t,v\n0,1\n1,101\n", "m/s", ["v: speeds from 1 m/s to 101 m/s", "check speed.unit"]),
        ("t,v\n0,-1\n1,2\n", "m/s", ["v: speeds from -1 m/s"]),
        ("t,v\n0,1\n1,\n", "m/s", ["v has no value at 1 s", "choose speed.start and speed.end"]),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, unit: str | None, said: list[str], refused: Refused) -> None:
    path = written(tmp_path, text)
    refused(lambda: read_speed_log(SpeedLog(path, "v", unit)), str(path), *said)


def test_a_run_follows_the_file_as_long_as_it_is(tmp_path: Path) -> None:
    path = written(tmp_path, "t,speed_kmh\n5,0\n7,0\n13,25\n20,25\n")
    run = bitepoint.run("p2-nedc", {"speed": str(path), "speed.column": "speed_kmh"})
    assert run.recording.time[-1] == 15.0
    assert 3.6 * run.recording["speed_target"][-1] == pytest.approx(25.0)
    assert 3.6 * run.recording["vehicle_speed"][-1] == pytest.approx(25.0, abs=1.0)


def test_settings_that_do_not_fit_are_refused(tmp_path: Path, refused: Refused) -> None:
    path = str(written(tmp_path, "t,v_mps\n0,0\n9,5\n"))
    column = {"speed": path, "speed.column": "v_mps"}
    refused(lambda: bitepoint.run("p2-nedc", {"speed": path}), "speed.column: missing", "name the speed column")
    refused(lambda: bitepoint.run("p2-nedc", {**column, "speed.rest": 1}), "speed.rest: unknown key")
    refused(lambda: bitepoint.run("p2-nedc", {**column, "intent": "nedc"}), "intent: given with speed=FILE")
    refused(lambda: bitepoint.run("p2-nedc", {"speed.column": "v_mps"}), "speed.column: no log", "speed=FILE")
    refused(lambda: bitepoint.run("dct-launch", column), "speed")
    refused(lambda: bitepoint.run("p2-tip-in", column), "speed")
