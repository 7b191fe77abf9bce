"""`bitepoint sweep`: what it prints, what it writes, and how it ends."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from bitepoint.studies.sweep import study
from tests.conftest import Command, names_in

GRADES = ("sweep", "dct-launch", "--over", "road.grade=0:20:5 %")


def test_json_is_one_object(bitepoint: Command, tmp_path: Path) -> None:
    done = bitepoint(*GRADES, "--over", "gearbox.gear=1,2", "--out", str(tmp_path), "--json")
    assert (done.status, done.err, done.out.count("\n")) == (0, "", 1)
    said = json.loads(done.out)
    assert list(said) == ["scenario", "rows", "ran", "failed", "statuses", "front", "out"]
    assert (said["rows"], said["ran"], said["failed"]) == (10, 10, 5)
    assert said["statuses"] == {"launched": 5, "refused": 5}
    assert said["front"][0]["row"] == 0
    assert said["out"] == str(tmp_path)
    assert names_in(tmp_path) == ["plan.json", "sweep.html", "sweep.parquet"]
    assert pq.read_table(tmp_path / "sweep.parquet")["road.grade"].to_pylist()[::2] == [0.0, 0.05, 0.1, 0.15, 0.2]


def test_a_person_reads_how_the_rows_ended_and_the_rows(bitepoint: Command) -> None:
    done = bitepoint(*GRADES, "--over", "gearbox.gear=1,2", "--set", "intent=slow")
    first, launched, refused, header, units, *rows = done.out.splitlines()
    assert (done.status, done.err, first) == (0, "", "dct-launch: 10 rows")
    assert launched == "  5 launched"
    assert refused.startswith("  5 refused, the first: --over: gearbox.gear: got an even gear; ")
    assert header.split() == ["row", "road.grade", "gearbox.gear", "status", "launch_time", "friction_work"]
    assert units.split() == ["s", "J"]
    assert [row.split()[0] for row in rows[:2]] == ["0*", "1"]
    assert len(rows) == 10


def test_of_many_rows_only_the_front_is_printed(bitepoint: Command) -> None:
    done = bitepoint("sweep", "dct-launch", "--over", "vehicle.mass=1400:1440", "--pareto", "friction_work,jerk_peak")
    first, _, front, _, _, *rows = done.out.splitlines()
    assert first == "dct-launch: 41 rows"
    assert front == "front of friction_work and jerk_peak, 41 rows, 30 of them"
    assert len(rows) == 30
    assert all(row.split()[0].endswith("*") for row in rows)


def test_a_finished_sweep_says_so_and_writes_nothing(bitepoint: Command, tmp_path: Path) -> None:
    assert bitepoint(*GRADES, "--out", str(tmp_path)).out.splitlines()[-1] == f"wrote {tmp_path / 'sweep.html'}"
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    again = bitepoint(*GRADES, "--out", str(tmp_path))
    assert again.out.startswith("dct-launch: 5 rows, all there already: nothing to run\n")
    assert "wrote" not in again.out
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before
    drawn = bitepoint(*GRADES, "--out", str(tmp_path), "--pareto", "jerk_peak,end_speed:max").out
    assert f"wrote {tmp_path / 'sweep.html'}" in drawn
    assert "Front: least jerk peak and largest end speed" in (tmp_path / "sweep.html").read_text("utf-8")


@pytest.mark.parametrize("kept", [True, False])
def test_an_interrupt_tells_how_to_go_on(
    kept: bool, bitepoint: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(plan: Any, rows: Any, threads: Any) -> Any:
        if rows[0] > 10:
            raise KeyboardInterrupt
        return run_rows(plan, rows, threads)

    run_rows = study.run_rows
    command = ["sweep", "dct-launch", "--over", "road.grade=0:19:1 %", *(["--out", str(tmp_path)] if kept else [])]
    monkeypatch.setattr(study, "run_rows", interrupted)
    done = bitepoint(*command)
    told = "17 rows are kept; the same command goes on from there" if kept else "nothing is kept without --out"
    assert (done.status, done.out, done.err) == (130, "", f"interrupted: {told}\n")
    monkeypatch.setattr(study, "run_rows", run_rows)
    there = ", 17 of them there already" if kept else ""
    assert bitepoint(*command).out.startswith(f"dct-launch: 20 rows{there}\n")


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("sweep", "dct-launch"), ("--over",)),
        (("sweep", "dct-lunch", "--over", "road.grade=0:1"), ("dct-lunch: no such scenario",)),
        ((*GRADES, "--over", "road.grade=1"), ("--over: road.grade: given twice",)),
        ((*GRADES, "--over", "vehicle.mass"), ("--over: got 'vehicle.mass'",)),
        ((*GRADES, "--pareto", "work,jerk"), ("--pareto: got work,jerk", "launch_time, friction_work")),
        ((*GRADES, "--set", "vehicle.mas=3"), ("--set: vehicle.mas: unknown key",)),
        ((*GRADES, "--threads", "0"), ("--threads",)),
        (("sweep", "dct-launch", "--over", "vehicle.mass=0:999999"), ("1000000 values", "at most 100000")),
    ],
)
def test_bad_input_is_one_line(
    arguments: tuple[str, ...], parts: tuple[str, ...], bitepoint: Command, tmp_path: Path
) -> None:
    bitepoint(*arguments, "--out", str(tmp_path / "out")).refusal(*parts)
    assert not (tmp_path / "out").exists()


def test_another_sweep_is_refused_and_fresh_begins_anew(bitepoint: Command, tmp_path: Path) -> None:
    bitepoint(*GRADES, "--out", str(tmp_path))
    other = (*GRADES, "--set", "intent=slow", "--out", str(tmp_path))
    bitepoint(*other).refusal(str(tmp_path), "differs in settings", "--fresh")
    assert bitepoint(*other, "--fresh").out.startswith("dct-launch: 5 rows\n")
