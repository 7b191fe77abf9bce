"""The conventional vehicle against an independent integrator, its road, and its start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from bitepoint.parts.road_profile import grade_profile
from tests.conftest import Refused
from tests.contracts.harness import PlantBench, nominal
from tests.plants import reference_conventional as reference
from tests.tolerances import ENERGY_TIGHT, REFERENCE_SPEED

PLANT = PLANTS["conventional"]
TICK = 0.01


def bench(vehicle: str = "hatchback-2l", **changes: Any) -> PlantBench:
    """A library vehicle; `block__key` changes a parameter."""
    p = nominal(PLANT, vehicle)
    for name, value in changes.items():
        block, _, key = name.partition("__")
        p[block][key] = value
    return PlantBench(PLANT, p)


def drive(plant: PlantBench, end: float) -> np.ndarray:
    """The motion at each tick of the programme of the reference."""
    rows = [plant.x["motion"].copy()]
    for k in range(round(end / TICK)):
        _, engine, clutch, brake, gear = [row for row in reference.PROGRAMME if row[0] <= k * TICK + 1e-9][-1]
        commands = {"engine_torque_request": engine, "clutch_torque_command": clutch, "brake_torque_command": brake}
        assert plant.step(TICK, **commands, gear_command=float(gear))[0] == 0
        rows.append(plant.x["motion"].copy())
    return np.concatenate(rows)


def test_a_drive_agrees_with_an_independent_integration() -> None:
    """Launch on the slipping clutch, a shift, a closing clutch, overrun with the brake, on a road of hills."""
    end = 12.0
    states = reference.integrate(end)
    profile = grade_profile(reference.WAY, reference.GRADE)
    start = {"start__speed": reference.START_SPEED, "start__engine_torque": reference.START_TORQUE}
    plant = bench(road__profile=profile, solver__substep=2.5e-4, **start)
    seen = drive(plant, end)
    assert np.ptp(states[9]) > 0.5  # metres of height
    for row, name in enumerate(reference.NAMES[:3]):
        assert seen[name] == pytest.approx(states[row], abs=2.0 * REFERENCE_SPEED), name
    for row, name in enumerate(reference.NAMES[3:6], 3):
        assert seen[name] == pytest.approx(states[row], abs=1e-5), name
    for row, name in enumerate(reference.NAMES[6:8], 6):
        assert seen[name] == pytest.approx(states[row], abs=0.01), name
    assert seen["distance"] == pytest.approx(states[8], abs=1e-3)
    assert seen["elevation"] == pytest.approx(states[9], abs=1e-4)
    assert seen["fuel_used"][-1] == pytest.approx(states[10, -1], rel=1e-5)


def test_the_books_close_in_a_drive_at_the_substep_of_the_vehicle() -> None:
    plant = bench(start__speed=reference.START_SPEED, start__engine_torque=reference.START_TORQUE)
    before = plant.y.copy()
    drive(plant, 12.0)
    work, heat, losses, stored = (
        float(plant.y[name][0] - before[name][0])
        for name in ("engine_work", "friction_heat", "losses", "stored_energy")
    )
    assert work > 1e5
    assert abs(work - heat - losses - stored) < 10.0 * ENERGY_TIGHT * work


def test_height_is_that_of_the_road() -> None:
    """A hill of 4 m over 500 m, driven over: the height follows the closed form."""
    way = np.arange(0.0, 501.0, 5.0)
    profile = grade_profile(way, 4.0 * np.pi / 500.0 * np.sin(2.0 * np.pi * way / 500.0))
    plant = bench(road__profile=profile, start__speed=20.0, gearbox__gear=4)
    while plant.y["distance"][0] < 500.0:
        plant.step(TICK, engine_torque_request=60.0, clutch_torque_command=300.0)
        s = min(float(plant.y["distance"][0]), 500.0)
        height = 2.0 * (1.0 - np.cos(2.0 * np.pi * s / 500.0))
        assert plant.y["elevation"][0] == pytest.approx(height, abs=0.005)


def test_a_road_of_many_points_keeps_its_height() -> None:
    rng = np.random.default_rng(2)
    way = np.concatenate([[0.0], np.cumsum(rng.uniform(2.0, 12.0, 3000))])
    grade = 0.05 * np.sin(way / 300.0)
    profile = grade_profile(way, grade)[0]
    at = np.arange(profile["points"]) * profile["spacing"]
    height = np.cumsum(0.5 * (profile["grades"][1:1024] + profile["grades"][:1023])) * profile["spacing"]
    true = 15.0 * (1.0 - np.cos(at[1:] / 300.0))
    assert at[-1] == pytest.approx(way[-1])
    assert height == pytest.approx(true, abs=0.05)


@pytest.mark.parametrize(
    ("way", "grade"), [([0.0], [0.0]), ([1.0, 2.0], [0.0, 0.0]), ([0.0, 0.0], [0.0, 0.0]), ([0.0, 9.0], [0.0, 0.6])]
)
def test_a_road_that_is_none_is_refused(way: list[float], grade: list[float], refused: Refused) -> None:
    refused(lambda: grade_profile(way, grade), "road", "expected")


@pytest.mark.parametrize("grade", [0.0, 0.1])
def test_the_brake_holds_a_standing_vehicle(grade: float) -> None:
    plant = bench(road__grade=grade)
    for _ in range(1000):
        plant.step(TICK, brake_torque_command=2000.0)
    assert abs(plant.y["vehicle_speed"][0]) < 1e-6
    assert abs(plant.y["distance"][0]) < 0.02


def test_rolls_below_the_launch_speed_with_a_slipping_clutch() -> None:
    plant = bench(start__speed=5.0 / 3.6, start__engine_torque=30.0)
    for _ in range(20):
        plant.step(TICK)
        assert plant.y["clutch_torque"][0] == pytest.approx(30.0, rel=1e-6)
    assert plant.y["engine_speed"][0] == pytest.approx(125.66, abs=0.5)  # 1200 rpm, in balance with the clutch


def test_dead_time_of_the_engine() -> None:
    plant = bench(engine__delay=0.05, start__speed=10.0, start__engine_torque=20.0)
    torques = [float(plant.y["engine_torque"][0])]
    for _ in range(10):
        plant.step(TICK, engine_torque_request=100.0)
        torques.append(float(plant.y["engine_torque"][0]))
    assert torques[5] == pytest.approx(20.0, abs=1e-6)
    assert torques[6] > 25.0
