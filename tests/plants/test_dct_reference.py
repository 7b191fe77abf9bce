"""The plant against an independent integrator: events located by it, rtol 1e-9."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from tests.contracts.harness import PlantBench, nominal
from tests.plants.reference_dct import Input, integrate
from tests.tolerances import LOCATED_LOCK, REFERENCE_SPEED, REFERENCE_TIME

SPEEDS = ("engine_speed", "plate_speed", "axle_speed", "wheel_speed")
TWISTS = ("damper_twist", "halfshaft_twist")


def ramp(throttle: float, top: float, rise: float, time: float) -> list[Input]:
    """A capacity that rises in steps of 20 ms."""
    return [Input(0.02, throttle, min(top, rise * 0.02 * k)) for k in range(round(time / 0.02))]


CASES = {
    "level": (0.0, ramp(0.17, 110.0, 150.0, 2.0)),
    "hard": (0.0, ramp(0.40, 200.0, 500.0, 1.2)),
    "uphill": (0.12, ramp(0.45, 170.0, 300.0, 2.0)),
    "downhill": (-0.03, ramp(0.10, 70.0, 100.0, 1.8)),
}


@pytest.mark.parametrize("case", CASES)
def test_agrees_with_an_independent_integration(case: str) -> None:
    grade, inputs = CASES[case]
    expected, release, lock = integrate(inputs, grade)
    assert lock is not None
    p = nominal(PLANTS["dct"], "dct-t240")
    p["road"]["grade"] = grade
    bench = PlantBench(PLANTS["dct"], p)
    time, located = 0.0, {}
    for u in inputs:
        for _ in range(round(u.duration / 0.0005)):  # one substep at a time, to see in which one an event fell
            held, locked = bench.y["vehicle_held"][0], bench.y["clutch_locked"][0]
            bench.step(0.0005, throttle=u.throttle, clutch_torque_command=u.capacity)
            time += 0.0005
            if held and not bench.y["vehicle_held"][0]:
                located["release"] = time
            if not locked and bench.y["clutch_locked"][0]:
                located["lock"] = time
    motion = bench.x["motion"][0]
    for name, value in zip((*SPEEDS, *TWISTS), expected, strict=True):
        assert motion[name] == pytest.approx(value, abs=REFERENCE_SPEED, rel=REFERENCE_SPEED), name
    assert located["lock"] - 0.0005 - 1e-9 <= lock <= located["lock"] + 1e-9
    assert time - bench.y["clutch_locked_time"][0] == pytest.approx(lock, abs=LOCATED_LOCK)
    if release is not None and release > 0.0:
        assert located["release"] - 0.0005 - 1e-9 <= release <= located["release"] + 1e-9


def test_lock_time_from_the_recording_agrees() -> None:
    """The figure that users see: sync_time of a recording with the library's raster of 2 ms."""
    from bitepoint.metrics import sync_time
    from bitepoint.recording import Channel, Recording

    grade, inputs = CASES["level"]
    _, _, lock = integrate(inputs, grade)
    assert lock is not None
    p = nominal(PLANTS["dct"], "dct-t240")
    bench = PlantBench(PLANTS["dct"], p)
    rows = [[bench.y[name][0] for name in ("engine_speed", "clutch_speed")]]
    for u in inputs:
        for _ in range(10):
            bench.step(0.002, throttle=u.throttle, clutch_torque_command=u.capacity)
            rows.append([bench.y[name][0] for name in ("engine_speed", "clutch_speed")])
    channels = (Channel("engine_speed", "rad/s"), Channel("clutch_speed", "rad/s"))
    recording = Recording(np.arange(len(rows)) * 0.002, channels, np.array(rows).T.copy())
    found = sync_time(recording, 0.0)
    assert found == pytest.approx(lock, abs=REFERENCE_TIME)


def test_error_falls_with_the_fourth_power_of_the_substep() -> None:
    """Down to where the kinks of the engine map take over, at 0.1 ms."""
    grade, inputs = CASES["level"]
    inputs = inputs[5:40]  # slipping all the time: smooth between the steps of the input
    expected, _, lock = integrate(inputs, grade)
    assert lock is None

    def error(h: float) -> float:
        p = nominal(PLANTS["dct"], "dct-t240")
        p["solver"]["substep"] = h
        bench = PlantBench(PLANTS["dct"], p)
        for u in inputs:
            bench.step(u.duration, throttle=u.throttle, clutch_torque_command=u.capacity)
        return abs(bench.x["motion"]["plate_speed"][0] - fine)

    p = nominal(PLANTS["dct"], "dct-t240")
    p["solver"]["substep"] = 2e-5
    bench = PlantBench(PLANTS["dct"], p)
    for u in inputs:
        bench.step(u.duration, throttle=u.throttle, clutch_torque_command=u.capacity)
    fine = bench.x["motion"]["plate_speed"][0]
    assert fine == pytest.approx(expected[1], abs=1e-5)
    order = np.log2(error(5e-4) / error(2.5e-4))
    assert 3.0 < order < 6.0
