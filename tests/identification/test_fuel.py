"""Fuel from logs of a drive: a synthetic truth comes back, outliers go, and what cannot be read is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint.identification.fuel.drives import REACH, joined, motion, vsp_outliers
from bitepoint.identification.fuel.engine_map import EnginePoints, read_points
from bitepoint.identification.fuel.folds import folds_of
from bitepoint.identification.fuel.logs import LogOptions, read_drives
from bitepoint.identification.fuel.measured import with_points
from bitepoint.identification.fuel.models import gear_rules, modelled
from bitepoint.identification.fuel.polynomials import CORRECTIONS, PLAIN, POWER, fit_correction, fit_plain
from bitepoint.identification.fuel.regression import clipped_least_squares
from bitepoint.identification.fuel.steady import fit_willans, vehicle_for, willans_columns, with_steady
from bitepoint.models.fuel_model import FuelModel, backward
from bitepoint.numerics.tables import lookup_map
from bitepoint.recording import Channel, Recording
from tests.conftest import REPOSITORY, Command, Refused

CAR = str(REPOSITORY / "examples" / "camry-2018.yaml")
TRUTH = (2e-4, 2e-5, 0.0, 4e-8, 7e-5, 1e-6, 2e-5)
"""Of 1, v, v^2, v^3, v a, v^2 a and v a^2: kg/s with m/s and m/s^2."""


def truth(speed: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    terms = [k * speed**i * acceleration**j for k, (i, j) in zip(TRUTH, POWER.terms, strict=True)]
    return np.maximum(sum(terms), 0.0)


def speeds(seed: int, rows: int = 900, top: float = 28.0) -> np.ndarray:
    """A drive with stops: a slow swing with a faster one on it."""
    time, rng = np.arange(rows) * 1.0, np.random.default_rng(seed)
    swing = np.sin(2 * np.pi * time / (140.0 + 10 * seed)) + 0.15 * np.sin(2 * np.pi * time / 23.0 + rng.uniform(0, 6))
    return np.clip(0.5 * top * (swing + 0.7), 0.0, top)


def recording(seed: int, lead: float = 0.0, noise: float = 0.0, **more: Any) -> Recording:
    v = speeds(seed, **more)
    time = np.arange(len(v), dtype=np.float64)
    bare = Recording(time, (Channel("vehicle_speed", "m/s"),), v[None])
    fuel = truth(*motion(bare, lead)) + noise * np.random.default_rng(seed).standard_normal(len(v))
    channels = (Channel("fuel_flow", "kg/s"), Channel("vehicle_speed", "m/s"))
    return Recording(time, channels, np.array([np.maximum(fuel, 0.0), v]), {"file": f"drive-{seed}"})


def write(path: Path, drive: Recording, fuel: tuple[str, float] = ("fuel_flow", 1.0)) -> Path:
    lines = [f"time_s,{fuel[0]},speed_mph"]
    for row in zip(drive.time, drive["fuel_flow"] * fuel[1], drive["vehicle_speed"] / 0.44704, strict=True):
        lines.append(",".join(repr(float(value)) for value in row))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_least_squares_of_what_is_cut_at_zero_finds_the_line_behind_it() -> None:
    x = np.stack([np.ones(400), np.linspace(-3.0, 3.0, 400)], axis=1)
    y = np.maximum(x @ [0.5, 2.0], 0.0)
    assert clipped_least_squares(x, y) == pytest.approx([0.5, 2.0], abs=1e-9)
    assert clipped_least_squares(x, y, np.array([0.0, 2.5]))[1] >= 2.5
    straight = np.linalg.lstsq(x, y, rcond=None)[0]
    assert abs(straight[1] - 2.0) > 0.5  # the rows at zero pull a straight line down


def test_a_synthetic_truth_is_recovered_with_its_lead(tmp_path: Path) -> None:
    files = [write(tmp_path / f"{n}.csv", recording(n, lead=0.25, noise=2e-5)) for n in range(3)]
    check = write(tmp_path / "check.csv", recording(7, lead=0.25, top=36.0))
    found = bitepoint.identify_fuel(files, validate=check)
    assert found.delay == 0.25
    assert (found.model.about["kind"], found.model.about["method"]) == ("plain", "power")
    assert found.errors["validation"].r2 > 0.995
    assert abs(found.errors["validation"].total_percent) < 1.0
    for k, (i, j) in zip(TRUTH, POWER.terms, strict=True):
        scale = 25.0**i * 1.0**j  # what each term is worth at 25 m/s and 1 m/s^2
        assert found.model.correction["rising"][0][i, j] * scale == pytest.approx(k * scale, abs=5e-5)


def test_the_choice_does_not_look_at_the_validation(tmp_path: Path) -> None:
    files = [write(tmp_path / f"{n}.csv", recording(n, noise=2e-5)) for n in range(2)]
    check = recording(7)
    odd = Recording(check.time, check.channels, np.array([check["fuel_flow"][::-1], check["vehicle_speed"]]), {})
    first = bitepoint.identify_fuel(files, validate=write(tmp_path / "a.csv", check))
    second = bitepoint.identify_fuel(files, validate=write(tmp_path / "b.csv", odd))
    assert (first.model.correction == second.model.correction).all()
    assert first.delay == second.delay
    assert second.errors["validation"].r2 < first.errors["validation"].r2 - 0.5


def test_a_spike_is_an_outlier_and_a_small_bin_has_none() -> None:
    drive = joined([recording(0), recording(1)], 0.0)
    number = np.floor(drive.specific_power / 2.0)
    counts = {each: int((number == each).sum()) for each in np.unique(number)}
    large, small = [each for each, rows in counts.items() if rows >= 60][:2]
    spare = np.flatnonzero(number == small)[REACH:]
    kept = ~np.isin(np.arange(len(drive)), spare)
    drive, number = drive.rows(kept), number[kept]
    for bin_number, fires in ((large, True), (small, False)):
        row = int(np.flatnonzero(number == bin_number)[0])
        spoiled = drive.fuel.copy()
        spoiled[row] = 0.05
        out, _ = vsp_outliers(replace(drive, fuel=spoiled))
        assert bool(out[row]) is fires
    _, bins = vsp_outliers(drive)
    assert sum(each.rows for each in bins) == len(drive)


def test_no_row_of_ten_can_be_three_standard_deviations_off() -> None:
    for rows, fires in ((10, False), (11, True)):
        values = np.zeros(rows)
        values[0] = 1.0
        assert (abs(values[0] - values.mean()) > 3.0 * values.std(ddof=1)) is np.bool_(fires)


def test_the_hardest_fold_is_the_fifth_with_the_highest_power() -> None:
    drive = joined([recording(0), recording(1)], 0.0)
    *logs, hardest = folds_of(drive)
    assert len(logs) == 2
    assert hardest.mean() == pytest.approx(0.2, abs=0.01)
    assert drive.specific_power[hardest].min() >= drive.specific_power[~hardest].max()
    assert len(folds_of(joined([recording(0)], 0.0))) == 5


@pytest.mark.parametrize("family", PLAIN, ids=lambda family: family.name)
def test_beyond_the_hull_a_polynomial_is_held(family: Any) -> None:
    drive = joined([recording(0), recording(1)], 0.0)
    model = FuelModel(fit_plain(family, drive))
    edge = float(drive.speed.max())
    fuel = model.flow(np.array([edge, 1.4 * edge, edge, edge]), np.array([0.0, 0.0, 9.0, 12.0]))
    if family.open_above:
        assert fuel[1] > 1.05 * fuel[0]
        assert fuel[3] > fuel[2] > fuel[0]
    else:
        assert fuel[1] == fuel[0]
        assert fuel[3] == fuel[2]
    braking = model.flow(np.full(3, 15.0), np.array([-3.0, -6.0, -12.0]))
    assert braking[1] == braking[2]


def write_engine(path: Path, drive: Any, fuel: np.ndarray, turning: np.ndarray, torque: np.ndarray) -> Path:
    rows = np.column_stack([drive.time, fuel * 1e3, drive.speed * 3.6, turning * 30 / np.pi, torque])
    header = "time_s,fuel_flow_g_per_s,vehicle_speed_kmh,engine_speed_rpm,engine_torque_nm"
    np.savetxt(path, rows, delimiter=",", header=header, comments="")
    return path


def test_a_steady_map_is_recovered_from_logged_points_and_from_the_motion() -> None:
    car, rule = vehicle_for(CAR), gear_rules(logged=True)[0]
    coefficients = np.array([3e-5, 8e-7, 2e-9, 5.9e-8, 3e-11])
    true = FuelModel(_nothing(), with_steady(car, coefficients), rule)
    drive = joined([recording(0), recording(1), recording(2)], 0.0)
    _, turning, torque = backward(car, rule, drive.speed, drive.acceleration, drive.grade)
    points = np.maximum(willans_columns(turning, torque) @ coefficients, 0.0)
    assert fit_willans(turning, torque, points) == pytest.approx(coefficients, rel=1e-6)
    again = FuelModel(_nothing(), with_steady(car, fit_willans(turning, torque, points)), rule)
    a, b = modelled(true, drive), modelled(again, drive)
    assert a == pytest.approx(b, abs=1e-9)
    driving = torque > 0.0  # on overrun the record takes another line to nothing than the points
    assert a[driving] == pytest.approx(points[driving], rel=0.02, abs=2e-6)
    assert (a[torque < -60.0] == 0.0).all()


def test_logged_engine_speed_and_torque_take_the_place_of_the_motion(tmp_path: Path) -> None:
    car, rule = vehicle_for(CAR), gear_rules(logged=True)[0]
    coefficients = np.array([3e-5, 8e-7, 2e-9, 5.9e-8, 3e-11])
    files: list[Path] = []
    for n in range(2):
        drive = joined([recording(n)], 0.0)
        _, turning, torque = backward(car, rule, drive.speed, drive.acceleration, drive.grade)
        torque = torque + 60.0 * np.sin(drive.time / 40.0)  # a wind, which only the engine feels
        fuel = np.maximum(willans_columns(turning, torque) @ coefficients, 0.0)
        files.append(write_engine(tmp_path / f"{n}.csv", drive, fuel, turning, torque))
    found = bitepoint.identify_fuel(files[0], validate=files[1], vehicle=CAR, delays={"fuel_flow": 0.0})
    steady = next(each for each in found.tried if each.kind == "steady")
    plain = max((each for each in found.tried if each.kind == "plain"), key=lambda each: each.score)
    assert found.delay == 0.0
    assert steady.errors["validation"].r2 > 0.99
    assert plain.errors["validation"].r2 < 0.9
    assert abs(steady.errors["validation"].total_percent) < 1.5
    unused = bitepoint.identify_fuel(files[0])
    assert any("a steady map needs --vehicle" in warning for warning in unused.warnings)


def island(speed: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """A steady fuel, kg/s, that is no Willans line: it has a place of best efficiency."""
    off = ((speed - 230.0) / 200.0) ** 2 + ((torque - 140.0) / 120.0) ** 2
    return 4e-5 + 4e-7 * speed + speed * torque / (0.40 * 42.67e6) * (1.0 + 0.25 * off)


def points_file(path: Path, speed: np.ndarray, torque: np.ndarray, fuel: np.ndarray) -> Path:
    rows = np.column_stack([speed * 30 / np.pi, torque, fuel * 1e3])
    np.savetxt(path, rows, delimiter=",", header="speed_rpm,torque_nm,fuel_g_per_s", comments="")
    return path


def scattered(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.uniform(80.0, 560.0, count), rng.uniform(5.0, 230.0, count)


def test_a_measured_map_goes_through_its_points_and_between_them(tmp_path: Path) -> None:
    speed, torque = scattered(0, 150)
    noisy = island(speed, torque) * (1.0 + 0.005 * np.random.default_rng(1).standard_normal(150))
    path = points_file(tmp_path / "map.csv", speed, torque, noisy)
    car = vehicle_for(CAR)
    bent = with_points(car, read_points(path), "map.csv").vehicle
    line = with_steady(car, fit_willans(speed, torque, noisy))
    turning, load = scattered(2, 300)

    def missed(vehicle: np.ndarray) -> np.ndarray:
        found = lookup_map.run(np.repeat(vehicle["engine"]["fuel"], 300), turning, load)
        return (found / island(turning, load) - 1.0)[load > 20.0]

    assert np.sqrt(np.mean(missed(bent) ** 2)) < 0.01
    assert np.sqrt(np.mean(missed(line) ** 2)) > 0.04
    flow = bent["engine"]["fuel"]["z"][0]
    assert (np.diff(flow, axis=1) >= 0.0).all()


def test_points_above_full_load_or_beyond_the_map_do_not_count_and_are_told(tmp_path: Path) -> None:
    speed, torque = scattered(0, 150)
    above = np.array([[90.0, 210.0], [120.0, 225.0], [100.0, 250.0]])  # of 143, 164 and 148 N m
    beyond = np.array([[20.0, 50.0], [300.0, -20.0]])
    car, fuel = vehicle_for(CAR), island(speed, torque)
    more = (np.append(each, [*above[:, k], *beyond[:, k]]) for k, each in enumerate((speed, torque)))
    path = points_file(tmp_path / "map.csv", *more, np.append(fuel, np.full(5, 0.02)))
    found = with_points(car, read_points(path), str(path))
    limit = 1.1 * np.interp(speed, car["engine"]["full_load"]["x"][0], car["engine"]["full_load"]["y"][0])
    high = int(np.count_nonzero(torque > limit))
    told = f"map.csv: {high + 5} of 155 points are left out: {high + 3} at more than 1.1 times full load, 2 beyond 44.."
    assert found.warnings[0].startswith(told)
    bare = with_points(car, EnginePoints(speed, torque, fuel).rows(torque <= limit), "map.csv")
    a, b = (each.vehicle["engine"]["fuel"]["z"] for each in (found, bare))
    assert a == pytest.approx(b, rel=1e-6, abs=1e-9)
    assert not any("left out" in each for each in bare.warnings)


def test_a_map_whose_points_are_far_from_idle_says_so() -> None:
    speed, torque = scattered(0, 150)
    points = EnginePoints(speed, torque, island(speed, torque))
    told = with_points(vehicle_for(CAR), points.rows(torque > 60.0), "bench/map.csv").warnings
    assert any(each.startswith("map.csv: idle, 700 r/min and 0 N m, is ") for each in told)
    idle = EnginePoints(np.append(speed, 75.0), np.append(torque, 2.0), np.append(points.fuel, 7.5e-5))
    assert not any("idle" in each for each in with_points(vehicle_for(CAR), idle, "map.csv").warnings)


@pytest.mark.parametrize(("bent", "said"), [(True, "the least smoothing"), (False, "the most smoothing")])
def test_a_smoothing_at_an_end_of_what_is_tried_is_told(bent: bool, said: str) -> None:
    speed, torque = scattered(0, 150)
    if bent:
        fuel = island(speed, torque) * (1.0 + 0.2 * np.sin(torque / 15.0) * np.sin(speed / 40.0))
    else:
        noise = 1.0 + 0.1 * np.random.default_rng(1).standard_normal(150)
        fuel = willans_columns(speed, torque) @ np.array([3e-5, 8e-7, 2e-9, 5.9e-8, 3e-11]) * noise
    found = with_points(vehicle_for(CAR), EnginePoints(speed, torque, fuel), "map.csv")
    assert any(each.startswith(f"map.csv: {said}") for each in found.warnings)


@pytest.mark.parametrize("waves", [False, True])
def test_far_beyond_its_points_a_measured_map_does_not_run_off(waves: bool) -> None:
    """Points of the upper half of torque tell of idling what a line through them does, whatever else they have."""
    speed, torque = (each[scattered(0, 150)[1] > 120.0] for each in scattered(0, 150))
    coefficients = np.array([3e-5, 8e-7, 2e-9, 5.9e-8, 3e-11])
    more = np.sin(speed / 60.0) * np.sin(torque / 25.0) if waves else ((torque - 120.0) / 110.0) ** 2
    noisy = 1.0 + 0.005 * np.random.default_rng(1).standard_normal(speed.size)
    fuel = willans_columns(speed, torque) @ coefficients * (1.0 + 0.2 * more) * noisy
    car = with_points(vehicle_for(CAR), EnginePoints(speed, torque, fuel), "map.csv").vehicle
    turning, none = np.array([80.0, 150.0, 300.0]), np.zeros(3)
    found = lookup_map.run(np.repeat(car["engine"]["fuel"], 3), turning, none)
    share = found / (willans_columns(turning, none) @ coefficients)
    assert share.min() > 0.5
    assert share.max() < 2.0


def test_a_measured_map_takes_the_place_of_the_logs(tmp_path: Path) -> None:
    car, rule = vehicle_for(CAR), gear_rules(logged=True)[0]
    path = points_file(tmp_path / "map.csv", *scattered(0, 150), island(*scattered(0, 150)))
    true = FuelModel(_nothing(), with_points(car, read_points(path), "map.csv").vehicle, rule)
    fast = recording(0, top=36.0)
    flow = modelled(true, joined([fast], 0.0))
    log = write(tmp_path / "a.csv", replace(fast, data=np.array([flow, fast["vehicle_speed"]])))
    found = bitepoint.identify_fuel(log, vehicle=CAR, engine_map=path, delays={"fuel_flow": 0.0})
    steady = next(each for each in found.tried if each.kind == "steady")
    assert steady.name.startswith("measured map")
    assert steady.errors["train"].r2 > 0.999
    assert found.model.about["engine_map"] == "map.csv"
    assert not any("not used" in warning for warning in found.warnings)


def test_a_map_that_is_not_taken_is_told(tmp_path: Path) -> None:
    path = points_file(tmp_path / "map.csv", *scattered(0, 150), 2.0 * island(*scattered(0, 150)))
    log = write(tmp_path / "a.csv", recording(0))
    found = bitepoint.identify_fuel(log, vehicle=CAR, engine_map=path, delays={"fuel_flow": 0.0})
    assert found.model.kind == "plain"
    assert found.model.about["engine_map"] is None
    assert any(warning.startswith("map.csv: not used by the model, which is plain") for warning in found.warnings)


def test_a_map_through_logged_points_is_taken_where_it_is_better(tmp_path: Path) -> None:
    car, rule = vehicle_for(CAR), gear_rules(logged=True)[0]
    files: list[Path] = []
    for n in range(2):
        drive = joined([recording(n)], 0.0)
        _, turning, torque = backward(car, rule, drive.speed, drive.acceleration, drive.grade)
        torque = np.where(torque > 0.0, np.minimum(torque + 60.0 * (1 + np.sin(drive.time / 40.0)), 230.0), torque)
        fuel = np.where(torque > 0.0, island(turning, torque), 0.0)
        files.append(write_engine(tmp_path / f"{n}.csv", drive, fuel, turning, torque))
    found = bitepoint.identify_fuel(files[0], validate=files[1], vehicle=CAR, delays={"fuel_flow": 0.0})
    steady = next(each for each in found.tried if each.kind == "steady")
    assert steady.name.startswith("map through logged points")
    assert steady.errors["validation"].r2 > 0.98


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed_rpm,torque_nm\n1000,50\n", "no columns of fuel_flow"),
        ("speed_rpm,torque_nm,fuel\n1000,50,0.5\n", "fuel_flow: 0.5 kg/s"),
        ("speed_rpm,torque_nm,fuel_g_per_s\n1000,50,0.5\n", "1 of 1 points within"),
        ("speed_kmh,torque_nm,fuel_g_per_s\n1000,50,0.5\n", "speed_kmh"),
        ("speed_rpm,torque_nm,fuel_g_per_s\n" + "2000,50,0.5\n" * 20, "3 speeds and 3 torques"),
        (
            "speed_rpm,torque_nm,fuel_g_per_s\n" + "".join(f"{1000 + 99 * k},{10 + 9 * k},0\n" for k in range(20)),
            "fuel_flow is zero at all 20 points",
        ),
    ],
)
def test_points_that_make_no_map_are_refused(tmp_path: Path, refused: Refused, text: str, said: str) -> None:
    log, path = write(tmp_path / "a.csv", recording(0)), tmp_path / "map.csv"
    path.write_text(text)
    refused(lambda: bitepoint.identify_fuel(log, vehicle=CAR, engine_map=path), "map.csv", said)


@pytest.mark.parametrize(("header", "factor"), [("fuel_l_per_h", 3.6e6 / 835.0), ("fuel [cc/s]", 1e6 / 835.0)])
def test_points_of_volume_take_the_density_that_is_given(
    tmp_path: Path, refused: Refused, bitepoint: Command, header: str, factor: float
) -> None:
    path = tmp_path / "map.csv"
    rows = np.column_stack([np.array([1e3, 2e3]), np.array([50.0, 90.0]), np.array([3e-4, 9e-4]) * factor])
    np.savetxt(path, rows, delimiter=",", header=f"speed_rpm,torque_nm,{header}", comments="")
    assert read_points(path, 835.0).fuel == pytest.approx([3e-4, 9e-4])
    refused(lambda: read_points(path), "map.csv", f"{header}: a flow of volume")
    log = str(write(tmp_path / "a.csv", recording(0)))
    given = ("identify", log, "--model", "fuel", "--vehicle", CAR, "--engine-map", str(path))
    bitepoint(*given).refusal("and no density; add --density")
    bitepoint(*given, "--density", "0.835 g/mL").refusal("2 of 2 points within")


def test_points_are_read_in_g_per_h(tmp_path: Path) -> None:
    path = tmp_path / "map.csv"
    path.write_text("speed_rpm,torque_nm,fuel_g_per_h\n1000,50,1080\n")
    assert read_points(path).fuel == pytest.approx([3e-4])


def test_a_marginal_efficiency_is_one_that_there_is() -> None:
    speed, torque = np.meshgrid(np.linspace(80, 400, 20), np.linspace(0, 200, 20))
    points = speed.ravel() * torque.ravel() / (0.8 * 42.67e6)
    found = fit_willans(speed.ravel(), torque.ravel(), points)
    assert found[3] == pytest.approx(1.0 / (0.46 * 42.67e6))


def test_a_correction_takes_up_what_the_steady_map_leaves() -> None:
    drive = joined([recording(0), recording(1)], 0.0)
    steady = 0.9 * drive.fuel + 2e-5
    linear = fit_correction(CORRECTIONS[0], drive, steady)
    left = drive.fuel - steady
    found = FuelModel(linear).flow(drive.speed, drive.acceleration)
    low = drive.speed <= 50.0 / 3.6
    assert float(linear["low_median"][0]) == pytest.approx(float(np.median(left[low])))
    assert np.isfinite(found).all()


def _nothing() -> Any:
    drive = joined([recording(0)], 0.0)
    return fit_correction(CORRECTIONS[0], drive, drive.fuel)  # nothing is left: all zero


@pytest.mark.parametrize("vehicle", [None, CAR])
def test_a_model_file_is_read_as_it_was_written(tmp_path: Path, vehicle: str | None) -> None:
    files = [write(tmp_path / f"{n}.csv", recording(n, noise=2e-5)) for n in range(2)]
    found = bitepoint.identify_fuel(files, vehicle=vehicle)
    steady = next((each.model for each in found.tried if each.kind == "steady"), found.model)
    steady.save(tmp_path / "m.json")
    again = FuelModel.load(tmp_path / "m.json")
    assert again.to_json() == steady.to_json()
    v, a = np.linspace(0, 30, 50), np.linspace(-2, 2, 50)
    assert (again.flow(v, a) == steady.flow(v, a)).all()
    assert again.kind == ("plain" if vehicle is None else "steady")
    car = again.applied(vehicle_for(CAR))
    assert (car["correction"] == again.correction).all()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "cannot be read as JSON"),
        ('{"model": "arx"}', "model: got 'arx'"),
        ('{"model": "fuel", "kind": "plain", "correction": {}}', "correction.lowest: missing"),
    ],
)
def test_another_file_is_no_fuel_model(tmp_path: Path, refused: Refused, text: str, said: str) -> None:
    path = tmp_path / "m.json"
    path.write_text(text)
    refused(lambda: FuelModel.load(path), str(path), said)


@pytest.mark.parametrize(
    ("header", "factor", "volume"),
    [
        ("fuel_flow_cc_per_s", 1e6 / 743.0, True),
        ("fuel_flow [L/h]", 3.6e6 / 743.0, True),
        ("fuel_flow_g_per_s", 1e3, False),
        ("fuel_flow (kg/h)", 3600.0, False),
        ("fuel_rate_g_s", 1e3, False),
    ],
)
def test_fuel_is_read_as_volume_or_as_mass(tmp_path: Path, header: str, factor: float, volume: bool) -> None:
    drive = recording(0)
    data, _ = read_drives([write(tmp_path / "a.csv", drive, (header, factor))], [], LogOptions())
    assert data.runs[0]["fuel_flow"] == pytest.approx(drive["fuel_flow"], rel=1e-9, abs=1e-15)
    assert data.runs[0]["vehicle_speed"] == pytest.approx(drive["vehicle_speed"], rel=1e-9)
    assert any("--density" in warning for warning in data.warnings) is volume
    heavy, _ = read_drives([tmp_path / "a.csv"], [], LogOptions(density=2.0 * 371.5 * 1.1))
    ratio = 1.1 if volume else 1.0
    assert heavy.runs[0]["fuel_flow"].sum() == pytest.approx(ratio * drive["fuel_flow"].sum())


def test_ten_rows_a_second_become_their_mean(tmp_path: Path) -> None:
    slow = recording(0)
    time = np.arange(10 * len(slow.time) - 9, dtype=np.float64) / 10.0
    data = np.array([np.interp(time, slow.time, slow[name]) for name in ("fuel_flow", "vehicle_speed")])
    data[0] += 1e-4 * np.sin(2 * np.pi * 2.0 * time)  # faster than a second: gone in the mean
    fast = Recording(time, slow.channels, np.maximum(data, 0.0), {})
    read, _ = read_drives([write(tmp_path / "fast.csv", fast)], [], LogOptions())
    run = read.runs[0]
    assert read.period == 1.0
    inside = np.interp(run.time, slow.time, slow["fuel_flow"])
    moving = inside > 3e-4
    assert run["fuel_flow"][moving] == pytest.approx(inside[moving], abs=6e-5)


BAD = {
    "no fuel": ("time_s,speed_mph\n0,0\n", "no channel fuel_flow"),
    "unit": ("time_s,fuel_flow [m],speed_mph\n", "of another dimension"),
    "unknown": ("time_s,fuel_flow [glug],speed_mph\n", "unknown unit"),
}


@pytest.mark.parametrize("case", [*BAD, "negative", "backwards", "short", "still", "dry"])
def test_what_cannot_be_used_is_refused_in_one_line(tmp_path: Path, refused: Refused, case: str) -> None:
    good, path = recording(0), tmp_path / "a.csv"
    values, time, rows = good.data.copy(), good.time.copy(), len(good.time)
    said = BAD.get(case, ("", ""))[1]
    if case == "negative":
        values[0, 50], said = -2e-3, "-0.002 kg/s at 50 s; expected none below zero"
    elif case == "backwards":
        time[20], said = time[18], "time does not increase at 18 s"
    elif case == "short":
        rows, said = 60, "60 rows of 1 s to train on"
    elif case == "still":
        values[1], said = 0.0, "the vehicle never moves"
    elif case == "dry":
        values[0], said = 0.0, "fuel_flow is zero throughout"
    lines = [BAD[case][0].splitlines()[0]] if case in BAD else ["time_s,fuel_flow,vehicle_speed"]
    columns = 2 if case == "no fuel" else 3
    for row in list(zip(time, *values, strict=True))[:rows]:
        lines.append(",".join(repr(float(value)) for value in row[:columns]))
    path.write_text("\n".join(lines) + "\n")
    refused(lambda: bitepoint.identify_fuel(path), said)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--density", "20 kg"), "--density: got unit 'kg' of another dimension"),
        (("--density", "9 g/mL"), "expected a liquid fuel"),
        (("--orders", "1,1,1"), "--orders: not an option of fuel"),
        (("--column", "slip=x"), "slip: unknown channel"),
        (("--vehicle", "nothing"), "nothing"),
        (("--engine-map", "map.csv"), "--engine-map: no vehicle whose engine it is; add --vehicle"),
        (("--vehicle", CAR, "--engine-map", "map.csv"), "map.csv"),
        (("--vehicle", "dct-t240"), "expected a vehicle of the plant conventional"),
    ],
)
def test_options_that_cannot_be_carried_out(
    bitepoint: Command, tmp_path: Path, options: tuple[str, ...], said: str
) -> None:
    path = write(tmp_path / "a.csv", recording(0))
    bitepoint("identify", str(path), "--model", "fuel", *options).refusal(said)


def test_options_of_fuel_are_none_of_a_launch(bitepoint: Command, tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", recording(0))
    bitepoint("identify", str(path), "--density", "0.743 g/mL").refusal("--density: not an option of arx")


def test_the_command_writes_model_and_report_and_tells_the_errors(bitepoint: Command, tmp_path: Path) -> None:
    files = [str(write(tmp_path / f"{n}.csv", recording(n, noise=2e-5), ("Fuel", 1e6 / 743.0))) for n in range(2)]
    options = ("--model", "fuel", "--validate", files[1], "--column", "fuel_flow=Fuel cc/s", "--density", "0.743 g/mL")
    model = tmp_path / "m.json"
    done = bitepoint("identify", files[0], *options, "--out", str(model), "--json")
    assert done.status == 0, done.err
    said = json.loads(done.out)
    assert said["model"] == "fuel"
    assert set(said["errors"]) == {"train", "validation"}
    assert {"total_percent", "r2", "rms"} <= set(said["errors"]["validation"])
    assert said["errors"]["validation"]["r2"] > 0.98
    assert not any("density" in warning for warning in said["warnings"])
    about = FuelModel.load(model).about
    assert [file["name"] for file in about["files"]["train"]] == ["0.csv"]
    assert len(about["files"]["validation"][0]["sha256"]) == 64
    page = model.with_suffix(".html").read_text()
    assert "Before and after the filter" in page
    told = bitepoint("identify", files[0], "--model", "fuel", "--column", "fuel_flow=Fuel cc/s").out
    assert "no validation logs" in told
    assert "quarters" in told
