"""Reproduction of the paper on the cheapest launch: its contract, what it claims, and the experiments on its steps."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from bitepoint.assembly import assemble
from bitepoint.scenarios.routes import load_route
from bitepoint.simulation.run import Simulation
from bitepoint.studies.eco_launch import fuel
from bitepoint.studies.eco_launch.cruise import STEEPNESS, scaled
from bitepoint.studies.eco_launch.euler import EULER, EXACT, euler_error, grid_plan
from bitepoint.studies.eco_launch.launches import BASELINES, PUBLISHED_SAVING
from bitepoint.studies.eco_launch.study import vehicle_model
from bitepoint.studies.papers import reproduce, save
from bitepoint.studies.reproduction import Reproduction, Row


@pytest.fixture(scope="module")
def found() -> Reproduction:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fuel, "data_folder", lambda: None)  # the fit itself is tested on measured data
        return reproduce("eco-launch")


def ours(found: Reproduction, case: str, quantity: str) -> float:
    value = next(row.ours for row in found.rows if (row.case, row.quantity) == (case, quantity))
    assert value is not None
    return value


def test_every_claim_is_within(found: Reproduction) -> None:
    claimed = [row for row in found.rows if row.tolerance is not None and row.reason == ""]
    assert len(claimed) == 25
    assert not [row for row in claimed if not row.within]


def test_without_measured_data_its_rows_say_so_and_claim_nothing(found: Reproduction) -> None:
    rows = [row for row in found.rows if row.reason]
    assert {row.quantity for row in rows} >= {"total_percent", "r2"}
    for row in rows:
        assert (row.ours, row.within, row.reason) == (None, None, "no measured data")
        assert "no measured data" in row.cells[3]
        assert row.to_json()["reason"] == "no measured data"


def test_saving_grows_with_the_speed_at_which_the_driver_shifts(found: Reproduction) -> None:
    savings = [ours(found, f"{name}, equal time and energy", "fuel_saving_equal_time") for name in BASELINES]
    assert savings == sorted(savings)
    raw = [ours(found, f"{name}, the paper's protocol", "fuel_saving_raw") for name in BASELINES]
    assert raw[0] < PUBLISHED_SAVING < raw[-1]


def test_how_fast_the_gearbox_shifts_hardly_matters(found: Reproduction) -> None:
    usual = ours(found, "typical, equal time and energy", "fuel_saving_equal_time")
    for time in ("0.05", "0.5"):
        other = ours(found, f"typical, a gearbox that shifts in {time} s", "fuel_saving_equal_time")
        assert other == pytest.approx(usual, abs=0.01)  # the driver beside the plan shifts with it as well


def test_the_papers_steps_promise_what_no_engine_can_do(found: Reproduction) -> None:
    for step in (2, 5, 10):
        assert ours(found, f"the paper's programme, steps of {step} m", "fuel over that at the best efficiency") < 1.0
    error = ours(found, "forward Euler, steps of 5 m", "speed too high after 10 m at 2 m/s²")
    assert 3.6 * error == pytest.approx(11.8, abs=0.1)


def test_finer_steps_on_uniform_speeds_make_it_worse(found: Reproduction) -> None:
    fuels = [ours(found, f"uniform speeds, exact steps of {step:g} m", "total_fuel") for step in (2.0, 1.0, 0.5)]
    assert fuels == sorted(fuels)
    assert fuels[-1] > 1.03 * fuels[0]


def test_on_hills_foresight_saves_what_brakes_would_take_and_nothing_on_the_flat(found: Reproduction) -> None:
    def of(grade: float, quantity: str) -> float:
        return ours(found, f"beyond: set speed held in the best gears, grade {100.0 * grade:g} %", quantity)

    savings = [of(grade, "saving") for grade in STEEPNESS]
    assert abs(savings[0]) < 1e-4
    assert savings == sorted(savings)
    for grade in STEEPNESS:
        assert of(grade, "brake work, with foresight") <= of(grade, "brake work, held")
        assert of(grade, "what less braking and overrun explains") == pytest.approx(of(grade, "saving"), abs=0.012)


def test_page_and_rows_are_written(found: Reproduction, tmp_path: Path) -> None:
    save(found, tmp_path)
    rows = json.loads((tmp_path / "rows.json").read_text())["rows"]
    keys = {"case", "quantity", "published", "ours", "unit", "tolerance", "within"}
    assert all(set(row) - {"reason"} == keys for row in rows)
    page = (tmp_path / "reproduction.html").read_text(encoding="utf-8")
    for caption in ("Economical shift schedule", "Saving against four drivers", "Fuel against time"):
        assert caption in page


@pytest.mark.parametrize("step", [0.1, 1.0, 5.0])
def test_error_of_a_step_is_the_energy_that_it_makes(step: float) -> None:
    start, acceleration = 2.0, 1.5
    end = math.sqrt(start**2 + 2.0 * acceleration * step) + euler_error(acceleration, start, step, step)
    assert end**2 - start**2 - 2.0 * acceleration * step == pytest.approx((acceleration * step / start) ** 2)


def test_exact_steps_keep_energy_and_agree_with_the_planner() -> None:
    model = vehicle_model()
    speeds = np.sqrt(np.linspace((5 / 3.6) ** 2, (49.8 / 3.6) ** 2, 225))
    exact = grid_plan(model, 5 / 3.6, 49.8 / 3.6, 150.0, 75, speeds, EXACT)
    assert exact is not None
    assert abs(exact.gain) < 150.0
    assert exact.fuel == pytest.approx(13.5e-3, rel=0.015)
    euler = grid_plan(model, 5 / 3.6, 49.8 / 3.6, 150.0, 75, speeds, EULER)
    assert euler is not None
    assert euler.gain > 10e3
    assert grid_plan(model, 5 / 3.6, 49.8 / 3.6, 10.0, 10, speeds, EXACT) is None


def test_a_scaled_road_has_the_grade_that_was_asked_for() -> None:
    road = load_route("hills")
    whole = scaled(road, 0.03, road.length)
    assert float(whole.grade.std()) == pytest.approx(0.03)
    assert scaled(road, 0.03, 10_000.0).length == 10_000.0


def test_a_plan_whose_shifts_take_no_time_is_driven() -> None:
    assembly = assemble("eco-launch", {"planner.shift_time": "0 s"})
    lane = Simulation(assembly.system).run(lambda recording: recording)[0]
    assert lane.status == "arrived"


@pytest.mark.parametrize(
    ("row", "within"),
    [
        (Row("c", "q", 2.0, -1.9, "%", 0.0, "magnitude"), True),
        (Row("c", "q", 2.0, -2.1, "%", 0.0, "magnitude"), False),
        (Row("c", "q", 0.83, 0.84, "1", 0.0, "least"), True),
        (Row("c", "q", 0.83, 0.82, "1", 0.0, "least"), False),
        (Row("c", "q", 0.83, None, "1", 0.0, "least", "no data"), None),
    ],
)
def test_verdict(row: Row, within: bool | None) -> None:
    assert row.within is within
