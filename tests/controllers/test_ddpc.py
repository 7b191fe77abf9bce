"""Predictive control of the launch: its predictions, its programme, its models, and the swarm beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.controllers import ddpc, ddpc_pso
from bitepoint.controllers.prediction import predict
from bitepoint.errors import InputError
from bitepoint.models.arx import ArxModel
from bitepoint.models.launch import DISTURBANCES, INPUTS, OUTPUTS, LaunchModel
from bitepoint.models.launch_vehicle import LaunchVehicle
from bitepoint.numerics.dense_qp import DenseQp
from bitepoint.recording import Recording

RNG = np.random.default_rng(3)


def random_model(orders: tuple[int, int, int]) -> ArxModel:
    n_a, n_b, n_g = orders
    past = np.zeros((n_a, 2, 2))
    past[0] = np.eye(2) + 0.05 * RNG.normal(size=(2, 2))
    past[1:] = 0.05 * RNG.normal(size=(n_a - 1, 2, 2))
    return ArxModel(
        OUTPUTS, INPUTS, DISTURBANCES, 0.01, past, RNG.normal(size=(n_b, 2, 1)), RNG.normal(size=(n_g, 2, 2)),
        np.zeros((0, 2, 2)),
    )  # fmt: skip


@pytest.mark.parametrize("orders", [(1, 1, 1), (2, 1, 1), (3, 2, 3)])
def test_prediction_is_what_the_model_simulates(orders: tuple[int, int, int]) -> None:
    model, depth, steps = random_model(orders), 3, 4
    rows = depth + 1 + steps
    u, d = RNG.normal(size=(rows, 1)), RNG.normal(size=(rows, 2))
    d[depth + 1 :] = d[depth]  # disturbances stay as they are
    y = model.free_run(RNG.normal(size=(rows, 2)), u, d)
    now = depth
    dy, du, dd = np.diff(y, axis=0), np.diff(u, axis=0)[:, 0], np.diff(d, axis=0)
    past = np.concatenate([dy[:now][::-1].ravel(), du[: now - 1][::-1][: depth - 1], dd[:now][::-1].ravel()])
    response, free = predict(model, steps, depth)
    moves = du[now - 1 + 0 : now - 1 + steps]
    # the row `now` is known; the move u(now) - u(now-1) is the first that is free
    for output in range(2):
        foreseen = y[now, output] + free[output] @ past + response[output] @ moves
        assert foreseen == pytest.approx(y[now + 1 : now + 1 + steps, output], abs=1e-9)


HILL = {"vehicle.mass": "1900 kg", "road.grade": "20 %"}


def recorded_programmes(intent: str = "normal") -> list[tuple[np.ndarray, ...]]:
    """The programmes of a launch: gradient, limits, and the move that was made."""
    assembly = assemble("dct-launch", {"controller": "ddpc", "intent": intent})
    part, recording = assembly.system.controllers[0], bitepoint.run("dct-launch", controller="ddpc", intent=intent)
    parameters = np.ascontiguousarray(part.parameters)
    memory = [parameters, *(t.zeros() for t in (part.state, part.inputs, part.outputs, part.work))]
    part.init.run(*memory)
    found = []
    for row in range(0, len(recording.recording.time), 5):
        for name in part.inputs.fields:
            memory[2][name] = recording.recording[name][row]
        before = memory[1].copy()
        part.step.run(*memory, 0.01)
        if before["phase"][0] == 1 and before["time"][0] > 0.3 and memory[1]["phase"][0] == 1:
            data, solution = memory[4]["data"][0], memory[4]["solution"][0]
            found.append((data["gradient"].copy(), data["low"].copy(), data["high"].copy(), solution["x"].copy()))
    return [(parameters["matrices"][0]["hessian"], parameters["matrices"][0]["constraints"], *each) for each in found]


def test_moves_are_the_minimisers_of_their_programmes() -> None:
    programmes = recorded_programmes()
    assert len(programmes) > 50
    solver = DenseQp(ddpc.MOVES, 3 * ddpc.MOVES)
    for hessian, constraints, gradient, low, high, x in programmes:
        answer = solver.solve(hessian, gradient, constraints, low, high)
        assert answer.status == 0
        assert x == pytest.approx(answer.x, abs=1e-9)


@pytest.mark.parametrize("settings", [{}, HILL, {**HILL, "engine.torque_gain": "0.8"}])
def test_the_programme_always_has_an_answer(settings: Mapping[str, str]) -> None:
    recording = bitepoint.run("dct-launch", {"controller": "ddpc", **settings}).recording
    assert (recording["solver_status"] == 0.0).all()


def test_an_engine_that_is_pulled_down_opens_the_clutch() -> None:
    """Without the limit it would stall: the torque falls while the engine is below its idle speed."""
    result = bitepoint.run("dct-launch", {"controller": "ddpc", **HILL})
    assert result.status == "launched"
    speed, command = result.recording["engine_speed"][::5], result.recording["clutch_torque_command"][::5]
    low = (speed < 80.0) & (result.recording["launch_phase"][::5] == 1.0)
    assert low.any()
    assert (np.diff(command)[low[:-1]] < 0.0).mean() > 0.5


def last_chance(recording: Recording, jerk: float) -> float:
    """Last time at which any controller can still keep the engine at its idle speed within a jerk: with full load at
    once, and the clutch torque falling as fast as the jerk allows."""
    car = LaunchVehicle.of(assemble("dct-launch", HILL).system.plant.parameters)
    model, step, found = car.model, 1e-3, 0.0
    for row in range(250, len(recording.time), 5):
        speed, clutch = recording["engine_speed"][row], recording["clutch_torque"][row]
        for _ in range(600):
            engine = float(np.interp(speed, car.engine_speeds, car.highest_torque))
            speed += step * (engine - clutch - model.engine_friction * speed) / model.engine_inertia
            clutch = max(clutch - step * model.torque_rate(jerk), 0.0)
            if speed < car.idle_speed:
                break
        else:
            found = float(recording.time[row])
    return found


def test_the_limit_is_seen_too_late_for_the_published_jerk() -> None:
    recording = bitepoint.run("dct-launch", {"controller": "ddpc", **HILL}).recording
    command = recording["clutch_torque_command"]
    opens = float(recording.time[1:][(np.diff(command) < 0.0) & (recording.time[1:] > 0.5)][0])
    assert last_chance(recording, 7.6) < opens - 0.05
    assert last_chance(recording, 18.0) > last_chance(recording, 7.6)


@pytest.mark.parametrize("intent", ["slow", "normal", "urgent"])
def test_on_the_level_the_horizon_of_the_limit_changes_nothing(intent: str) -> None:
    figures = [
        bitepoint.run("dct-launch", {"controller": "ddpc", "intent": intent, "controller.limit_horizon": steps})
        for steps in (4, 0, 30)
    ]
    assert len({str(each.to_json()) for each in figures}) == 1


def test_a_limit_that_is_foreseen_is_kept_with_the_published_jerk() -> None:
    foreseen = bitepoint.run("dct-launch", {"controller": "ddpc", **HILL, "controller.limit_horizon": 30}).metrics
    assert foreseen["engine_speed_min"].value >= 82.9
    assert foreseen["jerk_peak"].value <= 7.6
    assert foreseen["launch_time"].value <= 1.8
    without = bitepoint.run("dct-launch", {"controller": "ddpc", **HILL, "controller.limit_horizon": 0})
    assert without.status == "stalled"
    assert without.metrics["friction_work"].value == pytest.approx(11_720.0, rel=0.05)
    assert without.metrics["jerk_peak"].value <= 7.6


def test_engine_speeds_where_they_are_limited_are_those_of_the_model() -> None:
    vehicle = assemble("dct-launch", {}).system.plant.parameters
    source = {**ddpc.calibrations()["paper"], "limit_horizon": 30}
    source.pop("source")
    parameters = ddpc.design(vehicle, ddpc.CONTROLLER.calibration.parse(source, "test"))[0]
    model, moves = LaunchModel.of(vehicle).arx(0.01), np.array([3.0, -1.0, 2.0, 5.0])
    torque = np.concatenate([np.zeros(1), np.cumsum(moves), np.full(40, moves.sum())])[1:, np.newaxis]
    y = model.free_run(np.full((40, 2), 100.0), torque[:40], np.zeros((40, 2)))
    still = model.free_run(np.full((40, 2), 100.0), np.zeros((40, 1)), np.zeros((40, 2)))
    steps = [8, 15, 23, 30]
    found = parameters["matrices"]["constraints"][8:, :] @ moves
    assert found == pytest.approx((y - still)[steps, 0], rel=1e-9)


@pytest.mark.parametrize("intent", ["slow", "normal", "urgent"])
def test_first_move_of_the_swarm_is_that_of_the_programme(intent: str) -> None:
    """Within 0.05 N m at each step: both controllers see the same measurements."""
    controllers = [assemble("dct-launch", {"controller": name, "intent": intent}) for name in ("ddpc", "ddpc_pso")]
    recording = bitepoint.run("dct-launch", controller="ddpc", intent=intent).recording
    memories = []
    for assembly in controllers:
        part = assembly.system.controllers[0]
        memory = [part.parameters, *(t.zeros() for t in (part.state, part.inputs, part.outputs, part.work))]
        part.init.run(*memory)
        memories.append((part, memory))
    worst = 0.0
    for row in range(0, len(recording.time), 5):
        for part, memory in memories:
            for name in part.inputs.fields:
                memory[2][name] = recording[name][row]
            part.step.run(*memory, 0.01)
        exact, swarm = (memory[3]["clutch_torque_command"][0] for _, memory in memories)
        worst = max(worst, abs(exact - swarm))
        memories[1][1][1][...] = memories[0][1][1]  # both go on from the exact one's state
    assert 0.0 < worst < 0.05


def test_design_takes_an_identified_and_a_physical_model_alike() -> None:
    vehicle = assemble("dct-launch", {}).system.plant.parameters
    calibration = ddpc.CONTROLLER.calibration.parse(
        {k: v for k, v in ddpc.calibrations()["paper"].items() if k != "source"}, "test"
    )
    model = LaunchModel.of(vehicle).arx(0.01)
    padded = dataclasses.replace(model, past_outputs=np.concatenate([model.past_outputs, np.zeros((1, 2, 2))]))
    physical, identified = ddpc.design(vehicle, calibration), ddpc.design_on(vehicle, calibration, padded)
    for name in ("gradient", "free_slip", "free_engine"):
        assert physical[name] == pytest.approx(identified[name], abs=1e-12)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"period": 0.02}, "period"),
        ({"outputs": ("engine_speed", "speed")}, "outputs"),
        ({"past_outputs": np.zeros((4, 2, 2))}, "n_a = 4"),
        ({"past_inputs": np.zeros((3, 2, 1))}, "n_b = 3"),
    ],
)
def test_a_model_it_cannot_use_is_refused(change, problem, tmp_path) -> None:
    model = dataclasses.replace(random_model((2, 1, 1)), **change)
    model.save(tmp_path / "model.json")
    with pytest.raises(InputError, match=problem) as caught:
        bitepoint.run("dct-launch", {"controller": "ddpc", "controller.model": str(tmp_path / "model.json")})
    assert "model.json" in str(caught.value)


def test_a_controller_without_a_model_refuses_one(tmp_path) -> None:
    random_model((2, 1, 1)).save(tmp_path / "model.json")
    with pytest.raises(InputError, match="takes no model"):
        bitepoint.run("dct-launch", {"controller": "launch_pid", "controller.model": str(tmp_path / "model.json")})


def test_the_intention_block_can_give_the_slip_decay() -> None:
    by_pedal = bitepoint.run("dct-launch", controller="ddpc", intent="normal")
    by_network = bitepoint.run(
        "dct-launch", {"controller": "ddpc", "intent": "normal", "controller.intention": "network"}
    )
    assert "launch_intention" in by_network.recording
    assert by_network.recording["launch_intention"][-1] == 1.0
    assert by_network.metrics["friction_work"].value == pytest.approx(by_pedal.metrics["friction_work"].value, rel=0.02)


@pytest.mark.parametrize(("controller", "value"), [("ddpc", "oracle"), ("launch_pid", "network")])
def test_an_intention_that_cannot_be_had_is_refused(controller: str, value: str) -> None:
    with pytest.raises(InputError, match="intention"):
        bitepoint.run("dct-launch", {"controller": controller, "controller.intention": value})


def test_the_swarm_is_a_controller_of_its_own() -> None:
    assert ddpc_pso.CONTROLLER.parameters is ddpc.CONTROLLER.parameters
    assert ddpc_pso.CONTROLLER.step is not ddpc.CONTROLLER.step
