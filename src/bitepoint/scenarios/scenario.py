"""The scenario file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from bitepoint.errors import InputError, brief
from bitepoint.files import find, library_names, read_yaml
from bitepoint.records import Curve, Record, RecordArray, curve, quantity
from bitepoint.scenarios.cycles import cycle_trace
from bitepoint.scenarios.runs import LogSettings, Runs, parse_runs
from bitepoint.units import UnitError, parse


class Timing(Record):
    """Times of a run."""

    duration: float = quantity("s", 0.01, 100_000, "time after which the run has timed out", default=10.0)
    tick: float = quantity("s", 1e-5, 0.1, "step of the plant and raster of the recording", default=0.002)


_TIME = ("time", "s", 0.0, 1e6)


class PedalTrace(Record):
    """A pedal over time."""

    trace: Curve = curve(_TIME, ("pedal", "1", 0, 1), "pedal over time, constant beyond its ends")


class TorqueTrace(Record):
    """What the driver asks for at the input of the gearbox, over time."""

    trace: Curve = curve(_TIME, ("torque_request", "N*m", -5000, 5000), "torque over time, constant beyond its ends")


class SpeedTrace(Record):
    """A speed to follow over time."""

    trace: Curve = curve(_TIME, ("speed_target", "m/s", 0, 100), "speed over time, constant beyond its ends")


TRACES: Mapping[str, type[Record]] = {
    record.fields["trace"].axes[1].name: record for record in (PedalTrace, TorqueTrace, SpeedTrace)
}
"""What the driver does, by the name of the signal: one of them in each scenario."""


SPEED = "speed_target"
"""The signal whose traces may be cycles."""

TIMED_OUT = "timed out"
"""Status of a run that no stop rule ended, where the scenario expects one to."""


@dataclass(frozen=True)
class Scenario:
    """A scenario file, read and checked, except for the blocks that its plant has to know.

    Attributes:
        signal: what the driver does, a name of TRACES; intents: its trace by intent, each (time s, value in SI).
        given: further signals, which stay as they are: name -> value, still to be read in the signal's unit.
        supervisors: the parts that stand between driver and controller, by name, with what the scenario sets of them.
        road, start: blocks for the plant; rules: stop rules, their limits still to be read in the signal's unit.
        at_end: status of a run that no rule ended.
        planning: what is planned before it is driven, and with which settings; None for nothing.
        baseline: calibration of the driver that a plan is compared with; route: name or file of the road, or empty.
        runs, log: what differs between its runs, and how they are logged; None for a scenario of one run.
    """

    name: str
    where: str
    meaning: str
    plant: str
    vehicle: str
    controller: str
    metrics: str
    intent: str
    intents: Mapping[str, tuple[Sequence[float], Sequence[float]]]
    road: Mapping[str, Any]
    timing: RecordArray
    rules: Sequence[Mapping[str, Any]]
    runs: Runs | None = None
    log: RecordArray | None = None
    signal: str = "pedal"
    given: Mapping[str, Any] = field(default_factory=dict[str, Any])
    supervisors: Mapping[str, Mapping[str, Any]] = field(default_factory=dict[str, Mapping[str, Any]])
    start: Mapping[str, Any] = field(default_factory=dict[str, Any])
    at_end: str = TIMED_OUT
    planning: tuple[str, Mapping[str, Any]] | None = None
    baseline: str = ""
    route: str = ""


PLANNED = ("planner", "cruise")
"""Blocks that say what is planned: a launch, or a road within a band of speeds."""

LONGEST_HOLD = 100_000.0

_TEXTS = ("plant", "vehicle", "controller", "metrics", "intent")
_OPTIONAL = {"meaning": "", "signal": "pedal", "at_end": TIMED_OUT, "baseline": "", "route": ""}
_KEYS = (
    "meaning", *_TEXTS, "intents", "signal", "given", "supervisors", "road", "start", "timing", "stop", "at_end",
    "runs", "log", "baseline", "route", *PLANNED,
)  # fmt: skip
_RULE_KEYS = {"status", "signal", "above", "below", "hold", "reason"}


def scenario_names() -> list[str]:
    """Return the names of the scenarios in the library."""
    return library_names("scenarios")


def load_scenario(name: str) -> Scenario:
    """Return the library scenario `name`, or the one in the YAML file at that path.

    Raises:
        InputError: no such scenario, an unknown or missing key, or a value of the wrong kind.
    """
    path = find("scenarios", name, "scenario")
    data = read_yaml(path)
    where = str(path)
    for key in data:
        if key not in _KEYS:
            raise InputError(where, f"{key}: unknown key", f"expected one of {', '.join(_KEYS)}")
    for key in (*_TEXTS, "intents", "stop"):
        if key not in data:
            raise InputError(where, f"{key}: missing", "see the library scenario dct-launch for an example")
    texts = {key: _text(data[key], where, key) for key in _TEXTS}
    texts |= {key: _text(data.get(key, default), where, key) for key, default in _OPTIONAL.items()}
    if texts["signal"] not in TRACES:
        raise InputError(where, f"signal: got {texts['signal']}", f"expected one of {', '.join(TRACES)}")
    traces = _block(data, "intents", where)
    intents = {str(key): _trace(value, texts["signal"], where, f"intents.{key}") for key, value in traces.items()}
    if texts["intent"] not in intents:
        raise InputError(where, f"intent: got {texts['intent']}", f"expected one of {', '.join(intents)}")
    timing = Timing.parse(data.get("timing", {}), where, "timing")
    road, start, given = (_block({key: {}, **data}, key, where) for key in ("road", "start", "given"))
    rules = _rules(data["stop"], where)
    runs = parse_runs(data["runs"], where) if "runs" in data else None
    if "log" in data and runs is None:
        raise InputError(where, "log: without runs", "add the block runs, or leave log out")
    log = None if runs is None else LogSettings.parse(data.get("log", {}), where, "log")
    supervisors = _supervisors(data.get("supervisors", []), where)
    return Scenario(
        path.stem, where, **texts, intents=intents, road=road, start=start, given=given, timing=timing, rules=rules,
        runs=runs, log=log, supervisors=supervisors, planning=_planning(data, where),
    )  # fmt: skip


def _planning(data: Mapping[str, Any], where: str) -> tuple[str, Mapping[str, Any]] | None:
    given = [kind for kind in PLANNED if kind in data]
    if len(given) > 1:
        raise InputError(where, f"{given[1]}: beside {given[0]}", "leave one of them out")
    if not given:
        return None
    return given[0], _block(data, given[0], where)


def _text(value: object, where: str, key: str) -> str:
    if not isinstance(value, str):
        raise InputError(where, f"{key}: got {brief(value)}", "expected a name")
    return value


def _block(data: Mapping[str, Any], key: str, where: str) -> Mapping[str, Any]:
    value = data[key]
    if not isinstance(value, Mapping):
        raise InputError(where, f"{key}: got {brief(value)}", "expected a block of keys")
    return cast("Mapping[str, Any]", value)


def _supervisors(value: object, where: str) -> Mapping[str, Mapping[str, Any]]:
    if isinstance(value, Mapping):
        blocks: dict[str, Any] = {str(key): item for key, item in cast("Mapping[object, Any]", value).items()}
        return {key: _block(blocks, key, where) for key in blocks}
    if not isinstance(value, list):
        raise InputError(where, f"supervisors: got {brief(value)}", "expected a list of names, or a block of blocks")
    return {_text(item, where, "supervisors"): {} for item in cast("list[object]", value)}


def _trace(value: Any, signal: str, where: str, key: str) -> tuple[Sequence[float], Sequence[float]]:
    if signal == SPEED and isinstance(value, Mapping) and "cycle" in value:
        return _cycle(cast("Mapping[str, object]", value), where, key)
    fields: dict[str, Any] = {"trace": value}
    try:
        trace = TRACES[signal].parse(fields, where, "")["trace"][0]
    except InputError as error:
        raise InputError(where, error.problem.replace("trace", key, 1), error.mend) from None
    points = int(trace["points"])
    return trace["x"][:points].tolist(), trace["y"][:points].tolist()


def _cycle(value: Mapping[str, object], where: str, key: str) -> tuple[Sequence[float], Sequence[float]]:
    if len(value) > 1:
        raise InputError(where, f"{key}: got keys {', '.join(value)}", "expected cycle alone")
    try:
        time, speed = cycle_trace(str(value["cycle"]))
    except InputError as error:
        raise InputError(where, f"{key}.{error.where}: {error.problem}", error.mend) from None
    return time.tolist(), speed.tolist()


def _hold(value: object, where: str, key: str) -> float:
    try:
        hold = parse(value, "s")
    except UnitError as error:
        raise InputError(where, f"{key}: {error}", "expected a time, such as 0.5 s") from None
    if not 0.0 <= hold <= LONGEST_HOLD:
        raise InputError(where, f"{key}: got {brief(value)}", f"expected a time of 0..{LONGEST_HOLD:g} s")
    return hold


def _rules(value: object, where: str) -> Sequence[Mapping[str, Any]]:
    rules = cast("Sequence[object]", value)
    if not isinstance(value, list) or not all(isinstance(rule, Mapping) for rule in rules):
        raise InputError(where, "stop: not a list of rules", "expected - {status: ..., signal: ..., above: ...}")
    result: list[Mapping[str, Any]] = []
    for number, entry in enumerate(rules):
        rule = {str(name): item for name, item in cast("Mapping[object, Any]", entry).items()}
        unknown = set(rule) - _RULE_KEYS
        if unknown or "status" not in rule or "signal" not in rule or ("above" in rule) == ("below" in rule):
            mend = "expected status, signal, above or below, and perhaps hold and reason"
            raise InputError(where, f"stop[{number}]: got keys {', '.join(rule)}", mend)
        rule["hold"] = _hold(rule.get("hold", 0.0), where, f"stop[{number}].hold")
        result.append(rule)
    return result
