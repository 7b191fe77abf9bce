"""Long studies, run by `make slow`."""

from __future__ import annotations

import resource

import numpy as np
import pytest

import bitepoint
from bitepoint.studies import dct_launch
from bitepoint.studies.variations import vary

pytestmark = pytest.mark.slow


def test_a_whole_launch_is_the_same_in_both_lives() -> None:
    compiled = bitepoint.run("dct-launch", intent="urgent", noise__engine_speed=0.3, seed=5)
    interpreted = bitepoint.run("dct-launch", intent="urgent", noise__engine_speed=0.3, seed=5, life="interpreted")
    assert compiled.status == interpreted.status == "launched"
    assert np.array_equal(compiled.recording.data, interpreted.recording.data)
    assert compiled.metrics == interpreted.metrics


@pytest.mark.parametrize("intent", ["slow", "normal", "urgent"])
def test_off_nominal_launch_mpc_keeps_the_limits_of_a_thousand_vehicles_more_often(intent: str) -> None:
    shares = {
        name: vary({**settings, "intent": intent}, dct_launch.VEHICLES).share for name, settings in dct_launch.BESIDE
    }
    assert shares["launch_mpc"] > shares["launch_pid tuned"] + 0.1


def test_twenty_thousand_launches_in_bounded_memory() -> None:
    rng = np.random.default_rng(1)
    lanes = 20_000
    over = {
        "vehicle.mass": rng.uniform(1100, 2200, lanes),
        "road.grade": rng.uniform(-0.02, 0.25, lanes),
        "clutch.friction_gain": rng.uniform(0.7, 1.3, lanes),
        "engine.inertia": rng.uniform(0.15, 0.4, lanes),
    }
    bitepoint.run_batch("dct-launch", {name: values[:200] for name, values in over.items()})
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    batch = bitepoint.run_batch("dct-launch", over, {"noise.engine_speed": 0.2}, record=[0, lanes - 1])
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    assert grown < 400e6  # recordings of all lanes would take 5 GB
    assert set(batch.status) <= {"launched", "timed out", "stalled", "rolled back"}
    launched = np.array(batch.status) == "launched"
    assert launched.mean() > 0.99
    assert np.nanmax(batch.metrics["energy_residual"]) < 1e-3
    assert sorted(batch.recordings) == [0, lanes - 1]
