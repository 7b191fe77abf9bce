"""Scenarios of many runs: what their block must look like, and which runs it stands for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

import bitepoint
from bitepoint.files import library_folder, parse_yaml
from bitepoint.scenarios import load_scenario
from bitepoint.scenarios.runs import Runs
from tests.conftest import Refused

RUNS = Runs({"road.grade": [0, 0.1], "controller.throttle": [0.2, 0.3, 0.4]}, "controller.sequence")


def test_there_is_a_lane_for_each_combination() -> None:
    lanes = RUNS.lanes({}, True, 0)
    assert lanes["road.grade"] == [0, 0, 0, 0.1, 0.1, 0.1]
    assert lanes["controller.throttle"] == [0.2, 0.3, 0.4] * 2
    assert len(set(lanes["controller.sequence"])) == 6


def test_what_is_set_does_not_vary() -> None:
    assert set(RUNS.lanes({"road.grade": 0.3}, True, 0)) == {"controller.throttle", "controller.sequence"}
    alone = RUNS.lanes({"road.grade": 0, "controller.throttle": 1, "controller.sequence": 5}, True, 0)
    assert alone == {}


def test_the_keys_of_another_controller_are_left_out() -> None:
    assert RUNS.lanes({}, False, 0) == {"road.grade": [0, 0.1]}
    assert RUNS.lanes({}, True, 1)["controller.sequence"] != RUNS.lanes({}, True, 2)["controller.sequence"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"runs": 5}, "runs: got 5"),
        ({"runs": {}}, "runs: got keys"),
        ({"runs": {"vary": {}, "each": 1}}, "runs: got keys each, vary"),
        ({"runs": {"vary": {"road.grade": 5}}}, "runs.vary.road.grade: got 5"),
        ({"runs": {"vary": {"road.grade": []}}}, "runs.vary.road.grade: got []"),
        ({"runs": {"vary": {"grade": [1]}}}, "runs.vary.grade"),
        ({"runs": {"vary": {}, "number": 3}}, "runs.number: got 3"),
        ({"runs": {"vary": {f"a.{n}": list(range(20)) for n in range(4)}}}, "160000 combinations"),
        ({"log": {"noise": "1 kg"}}, "log.noise"),
        ({"log": {"raster": 1}}, "log.raster: unknown key"),
        ({"runs": None}, "runs: got nothing"),
    ],
)
def test_a_wrong_block_is_refused(tmp_path: Path, changes: dict[str, Any], said: str, refused: Refused) -> None:
    data = parse_yaml((library_folder("scenarios") / "dct-excitation.yaml").read_text(), "library")
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({**data, **changes}))
    refused(lambda: load_scenario(str(path)), str(path), said)


def test_logs_without_runs_are_refused(tmp_path: Path, refused: Refused) -> None:
    data = parse_yaml((library_folder("scenarios") / "dct-launch.yaml").read_text(), "library")
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({**data, "log": {}}))
    refused(lambda: load_scenario(str(path)), "log: without runs")


def test_a_key_that_no_part_knows_is_refused(tmp_path: Path, refused: Refused) -> None:
    data = parse_yaml((library_folder("scenarios") / "dct-excitation.yaml").read_text(), "library")
    data["runs"] = {"vary": {"vehicle.colour": [1, 2]}}
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(data))
    refused(lambda: bitepoint.run(str(path)), "vehicle.colour: unknown key")
