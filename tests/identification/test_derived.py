"""Torques that are derived instead of measured, against the simulated truth."""

from __future__ import annotations

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.identification.derived import map_torque, observed_load, with_channel
from bitepoint.models.launch import LaunchModel
from bitepoint.recording import Recording

SETTLED = 40


@pytest.fixture(scope="module")
def log() -> Recording:
    settings = {"vehicle.mass": 1600, "road.grade": 0.1, "controller.throttle": 0.2, "log.noise": 0.0}
    return bitepoint.run("dct-excitation", settings).logs["run-1"]


VEHICLE = assemble("dct-excitation", {}).system.plant.parameters


def test_the_map_torque_lacks_the_transient_loss(log: Recording) -> None:
    acceleration = np.gradient(log["engine_speed"], 0.01)
    expected = log["engine_torque"] + 0.03 * acceleration
    assert map_torque(log, VEHICLE["engine"], 0.2) == pytest.approx(expected, abs=1.2)  # torque jumps between two rows


def test_the_observer_finds_the_load(log: Recording) -> None:
    found = observed_load(log, LaunchModel.of(VEHICLE), 0.01)[SETTLED:]
    assert found.mean() == pytest.approx(log["load_torque"].mean(), abs=5.0)
    assert np.abs(found - log["load_torque"][SETTLED:]).max() < 60.0


def test_a_mass_that_is_wrong_appears_as_load(log: Recording) -> None:
    heavier = VEHICLE.copy()
    heavier["vehicle"]["mass"] = 1800.0
    believed, right = (observed_load(log, LaunchModel.of(p), 0.01)[SETTLED:].mean() for p in (heavier, VEHICLE))
    acceleration = np.polyfit(log.time, log["wheel_speed"], 1)[0]
    assert right - believed == pytest.approx(200.0 * 0.289**2 * acceleration, rel=0.05)


def test_a_channel_is_exchanged(log: Recording) -> None:
    changed = with_channel(log, "load_torque", np.zeros(len(log.time)))
    assert not changed["load_torque"].any()
    assert np.array_equal(changed["slip"], log["slip"])
    with pytest.raises(KeyError, match="no channel load"):
        with_channel(log, "load", np.zeros(len(log.time)))
