"""A scenario file is read whole and checked whole, before anything runs."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import pytest
import yaml

from bitepoint import api
from bitepoint.assembly import assemble
from bitepoint.files import library_folder, parse_yaml
from bitepoint.metrics import FAMILIES
from bitepoint.scenarios import Scenario, load_scenario, scenario_names
from tests.conftest import Refused

LAUNCH: dict[str, Any] = parse_yaml((library_folder("scenarios") / "dct-launch.yaml").read_text(), "dct-launch")
MISSING = object()


def written(folder: Path, **changes: Any) -> str:
    """The path of the library's launch with keys changed, or taken out; two underscores lead into a block."""
    data = copy.deepcopy(LAUNCH)
    for key, value in changes.items():
        *blocks, last = key.split("__")
        block = data
        for name in blocks:
            block = block[int(name) if name.isdigit() else name]
        if value is MISSING:
            del block[last]
        else:
            block[last] = value
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return str(path)


def test_the_library_launch_says_what_its_file_says() -> None:
    scenario = load_scenario("dct-launch")
    assert (scenario.name, scenario.plant, scenario.vehicle) == ("dct-launch", "dct", "dct-t240")
    assert (scenario.controller, scenario.metrics, scenario.intent) == ("launch_pid", "launch", "normal")
    assert scenario.meaning.startswith("move off from standstill")
    assert [times for times, _ in scenario.intents.values()] == [[0.0, 0.2]] * 3
    final = {name: pedal[1] for name, (_, pedal) in scenario.intents.items()}
    assert final == pytest.approx({"slow": 0.15, "normal": 0.235, "urgent": 0.31}, rel=1e-15)
    assert scenario.timing[0].tolist() == (10.0, 0.002)
    assert [rule["hold"] for rule in scenario.rules] == [0.6, 0.0, 0.0]


def test_every_library_scenario_can_be_put_together() -> None:
    assert scenario_names() == [
        "conventional-nedc", "dct-excitation", "dct-launch", "eco-launch", "p2-nedc", "p2-tip-in", "p2-tip-step",
        "predictive-cruise",
    ]  # fmt: skip
    for name in scenario_names():
        scenario = load_scenario(name)
        assert scenario.meaning
        assert scenario.metrics in FAMILIES
        for intent in scenario.intents if scenario.planning is None else ():
            assert assemble(name, {"intent": intent}).scenario.name == name


def test_a_scenario_file_runs_as_the_library_does(tmp_path: Path) -> None:
    mine, library = api.run(written(tmp_path)), api.run("dct-launch")
    assert mine.scenario == "mine"
    assert (mine.status, mine.reason, mine.metrics) == (library.status, library.reason, library.metrics)


def test_optional_keys_have_defaults(tmp_path: Path) -> None:
    scenario = load_scenario(written(tmp_path, meaning=MISSING, road=MISSING, timing=MISSING))
    assert (scenario.meaning, dict(scenario.road)) == ("", {})
    assert scenario.timing[0].tolist() == (10.0, 0.002)


def test_what_the_file_says_of_timing_and_road_is_used(tmp_path: Path) -> None:
    path = written(tmp_path, timing={"duration": "500 ms", "tick": "1 ms"}, road={"grade": "12 %"})
    built = assemble(path, {})
    assert (built.system.duration, built.system.tick) == (0.5, 0.001)
    assert built.system.plant.parameters["road"]["grade"].tolist() == [0.12]
    assert api.run(path).status == "timed out"


