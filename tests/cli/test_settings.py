"""Every key of --set: it changes the figures as physics says it must, or it is refused and nothing is written."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from bitepoint.files import library_yaml
from tests.conftest import Command

Figures = dict[str, float]
Launch = Callable[..., Figures]

SAME = 1e-6
"""Relative: the same pedal, given in another way, rounds each of its points once; measured 1e-9."""


@pytest.fixture
def launch(bitepoint: Command) -> Launch:
    """Launch with settings, which must succeed; return the figures."""

    def call(*settings: str, seed: int = 0) -> Figures:
        options = [option for setting in settings for option in ("--set", setting)]
        done = bitepoint("run", "dct-launch", "--json", "--seed", str(seed), *options)
        assert (done.status, done.err) == (0, ""), done.err
        said = json.loads(done.out)
        assert said["status"] == "launched", said
        return {name: figure["value"] for name, figure in said["metrics"].items()}

    return call


@pytest.mark.parametrize(
    ("before", "after", "higher", "lower"),
    [
        ("intent=slow", "intent=normal", "friction_work end_speed jerk_peak", "launch_time"),
        ("intent=normal", "intent=urgent", "friction_work end_speed jerk_peak jerk_peak_settled", "launch_time"),
        ("vehicle.mass=1600 kg", "vehicle.mass=2.2 t", "launch_time friction_work", "jerk_peak jerk_peak_settled"),
        ("road.grade=0 %", "road.grade=10 %", "launch_time friction_work", ""),
        ("road.grade=0", "road.grade=-0.02", "", "launch_time friction_work"),
        ("controller=launch_pid", "controller=none", "launch_time friction_work end_speed", "jerk_peak"),
        ("vehicle=dct-t240", "vehicle=dct-na190", "", "end_speed"),
        ("controller.touch_delay=0.28 s", "controller.touch_delay=600 ms", "launch_time", ""),
        ("controller.target_rise_time=0.89 s", "controller.target_rise_time=0.6 s", "friction_work", ""),
        ("clutch.friction_gain=1", "clutch.friction_gain=130 %", "jerk_peak", "launch_time friction_work"),
        ("gearbox.efficiency=97 %", "gearbox.efficiency=85 %", "launch_time friction_work", ""),
        ("lag.clutch_torque_command=0 s", "lag.clutch_torque_command=0.1 s", "launch_time friction_work", ""),
        ("vehicle.rolling_resistance=0", "vehicle.rolling_resistance=0.1", "launch_time friction_work", ""),
    ],
)
def test_a_setting_moves_the_figures_as_physics_says(
    launch: Launch, before: str, after: str, higher: str, lower: str
) -> None:
    one, other = launch(before), launch(after)
    for name in higher.split():
        assert other[name] > 1.001 * one[name], name
    for name in lower.split():
        assert other[name] < 0.999 * one[name], name


def test_the_papers_calibration_holds_the_engine_higher(launch: Launch) -> None:
    tuned = launch("intent=urgent", "controller.calibration=tuned")
    paper = launch("intent=urgent", "controller.calibration=paper")
    assert tuned == launch("intent=urgent")
    for name in ("launch_time", "friction_work", "end_speed"):
        assert paper[name] > 1.02 * tuned[name], name


def test_a_curve_is_set_in_yaml(launch: Launch) -> None:
    curve = "{{pedal: {{unit: '%', values: [0, 100]}}, torque: [0, {}]}}"
    weak, strong = (launch(f"controller.clutch_torque={curve.format(torque)}") for torque in ("400", "0.6 kN*m"))
    assert strong["launch_time"] < 0.95 * weak["launch_time"]


def test_noise_follows_the_seed(launch: Launch) -> None:
    noisy = "noise.engine_speed=10 rpm"
    assert launch(noisy) == launch(noisy)
    assert launch(noisy, seed=1) != launch(noisy)
    assert launch() == launch(seed=1) == launch("noise.engine_speed=0") != launch(noisy)


def test_a_delay_changes_the_launch(launch: Launch) -> None:
    assert launch("delay.engine_speed=40 ms")["launch_time"] != launch()["launch_time"]


def test_a_finer_tick_gives_the_same_launch(launch: Launch) -> None:
    coarse, fine = launch(), launch("timing.tick=0.5 ms")
    for name in ("launch_time", "friction_work", "end_speed"):
        assert fine[name] == pytest.approx(coarse[name], rel=0.01)


@pytest.fixture
def vehicle_file(tmp_path: Path) -> Path:
    """The library's vehicle, heavier, in a file."""
    data = json.loads(json.dumps(library_yaml("vehicles", "dct-t240.yaml")))
    data["vehicle"]["mass"] = "1.9 t"
    path = tmp_path / "heavy.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


