"""Reproduction of the paper on damping: its contract, and what it claims."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bitepoint.studies.p2_damping import LIMITS, least_loss
from bitepoint.studies.papers import reproduce, save
from bitepoint.studies.reproduction import Reproduction


@pytest.fixture(scope="module")
def found() -> Reproduction:
    return reproduce("p2-damping")


def ours(found: Reproduction, case: str, quantity: str) -> float:
    value = next(row.ours for row in found.rows if (row.case, row.quantity) == (case, quantity))
    assert value is not None
    return value


def test_every_claim_is_within(found: Reproduction) -> None:
    claimed = [row for row in found.rows if row.tolerance is not None]
    assert len(claimed) == 7
    assert all(row.within for row in claimed), claimed


def test_bounds_stand_above_the_controller(found: Reproduction) -> None:
    for limit in LIMITS:
        case = f"step of 480 N m, motor of {limit:g} N m"
        best = ours(found, case, "torsional_speed_reduction, bound")
        assert best - 0.05 < ours(found, case, "torsional_speed_reduction, damping_mpc") < best


def test_trends_over_weights_are_the_published_ones_and_over_the_horizon_only_with_euler(found: Reproduction) -> None:
    def rms(case: str) -> float:
        return ours(found, case, "correction_torque_rms")

    assert rms("q = 1") < rms("q = 10")
    assert rms("r = 1") > rms("r = 10")
    assert rms("prediction_horizon = 10") < rms("prediction_horizon = 100")
    assert rms("prediction_horizon, forward Euler = 10") > rms("prediction_horizon, forward Euler = 100")


def test_page_and_rows_are_written(found: Reproduction, tmp_path: Path) -> None:
    save(found, tmp_path)
    rows = json.loads((tmp_path / "rows.json").read_text())["rows"]
    keys = {"case", "quantity", "published", "ours", "unit", "tolerance", "within"}
    assert all(set(row) == keys for row in rows)
    assert "control horizon, steps" in (tmp_path / "reproduction.html").read_text(encoding="utf-8")


def test_least_loss_against_a_search_over_weights() -> None:
    rng = np.random.default_rng(2)
    figures = rng.uniform(1.0, 2.0, (30, 3))
    weights = rng.dirichlet(np.ones(3), 20_000)
    for chosen in range(5):
        costs = (figures / figures[chosen]) @ weights.T
        searched = float((1.0 - costs.min(axis=0)).min())
        assert least_loss(figures, chosen) == pytest.approx(searched, abs=5e-3)
        assert least_loss(figures, chosen) <= searched + 1e-9
