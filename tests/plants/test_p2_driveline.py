"""Clutch, gearbox, brake and tyres of the P2 hybrid: open, slipping and closed, shifting, coming to rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from bitepoint.plants.p2_hybrid import check
from tests.conftest import Refused
from tests.contracts.harness import PlantBench, nominal
from tests.plants.test_p2_engine_motor import TICK, drive, standing
from tests.plants.test_p2_reference import bench
from tests.tolerances import ENERGY_TIGHT


def balanced(plant: PlantBench, before: np.ndarray) -> float:
    """What the energy balance misses since, over what was turned over and 10 kJ.

    A jump of an input, which the tyres answer within a substep, costs up to 10 mJ.
    """
    y = plant.y
    since = {name: y[name][0] - before[name][0] for name in plant.plant.outputs.fields}
    work = since["engine_work"] + since["motor_work"]
    missing = work - since["friction_heat"] - since["losses"] - since["stored_energy"]
    turned = abs(since["engine_work"]) + abs(since["motor_work"]) + since["friction_heat"] + since["losses"] + 1e4
    return abs(missing) / turned


def test_an_open_clutch_carries_nothing_and_unwinds() -> None:
    plant = bench(start__engine_torque=200.0)
    before = plant.y.copy()
    seen = drive(plant, 0.5, engine_torque_request=0.0, clutch_torque_command=0.0, motor_torque_command=50.0)
    assert (seen["clutch_torque"] == 0.0).all()
    time = TICK * np.arange(1, 251)
    assert seen["clutch_twist"] == pytest.approx(200.0 / 1400.0 * np.exp(-time * 1400.0 / 6.0), rel=1e-3)
    assert balanced(plant, before) < ENERGY_TIGHT


def test_a_slipping_clutch_carries_its_capacity_and_turns_slip_to_heat() -> None:
    plant = standing()
    before = plant.y.copy()
    seen = drive(plant, 0.6, engine_torque_request=120.0, clutch_torque_command=80.0)
    assert (np.abs(seen["clutch_torque"]) <= 80.0).all()
    sliding = seen[100:]
    assert (sliding["clutch_torque"] == 80.0).all()
    slip = sliding["engine_speed"] - sliding["motor_speed"]
    assert slip.min() > 10.0
    heat = np.trapezoid(80.0 * slip, dx=TICK)
    tyres = np.trapezoid(sliding["tyre_force"] * (0.32 * sliding["wheel_speed"] - sliding["vehicle_speed"]), dx=TICK)
    assert sliding["friction_heat"][-1] - sliding["friction_heat"][0] == pytest.approx(heat + tyres, rel=1e-3)
    assert balanced(plant, before) < ENERGY_TIGHT


def test_a_clutch_that_is_closed_brings_engine_and_motor_together() -> None:
    plant = standing()
    before = plant.y.copy()
    for k in range(1500):
        plant.step(TICK, engine_torque_request=150.0, clutch_torque_command=min(0.6 * k, 600.0))
    assert plant.y["vehicle_speed"][0] > 2.0
    assert plant.y["engine_speed"][0] == pytest.approx(plant.y["motor_speed"][0], abs=0.2)
    heat = plant.x["motion"]["clutch_heat"][0]
    drive(plant, 0.5)
    assert plant.x["motion"]["clutch_heat"][0] == pytest.approx(heat, rel=1e-9)
    assert balanced(plant, before) < ENERGY_TIGHT


def test_shifts_through_neutral() -> None:
    plant = bench(start__engine_torque=0.0)
    before = plant.y.copy()
    drive(plant, 0.3, engine_torque_request=0.0, clutch_torque_command=0.0)
    plain = plant.y.copy()
    seen = drive(plant, 0.6, gear_command=3.0)
    neutral = seen["gear"] == 0.0
    assert neutral.sum() == pytest.approx(0.25 / TICK, abs=1)
    assert (seen["halfshaft_torque"][neutral] == 0.0).all()
    assert seen["gear"][~neutral].tolist() == [3.0] * int((~neutral).sum())
    assert seen["gear_ratio"] == pytest.approx(1.9 * 3.75)
    ratio, wheel = 7.125, plain["wheel_speed"][0]
    assert plant.y["motor_speed"][0] == pytest.approx(ratio * plant.y["wheel_speed"][0], rel=0.01)
    # the vehicle is so heavy that its speed hardly changes: half of J dw^2 turns to heat
    heat = 0.5 * 0.14 * (plain["motor_speed"][0] - ratio * wheel) ** 2
    assert plant.x["motion"]["synchroniser_heat"][0] == pytest.approx(heat, rel=0.05)
    assert plant.y["vehicle_speed"][0] == pytest.approx(plain["vehicle_speed"][0], abs=0.15)
    assert balanced(plant, before) < ENERGY_TIGHT


def test_shifts_at_a_standstill() -> None:
    plant = standing()
    seen = drive(plant, 0.5, gear_command=1.0)
    assert seen["gear"][-1] == 1.0
    assert (seen["gear"] == 0.0).sum() == pytest.approx(0.25 / TICK, abs=1)
    assert plant.y["vehicle_speed"][0] == 0.0
    assert plant.y["engine_speed"][0] == pytest.approx(800 * np.pi / 30)


def test_a_gear_waits_until_the_synchroniser_has_done_its_work() -> None:
    """The engine, still coupled, pulls more than the synchroniser does."""
    plant = bench(start__engine_torque=150.0)
    seen = drive(plant, 1.0, engine_torque_request=150.0, gear_command=3.0)
    assert (seen["gear"] == 0.0).all()
    assert (seen["halfshaft_torque"] == 0.0).all()
    seen = drive(plant, 2.0, engine_torque_request=0.0, clutch_torque_command=0.0)
    assert seen["gear"][-1] == 3.0


@pytest.mark.parametrize("command", [2.0, 7.0, 8.0, 0.0, np.nan], ids=["same", "none", "none", "keep", "not a number"])
def test_a_gear_that_is_engaged_or_does_not_exist_changes_nothing(command: float) -> None:
    plant = bench()
    for _ in range(50):
        plant.step(TICK, gear_command=command)
    assert plant.y["gear"][0] == 2.0


def test_another_gear_may_be_wanted_on_the_way() -> None:
    plant = bench(start__engine_torque=0.0)
    drive(plant, 0.1, engine_torque_request=0.0, clutch_torque_command=0.0, gear_command=3.0)
    seen = drive(plant, 0.3, gear_command=2.0)
    assert (seen["gear"] == 0.0).sum() == pytest.approx(0.25 / TICK, abs=2)
    assert seen["gear"][-1] == 2.0


@pytest.mark.parametrize("efficiency", [1.0, 0.9])
def test_gears_lose_their_share_in_either_direction(efficiency: float) -> None:
    plant = bench(gearbox__efficiency=efficiency, start__speed=12.0)
    before = plant.y.copy()
    for request in (150.0, -60.0):
        seen = drive(plant, 3.0, engine_torque_request=request)[-200:]
        power_in = np.trapezoid(seen["clutch_torque"] * seen["motor_speed"], dx=TICK)
        power_out = np.trapezoid(seen["halfshaft_torque"] * seen["wheel_speed"], dx=TICK)
        turning = 0.07 * (seen["motor_speed"][-1] ** 2 - seen["motor_speed"][0] ** 2)
        passed = (power_in - turning) * efficiency if request > 0.0 else (power_in - turning) / efficiency
        assert power_out == pytest.approx(passed, rel=5e-3)
    assert bool(plant.x["motion"]["gear_loss"][0] > 0.0) is (efficiency < 1.0)
    assert balanced(plant, before) < ENERGY_TIGHT


@pytest.mark.parametrize("grade", [0.0, 0.2, -0.2])
def test_comes_to_rest_under_the_brake_and_stays(grade: float) -> None:
    plant = bench(start__speed=12.0, start__engine_torque=0.0, road__grade=grade)
    before = plant.y.copy()
    brake = {"engine_torque_request": 0.0, "clutch_torque_command": 0.0, "brake_torque_command": 3500.0}
    seen = drive(plant, 6.0, **brake)
    stop = int(np.argmax(seen["vehicle_speed"] < 0.0))
    assert 0.5 < stop * TICK < 4.0
    assert (np.abs(seen["brake_torque"]) <= 3500.0 + 1e-9).all()
    after = seen[stop:]
    turns = (np.diff(np.sign(after["vehicle_speed"][:250])) != 0).sum()
    assert turns <= 2  # rocks once, does not chatter
    assert np.abs(after["vehicle_speed"]).max() < 0.4
    # the tyre is viscous below 1 m/s: what is left creeps by the grade over its stiffness
    creep = 2000 * 9.80665 * np.sin(np.arctan(grade)) / (1.05 * 2000 * 9.80665 * np.cos(np.arctan(grade)) * 14 * 1.6)
    assert seen["vehicle_speed"][-1] == pytest.approx(-creep, abs=2e-4)
    assert seen["wheel_speed"][-1] == pytest.approx(0.0, abs=2e-3)
    assert balanced(plant, before) < ENERGY_TIGHT


def test_wheels_lock_under_too_much_brake() -> None:
    seen = drive(
        bench(start__speed=12.0, road__friction=0.4), 0.5, brake_torque_command=8000.0, clutch_torque_command=0.0
    )
    assert seen["tyre_slip"][-1] == pytest.approx(-1.0, abs=0.02)
    assert seen["vehicle_acceleration"][-1] == pytest.approx(-0.4 * 9.80665 * 0.72, rel=0.05)


def test_rolls_to_rest_and_down_a_grade_by_itself() -> None:
    plant = bench(start__speed=0.5, start__engine_torque=0.0)
    drive(plant, 20.0, engine_torque_request=0.0, clutch_torque_command=0.0)
    assert abs(plant.y["vehicle_speed"][0]) < 2e-3
    steep = standing(road__grade=0.05)
    drive(steep, 2.0)
    expected = (
        -(0.05 - 0.012) * 9.80665 / np.hypot(1, 0.05) * 2.0 * 2000.0 / (2000.0 + (4.0 + 0.14 * 10.5**2) / 0.32**2)
    )
    assert steep.y["vehicle_speed"][0] == pytest.approx(expected, rel=0.1)
    assert steep.y["longitudinal_acceleration"][0] == pytest.approx(
        steep.y["vehicle_acceleration"][0] + 9.80665 * 0.05 / np.hypot(1, 0.05)
    )


@pytest.mark.parametrize("speed", [0.0, 0.6, 3.0])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"tyre__wheel_inertia": 0.5},
        {"halfshaft__damping": 2000.0},
        {"motor__inertia": 0.01},
        {"clutch__damping": 60.0},
    ],
    ids=["library", "light wheels", "damped half-shafts", "light motor", "damped clutch"],
)
def test_the_substep_follows_whatever_vehicle(changes: dict[str, Any], speed: float) -> None:
    plants = [bench(start__speed=speed, solver__substep=h, **changes) for h in (2e-3, 2e-5)]
    for plant in plants:
        drive(plant, 0.4, engine_torque_request=150.0, clutch_torque_command=100.0, motor_torque_command=50.0)
    coarse, fine = (plant.y[0] for plant in plants)
    assert coarse["wheel_speed"] == pytest.approx(fine["wheel_speed"], abs=0.02)
    assert coarse["halfshaft_torque"] == pytest.approx(fine["halfshaft_torque"], abs=5.0)


def test_what_contradicts_itself_is_refused(refused: Refused) -> None:
    plant = PLANTS["p2_hybrid"]

    def changed(block: str, key: str, value: float) -> np.ndarray:
        p = nominal(plant, "p2-suv")
        p[block][key] = value
        return p

    refused(lambda: check(changed("gearbox", "gear", 7), "file"), "file", "gear 7 has no ratio", "at least 0.5")
    refused(
        lambda: check(changed("engine", "idle_speed", 900), "file"), "engine.idle_speed", "below engine.speed_limit"
    )
    refused(lambda: check(changed("engine", "firing_speed", 100), "file"), "engine.firing_speed", "engine.idle_speed")
    check(nominal(plant, "p2-suv"), "file")
