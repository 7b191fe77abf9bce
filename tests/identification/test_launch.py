"""The model of a launch, identified from logs: its errors where it was not trained, and the known traps."""

from __future__ import annotations

import json
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

import bitepoint
from bitepoint.api import Identification
from bitepoint.assembly import PLANTS
from bitepoint.models.arx import ArxModel
from bitepoint.models.launch import LaunchModel
from bitepoint.recording import Channel, Recording
from tests.conftest import Command, Refused, names_in
from tests.contracts.harness import nominal
from tests.identification.conftest import Logs


@pytest.fixture(scope="module")
def found(training: Path, validation: Path) -> Identification:
    return bitepoint.identify(training, validate=validation)


def largest(found: Identification, name: str) -> float:
    return found.errors["validation"][name].free_run_max


def test_a_free_run_on_a_mass_and_a_grade_not_seen_stays_close(found: Identification) -> None:
    assert found.model.orders == (2, 1, 1, 0)
    assert largest(found, "engine_speed") <= 1.0
    assert largest(found, "slip") <= 2.5
    assert not [warning for warning in found.warnings if not warning.startswith("train: slip")]


@pytest.mark.parametrize("seed", [1, 2])
def test_it_does_so_with_other_noise_and_at_35_percent(logs: Logs, seed: int) -> None:
    check = logs(seed=20 + seed, road__grade="15 %", vehicle__mass="1700 kg", controller__throttle="35 %")
    again = bitepoint.identify(logs(seed=seed), validate=check)
    assert largest(again, "engine_speed") <= 1.0
    assert largest(again, "slip") <= 2.5


def test_ten_percent_throttle_cannot_hold_the_grade_and_is_still_told(training: Path, logs: Logs) -> None:
    check = logs(seed=5, road__grade="15 %", vehicle__mass="1700 kg", controller__throttle="10 %")
    speed = Recording.from_parquet(check / "run-1.parquet")["engine_speed"]
    assert speed[0] > 150.0
    assert speed[-1] < 90.0
    alone = bitepoint.identify(training, validate=check)
    assert largest(alone, "engine_speed") <= 1.0
    assert largest(alone, "slip") <= 2.5


def test_the_coefficients_are_those_of_the_reduced_model(training: Path) -> None:
    """A vehicle of the mean mass; the logged engine torque has its transient loss, so that inertia is the bare one."""
    parameters = nominal(PLANTS["dct"], "dct-t240")
    parameters["vehicle"]["mass"] = 1700.0
    physical = replace(LaunchModel.of(parameters), engine_inertia=0.25).arx(0.01)
    first = bitepoint.identify(training, orders=(1, 1, 1)).model
    assert first.past_inputs == pytest.approx(physical.past_inputs, rel=0.02)
    assert first.past_disturbances == pytest.approx(physical.past_disturbances, rel=0.03, abs=2e-5)
    assert first.past_outputs == pytest.approx(physical.past_outputs, abs=2e-3)


def test_least_squares_alone_is_biased_by_the_noise(training: Path, validation: Path, found: Identification) -> None:
    plain = bitepoint.identify(training, validate=validation, method="least squares")
    assert plain.errors["train"]["engine_speed"].one_step_rms < found.errors["train"]["engine_speed"].one_step_rms
    assert largest(plain, "engine_speed") > 2.0 * largest(found, "engine_speed")
    assert found.fit.method == "instruments"


def test_flat_roads_alone_do_not_tell_what_a_grade_does(logs: Logs, validation: Path) -> None:
    flat = bitepoint.identify(logs(road__grade=0), validate=validation)
    assert any("load_torque is all but constant" in warning for warning in flat.warnings)
    assert largest(flat, "slip") > 25.0
    assert flat.errors["train"]["slip"].one_step_rms < 0.3  # where it was trained nothing is to be seen of it


def test_one_mass_alone_misses_another_by_the_ratio_of_inertias(logs: Logs, validation: Path) -> None:
    one = bitepoint.identify(logs(vehicle__mass="1600 kg"), validate=validation)
    assert one.errors["train"]["slip"].free_run_max < 1.5
    assert 4.0 < largest(one, "slip") < 10.0  # 6 % of the 150 rad/s that the clutch gains


def plate_logs(folder: Path, settings: dict[str, object], seed: int) -> Path:
    """Logs whose slip is that of the driven plate, noise free."""
    from bitepoint.assembly import assemble
    from bitepoint.identification.logs import slip_rows
    from bitepoint.metrics import FAMILIES
    from bitepoint.scenarios import load_scenario
    from bitepoint.simulation.run import Simulation

    runs = load_scenario("dct-excitation").runs
    assert runs is not None
    assembly = assemble("dct-excitation", settings, runs.lanes(settings, True, seed))
    lanes = range(assembly.lanes)
    figures = FAMILIES["excitation"]
    for n, lane in enumerate(Simulation(assembly.system).run(figures, lanes=len(lanes), record=lanes, seed=seed)):
        r = lane.recording
        assert r is not None
        rows = slip_rows(r, 5)
        names = ("clutch_torque", "engine_torque", "road_torque")
        data = [r["engine_speed"][rows], r["slip_speed"][rows], *(r[name][rows + 1] for name in names)]
        columns = ("engine_speed", "slip", "clutch_torque", "engine_torque", "load_torque")
        channels = tuple(Channel(c, "N*m" if "torque" in c else "rad/s") for c in columns)
        Recording(r.time[rows], channels, np.array(data)).to_parquet(folder / f"run-{n:02}.parquet")
    return folder


