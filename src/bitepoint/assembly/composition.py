"""Putting a vehicle, a controller and a manoeuvre together by name, with settings applied."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bitepoint.assembly.bound import bound_wanted
from bitepoint.assembly.catalogue import CONTROLLERS, PEDAL, PLANTS
from bitepoint.assembly.settings import SET, Settings
from bitepoint.controllers import launch_intent
from bitepoint.controllers.controller import Controller
from bitepoint.errors import InputError, brief
from bitepoint.metrics import FAMILIES
from bitepoint.models.arx import ArxModel
from bitepoint.plants.plant import Plant
from bitepoint.recording import Channel
from bitepoint.records import Record, RecordArray
from bitepoint.scenarios import LogSettings, PedalLog, Scenario, Timing, load_scenario, read_pedal_log
from bitepoint.simulation.loop import MOST_RULES
from bitepoint.simulation.system import Imperfections, Part, Profile, StopRule, System
from bitepoint.units import UnitError, parse
from bitepoint.vehicles import Vehicle, load_vehicle

Lanes = Mapping[str, Sequence[Any] | npt.NDArray[Any]]
"""Dotted keys with one value per lane each."""

OVER = "over"
"""What errors name as the place of a value that differs between lanes."""

_IMPERFECTIONS = ("lag", "delay", "noise")
_CHOICES = ("calibration", "model", "intention")
"""Keys of the group controller that are no numbers of its calibration."""

_PEDAL_KEYS = ("column", "unit", "rest", "full", "start", "end")


@dataclass(frozen=True)
class Assembly:
    """A scenario put together: parts, loop, how its runs are logged, and whether its bound is asked for."""

    scenario: Scenario
    vehicle: Vehicle
    plant: Plant
    controller: Controller
    system: System
    lanes: int
    bound: bool
    about: Mapping[str, str]
    log: RecordArray | None = None


def assemble(scenario: str, settings: Mapping[str, Any], over: Lanes | None = None) -> Assembly:
    """Return the closed loop of a library scenario, or of a scenario file, with settings applied.

    Args:
        settings: as `--set` takes them: choices (intent, controller, vehicle, pedal) and dotted keys.
        over: dotted keys of plant or controller with one value per lane.

    Raises:
        InputError: whatever in the files or the settings is not as it should be.
    """
    manoeuvre = load_scenario(scenario)
    for key, known in (("plant", PLANTS), ("metrics", FAMILIES)):
        if getattr(manoeuvre, key) not in known:
            mend = f"expected one of {', '.join(known)}"
            raise InputError(manoeuvre.where, f"{key}: got {getattr(manoeuvre, key)}", mend)
    chosen = _sort(settings)
    vehicle = load_vehicle(str(chosen.choices.get("vehicle", manoeuvre.vehicle)))
    plant = _plant(vehicle, manoeuvre)
    controller = _controller(str(chosen.choices.get("controller", manoeuvre.controller)), plant)
    _refuse_unknown(chosen, plant, manoeuvre)
    lanes, lane_groups = _lanes(over or {})
    nominal = _nominal(plant, vehicle, manoeuvre)
    plant.check(nominal, vehicle.where)
    parameters = _varied(plant, nominal, chosen, lane_groups, lanes)
    calibration = _calibration(controller, chosen.group("controller"), lane_groups.get("controller", {}), lanes)
    timing = manoeuvre.timing.copy()
    _apply(Timing, timing, chosen.group("timing"), "timing.")
    profile = _pedal(manoeuvre, chosen)
    if "pedal" in chosen.choices and "duration" not in chosen.group("timing"):
        timing["duration"] = max(timing["duration"][0], profile.time[-1])
    advisers, advised = _intention(controller, nominal, chosen)
    system = System(
        plant=_plant_part(plant, parameters, float(timing["tick"][0])),
        controllers=[*advisers, _controller_part(controller, _designed(controller, nominal, calibration, chosen))],
        profiles=[profile, *advised],
        rules=list(_rules(manoeuvre, plant)),
        imperfections=_imperfections(plant, controller, chosen),
        duration=float(timing["duration"][0]),
        tick=float(timing["tick"][0]),
    )
    about = {"scenario": manoeuvre.name, "vehicle": vehicle.name, "controller": controller.name}
    about |= {f"set.{key}": str(value) for key, value in settings.items()}
    log = None if manoeuvre.log is None else manoeuvre.log.copy()
    if log is not None:
        _apply(LogSettings, log, chosen.group("log"), "log.")
    bound = bound_wanted(chosen, over is not None)
    return Assembly(manoeuvre, vehicle, plant, controller, system, lanes, bound, about, log)


def _sort(settings: Mapping[str, Any]) -> Settings:
    sorted_settings = Settings()
    for key, value in settings.items():
        group, dot, rest = key.partition(".")
        if dot:
            sorted_settings.groups.setdefault(group, {})[rest] = value
        else:
            sorted_settings.choices[key] = value
    return sorted_settings


def _refuse_unknown(settings: Settings, plant: Plant, scenario: Scenario) -> None:
    choices = ("intent", "controller", "vehicle", "pedal")
    groups = (*plant.parameters.fields, "controller", "pedal", "timing", "report", *_IMPERFECTIONS)
    groups += () if scenario.log is None else ("log",)
    for key in settings.choices:
        if key in groups and key not in choices:
            raise InputError(SET, f"{key}: a group of keys", f"name one of its keys, as in {key}.KEY=VALUE")
        if key not in choices:
            mend = f"expected one of {', '.join(choices)}, or a key of {', '.join(groups)}, such as vehicle.mass"
            raise InputError(SET, f"{key}: unknown key", mend)
    for group in settings.groups:
        if group not in groups:
            raise InputError(SET, f"{group}: unknown group", f"expected one of {', '.join(groups)}")


def _plant(vehicle: Vehicle, scenario: Scenario) -> Plant:
    if vehicle.plant not in PLANTS:
        mend = f"expected one of {', '.join(PLANTS)}"
        raise InputError(vehicle.where, f"plant: got {vehicle.plant}", mend)
    if vehicle.plant != scenario.plant:
        mend = f"scenario {scenario.name} needs a vehicle with plant: {scenario.plant}"
        raise InputError(vehicle.where, f"plant: got {vehicle.plant}", mend)
    return PLANTS[vehicle.plant]


def _controller(name: str, plant: Plant) -> Controller:
    fitting = [controller.name for controller in CONTROLLERS.values() if plant.name in controller.plants]
    if name not in fitting:
        raise InputError("controller", f"got {name}", f"expected one of {', '.join(fitting)}")
    return CONTROLLERS[name]


def _lanes(over: Lanes) -> tuple[int, dict[str, dict[str, Sequence[Any] | npt.NDArray[Any]]]]:
    for key, values in over.items():
        if isinstance(values, str) or np.ndim(values) != 1:
            raise InputError(OVER, f"{key}: got {brief(values)}", "expected a sequence, one value per lane")
    lengths = {len(values) for values in over.values()}
    if len(lengths) > 1 or 0 in lengths:
        raise InputError(OVER, f"got columns of {sorted(lengths)} values", "expected as many values in each")
    groups: dict[str, dict[str, Sequence[Any] | npt.NDArray[Any]]] = {}
    for key, values in over.items():
        group, dot, rest = key.partition(".")
        if not dot:
            raise InputError(OVER, f"{key}: cannot differ between lanes", "expected keys such as vehicle.mass")
        groups.setdefault(group, {})[rest] = values
    return (lengths.pop() if lengths else 1), groups


def _nominal(plant: Plant, vehicle: Vehicle, scenario: Scenario) -> RecordArray:
    road = plant.parameters.fields["road"].record
    assert road is not None
    road.parse(scenario.road, scenario.where, "road")  # so that its errors name the scenario
    return plant.parameters.parse({**vehicle.blocks, "road": scenario.road}, vehicle.where)


def _apply(
    record: type[Record], target: RecordArray, values: Mapping[str, Any], prefix: str = "", where: str = SET
) -> None:
    for key, value in values.items():
        record.assign(target, key, value, where, prefix)


def _varied(
    plant: Plant,
    nominal: RecordArray,
    settings: Settings,
    lane_groups: Mapping[str, Lanes],
    lanes: int,
) -> RecordArray:
    """Return the parameters of the plant: the nominal ones with the settings, one record per lane where they differ."""
    parameters = nominal.copy()
    for block in plant.parameters.fields:
        changes = {f"{block}.{key}": value for key, value in settings.group(block).items()}
        _apply(plant.parameters, parameters, changes)
    blocks = [block for block in lane_groups if block != "controller"]
    if blocks:
        parameters = np.repeat(parameters, lanes)
    for block in blocks:
        if block not in plant.parameters.fields:
            raise InputError(OVER, f"{block}: unknown group", f"expected one of {', '.join(plant.parameters.fields)}")
        _apply(plant.parameters, parameters, {f"{block}.{key}": v for key, v in lane_groups[block].items()}, "", OVER)
    plant.check(parameters, SET)
    return parameters


def _calibration(controller: Controller, settings: Mapping[str, Any], over: Lanes, lanes: int) -> RecordArray:
    shipped = controller.calibrations()
    name = str(settings.get("calibration", controller.default_calibration))
    if name not in shipped:
        mend = f"expected one of {', '.join(shipped)}"
        raise InputError(SET, f"controller.calibration: {controller.name} has no {name}", mend)
    values = {key: value for key, value in shipped[name].items() if key != "source"}
    calibration = controller.calibration.parse(values, f"calibration {name} of {controller.name}")
    changes = {key: value for key, value in settings.items() if key not in _CHOICES}
    _apply(controller.calibration, calibration, changes, "controller.")
    if over:
        calibration = np.repeat(calibration, lanes)
        if "calibration" in over:
            raise InputError(OVER, "controller.calibration: cannot differ between lanes", "run one batch for each")
        _apply(controller.calibration, calibration, over, "controller.", OVER)
    return calibration


def _designed(
    controller: Controller, vehicle: RecordArray, calibration: RecordArray, settings: Settings
) -> RecordArray:
    file = settings.group("controller").get("model")
    if file is None:
        return controller.design(vehicle, calibration)
    if controller.design_on is None:
        able = [other.name for other in CONTROLLERS.values() if other.design_on is not None]
        mend = f"leave it out, or choose a controller that takes one: {', '.join(able)}"
        raise InputError(SET, f"controller.model: {controller.name} takes no model", mend)
    try:
        return controller.design_on(vehicle, calibration, ArxModel.load(str(file)))
    except InputError as error:
        if error.where != "model":
            raise
        raise InputError(str(file), error.problem, error.mend) from None


def _intention(controller: Controller, vehicle: RecordArray, settings: Settings) -> tuple[list[Part], list[Profile]]:
    """Return the block that tells the launch intention, or the constant that stands for none of it."""
    signal = launch_intent.CONTROLLER.command.fields["slip_decay"]
    chosen = settings.group("controller").get("intention")
    if signal.name not in controller.measurement.fields:
        if chosen is not None:
            raise InputError(SET, f"controller.intention: {controller.name} does not ask for it", "leave it out")
        return [], []
    if chosen not in (None, "pedal", "network"):
        raise InputError(SET, f"controller.intention: got {brief(chosen)}", "expected pedal or network")
    if chosen == "network":
        adviser = launch_intent.CONTROLLER
        calibration = _calibration(adviser, {}, {}, 1)
        return [_controller_part(adviser, adviser.design(vehicle, calibration))], []
    nothing = Channel(signal.name, signal.unit, signal.meaning)
    return [], [Profile(nothing, np.zeros(1), np.zeros(1))]


def _plant_part(plant: Plant, parameters: RecordArray, tick: float) -> Part:
    return Part(
        plant.name, plant.init, plant.step, parameters, plant.parameters, plant.state, plant.inputs, plant.outputs,
        plant.work, tick,
    )  # fmt: skip


def _controller_part(controller: Controller, parameters: RecordArray) -> Part:
    return Part(
        controller.name, controller.init, controller.step, parameters, controller.parameters, controller.state,
        controller.measurement, controller.command, controller.work, controller.period,
    )  # fmt: skip


def _pedal(scenario: Scenario, settings: Settings) -> Profile:
    if "pedal" in settings.choices:
        if "intent" in settings.choices:
            raise InputError(SET, "intent: given with pedal=FILE", "leave one of them out")
        time, pedal = read_pedal_log(_pedal_log(str(settings.choices["pedal"]), settings.group("pedal")))
        return Profile(PEDAL, time, pedal)
    if settings.group("pedal"):
        raise InputError(SET, f"pedal.{next(iter(settings.group('pedal')))}: no log", "add --set pedal=FILE")
    intent = str(settings.choices.get("intent", scenario.intent))
    if intent not in scenario.intents:
        raise InputError("intent", f"got {intent}", f"expected one of {', '.join(scenario.intents)}")
    times, values = scenario.intents[intent]
    return Profile(PEDAL, np.array(times, float), np.array(values, float))


def _pedal_log(file: str, settings: Mapping[str, Any]) -> PedalLog:
    for key in settings:
        if key not in _PEDAL_KEYS:
            raise InputError(SET, f"pedal.{key}: unknown key", f"expected one of {', '.join(_PEDAL_KEYS)}")
    if "column" not in settings:
        raise InputError(SET, "pedal.column: missing", f"name the pedal column of {file}")
    numbers = {key: _number(f"pedal.{key}", settings[key], "percent") for key in ("rest", "full") if key in settings}
    numbers |= {key: _number(f"pedal.{key}", settings[key], "s") for key in ("start", "end") if key in settings}
    unit = settings.get("unit")
    if unit not in (None, "percent", "ratio"):
        raise InputError(SET, f"pedal.unit: got {brief(unit)}", "expected percent or ratio")
    ratio = None if unit is None else unit == "ratio"
    return PedalLog(Path(file), str(settings["column"]), **numbers, ratio=ratio)


def _number(key: str, value: object, unit: str) -> float:
    try:
        number = parse(value, unit)
    except UnitError as error:
        raise InputError(SET, f"{key}: {error}", f"expected a number in {unit}") from None
    if not np.isfinite(number):
        raise InputError(SET, f"{key}: got {value}", f"expected a finite number in {unit}")
    return number


def _rules(scenario: Scenario, plant: Plant) -> Iterator[StopRule]:
    if len(scenario.rules) > MOST_RULES:
        raise InputError(scenario.where, f"stop: got {len(scenario.rules)} rules", f"expected at most {MOST_RULES}")
    for number, rule in enumerate(scenario.rules):
        signal = plant.outputs.fields.get(str(rule["signal"]))
        if signal is None:
            mend = f"expected one of {', '.join(plant.outputs.fields)}"
            raise InputError(scenario.where, f"stop[{number}].signal: got {rule['signal']}", mend)
        side = "above" if "above" in rule else "below"
        try:
            limit = parse(rule[side], signal.unit)
        except UnitError as error:
            raise InputError(scenario.where, f"stop[{number}].{side}: {error}", signal.expected()) from None
        if not np.isfinite(limit):
            raise InputError(scenario.where, f"stop[{number}].{side}: got {rule[side]}", signal.expected())
        reason = str(rule.get("reason", f"{signal.name} went {side} {rule[side]}"))
        yield StopRule(str(rule["status"]), reason, signal.name, side == "above", limit, float(rule["hold"]))


def _imperfections(plant: Plant, controller: Controller, settings: Settings) -> Imperfections:
    values: dict[str, dict[str, float]] = {}
    for kind in _IMPERFECTIONS:
        values[kind] = {}
        for name, value in settings.group(kind).items():
            record = plant.inputs if kind == "lag" else controller.measurement
            signal = record.fields.get(name)
            if signal is None:
                raise InputError(SET, f"{kind}.{name}: unknown signal", f"expected one of {', '.join(record.fields)}")
            number = _number(f"{kind}.{name}", value, signal.unit if kind == "noise" else "s")
            if number < 0.0:
                raise InputError(SET, f"{kind}.{name}: got {value}", "expected 0 or more")
            values[kind][name] = number
    return Imperfections(**values)
