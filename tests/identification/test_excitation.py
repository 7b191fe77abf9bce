"""The scenario that makes logs, and its controller."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import CONTROLLERS, PLANTS
from bitepoint.controllers.excitation import ExcitationState, next_random
from bitepoint.recording import Recording
from bitepoint.vehicles import load_vehicle
from tests.conftest import Command, Refused, names_in
from tests.contracts.harness import nominal

COLUMNS = {
    "engine_speed": "rad/s", "wheel_speed": "rad/s", "slip": "rad/s", "clutch_torque": "N*m", "engine_torque": "N*m",
    "load_torque": "N*m",
}  # fmt: skip


@pytest.fixture(scope="module")
def noise_free() -> dict[str, Recording]:
    return dict(bitepoint.run("dct-excitation", log__noise=0).logs)


@pytest.fixture(scope="module")
def noisy() -> dict[str, Recording]:
    return dict(bitepoint.run("dct-excitation").logs)


def test_there_is_a_run_for_each_mass_grade_and_throttle(noise_free: dict[str, Recording]) -> None:
    keys = ("vehicle.mass", "road.grade", "controller.throttle")
    cases = {tuple(log.about[f"run.{key}"] for key in keys) for log in noise_free.values()}
    assert len(noise_free) == len(cases) == 2 * 5 * 5
    grades, throttles = ({case[n] for case in cases} for n in (1, 2))
    assert grades == {"0 %", "5 %", "10 %", "15 %", "20 %"}
    assert throttles == {"10 %", "20 %", "30 %", "40 %", "50 %"}


def test_a_log_is_the_slip_phase_on_a_raster(noise_free: dict[str, Recording]) -> None:
    for log in noise_free.values():
        assert {channel.name: channel.unit for channel in log.channels} == COLUMNS
        assert np.diff(log.time) == pytest.approx(0.01, abs=1e-9)
        assert len(log.time) >= 40
        assert (log["wheel_speed"] > 0.0).all()
        assert (log["slip"] > -3.0).all()  # the shaft's oscillation, which the plate has and the wheel has not
        assert log["engine_speed"].min() >= 83.0
        assert log["engine_speed"].max() <= 250.0
        assert log["slip"] == pytest.approx(log["engine_speed"] - 14.557 * log["wheel_speed"], abs=0.01)


def test_rows_obey_the_equation_of_the_engine(noise_free: dict[str, Recording]) -> None:
    """(Te - Tc - ce we) Ts is the change of Ie we: so torques and speeds of a row belong together."""
    for log in noise_free.values():
        speed, engine, clutch = (log[name] for name in ("engine_speed", "engine_torque", "clutch_torque"))
        change = 0.01 * (engine - clutch - 0.02 * speed)[:-1] / 0.25
        assert np.diff(speed) == pytest.approx(change, rel=0.012, abs=0.02)


def test_the_clutch_torque_jumps_by_levels_of_8_newton_metres(noise_free: dict[str, Recording]) -> None:
    log = noise_free["run-01"]
    torque = log["clutch_torque"][30:]
    base = 0.5 * (torque.max() + torque.min())
    assert 6.0 < torque.max() - base <= 8.0 + 1e-9
    holds = np.diff(np.flatnonzero(np.abs(np.diff(torque)) > 1e-9))
    dwell = holds[holds > 2] * 0.01  # a large jump takes three steps at 750 N m/s
    assert dwell.min() >= 0.02
    assert dwell.max() <= 0.16
    assert len(set(torque.round(6))) > 10


def test_noise_is_white_and_normal_and_can_be_set(
    noise_free: dict[str, Recording], noisy: dict[str, Recording]
) -> None:
    errors = [noisy[name]["engine_speed"] - noise_free[name]["engine_speed"] for name in noise_free]
    wheel = [14.557 * (noisy[name]["wheel_speed"] - noise_free[name]["wheel_speed"]) for name in noise_free]
    for every in (np.concatenate(errors), np.concatenate(wheel)):
        assert every.std() == pytest.approx(0.1, rel=0.05)
        assert abs(np.corrcoef(every[1:], every[:-1])[0, 1]) < 0.05
    for log in noisy.values():
        assert log["slip"] == pytest.approx(log["engine_speed"] - float(log.about["ratio"]) * log["wheel_speed"])


def test_the_seed_decides_noise_and_levels() -> None:
    settings = {"road.grade": 0, "controller.throttle": 0.3, "vehicle.mass": 1600}
    one, again, other = (bitepoint.run("dct-excitation", settings, seed=seed).logs["run-1"] for seed in (3, 3, 4))
    assert np.array_equal(one.data, again.data)
    rows = min(len(one.time), len(other.time))
    assert not np.array_equal(one["clutch_torque"][:rows], other["clutch_torque"][:rows])


def test_settings_pin_what_would_vary() -> None:
    result = bitepoint.run("dct-excitation", road__grade="15 %", vehicle__mass="1700 kg")
    assert len(result.logs) == 5
    for log in result.logs.values():
        assert log["load_torque"].min() == pytest.approx(1700 * 9.80665 * 0.289 * (0.15 + 0.018) / 1.15**0.5, rel=0.07)


def test_every_random_number_comes_once_in_a_period() -> None:
    state = ExcitationState.zeros()
    state["random"] = 1.0
    seen = [float(next_random.run(state)[0] * 0 + state["random"][0]) for _ in range(8190)]
    assert sorted(seen) == [*map(float, range(-4095, 0)), *map(float, range(1, 4096))]


def test_the_base_torque_balances_the_engine() -> None:
    controller = CONTROLLERS["excitation"]
    calibration = controller.calibration.parse({"throttle": 0.2, "hold_speed": 160.0}, "test")
    designed = controller.design(nominal(PLANTS[load_vehicle("dct-t240").plant], "dct-t240"), calibration)
    log = bitepoint.run("dct-excitation", road__grade=0, vehicle__mass=1600, controller__throttle=0.2).logs["run-1"]
    assert log["clutch_torque"][30:].mean() == pytest.approx(float(designed["balance_torque"][0]), abs=3.0)
    assert np.ptp(log["engine_speed"][30:]) < 25.0


def test_the_command_writes_logs_that_are_valid_one_by_one(bitepoint: Command, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = bitepoint("run", "dct-excitation", "--set", "vehicle.mass=1600 kg", "--json", "--out", str(out))
    said = json.loads(done.out)
    assert (done.status, set(said), said["status"]) == (0, {"scenario", "status", "reason", "metrics"}, "logged")
    assert said["metrics"]["runs"] == {"value": 25.0, "unit": "1"}
    assert json.loads((out / "metrics.json").read_text()) == said
    assert len(list(out.glob("*.parquet"))) == 25
    assert "<html" in (out / "excitation.html").read_text()
    again = bitepoint(
        "run", "dct-excitation", "--set", "vehicle.mass=1600 kg", "--set", "road.grade=0", "--out", str(out)
    )
    assert "wrote 5 logs" in again.out
    files = [name for name in names_in(out) if name.endswith(".parquet")]
    assert files == [f"run-{n}.parquet" for n in range(1, 6)]  # no log of the earlier set is left
    for name in files:
        assert len(Recording.from_parquet(out / name).channels) == 6


def test_a_run_that_never_slips_is_left_out_and_told() -> None:
    result = bitepoint.run("dct-excitation", road__grade="40 %", vehicle__mass=3000, controller__throttle="10 %")
    assert (result.status, dict(result.logs)) == ("not logged", {})
    assert result.reason.startswith("0 of 1 runs")


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"log.noise": -1}, ["log.noise", "0..1000 rad/s"]),
        ({"log.noise": "1 N*m"}, ["log.noise", "another dimension"]),
        ({"log.period": "7 ms"}, ["log.period: got 0.007 s", "multiple of the tick"]),
        ({"log.columns": 3}, ["log.columns: unknown key"]),
        ({"controller.throttle": "110 %"}, ["controller.throttle"]),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], said: list[str], refused: Refused) -> None:
    refused(lambda: bitepoint.run("dct-excitation", settings), *said)


def test_log_settings_belong_to_scenarios_that_log(refused: Refused) -> None:
    refused(lambda: bitepoint.run("dct-launch", log__noise=0), "log: unknown group")