def test_slip_of_the_driven_plate_makes_a_useless_free_run(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    train = plate_logs(tmp_path / "a", {}, 0)
    check = plate_logs(tmp_path / "b", {"road.grade": 0.15, "vehicle.mass": 1700}, 5)
    plate = bitepoint.identify(train, validate=check, method="least squares")
    assert largest(plate, "slip") > 24.0
    assert plate.errors["validation"]["slip"].one_step_rms < 0.1 * largest(plate, "slip")


def test_without_validation_logs_some_runs_are_held_out(training: Path) -> None:
    alone = bitepoint.identify(training)
    assert (len(alone.training), len(alone.validation)) == (40, 10)
    assert "10 of 50 runs are held out" in alone.warnings[0]
    names = {run.about["file"] for run in alone.training}
    assert not names & {run.about["file"] for run in alone.validation}


def test_a_late_torque_is_noticed_and_mended(logs: Logs, tmp_path: Path) -> None:
    folder = logs(vehicle__mass="1600 kg")
    for path in folder.glob("*.parquet"):
        log = Recording.from_parquet(path)
        data = log.data.copy()
        data[3, 3:], data[3, :3] = log["clutch_torque"][:-3], log["clutch_torque"][0]
        Recording(log.time, log.channels, data).to_parquet(tmp_path / path.name)
    late = bitepoint.identify(tmp_path)
    assert any("clutch_torque seems to be 30 ms too late" in warning for warning in late.warnings)
    mended = bitepoint.identify(tmp_path, delays={"clutch_torque": "30 ms"})
    assert not any("seems to be" in warning for warning in mended.warnings)
    assert mended.errors["validation"]["slip"].one_step_rms < 0.8 * late.errors["validation"]["slip"].one_step_rms


def test_logs_that_are_finer_than_the_raster_serve_as_well(logs: Logs, validation: Path) -> None:
    found = bitepoint.identify(logs(log__period="2 ms"), validate=validation, period="10 ms")
    assert largest(found, "engine_speed") <= 1.0
    assert largest(found, "slip") <= 2.5
    assert "finer than the raster: 50 logs" in found.warnings[0]


def test_slip_is_formed_from_the_wheel_speed(training: Path, validation: Path, found: Identification) -> None:
    ratio = float(Recording.from_parquet(training / "run-01.parquet").about["ratio"])
    formed = bitepoint.identify(training, validate=validation, ratio=ratio)
    assert formed.model.outputs == ("engine_speed", "slip")
    assert formed.training[0]["slip"] == pytest.approx(found.training[0]["slip"], abs=1e-6)
    assert formed.model.past_outputs == pytest.approx(found.model.past_outputs, abs=1e-4)
    assert formed.model.about["ratio"] == ratio


@pytest.mark.parametrize(
    ("channel", "factor", "said"),
    [
        ("time", 1e3, "rows are 10 s apart, a launch lasts about a second"),
        ("slip", 100.0, "slip: reaches"),
        ("engine_speed", 30.0 / np.pi, "engine_speed: reaches"),
    ],
)
def test_units_that_cannot_be_are_refused(
    logs: Logs, tmp_path: Path, refused: Refused, channel: str, factor: float, said: str
) -> None:
    log = Recording.from_parquet(logs(vehicle__mass="1600 kg", controller__throttle="30 %") / "run-1.parquet")
    data, time = log.data.copy(), log.time
    if channel == "time":
        time = factor * time
    else:
        data[[each.name for each in log.channels].index(channel)] *= factor
    Recording(time, log.channels, data).to_parquet(tmp_path / "a.parquet")
    refused(lambda: bitepoint.identify(tmp_path / "a.parquet"), said)


def test_a_log_that_is_read_with_few_rows_has_a_report(bitepoint: Command, logs: Logs, tmp_path: Path) -> None:
    log = Recording.from_parquet(logs(vehicle__mass="1600 kg", controller__throttle="30 %") / "run-1.parquet")
    Recording(log.time[:20], log.channels, log.data[:, :20]).to_parquet(tmp_path / "a.parquet")
    done = bitepoint("identify", str(tmp_path / "a.parquet"), "--out", str(tmp_path / "m.json"))
    assert (done.status, done.err) == (0, "")
    assert "seems to be" not in done.out
    assert names_in(tmp_path) == ["a.parquet", "m.html", "m.json"]


# the command


def test_json_has_the_promised_form(bitepoint: Command, training: Path, validation: Path, tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    files = [str(path) for path in sorted(validation.iterdir())]
    each = [word for path in files for word in ("--validate", path)]
    done = bitepoint("identify", str(training), *each, "--orders", "2,1,1", "--out", str(model), "--json")
    assert (done.status, done.err) == (0, "")
    said = json.loads(done.out)
    assert set(said) == {"model", "orders", "errors", "warnings"}
    assert (said["model"], said["orders"]) == ("arx", [2, 1, 1])
    for part in ("train", "validation"):
        assert set(said["errors"][part]) == {"one_step", "free_run"}
        assert all(set(errors) == {"engine_speed", "slip"} for errors in said["errors"][part].values())
    assert said["errors"]["validation"]["free_run"]["slip"] <= 2.5
    read = ArxModel.load(model)
    assert (read.kind, read.period, read.orders) == ("arx", 0.01, (2, 1, 1, 0))
    assert (
        read.about["errors"]["validation"]["slip"]["free_run_max"] == said["errors"]["validation"]["free_run"]["slip"]
    )
    assert {part: len(files) for part, files in read.about["files"].items()} == {"train": 50, "validation": 5}
    (first, *_) = read.about["files"]["train"]
    assert first == {"name": "run-01.parquet", "sha256": sha256((training / "run-01.parquet").read_bytes()).hexdigest()}
    page = (tmp_path / "model.html").read_text()
    for text in ("engine speed, rad", "autocorrelation", "unit circle", "Coefficients", "order n_a", "Validation"):
        assert text in page
    assert names_in(tmp_path) == ["model.html", "model.json"]


def test_armax_and_auto_by_command(bitepoint: Command, logs: Logs, tmp_path: Path) -> None:
    folder = str(logs(vehicle__mass="1600 kg", controller__throttle="30 %"))
    said = json.loads(bitepoint("identify", folder, "--model", "armax", "--orders", "2,1,1,1", "--json").out)
    assert (said["model"], said["orders"]) == ("armax", [2, 1, 1, 1])
    said = json.loads(bitepoint("identify", folder, "--orders", "auto", "--json").out)
    assert said["model"] == "arx"
    done = bitepoint("identify", folder, "--report", str(tmp_path / "r.html"))
    assert done.out.splitlines()[0].startswith("arx (2, 1, 1) by ")
    assert names_in(tmp_path) == ["r.html"]


def test_a_broken_log_among_good_ones_is_a_warning(bitepoint: Command, logs: Logs, tmp_path: Path) -> None:
    good = logs(vehicle__mass="1600 kg", controller__throttle="30 %")
    bad = tmp_path / "bad.parquet"
    bad.write_bytes((good / "run-1.parquet").read_bytes()[:-100])
    said = json.loads(bitepoint("identify", str(good), str(bad), "--json").out)
    assert any("bad.parquet: cannot be read" in warning and "left out" in warning for warning in said["warnings"])
    bitepoint("identify", str(bad), "--json").refusal("bad.parquet: cannot be read")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--model", "narx"], ["--model: got narx", "arx, armax"]),
        (["--orders", "2,1"], ["--orders: got 2,1", "n_a,n_b,n_g"]),
        (["--orders", "two"], ["--orders: got 'two'"]),
        (["--orders", "2,1,0"], ["--orders: got 2,1,0"]),
        (["--orders", "99,1,1"], ["--orders: got 99,1,1"]),
        (["--method", "magic"], ["--method: got magic"]),
        (["--column", "engine_speed"], ["--column: got 'engine_speed'"]),
        (["--column", "speed=n"], ["--column: speed: unknown channel"]),
        (["--column", "slip=n"], ["no channel n for slip"]),
        (["--column", "slip=a", "--column", "slip=b"], ["--column: slip: given twice"]),
        (["--delay", "slip=2 kg"], ["--delay: slip: got unit 'kg'"]),
        (["--ratio", "0"], ["--ratio: got 0", "0.1..100"]),
        (["--ratio", "x"], ["--ratio"]),
        (["--period", "1 m"], ["--period: got unit 'm'"]),
        (["--period", "2 s"], ["no piece of it has 10 rows"]),
        (["--validate", "nowhere"], ["nowhere: no such file"]),
        (["--out", "nowhere/model.json"], ["nowhere/model.json: cannot be written"]),
        (["--out", "model.html"], ["model.html: is model and report", ".json"]),
        (["--fast"], ["--fast"]),
    ],
)
def test_bad_input_is_one_line(
    bitepoint: Command, logs: Logs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], said: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = logs(vehicle__mass="1600 kg", controller__throttle="30 %")
    bitepoint("identify", str(folder), "--json", *options).refusal(*said)
    assert names_in(tmp_path) == []


def test_logs_that_are_too_short_are_refused(logs: Logs, refused: Refused, tmp_path: Path) -> None:
    log = Recording.from_parquet(logs(vehicle__mass="1600 kg", controller__throttle="30 %") / "run-1.parquet")
    Recording(log.time[:12], log.channels, log.data[:, :12]).to_parquet(tmp_path / "a.parquet")
    refused(lambda: bitepoint.identify(tmp_path / "a.parquet"), "12 rows for orders 2,1,1")
