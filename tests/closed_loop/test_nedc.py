"""The NEDC with a driver: the car follows it, on a slippery road and laden too, and nothing swings after a shift."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint.recording import Recording

CONDITIONS: Mapping[str, Mapping[str, Any]] = {
    "as it is": {},
    "slippery": {"road.friction": 0.25},
    "laden": {"vehicle.mass": "2600 kg"},
    "uphill": {"road.grade": "3 %", "timing.duration": "400 s"},
    "early shifts": {"speed_driver.shift_up_speed": "170 rad/s", "timing.duration": "400 s"},
    "schedule": {"speed_driver.schedule": "1", "timing.duration": "400 s"},
    "electric": {"torque_split.mode": "electric", "timing.duration": "400 s"},
    "other gears": {"gearbox.shift_time": "0.5 s", "timing.duration": "400 s"},
}


@cache
def driven(name: str) -> Any:
    """The run under a condition; it and its figures are not changed."""
    return bitepoint.run("p2-nedc", dict(CONDITIONS[name]))


@pytest.mark.parametrize("name", CONDITIONS)
def test_the_car_follows_the_cycle(name: str) -> None:
    run = driven(name)
    figures = {key: figure.value for key, figure in run.metrics.items()}
    assert run.status == "completed"
    assert figures["within_tolerance"] >= 0.99
    assert figures["speed_error_rms"] < 0.2
    assert figures["energy_residual"] < 1e-6


def test_the_economy_schedule_of_the_engine_shifts_earlier() -> None:
    """From 3rd to 4th between 22 and 31 km/h, where the speed of the input asks for some 40 km/h."""

    def upshifts(run: Any) -> list[float]:
        gear, speed = run.recording["gear_command"], run.recording["vehicle_speed"]
        return [3.6 * float(speed[k]) for k in np.flatnonzero((gear[1:] == 4.0) & (gear[:-1] == 3.0))]

    early, late = upshifts(driven("schedule")), upshifts(driven("as it is"))
    assert all(20.0 < speed < 33.0 for speed in early)
    assert min(late) > 33.0


def test_the_way_is_that_of_the_cycle() -> None:
    assert driven("as it is").metrics["distance"].value == pytest.approx(11_013, rel=0.005)


def test_every_gear_is_used_and_nothing_is_asked_in_neutral() -> None:
    recording: Recording = driven("as it is").recording
    gear = recording["gear"]
    assert set(np.unique(gear)) == {0, 1, 2, 3, 4, 5, 6}
    neutral = gear[1:] == 0.0
    assert np.abs(recording["torque_request"][1:][neutral]).max() < 1.0
    assert recording["clutch_torque_command"][1:][neutral][5:].min() == 0.0


def test_the_engine_drives_and_never_falls_below_idle() -> None:
    recording: Recording = driven("as it is").recording
    closed = recording["clutch_torque_command"] > 0.0
    assert 0.2 < closed.mean() < 0.8
    assert recording["engine_speed"].min() > 0.97 * recording["engine_speed"][0]
    assert recording["engine_torque"][closed].max() > 100.0


def swings(recording: Recording) -> list[float]:
    """Largest torsional speed, rad/s, from 1 s to 2 s after each shift that is followed by steady driving."""
    gear, speed, target = (recording[name] for name in ("gear", "vehicle_speed", "speed_target"))
    rate = np.diff(target, append=target[-1])
    found: list[float] = []
    for k in np.flatnonzero((gear[:-1] == 0.0) & (gear[1:] > 0.0)) + 1:
        after = slice(k, k + 200)
        if gear[after].min() > 0.0 and np.ptp(rate[after]) < 1e-6 and speed[after].min() > 1.0:
            found.append(float(np.abs(recording["torsional_speed"][k + 100 : k + 200]).max()))
    return found


@pytest.mark.parametrize("name", ["as it is", "slippery", "laden"])
def test_nothing_swings_after_a_shift(name: str) -> None:
    found = swings(driven(name).recording)
    assert len(found) > 5
    assert max(found) < 0.06


def test_a_finer_tick_makes_no_other_drive() -> None:
    settings = {"timing.duration": "130 s"}
    coarse = bitepoint.run("p2-nedc", settings).recording
    fine = bitepoint.run("p2-nedc", {**settings, "timing.tick": "2 ms"}).recording
    assert fine["vehicle_speed"][::5] == pytest.approx(coarse["vehicle_speed"], abs=1e-3)
