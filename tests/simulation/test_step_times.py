"""Times of a controller's steps: they are those of the run, and only where they were asked for."""

from __future__ import annotations

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.simulation.step_times import step_times
from tests.conftest import Command, Refused

CASES = [
    ("p2-tip-step", {"noise.wheel_speed": 0.05, "delay.motor_speed": "10 ms"}),
    ("p2-tip-step", {"controller": "damping_shaping"}),
    ("dct-launch", {"controller": "launch_mpc", "noise.engine_speed": 0.3}),
]


@pytest.mark.parametrize(("scenario", "settings"), CASES)
def test_the_steps_are_those_of_the_run_to_the_bit(scenario: str, settings: dict[str, object]) -> None:
    part = assemble(scenario, settings).system.controllers[-1]
    recording = bitepoint.run(scenario, settings, seed=3).recording
    found = step_times(part, recording)
    every = round(part.period / 0.002)
    wanted = np.array([recording[name][::every] for name in part.outputs.fields]).T
    assert found.outputs.tobytes() == np.ascontiguousarray(wanted).tobytes()
    assert found.seconds.shape == (len(wanted),)
    assert (found.seconds > 0.0).all()


def test_solve_times_are_there_where_they_are_asked_for() -> None:
    without = bitepoint.run("p2-tip-step").metrics
    assert without["solve_time_p999"].value is None
    assert "report.solve_time=true" in without["solve_time_p999"].reason
    timed = bitepoint.run("p2-tip-step", report__solve_time=True).metrics
    median, rare = timed["solve_time_p50"].value, timed["solve_time_p999"].value
    assert median is not None
    assert rare is not None
    assert 0.0 < median <= rare
    assert {name: timed[name] for name in timed if "solve" not in name} == {
        name: without[name] for name in timed if "solve" not in name
    }
    assert "solve_time_p999" not in bitepoint.run("dct-launch").metrics
    assert bitepoint.run("dct-launch", report__solve_time=True).metrics["solve_time_p50"].unit == "s"


def test_a_batch_has_no_times(refused: Refused) -> None:
    over = {"vehicle.mass": [1700.0, 1800.0]}
    assert np.isnan(bitepoint.run_batch("p2-tip-step", over).metrics["solve_time_p999"]).all()
    refused(lambda: bitepoint.run_batch("p2-tip-step", over, report__solve_time=True), "report.solve_time", "single")


def test_wrong_settings_are_one_line(bitepoint: Command) -> None:
    bitepoint("run", "p2-tip-step", "--set", "report.solve_time=3").refusal("report.solve_time", "true or false")
    bitepoint("run", "p2-tip-step", "--set", "report.times=true").refusal("report.times", "report.solve_time")
