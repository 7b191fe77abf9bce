"""What is made of the rows of a sweep: fronts, pictures, a page."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import bitepoint
from bitepoint import SweepResult
from tests.cli.test_cli import Links
from tests.conftest import Refused, names_in


@pytest.fixture(scope="module")
def found() -> SweepResult:
    """Two numbers are swept; one gear is refused, another is too long for the steep grades."""
    over = {"road.grade": "0:20:4 %", "gearbox.gear": "1:3"}
    return bitepoint.sweep("dct-launch", over, pareto="friction_work,jerk_peak:max")


def test_the_front_is_that_of_the_rows_that_launched(found: SweepResult) -> None:
    rows = found.rows.to_pylist()
    launched = [row for row in rows if row["status"] == "launched"]
    assert found.counted.tolist() == [row["status"] == "launched" for row in rows]
    best = [
        row["row"]
        for row in launched
        if not any(
            other["friction_work"] <= row["friction_work"]
            and other["jerk_peak"] >= row["jerk_peak"]
            and (other["friction_work"] < row["friction_work"] or other["jerk_peak"] > row["jerk_peak"])
            for other in launched
        )
    ]
    front = found.front()
    assert sorted(front["row"].to_pylist()) == best
    assert front["friction_work"].to_pylist() == sorted(front["friction_work"].to_pylist())


def test_statuses_say_which_rows_may_be_on_the_front() -> None:
    over = {"timing.duration": "1.3,4 s"}
    stopped = bitepoint.sweep("dct-launch", over, statuses=["timed out"])
    assert stopped.rows["launch_time"].null_count == 0
    assert stopped.front()["row"].to_pylist() == [0]
    assert bitepoint.sweep("dct-launch", over, statuses=["launched"]).front()["row"].to_pylist() == [1]


def test_json_has_counts_and_the_front(found: SweepResult) -> None:
    said = found.to_json()
    assert {key: said[key] for key in ("scenario", "rows", "ran", "failed", "out")} == {
        "scenario": "dct-launch",
        "rows": 18,
        "ran": 18,
        "failed": 6,
        "out": None,
    }
    assert sum(said["statuses"].values()) == 18
    assert list(said["front"][0]) == ["row", "road.grade", "gearbox.gear", "friction_work", "jerk_peak"]


def test_two_numbers_are_a_heat_map_with_the_rows_that_lack_the_figure_marked(found: SweepResult) -> None:
    figure = found.figure("friction_work")
    heat = [trace for trace in figure.data if trace.type == "heatmap"]
    shown = [trace for trace in figure.data if trace.visible]
    assert [trace.type for trace in shown] == ["heatmap", "scatter"]
    values = np.array(shown[0].z, float).ravel()
    expected = np.array(found.rows["friction_work"].to_pylist(), float)
    assert np.array_equal(values, expected, equal_nan=True)
    assert len(shown[1].x) == found.rows["friction_work"].null_count > 6
    assert len(figure.layout.updatemenus[0].buttons) == len(heat) == 7
    assert (figure.layout.xaxis.title.text, figure.layout.yaxis.title.text) == ("gearbox.gear", "road.grade")


def test_one_number_is_a_line_in_a_panel_for_each_figure() -> None:
    figure = bitepoint.sweep("dct-launch", {"vehicle.mass": "1800,1400,1600 kg"}).figure()
    assert [list(trace.x) for trace in figure.data] == [[1400.0, 1600.0, 1800.0]] * 7
    assert {note.text for note in figure.layout.annotations} >= {"launch time, s", "jerk peak, m/s³"}


def test_a_text_beside_a_number_is_a_line_of_its_own() -> None:
    figure = bitepoint.sweep("dct-launch", {"intent": "slow,normal", "road.grade": "0:20:10 %"}).figure()
    lines = [trace for trace in figure.data if trace.mode == "lines+markers"]
    assert [trace.name for trace in lines[:2]] == ["slow", "normal"]
    assert len(lines) == 14


def test_more_keys_are_parallel_coordinates_of_the_rows_with_all_figures() -> None:
    over = {"intent": "slow,normal", "road.grade": "0,0.1", "gearbox.gear": "1,2"}
    found = bitepoint.sweep("dct-launch", over)
    (trace,) = found.figure("jerk_peak").data
    labels = [dimension.label for dimension in trace.dimensions]
    assert labels[:4] == ["intent", "road.grade", "gearbox.gear", "launch time, s"]
    assert list(trace.dimensions[0].ticktext) == ["slow", "normal"]
    assert list(trace.line.color) == [v for v in found.rows["jerk_peak"].to_pylist() if v is not None]
    assert all(len(dimension["values"]) == 4 for dimension in trace.dimensions)


def test_the_front_is_drawn_with_units(found: SweepResult) -> None:
    figure = found.front_figure()
    assert (figure.layout.xaxis.title.text, figure.layout.yaxis.title.text) == ("friction work, J", "jerk peak, m/s³")
    drawn = next(trace for trace in figure.data if trace.name == "front")
    assert list(drawn.x) == found.front()["friction_work"].to_pylist()


def test_the_page_tells_why_rows_failed_and_needs_no_network(found: SweepResult, tmp_path: Path) -> None:
    paths = found.save(tmp_path / "new")
    assert names_in(tmp_path / "new") == ["sweep.html", "sweep.parquet"] == sorted(path.name for path in paths)
    text = (tmp_path / "new" / "sweep.html").read_text("utf-8")
    assert "18 rows over road.grade, gearbox.gear: " in text
    assert "refused: --over: gearbox.gear: got an even gear" in text
    assert "Front: least friction work and largest jerk peak" in text
    links = Links()
    links.feed(text)
    assert not links.loaded


def test_an_unknown_figure_is_refused(found: SweepResult, refused: Refused) -> None:
    refused(lambda: found.figure("jerk"), "metric: got jerk", "jerk_peak")
    refused(lambda: found.save(), "folder: none given")


def test_repr_tells_how_the_rows_ended(found: SweepResult) -> None:
    assert re.fullmatch(r"<SweepResult of dct-launch: \d+ launched, 6 refused, \d timed out>", repr(found))
