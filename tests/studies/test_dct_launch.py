"""Reproduction of the launch paper: its contract, its figures, and what the other controllers reach beside them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bitepoint.studies import dct_launch
from bitepoint.studies.papers import PAPERS, reproduce, save
from bitepoint.studies.reproduction import Reproduction, Row
from bitepoint.studies.variations import RANGES, vary
from tests.conftest import Command

VEHICLES = 200
"""Random vehicles here; `make slow` tries as many as the study."""


@pytest.fixture(scope="module")
def found() -> Reproduction:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dct_launch, "VEHICLES", VEHICLES)
        return reproduce("dct-launch")


def rows(found: Reproduction, case: str) -> dict[str, Row]:
    return {row.quantity: row for row in found.rows if row.case == case}


@pytest.mark.parametrize("intent", ["slow", "normal", "urgent"])
@pytest.mark.parametrize("case", ["ddpc", "ddpc on the identified model", "launch_pid"])
def test_table_3_is_met_with_one_parameter_set(found: Reproduction, case: str, intent: str) -> None:
    figures = rows(found, f"{case}, {intent}")
    for quantity, tolerance in (("launch_time", 0.05), ("friction_work", 0.05), ("jerk_peak", 0.10)):
        assert figures[quantity].tolerance == tolerance
        assert figures[quantity].within, figures[quantity]


def test_identification_errors_are_below_the_published_ones(found: Reproduction) -> None:
    for part in ("the paper's training run", "validation"):
        for row in rows(found, f"identification, {part}").values():
            assert row.within, row


def test_a_tuned_baseline_stands_in_every_table(found: Reproduction) -> None:
    cases = {row.case for row in found.rows}
    for case in cases:
        if case.startswith("launch_mpc"):
            assert case.replace("launch_mpc", "launch_pid tuned") in cases


@pytest.mark.parametrize("intent", ["slow", "normal", "urgent"])
def test_off_nominal_launch_mpc_keeps_the_limits_more_often_than_the_tuned_baseline(
    found: Reproduction, intent: str
) -> None:
    shares = {
        name: rows(found, f"{name}, {VEHICLES} random vehicles, {intent}")["share_within_limits"].ours
        for name in ("launch_mpc", "launch_pid tuned")
    }
    assert shares["launch_mpc"] is not None
    assert shares["launch_pid tuned"] is not None
    assert shares["launch_mpc"] > shares["launch_pid tuned"] + 0.1


def test_rows_have_the_keys_that_others_rely_on(found: Reproduction) -> None:
    told = json.loads(json.dumps(found.to_json(), allow_nan=False))
    keys = {"case", "quantity", "published", "ours", "unit", "tolerance", "within"}
    assert all(set(row) == keys for row in told["rows"])


def test_page_and_rows_are_written(found: Reproduction, tmp_path: Path) -> None:
    paths = save(found, tmp_path / "new")
    assert {path.name for path in paths} == {"rows.json", "reproduction.html"}
    page = (tmp_path / "new" / "reproduction.html").read_text(encoding="utf-8")
    assert "friction_work" in page
    assert "1700 kg" in page


def test_unknown_paper_is_one_line_and_status_2(bitepoint: Command) -> None:
    done = bitepoint("reproduce", "nature")
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert "expected one of" in done.err


def test_a_folder_that_cannot_be_is_told_before_anything_is_run(
    bitepoint: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr("bitepoint.studies.papers.reproduce", lambda *_: pytest.fail("it was run"))
    bitepoint("reproduce", "dct-launch", "--out", str(tmp_path / "file")).refusal("file: cannot be written")


def test_papers_are_listed(bitepoint: Command) -> None:
    done = bitepoint("reproduce")
    assert done.status == 0
    assert all(name in done.out for name in PAPERS)


@pytest.mark.parametrize(
    ("row", "within"),
    [
        (Row("c", "q", 100.0, 104.9, "s", 0.05), True),
        (Row("c", "q", 100.0, 105.1, "s", 0.05), False),
        (Row("c", "q", 100.0, None, "s", 0.05), False),
        (Row("c", "q", None, 1.0, "s"), None),
        (Row("c", "q", 100.0, 1.0, "s", 0.0, "most"), True),
        (Row("c", "q", 100.0, 100.1, "s", 0.0, "most"), False),
    ],
)
def test_verdict(row: Row, within: Any) -> None:
    assert row.within is within


def test_random_vehicles_are_the_same_for_every_controller() -> None:
    first, second = (vary({"controller": name, "intent": "slow"}, 8) for name in ("launch_pid", "none"))
    for key, (low, high) in RANGES.items():
        assert (first.over[key] == second.over[key]).all()
        assert ((first.over[key] >= low) & (first.over[key] <= high)).all()
    assert not second.launched.all()