def test_a_vehicle_file_is_the_same_as_its_settings(launch: Launch, vehicle_file: Path) -> None:
    assert launch(f"vehicle={vehicle_file}") == launch("vehicle.mass=1900 kg")
    assert launch(f"vehicle={vehicle_file}", "vehicle.mass=1600 kg") == launch()


def test_a_road_in_a_vehicle_file_is_not_dropped_in_silence(bitepoint: Command, vehicle_file: Path) -> None:
    vehicle_file.write_text(vehicle_file.read_text() + "road: {grade: 20 %}\n")
    bitepoint("run", "dct-launch", "--set", f"vehicle={vehicle_file}").refusal(str(vehicle_file), "road")


@pytest.fixture
def log(tmp_path: Path) -> str:
    """A log whose pedal rests at 14 %, is pressed as the intent normal at 101 s, and further at 102 s."""
    times = [99.0, 101.0, 101.2, 102.0, 102.2, 110.0]
    pedal = [14.0, 14.0, 37.5, 37.5, 60.0, 60.0]
    soft = [14.0, 14.0, 29.0, 29.0, 29.0, 29.0]
    rows = "".join(f"{t},{p},{s}\n" for t, p, s in zip(times, pedal, soft, strict=True))
    (tmp_path / "log.csv").write_text("time_s,pedal,soft\n" + rows)
    return f"pedal={tmp_path / 'log.csv'}"


def test_a_pedal_from_a_log_is_the_pedal_of_an_intent(launch: Launch, log: str) -> None:
    cut = (log, "pedal.column=pedal", "pedal.rest=14 %", "pedal.start=101 s", "pedal.end=102 s")
    assert launch(*cut) == pytest.approx(launch("intent=normal"), rel=SAME)
    assert launch(log, "pedal.column=soft", "pedal.rest=14", "pedal.start=101") == pytest.approx(
        launch("intent=slow"), rel=SAME
    )


def test_column_rest_full_start_and_end_of_a_log_each_count(launch: Launch, log: str) -> None:
    settings = {"column": "pedal", "rest": "14", "start": "101", "end": "102"}

    def cut(**changes: str) -> Figures:
        return launch(log, *(f"pedal.{key}={value}" for key, value in {**settings, **changes}.items()))

    assert cut(column="soft")["launch_time"] > 1.1 * cut()["launch_time"]
    assert cut(rest="20")["launch_time"] > cut()["launch_time"]
    assert cut(full="70")["end_speed"] > 1.1 * cut()["end_speed"]
    assert cut(end="110")["friction_work"] > 1.05 * cut()["friction_work"]
    assert cut(start="99")["launch_time"] == pytest.approx(cut()["launch_time"], abs=0.011)
    assert cut(start="102.2", end="110")["end_speed"] > 1.1 * cut()["end_speed"]


def test_a_log_longer_than_the_scenario_is_run_to_its_end(bitepoint: Command, tmp_path: Path) -> None:
    time = np.arange(0.0, 20.0, 0.1)
    rows = "".join(f"{t:.1f},{50 if t > 13 else 0}\n" for t in time)
    (tmp_path / "log.csv").write_text("t,p\n" + rows)
    options = ("--set", f"pedal={tmp_path / 'log.csv'}", "--set", "pedal.column=p")
    assert json.loads(bitepoint("run", "dct-launch", "--json", *options).out)["status"] == "launched"
    short = json.loads(bitepoint("run", "dct-launch", "--json", *options, "--set", "timing.duration=5 s").out)
    assert (short["status"], short["reason"]) == ("timed out", "no stop rule held within 5 s")