RULE_KEYS = "expected status, signal, above or below, and perhaps hold and reason"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mood": 3}, ["mood: unknown key", "expected one of meaning, plant, vehicle, controller"]),
        *(({key: MISSING}, [f"{key}: missing", "dct-launch"]) for key in ("plant", "vehicle", "controller", "metrics")),
        *(({key: MISSING}, [f"{key}: missing", "dct-launch"]) for key in ("intent", "intents", "stop")),
        *(({key: 3}, [f"{key}: got 3", "expected a name"]) for key in ("plant", "vehicle", "controller", "metrics")),
        ({"intent": None}, ["intent: got nothing", "expected a name"]),
        ({"intent": "brisk"}, ["intent: got brisk", "expected one of slow, normal, urgent"]),
        ({"intents": []}, ["intents: got []", "expected a block of keys"]),
        ({"intents": "slow"}, ["intents: got 'slow'", "expected a block of keys"]),
        ({"intents": {}}, ["intent"]),
        ({"intents__slow": 3}, ["intents.slow: got 3", "expected a block with time (s) and pedal (1)"]),
        ({"intents__slow__pedal": MISSING}, ["intents.slow.pedal: missing", "time (s) and pedal (1)"]),
        ({"intents__slow__speed": [0, 1]}, ["intents.slow.speed: unknown key", "expected time and pedal"]),
        ({"intents__slow__pedal": [0, "101 %"]}, ["intents.slow.pedal: got '101 %'", "a number in 0..1"]),
        ({"intents__slow__pedal": [0, "5 deg"]}, ["intents.slow.pedal: got an angle"]),
        ({"intents__slow__time": [0, "1 m"]}, ["intents.slow.time: got unit 'm'", "0..1e+06 s"]),
        ({"intents__slow__time": [1, 0]}, ["intents.slow.time: not strictly increasing"]),
        ({"intents__slow__time": [0, 1, 2]}, ["intents.slow.pedal: got 2 values", "expected 3 times"]),
        ({"road": 5}, ["road: got 5", "expected a block of keys"]),
        ({"timing": []}, ["timing: got []", "expected a block of keys"]),
        ({"timing": None}, ["timing: got nothing", "expected a block of keys"]),
        ({"timing__ticks": 3}, ["timing.ticks: unknown key", "duration, tick"]),
        ({"timing__tick": 0}, ["timing.tick: got 0", "1e-05..0.1 s"]),
        ({"timing__duration": math.inf}, ["timing.duration: got inf", "0.01..100000 s"]),
        ({"timing__duration": "1 kg"}, ["timing.duration: got unit 'kg'", "0.01..100000 s"]),
        ({"stop": {}}, ["stop: not a list of rules", "expected - {status: ..., signal: ..., above: ...}"]),
        ({"stop": ["launched"]}, ["stop: not a list of rules"]),
        ({"stop": [{}]}, ["stop[0]: got keys", RULE_KEYS]),
        ({"stop__1__status": MISSING}, ["stop[1]: got keys signal, below, reason", RULE_KEYS]),
        ({"stop__1__signal": MISSING}, ["stop[1]: got keys", RULE_KEYS]),
        ({"stop__1__below": MISSING}, ["stop[1]: got keys", RULE_KEYS]),
        ({"stop__1__above": 3}, ["stop[1]: got keys", RULE_KEYS]),
        ({"stop__1__over": 3}, ["stop[1]: got keys", RULE_KEYS]),
        ({"stop__0__hold": "1 m"}, ["stop[0].hold: got unit 'm'", "expected a time, such as 0.5 s"]),
        ({"stop__0__hold": "soon"}, ["stop[0].hold: got 'soon'", "expected a time"]),
        ({"stop__0__hold": math.nan}, ["stop[0].hold: got", "expected a time"]),
        ({"stop__0__hold": math.inf}, ["stop[0].hold: got", "expected a time"]),
        ({"stop__0__hold": "1e300 s"}, ["stop[0].hold: got", "expected a time"]),
        ({"stop__0__hold": -1}, ["stop[0].hold: got", "expected a time"]),
    ],
)  # fmt: skip
def test_a_wrong_scenario_is_refused_when_it_is_read(
    tmp_path: Path, changes: dict[str, Any], said: list[str], refused: Refused
) -> None:
    path = written(tmp_path, **changes)
    refused(lambda: load_scenario(path), path, *said)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"metrics": "landing"}, ["metrics: got landing", "expected one of launch"]),
        ({"plant": "ev"}, ["plant: got ev"]),
        ({"road__grade": "90 %"}, ["road.grade: got '90 %'", "-0.5..0.5"]),
        ({"road__gradient": "9 %"}, ["road.gradient: unknown key", "grade, air_density"]),
        ({"stop__0__signal": "mood"}, ["stop[0].signal: got mood", "expected one of engine_speed, clutch_speed"]),
        ({"stop__1__below": "5 kg"}, ["stop[1].below: got unit 'kg'", "rad/s"]),
        ({"stop__1__below": math.nan}, ["stop[1].below: got", "rad/s"]),
        ({"stop": [dict(rule) for rule in LAUNCH["stop"] * 6]}, ["stop", "16"]),
    ],
)
def test_a_scenario_that_its_plant_cannot_do_is_refused(
    tmp_path: Path, changes: dict[str, Any], said: list[str], refused: Refused
) -> None:
    path = written(tmp_path, **changes)
    refused(lambda: api.run(path), path, *said)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"vehicle": "boat"}, ["boat: no such vehicle", "dct-na190, dct-t240"]),
        ({"controller": "hope"}, ["got hope", "expected one of none, launch_pid"]),
        ({"timing__tick": "3 ms"}, ["timing.tick", "0.01 s over a tick of 0.003 s", "expected a multiple of the tick"]),
    ],
)
def test_a_scenario_whose_parts_do_not_fit_is_refused(
    tmp_path: Path, changes: dict[str, Any], said: list[str], refused: Refused
) -> None:
    path = written(tmp_path, **changes)
    refused(lambda: api.run(path), *said)


def test_an_unknown_scenario_is_refused(tmp_path: Path, refused: Refused) -> None:
    refused(lambda: load_scenario("dct-lunch"), "dct-lunch: no such scenario", "dct-launch")
    refused(lambda: load_scenario(str(tmp_path / "none.yaml")), "none.yaml", "no such file")


def test_reasons_have_a_default(tmp_path: Path) -> None:
    path = written(tmp_path, stop=[{"status": "fast", "signal": "vehicle_speed", "above": "1 km/h"}])
    result = api.run(path)
    assert result.status == "fast"
    assert result.reason.startswith("vehicle_speed went above 1 km/h, ")


def test_a_scenario_is_a_value() -> None:
    assert load_scenario("dct-launch").intents == load_scenario("dct-launch").intents
    assert isinstance(load_scenario("dct-launch"), Scenario)
