"""A sweep: its rows are single runs, its table says where they come from, and what is refused is a row."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.studies.sweep import rows
from bitepoint.studies.sweep.grid import Grid, axis
from bitepoint.studies.sweep.plan import Plan, code_digest
from bitepoint.version import __version__
from tests.conftest import Refused


def plan(over: Mapping[str, Any], settings: Mapping[str, Any] | None = None, seed: int = 0) -> Plan:
    return Plan("dct-launch", Grid(tuple(axis(key, values) for key, values in over.items())), settings or {}, seed)


def test_a_row_is_the_single_run_that_its_configuration_says() -> None:
    over = {"road.grade": "0:10:5 %", "intent": "slow,urgent", "vehicle.mass": [1400, 1700.5]}
    settings = {"noise.engine_speed": "0.5 rad/s", "delay.clutch_speed": "10 ms"}
    found = bitepoint.sweep("dct-launch", over, settings, seed=5, clutch__friction_gain=0.95)
    assert found.rows.num_rows == found.ran == 12
    for row in found.rows.to_pylist():
        own = json.loads(row["configuration"])
        assert (own["scenario"], own["vehicle"], own["controller"]) == ("dct-launch", "dct-t240", "launch_pid")
        result = bitepoint.run(own["scenario"], own["settings"], seed=own["seed"])
        assert (row["status"], row["reason"], row["seed"]) == (result.status, result.reason, 5)
        assert {name: row[name] for name in result.metrics} == {n: m.value for n, m in result.metrics.items()}


def test_swept_keys_are_columns_in_si_in_the_order_of_the_grid() -> None:
    over = {"intent": "slow,normal", "road.grade": "0:20:10 %", "gearbox.gear": "1,3", "engine.idle_speed": "800 rpm"}
    found = bitepoint.sweep("dct-launch", over)
    assert found.rows["row"].to_pylist() == list(range(12))
    assert found.rows["intent"].to_pylist() == ["slow"] * 6 + ["normal"] * 6
    assert found.rows["road.grade"].to_pylist() == [0.0, 0.0, 0.1, 0.1, 0.2, 0.2] * 2
    assert found.rows["gearbox.gear"].to_pylist() == [1, 3] * 6
    assert found.rows["engine.idle_speed"][0].as_py() == pytest.approx(800 * np.pi / 30)


def test_columns_tell_their_unit_meaning_and_role() -> None:
    found = bitepoint.sweep("dct-launch", {"vehicle.mass": "1500,1600", "noise.engine_speed": "0,1"})
    told = {field.name: {k.decode(): v.decode() for k, v in field.metadata.items()} for field in found.rows.schema}
    assert told["vehicle.mass"] == {"role": "swept", "unit": "kg", "meaning": "mass of the loaded vehicle"}
    assert told["noise.engine_speed"]["unit"] == "rad/s"
    single = bitepoint.run("dct-launch").metrics
    figures = {name: each["unit"] for name, each in told.items() if each["role"] == "figure"}
    assert figures == {name: metric.unit for name, metric in single.items()}
    assert found.rows["version"].to_pylist() == [__version__] * 4
    assert found.rows["code"].to_pylist() == [code_digest()] * 4
    assert all(each["meaning"] for each in told.values())


def test_a_figure_that_does_not_exist_is_null() -> None:
    found = bitepoint.sweep("dct-launch", {"timing.duration": "0.5,4 s"})
    assert found.rows["status"].to_pylist() == ["timed out", "launched"]
    assert [value is None for value in found.rows["launch_time"].to_pylist()] == [True, False]
    assert found.failed == 0


def test_a_refused_combination_is_a_row_and_the_others_run() -> None:
    found = bitepoint.sweep("dct-launch", {"gearbox.gear": "1:3", "vehicle.mass": "1500,10 kg"})
    assert found.rows["status"].to_pylist() == ["launched", *["refused"] * 3, "launched", "refused"]
    assert found.counts == {"refused": 4, "launched": 2}
    reasons = found.rows["reason"].to_pylist()
    assert reasons[1] == "--over: vehicle.mass: got '10 kg'; expected a number in 50..60000 kg"
    assert reasons[2].startswith("--over: gearbox.gear: got an even gear; ")
    refused = found.rows.slice(2, 1).to_pylist()[0]
    assert json.loads(refused["configuration"])["settings"] == {"gearbox.gear": "2", "vehicle.mass": "1500 kg"}
    assert (refused["parameters"], refused["launch_time"], found.failed) == (None, None, 4)


def test_a_refusal_is_found_by_halving(monkeypatch: pytest.MonkeyPatch) -> None:
    designed: list[int] = []

    def counted(*arguments: Any) -> Any:
        designed.append(len(arguments[2]["vehicle.mass"]))
        return assemble(*arguments)

    monkeypatch.setattr(rows, "assemble", counted)
    found = rows.run_rows(plan({"vehicle.mass": [*range(1400, 1431), 10]}), range(32))
    assert [row.status for row in found] == ["launched"] * 31 + ["refused"]
    assert designed == [32, 16, 16, 8, 8, 4, 4, 2, 2, 1, 1]


def test_a_value_that_its_key_never_takes_is_refused_for_all_its_rows_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    designed: list[int] = []

    def counted(*arguments: Any) -> Any:
        designed.append(len(arguments[2]["vehicle.mass"]))
        return assemble(*arguments)

    monkeypatch.setattr(rows, "assemble", counted)
    found = rows.run_rows(plan({"road.grade": "0:15:1 %", "vehicle.mass": [1500, 10, 1600]}), range(48))
    assert [row.status for row in found] == ["launched", "refused", "launched"] * 16
    assert designed == [48, 16, 32, 16, 16]


def test_a_design_without_a_solution_is_a_refusal(monkeypatch: pytest.MonkeyPatch) -> None:
    def singular(_name: str, _settings: Any, over: Mapping[str, Any]) -> Any:
        if 1500 in over["vehicle.mass"]:
            raise np.linalg.LinAlgError("Singular matrix")
        return assemble("dct-launch", {}, over)

    monkeypatch.setattr(rows, "assemble", singular)
    found = rows.run_rows(plan({"vehicle.mass": [1400, 1500]}), range(2))
    assert [row.status for row in found] == ["launched", "refused"]
    assert found[1].reason == "controller: cannot be designed (Singular matrix); choose other values"


def test_a_key_that_only_one_controller_has_is_refused_for_the_other() -> None:
    over = {"controller": "launch_pid,launch_mpc", "controller.clutch_kp": "3,4"}
    found = bitepoint.sweep("dct-launch", over)
    assert found.rows["status"].to_pylist() == ["launched", "launched", "refused", "refused"]
    assert "controller.clutch_kp: unknown key" in found.rows["reason"][2].as_py()
    assert [json.loads(text)["controller"] for text in found.rows["configuration"].to_pylist()][1:3] == [
        "launch_pid",
        "launch_mpc",
    ]


def test_rows_with_the_same_parameters_have_the_same_digest() -> None:
    over = {"vehicle.mass": ["1600 kg", "1.6 t", 1700], "intent": "slow,normal"}
    digests = bitepoint.sweep("dct-launch", over).rows["parameters"].to_pylist()
    assert digests[0] == digests[2]
    assert digests[1] == digests[3]
    assert len(set(digests)) == 4
    alone = bitepoint.sweep("dct-launch", {"vehicle.mass": [1600]}, intent="slow").rows["parameters"].to_pylist()
    assert alone == [digests[0]]


def test_the_seed_is_swept_like_a_key() -> None:
    found = bitepoint.sweep("dct-launch", {"seed": "0:2"}, {"noise.engine_speed": "1 rad/s"})
    single = [
        bitepoint.run("dct-launch", {"noise.engine_speed": "1 rad/s"}, seed=seed).metrics["friction_work"].value
        for seed in range(3)
    ]
    assert found.rows["seed"].to_pylist() == [0, 1, 2]
    assert found.rows["friction_work"].to_pylist() == single
    assert len(set(single)) == 3


def test_threads_change_nothing() -> None:
    over = {"vehicle.mass": "1400:1460"}
    one, two = (bitepoint.sweep("dct-launch", over, threads=threads).rows for threads in (1, 2))
    assert one.equals(two)


@pytest.mark.parametrize(
    ("over", "settings", "parts"),
    [
        ({"road.grad": "0:20"}, {}, ("--over: road.grad: unknown key",)),
        ({"roads.grade": "0:20"}, {}, ("roads: unknown group",)),
        ({"road.grade": "0:20 kg"}, {}, ("--over: road.grade: got unit 'kg' of another dimension",)),
        ({"road.grade": "0:1"}, {"road.grade": 0.1}, ("--over: road.grade: given in --set too",)),
        ({"road.grade": "0,0.1"}, {"vehicle.mass": 3}, ("--set: vehicle.mass: got 3",)),
        ({"vehicle.mass": "1:4"}, {}, ("--over: vehicle.mass: got '1' (the first; every row refused)",)),
        ({"vehicle.mass": "1:4"}, {"report.bound": "true"}, ("vehicle.mass: got '1'",)),
        ({"intent": "slow,fast,faster"}, {"controller": "lunch"}, ("controller: got lunch",)),
        ({"seed": "0.5,2"}, {}, ("seed: got 0.5", "whole number")),
        ({"seed": "-1:2"}, {}, ("seed: got -1",)),
    ],
)
def test_mistakes_that_all_rows_share_are_told_before_anything_is_written(
    over: Mapping[str, Any], settings: Mapping[str, Any], parts: tuple[str, ...], refused: Refused, tmp_path: Path
) -> None:
    refused(lambda: bitepoint.sweep("dct-launch", over, settings, out=tmp_path / "out"), *parts)
    assert not (tmp_path / "out").exists()


def test_a_scenario_of_many_runs_is_refused(refused: Refused) -> None:
    refused(lambda: bitepoint.sweep("dct-excitation", {"road.grade": "0,0.1"}), "dct-excitation", "of one run")


def test_no_threads_are_refused(refused: Refused) -> None:
    refused(lambda: bitepoint.sweep("dct-launch", {"road.grade": "0,0.1"}, threads=0), "threads: got 0")
