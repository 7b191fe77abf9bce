"""A sweep that is killed goes on: nothing is lost, nothing is run twice, and the table is the same in the end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

import bitepoint
from bitepoint.studies.sweep import study
from bitepoint.studies.sweep.folder import SweepFolder
from tests.conftest import Refused, names_in

OVER = {"road.grade": "0:20:2 %", "vehicle.mass": "1400,10 kg", "intent": "slow,normal"}
NOISE = {"noise.engine_speed": "0.5 rad/s"}
ROWS = 44

KILLED = """
import os, signal, sys
from pathlib import Path
import bitepoint
from bitepoint.studies.sweep import folder

def kill(*_):
    os.kill(os.getpid(), signal.SIGKILL)

place, out = sys.argv[1:]
replace = Path.replace
def fatal(self, target):
    count["n"] += "part-" in self.name
    kill() if count["n"] == 3 else replace(self, target)
count = {"n": 0}
if place == "in a part":
    Path.replace = fatal
if place == "before the parts are cleared":
    folder.SweepFolder.clear = kill
bitepoint.sweep("dct-launch", OVER, NOISE, out=out, seed=1,
    progress=lambda done, rows: kill() if place == "between parts" and done > 10 else None)
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The table of a sweep that nobody killed."""
    folder = tmp_path_factory.mktemp("whole")
    found = bitepoint.sweep("dct-launch", OVER, NOISE, out=folder, seed=1)
    assert found.ran == ROWS
    return (folder / "sweep.parquet").read_bytes()


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The rows that are run in this process."""
    numbers: list[int] = []

    def noted(plan: Any, rows: Any, threads: Any) -> Any:
        numbers.extend(rows)
        return run_rows(plan, rows, threads)

    run_rows = study.run_rows
    monkeypatch.setattr(study, "run_rows", noted)
    return numbers


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL on this system")
@pytest.mark.parametrize("place", ["between parts", "in a part", "before the parts are cleared"])
def test_a_killed_sweep_goes_on(place: str, whole: bytes, ran: list[int], tmp_path: Path) -> None:
    text = f"OVER, NOISE = {OVER!r}, {NOISE!r}\n{KILLED}"
    done = subprocess.run([sys.executable, "-c", text, place, str(tmp_path)], capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    kept = [n for part in (tmp_path / "parts").glob("part-*") for n in pq.read_table(part)["row"].to_pylist()]
    assert 0 < len(kept) == len(set(kept))
    found = bitepoint.sweep("dct-launch", OVER, NOISE, out=tmp_path, seed=1)
    assert found.ran == ROWS - len(kept) == len(ran)
    assert sorted([*kept, *ran]) == list(range(ROWS))
    assert (tmp_path / "sweep.parquet").read_bytes() == whole
    assert names_in(tmp_path) == ["plan.json", "sweep.parquet"]


def test_a_finished_sweep_does_nothing_more(ran: list[int], tmp_path: Path) -> None:
    first = bitepoint.sweep("dct-launch", {"road.grade": "0:10:5 %"}, out=tmp_path)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    ran.clear()
    again = bitepoint.sweep("dct-launch", {"road.grade": "0:10:5 %"}, out=tmp_path)
    assert (first.ran, again.ran, ran) == (3, 0, [])
    assert again.rows.equals(first.rows)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


def test_a_part_that_is_damaged_is_run_again(ran: list[int], tmp_path: Path) -> None:
    over = {"road.grade": "0:19:1 %"}
    with pytest.raises(KeyboardInterrupt):
        bitepoint.sweep("dct-launch", over, out=tmp_path, progress=interrupt)
    *_, last = sorted((tmp_path / "parts").iterdir())
    lost = pq.read_table(last).num_rows
    last.write_bytes(last.read_bytes()[:-10])
    ran.clear()
    found = bitepoint.sweep("dct-launch", over, out=tmp_path)
    assert len(ran) == 20 - 17 + lost
    assert found.rows["row"].to_pylist() == list(range(20))


def interrupt(done: int, rows: int) -> None:
    if 0 < done < rows:
        raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("over", "settings", "seed", "differs"),
    [
        ({"road.grade": "0:10:2 %"}, {}, 0, "over"),
        ({"road.grade": "0:10:5 %"}, {"intent": "slow"}, 0, "settings"),
        ({"road.grade": "0:10:5 %"}, {}, 1, "seed"),
    ],
)
def test_another_sweep_in_the_folder_is_refused(
    over: dict[str, str], settings: dict[str, str], seed: int, differs: str, refused: Refused, tmp_path: Path
) -> None:
    bitepoint.sweep("dct-launch", {"road.grade": "0:10:5 %"}, out=tmp_path)
    kept = (tmp_path / "sweep.parquet").read_bytes()
    message = refused(lambda: bitepoint.sweep("dct-launch", over, settings, out=tmp_path, seed=seed), str(tmp_path))
    assert message.endswith(f"differs in {differs}; choose another folder, or start anew with --fresh")
    assert (tmp_path / "sweep.parquet").read_bytes() == kept
    found = bitepoint.sweep("dct-launch", over, settings, out=tmp_path, seed=seed, fresh=True)
    assert found.ran == found.rows.num_rows
    assert json.loads((tmp_path / "plan.json").read_text())["seed"] == seed


def test_a_changed_file_or_code_is_another_sweep(
    refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    car, out = tmp_path / "car.yaml", tmp_path / "out"
    library = Path(bitepoint.__file__).parent / "vehicles" / "dct-t240.yaml"
    car.write_text(library.read_text("utf-8"), "utf-8")

    def again() -> Any:
        return bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, vehicle=str(car), out=out)

    again()
    car.write_text(car.read_text("utf-8") + "\n# heavier\n", "utf-8")
    refused(again, "differs in files_sha256")
    car.write_text(library.read_text("utf-8"), "utf-8")
    assert again().ran == 0
    monkeypatch.setattr("bitepoint.studies.sweep.plan.code_digest", lambda: "0")
    refused(again, "differs in code")


@pytest.mark.parametrize(("plan", "told"), [(None, "without plan.json"), ("{", "its plan.json cannot be read")])
def test_a_folder_without_a_plan_is_refused(plan: str | None, told: str, refused: Refused, tmp_path: Path) -> None:
    bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, out=tmp_path)
    (tmp_path / "plan.json").unlink()
    if plan is not None:
        (tmp_path / "plan.json").write_text(plan)
    refused(lambda: bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, out=tmp_path), told, "--fresh")


def test_a_place_that_is_no_folder_is_refused(refused: Refused, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    refused(lambda: bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, out=tmp_path / "file"), "file: cannot be")
    assert names_in(tmp_path) == ["file"]


@pytest.mark.skipif(os.name == "nt", reason="no locks there")
def test_two_processes_do_not_sweep_into_one_folder(refused: Refused, tmp_path: Path) -> None:
    with SweepFolder(tmp_path, {}).held():
        refused(lambda: bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, out=tmp_path), "another process")
    assert bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, out=tmp_path).ran == 2
