"""Predictive control of clutch and engine: what it reaches, nominal, with engine lag, off nominal, and with noise."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import bitepoint
from bitepoint.api import Result
from bitepoint.assembly import assemble
from bitepoint.controllers.launch_mpc_design import responses
from bitepoint.controllers.launch_mpc_records import ENDS, STEP
from bitepoint.errors import InputError
from bitepoint.models.launch import LaunchModel

INTENTS = ("slow", "normal", "urgent")
JERK = {"slow": 3.3, "normal": 7.3, "urgent": 10.0}
TIME = {"slow": 1.35, "normal": 1.05, "urgent": 1.08}
WORK = {"slow": 2950.0, "normal": 3300.0, "urgent": 7000.0}
PAPER_TIME = {"slow": 1.52, "normal": 1.29, "urgent": 1.23}
HILL = {"vehicle.mass": "1900 kg", "road.grade": "20 %"}


def launch(intent: str, settings: Mapping[str, str] | None = None, controller: str = "launch_mpc") -> Result:
    return bitepoint.run("dct-launch", {"controller": controller, "intent": intent, **(settings or {})})


def figure(result: Result, name: str) -> float:
    value = result.metrics[name].value
    assert value is not None, result.reason
    return value


@pytest.mark.parametrize("intent", INTENTS)
def test_nominal_launch_within_its_limits(intent: str) -> None:
    result = launch(intent)
    assert result.status == "launched"
    assert figure(result, "jerk_peak_settled") <= JERK[intent]
    assert figure(result, "launch_time") <= TIME[intent]
    assert figure(result, "friction_work") <= WORK[intent]
    at = PAPER_TIME[intent]
    speeds = [
        np.interp(at, r.recording.time, r.recording["vehicle_speed"]) for r in (result, launch(intent, None, "ddpc"))
    ]
    assert speeds[0] >= 0.98 * speeds[1]


@pytest.mark.parametrize(("intent", "jerk"), [("slow", 9.0), ("normal", 8.0), ("urgent", 10.0)])
def test_engine_lag_is_found_and_led(intent: str, jerk: float) -> None:
    result = launch(intent, {"engine.lag": "0.1 s"})
    assert result.status == "launched"
    assert figure(result, "jerk_peak_settled") <= jerk
    assert figure(result, "engine_speed_min") >= 78.0


def test_heavy_on_a_hill() -> None:
    result = launch("normal", HILL)
    assert result.status == "launched"
    assert figure(result, "launch_time") <= 1.85
    assert figure(result, "friction_work") <= 12_000.0
    assert figure(result, "engine_speed_min") >= 82.5
    assert figure(result, "jerk_peak") <= 13.5


@pytest.mark.parametrize("intent", INTENTS)
def test_noise_is_borne(intent: str) -> None:
    noise = {"noise.engine_speed": "0.1 rad/s", "noise.clutch_speed": "0.1 rad/s", "noise.wheel_speed": "0.01 rad/s"}
    result = launch(intent, noise)
    assert result.status == "launched"
    assert figure(result, "jerk_peak_settled") <= 1.2 * JERK[intent]
    assert figure(result, "launch_time") <= 1.2 * TIME[intent]


def test_road_torque_and_lag_are_estimated() -> None:
    recording = launch("normal", {**HILL, "engine.lag": "0.1 s"}).recording
    slipping = (recording["launch_phase"] == 1.0) & (recording["vehicle_held"] < 0.5)
    late = slipping & (recording.time > recording.time[slipping][0] + 0.7)
    error = recording["road_torque_estimate"][late] - recording["road_torque"][late]
    assert np.abs(error).mean() < 0.2 * recording["road_torque"][late].mean()
    assert recording["engine_lag_estimate"][late].mean() == pytest.approx(0.1, abs=0.06)


def test_programme_always_has_an_answer() -> None:
    for settings in ({}, HILL, {"engine.torque_gain": "0.6"}, {"clutch.friction_gain": "1.6"}):
        for intent in INTENTS:
            recording = launch(intent, settings).recording
            assert (recording["solver_status"] == 0.0).all(), (settings, intent)


def test_letting_the_pedal_go_opens_the_clutch() -> None:
    assembly = assemble("dct-launch", {"controller": "launch_mpc"})
    part = assembly.system.controllers[0]
    memory = [part.parameters, *(t.zeros() for t in (part.state, part.inputs, part.outputs, part.work))]
    part.init.run(*memory)
    measured, command = memory[2], memory[3]
    measured["engine_speed"] = 90.0
    for pedal, steps in ((0.235, 40), (0.0, 60)):
        measured["pedal"] = pedal
        for _ in range(steps):
            assert part.step.run(*memory, 0.01)[0] == 0
        if pedal > 0.0:
            assert command["clutch_torque_command"][0] > 20.0
    assert command["clutch_torque_command"][0] == 0.0
    assert command["launch_phase"][0] == 0.0


def test_responses_are_the_integrals_of_the_torques() -> None:
    risen, summed = responses()
    fine = np.linspace(0.0, STEP * ENDS[-1], 20_001)
    starts = STEP * np.array([0, *ENDS[:-1]])
    ends = STEP * np.array(ENDS)
    for segment in range(len(ENDS)):
        torque = np.clip(fine - starts[segment], 0.0, ends[segment] - starts[segment])
        integral = np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1]) * np.diff(fine))])
        at = STEP * np.arange(1, ENDS[-1] + 1)
        assert risen[:, segment] == pytest.approx(np.interp(at, fine, torque), abs=1e-9)
        assert summed[:, segment] == pytest.approx(np.interp(at, fine, integral), abs=1e-8)


def test_design_reduces_the_vehicle_as_the_launch_model_does() -> None:
    assembly = assemble("dct-launch", {"controller": "launch_mpc"})
    model = LaunchModel.of(assembly.system.plant.parameters)
    parameters = assembly.system.controllers[0].parameters[0]
    assert parameters["inertia"] == model.inertia
    assert parameters["torque"]["inertia"] == model.engine_inertia


def test_identified_inertias_are_those_of_the_vehicle_that_was_logged(tmp_path: Path) -> None:
    vehicle = assemble("dct-launch", {}).system.plant.parameters
    model = LaunchModel.of(vehicle)
    again = model.identified(model.arx(0.01))
    assert again.engine_inertia == pytest.approx(model.engine_inertia, rel=0.01)  # friction bends the straight line
    assert again.inertia == pytest.approx(model.inertia, rel=1e-9)
    run = {"vehicle.mass": "1600 kg"}
    bitepoint.run("dct-excitation", run).save(tmp_path / "logs")
    found = bitepoint.identify(tmp_path / "logs").model
    identified = model.identified(found)
    assert identified.engine_inertia == pytest.approx(vehicle["engine"]["inertia"][0], rel=0.05)
    assert identified.inertia == pytest.approx(model.inertia, rel=0.05)
    found.save(tmp_path / "model.json")
    result = launch("normal", {"controller.model": str(tmp_path / "model.json")})
    assert result.status == "launched"
    assert figure(result, "jerk_peak_settled") <= 1.1 * JERK["normal"]


def test_a_model_that_makes_no_sense_is_refused() -> None:
    model = LaunchModel.of(assemble("dct-launch", {}).system.plant.parameters)
    arx = model.arx(0.01)
    with pytest.raises(InputError, match="per N m"):
        model.identified(dataclasses.replace(arx, past_inputs=-arx.past_inputs))
    with pytest.raises(InputError, match="other signals"):
        model.identified(dataclasses.replace(arx, outputs=("a", "b")))
