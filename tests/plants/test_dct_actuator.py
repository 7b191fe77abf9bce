"""The plant with an active clutch actuator: fill, friction, and what is left when it is off or ideal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bitepoint import run
from bitepoint.assembly import PLANTS
from bitepoint.parts.clutch_actuator import pressure_for_torque, torque_from_pressure
from tests.contracts.harness import PlantBench, nominal, same_bits
from tests.plants.reference_dct import Input, axle_torques, derivative, road
from tests.tolerances import REFERENCE_SPEED

DCT = PLANTS["dct"]
ON = "dct-t240 with actuator"
KISS = 800.0 / 0.0042


def bench(**values: Any) -> PlantBench:
    p = nominal(DCT, ON)
    for name, value in values.items():
        block = "clutch" if name == "friction_gain" else "actuator"
        p[block][name] = value
    return PlantBench(DCT, p)


def test_pressure_follows_its_command_as_a_first_order_lag_does() -> None:
    plant = bench(fill_time=0.08)
    assert plant.y["clutch_pressure"][0] == pytest.approx(KISS)
    start = KISS
    for command in (120.0, 40.0, 0.0):
        goal = (800.0 + command / (8 * 0.13 * 0.07)) / 0.0042
        for k in range(1, 101):
            plant.step(0.002, throttle=0.25, clutch_torque_command=command)
            expected = goal + (start - goal) * np.exp(-0.002 * k / 0.08)
            assert plant.y["clutch_pressure"][0] == pytest.approx(expected, rel=1e-8)
        start = plant.y["clutch_pressure"][0]


@pytest.mark.parametrize(
    ("gain", "temperature", "expected"), [(1.0, 363.15, 1.0), (0.8, 363.15, 0.8), (1.0, 403.15, 0.96)]
)
def test_a_slipping_clutch_carries_the_command_times_its_friction_over_the_nominal_one(
    gain: float, temperature: float, expected: float
) -> None:
    plant = bench(friction_gain=gain, temperature=temperature, heat_capacity=1e6)
    for _ in range(300):
        plant.step(throttle=0.3, clutch_torque_command=100.0)
    assert plant.y["slip_speed"][0] > 50.0
    assert plant.y["clutch_torque"][0] == pytest.approx(100.0 * expected, rel=1e-3)


def test_agrees_with_an_independent_integration() -> None:
    command, throttle, duration = 110.0, 0.3, 0.5
    goal = (800.0 + command / (8 * 0.13 * 0.07)) / 0.0042
    climb, rolling = road(0.0)

    def capacity(t: float, x: np.ndarray) -> float:
        pressure = goal + (KISS - goal) * np.exp(-t / 0.05)
        friction = (0.13 - 0.015 * np.exp(-abs(x[0] - x[1]) / 5.0)) * (1.0 - 0.001 * x[6] / 1000.0)
        return 8 * friction * 0.07 * (pressure * 0.0042 - 800.0)

    def rhs(t: float, x: np.ndarray, held: bool) -> np.ndarray:
        torque = capacity(t, x)
        motion = derivative(x[:6], Input(duration, throttle, torque), 0.0, False, held)
        return np.append(motion, torque * (x[0] - x[1]))

    def pull(_t: float, x: np.ndarray, _held: bool) -> float:
        return axle_torques(x[:6])[1] - climb - rolling

    pull.terminal = True  # type: ignore[attr-defined]
    exact = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-11, "max_step": 0.01}
    start = np.array([83.0, 0, 0, 0, 0, 0, 0])
    standing = solve_ivp(rhs, (0.0, duration), start, events=pull, args=(True,), **exact)
    assert standing.status == 1
    rolling_off = solve_ivp(rhs, (standing.t[-1], duration), standing.y[:, -1], args=(False,), **exact)
    engine, plate, axle, wheel, _, _, heat = rolling_off.y[:, -1]
    plant = bench()
    for _ in range(250):
        plant.step(0.002, throttle=throttle, clutch_torque_command=command)
    motion = plant.x["motion"][0]
    assert engine - plate > 10.0
    for name, expected in (
        ("engine_speed", engine),
        ("plate_speed", plate),
        ("axle_speed", axle),
        ("wheel_speed", wheel),
    ):
        assert motion[name] == pytest.approx(expected, abs=REFERENCE_SPEED), name
    assert motion["friction_work"] == pytest.approx(heat, rel=1e-6)


@pytest.mark.parametrize("intent", ["slow", "normal", "urgent"])
def test_a_fast_actuator_with_even_friction_is_none(intent: str) -> None:
    ideal = {"actuator.fill_time": "1 ms", "actuator.static_friction": 0.13, "actuator.temperature_slope": 0.0}
    with_it = run("dct-launch", intent=intent, **{"actuator.active": 1, **ideal}).metrics
    without = run("dct-launch", intent=intent).metrics
    for name in ("launch_time", "friction_work", "jerk_peak", "end_speed"):
        assert with_it[name].value == pytest.approx(without[name].value, rel=5e-3), name


def test_when_it_is_off_its_values_change_nothing() -> None:
    off = [nominal(DCT, "dct-t240") for _ in range(2)]
    off[1]["actuator"]["fill_time"], off[1]["actuator"]["sliding_friction"] = 0.3, 0.05
    benches = [PlantBench(DCT, p) for p in off]
    for k in range(300):
        for each in benches:
            each.step(throttle=0.3, clutch_torque_command=min(0.5 * k, 120.0))
        assert same_bits(benches[0].y, benches[1].y)
    assert benches[0].y["clutch_pressure"][0] == 0.0


def test_a_pressure_is_commanded_by_the_torque_that_it_nominally_gives() -> None:
    plant = bench()
    wanted = 6.2e5
    a = plant.p["actuator"].copy()
    command = torque_from_pressure.run(a, a["sliding_friction"].copy(), wanted)[0]
    assert pressure_for_torque.run(a, a["sliding_friction"].copy(), command)[0] == pytest.approx(wanted, rel=1e-12)
    for _ in range(1000):
        plant.step(throttle=0.3, clutch_torque_command=command)
    assert plant.y["clutch_pressure"][0] == pytest.approx(wanted, rel=1e-9)