KEYS = "expected one of intent, controller, vehicle, pedal, speed, or a key of vehicle, engine"


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (["intent=brisk"], ["intent", "got brisk", "slow, normal, urgent"]),
        (["controller=hope"], ["controller", "got hope", "none, launch_pid"]),
        (["controller.calibration=wild"], ["controller.calibration", "launch_pid has no wild", "paper, tuned"]),
        (["controller=none", "controller.calibration=paper"], ["controller.calibration: none has no paper"]),
        (["controller.gain=1"], ["controller.gain: unknown key", "engine_target"]),
        (["controller.engine_speed.kp=11"], ["controller.engine_speed.kp: got '11'", "0..10 s/rad"]),
        (["vehicle.mass=5 s"], ["vehicle.mass: got unit 's' of another dimension", "50..60000 kg"]),
        (["vehicle.mass=-1"], ["vehicle.mass: got '-1'", "50..60000 kg"]),
        (["vehicle.mass=nan"], ["vehicle.mass: got 'nan'", "50..60000 kg"]),
        (["vehicle.mass=1e400"], ["vehicle.mass: got '1e400'", "50..60000 kg"]),
        (["vehicle.mass=[1600, 1700]"], ["vehicle.mass: got 2 values", "expected 1 value"]),
        (["vehicle.mass={a: 1}"], ["vehicle.mass: got {'a': 1}", "50..60000 kg"]),
        (["vehicle.mas=1600"], ["vehicle.mas: unknown key", "mass, wheel_radius"]),
        (["road.grade=51 %"], ["road.grade: got '51 %'", "-0.5..0.5"]),
        (["road.grade=10 deg"], ["road.grade: got an angle", "-0.5..0.5"]),
        (["vehicle=boat"], ["boat: no such vehicle", "dct-na190, dct-t240"]),
        (["vehicle=boat.yaml"], ["boat.yaml: no such file"]),
        (["mood=good"], ["mood: unknown key", KEYS]),
        (["mood.level=3"], ["mood", "unknown", "expected one of"]),
        (["seed=1"], ["seed: unknown key", KEYS]),
        (["scenario=dct-launch"], ["scenario: unknown key", KEYS]),
        (["life=interpreted"], ["life: unknown key", KEYS]),
        (["vehicle.mass"], ["got 'vehicle.mass'", "expected key=value"]),
        (["vehicle.mass="], ["got 'vehicle.mass='", "expected key=value"]),
        (["=1600"], ["got '=1600'", "expected key=value"]),
        (["vehicle.mass=1600", "vehicle.mass=1700"], ["vehicle.mass: given twice", "leave one of them out"]),
        (["vehicle.mass=[1600"], ["vehicle.mass", "not YAML"]),
        (["gearbox.gear=7"], ["gear 7 has no ratio"]),
        (["gearbox.gear=2"], ["gearbox.gear", "clutch 2"]),
        (["engine.idle_speed=300 rad/s", "engine.speed_limit=200 rad/s"], ["engine.idle_speed", "engine.speed_limit"]),
        (["timing.duration=nan"], ["timing.duration: got 'nan'", "0.01..100000 s"]),
        (["timing.tick=3 ms"], ["0.003 s", "multiple of the tick"]),
        (["timing.ticks=3"], ["timing.ticks: unknown key", "duration, tick"]),
        (["lag.mood=1 s"], ["lag.mood", "throttle, clutch_torque_command"]),
        (["lag.throttle=-1 s"], ["lag.throttle: got -1 s", "expected 0 or more"]),
        (["lag.throttle=inf"], ["lag.throttle: got inf", "expected a finite number in s"]),
        (["delay.engine_speed=3 ms"], ["delay.engine_speed", "multiple of the tick"]),
        (["delay.engine_speed=1e9 s"], ["delay.engine_speed"]),
        (["delay.throttle=10 ms"], ["delay.throttle", "pedal, engine_speed, clutch_speed"]),
        (["noise.engine_speed=5 kg"], ["noise.engine_speed: got unit 'kg'", "rad/s"]),
        (["pedal.rest=14"], ["pedal.rest", "add --set pedal=FILE"]),
        (["LOG"], ["pedal.column: missing", "name the pedal column"]),
        (["LOG", "pedal.column=brake"], ["log.csv", "no column brake", "expected one of pedal, soft"]),
        (["LOG", "pedal.column=pedal", "intent=slow"], ["intent: given with pedal=FILE", "leave one of them out"]),
        (
            ["LOG", "pedal.column=pedal", "pedal.gain=2"],
            ["pedal.gain: unknown key", "column, unit, rest, full, start, end"],
        ),
        (["LOG", "pedal.column=pedal", "pedal.rest=5 s"], ["pedal.rest: got unit 's'", "percent"]),
        (["LOG", "pedal.column=pedal", "pedal.rest=inf"], ["pedal.rest: got inf", "finite"]),
        (["LOG", "pedal.column=pedal", "pedal.start=soon"], ["pedal.start: got 'soon'", "expected a number in s"]),
        (["LOG", "pedal.column=pedal", "pedal.start=200"], ["log.csv", "fewer than two rows", "99..110 s"]),
        (["LOG", "pedal.column=pedal", "pedal.rest=20", "pedal.full=10"], ["pedal.full: got 10 %", "20 %"]),
        (["pedal=none.csv", "pedal.column=p"], ["none.csv: no such file"]),
    ],
    ids=lambda value: " ".join(value) if value and "=" in value[0] else "",
)
def test_a_bad_setting_is_refused_and_nothing_is_written(
    bitepoint: Command, tmp_path: Path, log: str, settings: list[str], said: list[str]
) -> None:
    options = [option for setting in settings for option in ("--set", log if setting == "LOG" else setting)]
    bitepoint("run", "dct-launch", "--json", "--out", str(tmp_path / "out"), *options).refusal(*said)
    assert not (tmp_path / "out").exists()


def test_a_grade_may_be_any_ratio(launch: Launch) -> None:
    ratio = launch("road.grade=0.1")
    for text in ("100 m/km", "10 %", "1e-1", "100 mm/m"):
        assert launch(f"road.grade={text}") == pytest.approx(ratio, rel=SAME)
