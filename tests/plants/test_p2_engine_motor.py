"""Engine and motor of the P2 hybrid: limits, dead times, idle, fuel, electricity, heat."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.contracts.harness import PlantBench
from tests.plants.test_p2_reference import bench

TICK = 0.002


def drive(plant: PlantBench, time: float, **inputs: Any) -> np.ndarray:
    """Hold inputs for some time; return the outputs at each tick."""
    rows = []
    for _ in range(round(time / TICK)):
        assert plant.step(TICK, **inputs)[0] == 0
        rows.append(plant.y.copy())
    return np.concatenate(rows)


def standing(**changes: Any) -> PlantBench:
    return bench(**{"start__speed": 0.0, **changes})


@pytest.mark.parametrize("steps", [1, 10, 125])
@pytest.mark.parametrize(("part", "command"), [("engine", "engine_torque_request"), ("motor", "motor_torque_command")])
def test_dead_times_are_exact_in_steps(part: str, command: str, steps: int) -> None:
    late, plain = bench(**{f"{part}__delay": steps * TICK}), bench()
    before = {command: 15.0 if part == "engine" else 0.0}
    for plant in (late, plain):
        drive(plant, 10 * TICK, **before)
    seen = drive(late, 0.4, **{command: 60.0})[f"{part}_torque"]
    drive(plain, steps * TICK, **before)
    assert np.array_equal(seen[steps:], drive(plain, 0.4 - steps * TICK, **{command: 60.0})[f"{part}_torque"])
    assert (np.abs(seen[:steps] - before[command]) < 1e-3).all()
    assert abs(seen[steps] - before[command]) > 0.5


def test_engine_and_motor_follow_as_lags_of_first_order() -> None:
    seen = drive(bench(motor__torque_rate_limit=1e6), 0.2, engine_torque_request=200.0, motor_torque_command=80.0)
    time = TICK * np.arange(1, 101)
    assert seen["engine_torque"] == pytest.approx(200.0 - 185.0 * np.exp(-time / 0.05), abs=1e-3)
    assert seen["motor_torque"] == pytest.approx(80.0 * (1.0 - np.exp(-time / 0.01)), abs=1e-3)


def test_the_command_of_the_motor_changes_at_its_rate_limit() -> None:
    seen = drive(bench(motor__torque_rate_limit=1000.0), 0.1, motor_torque_command=300.0)["motor_torque"]
    assert np.diff(seen)[25:] / TICK == pytest.approx(1000.0, rel=0.02)


def test_the_engine_gives_what_full_load_and_drag_leave() -> None:
    high = drive(bench(), 1.0, engine_torque_request=5000.0)
    speed = high["engine_speed"][-1] * 30.0 / np.pi
    assert 1800.0 < speed < 5500.0
    assert high["engine_torque"][-1] == pytest.approx(500.0, rel=1e-3)
    low = drive(bench(), 1.0, engine_torque_request=-500.0)
    drag = 35.0 + 0.06 * low["engine_speed"][-1]
    assert low["engine_torque"][-1] == pytest.approx(-drag, rel=1e-2)


def test_idle_is_held_and_found_again() -> None:
    plant = standing()
    assert plant.y["engine_speed"][0] == pytest.approx(800 * np.pi / 30)
    drive(plant, 0.5, engine_torque_request=30.0)
    assert plant.y["engine_speed"][0] > 110.0
    drive(plant, 6.0, engine_torque_request=0.0)
    assert plant.y["engine_speed"][0] == pytest.approx(800 * np.pi / 30, abs=0.1)
    assert plant.y["fuel_flow"][0] == pytest.approx(0.196e-3, rel=0.02)


def test_an_engine_below_its_firing_speed_comes_to_rest() -> None:
    plant = standing(start__engine_running=0)
    assert plant.y["engine_speed"][0] == 0.0
    seen = drive(plant, 1.0, engine_torque_request=300.0)
    assert (seen["engine_speed"] == 0.0).all()
    assert (seen["fuel_used"] == 0.0).all()
    slow = standing()
    slow.x["motion"]["engine_speed"] = 25.0
    drive(slow, 3.0, engine_torque_request=300.0)
    assert abs(slow.y["engine_speed"][0]) < 0.01


def test_the_motor_starts_the_engine_through_the_clutch() -> None:
    plant = bench(start__engine_torque=0.0)
    plant.x["motion"]["engine_speed"] = 0.0
    plant.x["motion"]["clutch_twist"] = 0.0
    drive(plant, 0.5, clutch_torque_command=100.0, motor_torque_command=150.0)
    assert plant.y["engine_speed"][0] > 150.0
    drive(plant, 0.5, clutch_torque_command=600.0, engine_torque_request=200.0, motor_torque_command=0.0)
    assert plant.y["engine_torque"][0] == pytest.approx(200.0, rel=1e-3)


def test_fuel_is_cut_above_the_speed_limit_and_while_dragging() -> None:
    plant = standing()
    drive(plant, 8.0, engine_torque_request=300.0)
    limit = 7600 * np.pi / 30
    assert limit < plant.y["engine_speed"][0] < limit + 12.0
    used = plant.y["fuel_used"][0]
    drive(plant, 0.5, engine_torque_request=-500.0)
    before = plant.y["fuel_used"][0]
    drive(plant, 0.5, engine_torque_request=-500.0)
    assert used < before
    assert plant.y["engine_speed"][0] > 400.0
    assert plant.y["fuel_used"][0] - before < 1e-3 * used


def test_fuel_is_that_of_the_willans_line() -> None:
    seen = drive(bench(start__speed=12.0), 2.0, engine_torque_request=220.0)[500:]
    speed = seen["engine_speed"]
    expected = (seen["engine_torque"] + 35.0 + 0.06 * speed) * speed / (0.40 * 42.7e6)
    assert seen["fuel_flow"] == pytest.approx(expected, rel=5e-3)
    burnt = np.trapezoid(seen["fuel_flow"], dx=TICK)
    assert seen["fuel_used"][-1] - seen["fuel_used"][0] == pytest.approx(burnt, rel=1e-4)


def test_power_of_the_motor_is_limited_and_falls_with_the_voltage() -> None:
    for voltage in (360.0, 300.0):
        nominal = {"motor__power_limit": 60e3, "motor__nominal_voltage": 360.0, "motor__heat_capacity": 1e6}
        plant = bench(start__speed=12.0, motor__voltage=voltage, **nominal)
        seen = drive(plant, 0.5, motor_torque_command=300.0)[100:]
        power = seen["motor_torque"] * seen["motor_speed"]
        assert power == pytest.approx(60e3 * voltage / 360.0, rel=0.02)
        assert (seen["motor_torque"] <= seen["motor_torque_limit"] * 1.05).all()
        assert (seen["motor_voltage"] == voltage).all()
    assert bench(motor__torque_limit=120.0).y["motor_torque_limit"][0] == 120.0
    seen = drive(bench(motor__torque_limit=120.0), 0.3, motor_torque_command=-300.0)
    assert seen["motor_torque"][-1] == pytest.approx(-120.0, rel=1e-3)


def test_a_hot_motor_gives_less() -> None:
    for celsius, share in ((100.0, 1.0), (160.0, 0.5), (185.0, 0.0)):
        plant = bench(motor__temperature=celsius + 273.15, motor__heat_capacity=1e6)
        assert plant.y["motor_torque_limit"][0] == pytest.approx(300.0 * share, abs=1e-6)


@pytest.mark.parametrize("torque", [80.0, -80.0], ids=["driving", "generating"])
def test_current_efficiency_and_heat(torque: float) -> None:
    plant = bench(start__speed=12.0, motor__cooling=0.0)
    seen = drive(plant, 2.0, motor_torque_command=torque, engine_torque_request=-torque)
    y = seen[-1]
    loss = 0.09 * torque**2 + y["motor_speed"] + 0.002 * y["motor_speed"] ** 2 + 50.0
    efficiency = 1.0 / (1.0 + loss / abs(torque * y["motor_speed"]))  # as the map of the vehicle was made
    power = y["motor_torque"] * y["motor_speed"]
    electric = power / efficiency if torque > 0.0 else power * efficiency
    assert y["motor_current"] * y["motor_voltage"] == pytest.approx(electric, rel=5e-3)
    assert np.sign(y["motor_current"]) == np.sign(torque)
    heat = y["electric_energy"] - y["motor_work"]
    assert heat > 1000.0
    assert y["motor_temperature"] - 338.15 == pytest.approx(heat / 10_000.0, rel=1e-6)


def test_the_winding_cools_to_its_coolant() -> None:
    plant = standing(motor__temperature=390.0)
    seen = drive(plant, 20.0)
    expected = 338.15 + (390.0 - 338.15) * np.exp(-20.0 * 150.0 / 10_000.0)
    assert seen["motor_temperature"][-1] == pytest.approx(expected, abs=1e-6)
