"""Both lives of the plant through all of its events: release, lock, unlock, relock, stop, roll back, stick."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from bitepoint.parts.gears import axle_side_inertia
from tests.contracts.harness import PlantBench, nominal, same_bits

PHASES = (
    # time s, throttle, capacity N m
    (0.25, 0.25, 140.0),  # release, slip, lock
    (0.04, 0.30, 200.0),  # locked
    (0.05, 0.60, 10.0),  # unlock: the engine races
    (0.12, 0.00, 280.0),  # the clutch catches it: relock
    (0.30, 0.03, 0.0),  # rolls uphill, stops, rolls back
)


def test_lives_agree_through_every_event() -> None:
    p = nominal(PLANTS["dct"], "dct-t240")
    p["road"]["grade"] = 0.12
    benches = [PlantBench(PLANTS["dct"], p.copy(), life) for life in ("compiled", "interpreted")]
    modes: list[tuple[int, float]] = []
    for time, throttle, capacity in PHASES:
        for _ in range(round(time / 0.01)):
            for bench in benches:
                assert bench.step(0.01, throttle=throttle, clutch_torque_command=capacity)[0] == 0
            assert same_bits(benches[0].y, benches[1].y)
            mode = benches[0].x["mode"][0]
            modes.append((int(mode["locked"]), float(mode["rolling_direction"])))
    assert same_bits(benches[0].x, benches[1].x)
    locks = [after[0] - before[0] for before, after in pairwise(modes) if after[0] != before[0]]
    assert locks[:3] == [1, -1, 1]
    assert {direction for _, direction in modes} >= {1.0, -1.0}
    assert benches[0].y["vehicle_speed"][0] < 0.0


def test_sticks_on_a_slope_that_rolling_resistance_holds() -> None:
    p = nominal(PLANTS["dct"], "dct-t240")
    p["road"]["grade"] = 0.01  # below the rolling resistance of 0.018
    bench = PlantBench(PLANTS["dct"], p)
    for k in range(300):
        bench.step(throttle=0.3, clutch_torque_command=min(0.5 * k, 90.0))
    assert bench.y["vehicle_speed"][0] > 0.1
    for _ in range(4000):
        bench.step(throttle=0.03, clutch_torque_command=0.0)
    assert bench.y["vehicle_speed"][0] == 0.0
    assert bench.y["vehicle_held"][0] == 1.0
    assert bench.x["mode"]["hill_hold"][0] == 0


@pytest.mark.parametrize("change", [("damping", 40.0), ("stiffness", 60_000.0)])
def test_a_stiffer_damper_needs_no_shorter_setting(change: tuple[str, float]) -> None:
    p = nominal(PLANTS["dct"], "dct-t240")
    p["damper"][change[0]] = change[1]
    bench = PlantBench(PLANTS["dct"], p.copy())
    p["solver"]["substep"] = 2e-5
    fine = PlantBench(PLANTS["dct"], p)
    for k in range(700):
        for each in (bench, fine):
            each.step(throttle=0.25, clutch_torque_command=min(0.3 * k, 120.0))
    assert bench.y["clutch_speed"][0] == pytest.approx(fine.y["clutch_speed"][0], abs=1e-3)


def test_a_stalled_engine_comes_to_rest() -> None:
    bench = PlantBench(PLANTS["dct"], nominal(PLANTS["dct"], "dct-t240"))
    for _ in range(3000):
        bench.step(throttle=0.0, clutch_torque_command=0.0)
    assert abs(bench.y["engine_speed"][0]) < 0.5
    assert np.isfinite(bench.y.view(np.float64)).all()


@pytest.mark.parametrize(
    "changes",
    [
        {"halfshaft": {"damping": 1e5}, "vehicle": {"mass": 50.0, "wheel_radius": 0.1}},
        {
            "halfshaft": {"damping": 0.0, "stiffness": 1e7},
            "damper": {"damping": 0.0},
            "gearbox": {"efficiency": 1.0, "axle_inertia": 0.1, "odd_shaft_inertia": 0.001, "layshaft_inertia": 0.0},
        },
    ],
    ids=["heavily damped, light car", "stiff and undamped"],
)
def test_the_substep_follows_whatever_driveline(changes: dict[str, dict[str, float]]) -> None:
    p = nominal(PLANTS["dct"], "dct-t240")
    for block, values in changes.items():
        for name, value in values.items():
            p[block][name] = value
    bench = PlantBench(PLANTS["dct"], p)
    before = bench.y.copy()
    for k in range(300):
        assert bench.step(throttle=0.25, clutch_torque_command=min(0.4 * k, 90.0))[0] == 0
    y = bench.y
    missed = y["engine_work"] - y["friction_heat"] - y["losses"] - (y["stored_energy"] - before["stored_energy"])
    assert abs(missed[0]) < 1e-3 * y["engine_work"][0]


def test_the_fuel_is_cut_above_the_speed_limit() -> None:
    bench = PlantBench(PLANTS["dct"], nominal(PLANTS["dct"], "dct-t240"))
    for _ in range(5000):
        bench.step(throttle=1.0, clutch_torque_command=0.0)
    assert 628.0 < bench.y["engine_speed"][0] < 640.0


def test_the_lock_is_known_to_within_the_step() -> None:
    times = []
    for tick in (0.01, 0.002, 0.0005):
        bench = PlantBench(PLANTS["dct"], nominal(PLANTS["dct"], "dct-t240"))
        for _ in range(round(1.0 / tick)):
            bench.step(tick, throttle=0.15, clutch_torque_command=100.0)
        assert bench.y["clutch_locked"][0] == 1.0
        times.append(1.0 - bench.y["clutch_locked_time"][0])
    assert times == pytest.approx([times[0]] * 3, abs=1e-6)


def test_axle_inertia_in_third_gear() -> None:
    gearbox = nominal(PLANTS["dct"], "dct-t240")["gearbox"].copy()
    gearbox["gear"] = 3
    turning = 0.006 * 1.2301**2 + 0.008 + 0.006 * 1.7064**2
    assert axle_side_inertia.run(gearbox)[0] == pytest.approx(1.6 + 4.4705**2 * turning)
