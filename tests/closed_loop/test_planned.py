"""Scenarios that are planned before they are driven: what a plan saves on the plant, and what is refused."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

import bitepoint
from bitepoint import Result
from bitepoint.assembly import Comparer, assemble
from bitepoint.assembly.comparison import Drive
from bitepoint.files import library_folder
from bitepoint.models.fuel_model import FuelModel, GearRule
from bitepoint.recording import Recording
from bitepoint.records import Curve
from tests.conftest import Refused, names_in

LENGTH = 150.0


@cache
def launched(**settings: str) -> Result:
    return bitepoint.run("eco-launch", {key.replace("__", "."): value for key, value in settings.items()})


def value(result: Result, name: str) -> float:
    found = result.metrics[name].value
    assert found is not None, name
    return found


@pytest.mark.parametrize(("baseline", "least"), [("typical", 0.08), ("eco", 0.025)])
def test_a_launch_to_a_plan_saves_fuel_in_the_same_time(baseline: str, least: float) -> None:
    result = launched(baseline=baseline)
    assert result.status == "arrived"
    assert value(result, "fuel_saving_equal_time") >= least
    assert value(result, "saving_realised") >= 0.95
    assert abs(value(result, "end_speed_error")) < 0.1 / 3.6 * 2
    assert value(result, "grid_gap") <= 0.003
    assert value(result, "mean_speed_loss") > 0.0
    assert value(result, "fuel_saving_raw") == pytest.approx(
        1.0 - value(result, "fuel_used") / value(result, "baseline_fuel")
    )


def test_the_saving_is_what_the_recordings_say() -> None:
    """Fuel, time and speed where the way ends, from the rows alone; the fuel of a joule from two steady speeds."""
    result = launched(baseline="typical")
    base, equal = result.compared["baseline"], result.compared["equal-time"]

    def at_the_end(recording: Recording, name: str) -> float:
        way = recording["distance"]
        k = int(np.argmax(way > LENGTH))
        share = (LENGTH - way[k - 1]) / (way[k] - way[k - 1])
        column = recording.time if name == "time" else recording[name]
        return float(column[k - 1] + share * (column[k] - column[k - 1]))

    assert at_the_end(equal, "time") == pytest.approx(at_the_end(base, "time"), rel=2.1e-3)
    mass = 1474.0 + 3.6 / 0.317**2
    worth = 240e-3 / 3.6e6 / 0.92  # kg/J at the wheels, at the engine's best, 239 g/kWh
    corrected = {
        name: at_the_end(each, "fuel_used")
        - worth * 0.5 * mass * (at_the_end(each, "vehicle_speed") ** 2 - (49.8 / 3.6) ** 2)
        for name, each in (("base", base), ("equal", equal))
    }
    assert value(result, "fuel_saving_equal_time") == pytest.approx(
        1.0 - corrected["equal"] / corrected["base"], abs=0.004
    )


def test_a_price_of_time_and_a_least_acceleration_are_kept() -> None:
    cheap, dear = launched(), launched(planner__time_price="2 g/s")
    assert value(dear, "drive_time") < value(cheap, "drive_time") - 2.0
    assert value(dear, "fuel_used") > value(cheap, "fuel_used")
    plan = assemble("eco-launch", {"planner.minimum_acceleration": "0.6 m/s^2"}).planned
    assert plan is not None
    driven = ~plan.plan.shifting[:-1] & (plan.plan.engine_torque[:-1] > 0.0)
    assert plan.plan.acceleration[:-1][driven].min() >= 0.6 - 1e-9
    assert (np.diff(plan.plan.gear) >= 0).all()


def test_gears_alone_save_nothing_where_the_gear_is_the_best_one() -> None:
    """With a single gear there is no better one; with all of them, what is saved is between nothing and all."""
    assembly = assemble("eco-launch", {})
    assert assembly.planned is not None
    recording = launched(baseline="typical").compared["baseline"]

    def saved(model: np.ndarray, driven: Recording) -> float:
        planned = dataclasses.replace(assembly.planned, model=model)
        return Comparer(planned, assembly.system, assembly.baseline, 0, "compiled").gear_only_saving(driven)

    model = assembly.planned.model.copy()
    assert 0.0 < saved(model, recording) < 0.3
    model["gearbox"]["ratios"][0, 3:] = 0.0
    row = [channel.name for channel in recording.channels].index("gear")
    data = recording.data.copy()
    data[row] = 3.0
    model["gearbox"]["ratios"][0, :3] = 1.436
    assert saved(model, dataclasses.replace(recording, data=data)) == pytest.approx(0.0, abs=1e-12)


def test_a_drive_that_does_not_arrive_has_no_figures_at_the_end() -> None:
    result = bitepoint.run("eco-launch", {"timing.duration": "3 s"})
    assert result.status == "timed out"
    assert result.metrics["fuel_saving_raw"].value is None
    assert Drive.of(result.recording, LENGTH) is None


def test_predictive_cruise_saves_over_hills() -> None:
    result = bitepoint.run("predictive-cruise")
    assert result.status == "arrived"
    assert value(result, "fuel_saving_equal_time") >= 0.03
    assert value(result, "saving_realised") >= 0.95
    assert value(result, "drive_time") == pytest.approx(20_000.0 / (73.7 / 3.6), rel=5e-3)
    speed = result.recording["vehicle_speed"] * 3.6
    assert speed.min() > 73.7 - 5.0 - 1.5  # the band holds for the plan; shifts uphill fall below it a little
    assert speed.max() < 73.7 + 5.0 + 0.5


def test_a_road_from_a_file_is_driven(tmp_path: Path) -> None:
    road = tmp_path / "road.csv"
    rows = [f"{s},{2.0 * np.sin(s / 300.0):.6f}" for s in range(0, 3001, 20)]
    road.write_text("distance_m,grade_percent\n" + "\n".join(rows) + "\n")
    result = bitepoint.run("predictive-cruise", {"road": str(road), "cruise.receding": "1"})
    assert value(result, "distance") == 3000.0
    grade = np.interp(
        result.recording["distance"], range(0, 3001, 20), [2e-2 * np.sin(s / 300.0) for s in range(0, 3001, 20)]
    )
    assert result.recording["road_grade"] == pytest.approx(grade, abs=1e-4)


def test_limits_of_the_road_hold_for_the_plan_and_for_the_baseline(tmp_path: Path) -> None:
    road = tmp_path / "road.csv"
    limits = [f"{s},0,{50 if 1000 <= s < 2000 else 90}" for s in range(0, 3001, 20)]
    road.write_text("distance_m,grade,speed_limit_kmh\n" + "\n".join(limits) + "\n")
    result = bitepoint.run("predictive-cruise", {"road": str(road)})
    for recording, late in ((result.recording, 0.0), (result.compared["baseline"], 150.0)):
        way, speed = recording["distance"], recording["vehicle_speed"] * 3.6
        assert speed[(way > 1000.0 + late) & (way < 2000.0)].max() < 52.0
        assert speed[way < 900.0].max() > 73.0
    assert value(result, "fuel_saving_equal_time") > 0.0


def road_with_stops(path: Path, length: float, stops: list[float], grade: float = 0.0) -> str:
    """Write a road with stop lines; return its name."""
    places = sorted({0.0, length, *stops})
    path.write_text("distance_m,grade,stop\n" + "".join(f"{s},{grade},{int(s in stops)}\n" for s in places))
    return str(path)


def stands(recording: Recording) -> list[tuple[float, float]]:
    """Return where the vehicle stands, m, and for how long, s."""
    still = np.abs(recording["vehicle_speed"]) < 0.08  # it rocks once
    edges = np.flatnonzero(np.diff(np.concatenate(([0], still.astype(int), [0]))))
    time, way = np.append(recording.time, recording.time[-1]), recording["distance"]
    return [(float(way[a]), float(time[b] - time[a])) for a, b in edges.reshape(-1, 2)]


@pytest.mark.parametrize(
    ("scenario", "length", "stops", "grade", "settings"),
    [
        ("predictive-cruise", 2000.0, [703.0, 1301.0], 0.0, {"cruise.minimum_acceleration": "-1.5 m/s^2"}),
        ("predictive-cruise", 2000.0, [703.0, 1301.0], -0.04, {"cruise.receding": "1"}),
        (
            "eco-launch",
            400.0,
            [151.0],
            0.12,
            {"planner.minimum_acceleration": "-2 m/s^2", "planner.time_price": "2 g/s"},
        ),
        ("eco-launch", 400.0, [151.0], -0.10, {"planner.minimum_acceleration": "-2 m/s^2"}),
        ("eco-launch", 400.0, [151.0], -0.20, {"planner.minimum_acceleration": "-1 m/s^2"}),
    ],
)
def test_stop_lines_are_kept(
    tmp_path: Path, scenario: str, length: float, stops: list[float], grade: float, settings: dict[str, str]
) -> None:
    """By the plan and by the baseline: within half a metre of each line, for as long as was asked."""
    kind = "planner" if scenario == "eco-launch" else "cruise"
    road = road_with_stops(tmp_path / "road.csv", length, stops, grade)
    result = bitepoint.run(scenario, {"road": road, f"{kind}.dwell": "3 s", **settings})
    assert result.status == "arrived"
    assert {"baseline"} <= set(result.compared)
    for recording in (result.recording, *result.compared.values()):
        stood = stands(recording)
        assert [way for way, _ in stood] == pytest.approx(stops, abs=0.5)
        assert all(2.4 < time < 5.5 for _, time in stood)
    assert value(result, "fuel_saving_equal_time") > 0.04
    assert result.metrics["saving_realised"].value is None or value(result, "saving_realised") > 0.9


def test_where_no_plan_is_as_fast_as_the_baseline_it_is_told(tmp_path: Path) -> None:
    road = road_with_stops(tmp_path / "road.csv", 2000.0, [1000.0])
    result = bitepoint.run("predictive-cruise", {"road": road, "cruise.minimum_acceleration": "-0.4 m/s^2"})
    assert result.status == "arrived"
    assert result.metrics["fuel_saving_raw"].value is not None
    assert str(result.metrics["fuel_saving_equal_time"]) == "– (no plan is as fast as the baseline)"


def test_lines_that_cannot_be_kept_are_refused(tmp_path: Path, refused: Refused) -> None:
    many = road_with_stops(tmp_path / "many.csv", 4000.0, [100.0 * k for k in range(1, 34)])
    refused(lambda: bitepoint.run("predictive-cruise", {"road": many}), "33 stop lines", "expected up to 32")
    last = road_with_stops(tmp_path / "last.csv", 1000.0, [1000.0])
    refused(lambda: bitepoint.run("predictive-cruise", {"road": last}), "a stop line at its end", "go on")
    one = road_with_stops(tmp_path / "one.csv", 300.0, [150.0])
    refused(lambda: bitepoint.run("eco-launch", {"road": one}), "may not slow down", "less than 0 m/s^2")


def test_a_planned_drive_writes_the_drives_beside_it(tmp_path: Path) -> None:
    launched().save(tmp_path)
    assert names_in(tmp_path) == [
        "baseline.parquet", "driving.html", "equal-time.parquet", "metrics.json", "recording.parquet",
    ]  # fmt: skip
    assert "Over the way" in (tmp_path / "driving.html").read_text()


@pytest.mark.parametrize(
    ("scenario", "settings", "line"),
    [
        ("eco-launch", {"baseline": "sporty"}, "baseline: got sporty; expected one of eco, mid, typical, late, cruise"),
        ("eco-launch", {"planner.time_price": "-1 g/s"}, "planner.time_price"),
        ("eco-launch", {"planner.colour": "1"}, "--set: planner.colour: unknown key"),
        (
            "eco-launch",
            {"planner.length": "12 m"},
            "planner: at 12 m: no faster than 12.5 m/s, where 13.8 m/s is wanted",
        ),
        ("eco-launch", {"planner.length": "20 m"}, "planner: no way from 1.38889 m/s to 13.8333..13.8333 m/s"),
        (
            "eco-launch",
            {"speed": "x.csv", "speed.column": "v"},
            "--set: speed: eco-launch drives to a plan; leave it out",
        ),
        ("eco-launch", {"planner.fuel_model": "no.json"}, "no.json"),
        ("predictive-cruise", {"cruise.band": "0.1 km/h"}, "cruise.band"),
        ("predictive-cruise", {"cruise.set_speed": "200 km/h"}, "cruise: no gear holds 55.5556 m/s"),
        ("predictive-cruise", {"road": "nowhere"}, "nowhere: no such road"),
        ("eco-launch", {"road": "hills"}, "planner: a launch over 20000 m; expected up to 1000 m"),
        ("dct-launch", {"baseline": "eco"}, "--set: baseline: unknown key"),
        ("dct-launch", {"planner.length": "100 m"}, "--set: planner: unknown group"),
    ],
)
def test_what_cannot_be_planned_is_refused(
    refused: Refused, scenario: str, settings: dict[str, str], line: str
) -> None:
    refused(lambda: bitepoint.run(scenario, settings), line)


def test_a_plan_takes_a_fuel_model_that_knows_gears(tmp_path: Path, refused: Refused) -> None:
    planned = assemble("eco-launch", {}).planned
    assert planned is not None
    correction = planned.model["correction"].copy()
    for edge, acceleration in (("lowest", -3.0), ("highest", 3.0)):
        correction[edge] = Curve.through([0.0, 40.0], [acceleration, acceleration])[0]
    plain, steady = str(tmp_path / "plain.json"), str(tmp_path / "steady.json")
    FuelModel(correction).save(plain)
    refused(lambda: bitepoint.run("eco-launch", {"planner.fuel_model": plain}), f"{plain}: a plain fuel model")
    vehicle = planned.model.copy()
    vehicle["engine"]["fuel"]["z"] *= 2.0
    rule = GearRule.parse({"lowest_speed": 120.0, "highest_load": 0.9}, "")
    FuelModel(correction, vehicle, rule).save(steady)
    twice = assemble("eco-launch", {"planner.fuel_model": steady}).planned
    assert twice is not None
    assert twice.plan.total_fuel == pytest.approx(2.0 * planned.plan.total_fuel, rel=0.01)


def test_a_scenario_file_of_a_planned_drive(tmp_path: Path, refused: Refused) -> None:
    text = (library_folder("scenarios") / "eco-launch.yaml").read_text()
    data = yaml.safe_load(text)
    data["cruise"] = {"band": "5 km/h"}
    path = tmp_path / "both.yaml"
    path.write_text(yaml.safe_dump(data))
    refused(lambda: bitepoint.run(str(path)), "cruise: beside planner; leave one of them out")


def test_names_that_others_rely_on() -> None:
    said = launched(baseline="mid").to_json()
    assert set(said["metrics"]) >= {
        "fuel_used", "fuel_saving_equal_time", "fuel_saving_raw", "gear_only_share", "mean_speed_loss",
        "end_speed_error", "plan_time", "grid_gap",
    }  # fmt: skip
