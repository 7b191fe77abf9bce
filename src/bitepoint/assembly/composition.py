"""Putting a vehicle, a controller and a manoeuvre together by name, with settings applied."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bitepoint.assembly.catalogue import CONTROLLERS, PLANTS, SUPERVISORS, controllers_for
from bitepoint.assembly.planned import (
    BASELINE,
    DRIVER,
    ROAD,
    PlannedDrive,
    planned_drive,
    scheduled,
)
from bitepoint.assembly.profiles import LOGS, given_profiles
from bitepoint.assembly.report_wishes import ReportWishes, report_wishes
from bitepoint.assembly.settings import SET, Settings, number
from bitepoint.controllers import launch_intent
from bitepoint.controllers.controller import Controller
from bitepoint.errors import InputError, brief
from bitepoint.metrics import FAMILIES, Metrics
from bitepoint.models.arx import ArxModel
from bitepoint.plants.plant import Plant
from bitepoint.recording import Channel, Recording
from bitepoint.records import Record, RecordArray
from bitepoint.scenarios import LogSettings, Scenario, Timing, load_scenario
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


@dataclass(frozen=True)
class Assembly:
    """A scenario put together: parts, loop, figures, how its runs are logged, and what `report.*` asks for.

    Where it was planned: the plan, and the controllers of the baseline that it is compared with.
    """

    scenario: Scenario
    vehicle: Vehicle
    plant: Plant
    controller: Controller
    system: System
    figures: Callable[[Recording], Metrics]
    lanes: int
    report: ReportWishes
    about: Mapping[str, str]
    log: RecordArray | None = None
    planned: PlannedDrive | None = None
    baseline: Sequence[Part] = ()


def assemble(scenario: str, settings: Mapping[str, Any], over: Lanes | None = None) -> Assembly:
    """Return the closed loop of a library scenario, or of a scenario file, with settings applied.

    Args:
        settings: as `--set` takes them: choices (intent, controller, vehicle, pedal, speed) and dotted keys.
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
    planned = planned_drive(manoeuvre, chosen, _started(plant, nominal, chosen))
    if planned is not None:
        planned.prepare(nominal)
        chosen.groups.setdefault(DRIVER, {}).setdefault("calibration", planned.baseline)
    parameters = _varied(plant, nominal, chosen, lane_groups, lanes)
    calibration = _calibration(controller, chosen.group("controller"), lane_groups.get("controller", {}), lanes)
    supervisors = _supervisors(manoeuvre, plant)
    controllers = [*supervisors, controller]
    profiles = list(given_profiles(manoeuvre, chosen, [plant.inputs, *(each.measurement for each in controllers)]))
    rules = list(_rules(manoeuvre, plant))
    if planned is not None:
        profiles[0] = planned.chased(profiles[0])
        rules.append(planned.arrival)
    timing = _timing(manoeuvre, chosen, profiles[0], planned)
    beside, constant = _intention(controller, nominal, chosen)
    before = [_supervisor_part(each, plant, nominal, manoeuvre, chosen) for each in supervisors]
    main = _controller_part(controller, _designed(controller, nominal, calibration, chosen))
    parts = [*before, *beside, main]
    baseline = [] if planned is None else planned.chasing(parts)
    system = System(
        plant=_plant_part(plant, parameters, float(timing["tick"][0])),
        controllers=parts if planned is None else planned.followed(parts, planned.plan),
        profiles=[*profiles, *constant],
        rules=rules,
        imperfections=_imperfections(plant, controllers, chosen),
        duration=float(timing["duration"][0]),
        tick=float(timing["tick"][0]),
        at_end=manoeuvre.at_end,
    )
    about = {"scenario": manoeuvre.name, "vehicle": vehicle.name, "controller": controller.name}
    about |= {f"set.{key}": str(value) for key, value in settings.items()}
    log = None if manoeuvre.log is None else manoeuvre.log.copy()
    if log is not None:
        _apply(LogSettings, log, chosen.group("log"), "log.")
    report = report_wishes(chosen, manoeuvre.metrics, over is not None)
    figures = FAMILIES[manoeuvre.metrics].measure(_weights(manoeuvre, chosen))
    return Assembly(
        manoeuvre, vehicle, plant, controller, system, figures, lanes, report, about, log, planned, baseline
    )


def _timing(scenario: Scenario, settings: Settings, driver: Profile, planned: PlannedDrive | None) -> RecordArray:
    """Return the times of the run: as long as what is driven, where nobody says how long."""
    timing = scenario.timing.copy()
    _apply(Timing, timing, settings.group("timing"), "timing.")
    if "duration" not in settings.group("timing"):
        if planned is not None:
            timing["duration"] = planned.longest
        elif set(LOGS.values()) & set(settings.choices):
            least = 0.0 if "speed" in settings.choices else timing["duration"][0]
            timing["duration"] = max(least, driver.time[-1])
    return timing


def _weights(scenario: Scenario, settings: Settings) -> RecordArray | None:
    """Return the settings of the figures of the scenario; None where they have none."""
    record = FAMILIES[scenario.metrics].settings
    if record is None:
        return None
    weights = record.parse({}, scenario.where)
    _apply(record, weights, settings.group("cost"), "cost.")
    return weights


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
    choices = ("intent", "controller", "vehicle", *LOGS.values())
    groups = (*plant.parameters.fields, "controller", "timing", "report", *_IMPERFECTIONS)
    groups += (LOGS[scenario.signal],) if scenario.signal in LOGS else ()
    groups += () if scenario.log is None else ("log",)
    groups += () if FAMILIES[scenario.metrics].settings is None else ("cost",)
    groups += tuple(scenario.supervisors)
    if scenario.planning is not None:
        choices += (BASELINE, ROAD)
        groups += (scenario.planning[0],)
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
    fitting = controllers_for(plant.name)
    if name not in fitting:
        raise InputError("controller", f"got {name}", f"expected one of {', '.join(fitting)}")
    return fitting[name]


def _supervisors(scenario: Scenario, plant: Plant) -> list[Controller]:
    fitting = {name: each for name, each in SUPERVISORS.items() if plant.name in each.plants}
    for name in scenario.supervisors:
        if name not in fitting:
            mend = f"expected some of {', '.join(fitting)}" if fitting else f"plant {plant.name} has none"
            raise InputError(scenario.where, f"supervisors: got {name}", mend)
    return [fitting[name] for name in scenario.supervisors]


def _supervisor_part(
    supervisor: Controller, plant: Plant, vehicle: RecordArray, scenario: Scenario, settings: Settings
) -> Part:
    """Return the part with what the scenario sets of it, then what the user sets."""
    calibration = _calibration(supervisor, settings.group(supervisor.name), {}, 1, scenario)
    parameters = supervisor.design(vehicle, calibration)
    return _controller_part(supervisor, scheduled(supervisor, parameters, plant, vehicle))


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
    blocks = {"road": scenario.road} | ({"start": scenario.start} if scenario.start else {})
    for name, block in blocks.items():  # so that errors in them name the scenario
        declared = plant.parameters.fields.get(name)
        if declared is None or declared.record is None:
            raise InputError(scenario.where, f"{name}: unknown to plant {plant.name}", "leave it out")
        declared.record.parse(block, scenario.where, name)
    return plant.parameters.parse({**vehicle.blocks, **blocks}, vehicle.where)


def _started(plant: Plant, nominal: RecordArray, settings: Settings) -> RecordArray:
    """Return the vehicle of the library as it stands at the start: the driver sees that."""
    seen = nominal.copy()
    changes = {f"start.{key}": value for key, value in settings.group("start").items()}
    _apply(plant.parameters, seen, changes)
    return seen


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


def _calibration(
    controller: Controller,
    settings: Mapping[str, Any],
    over: Lanes,
    lanes: int,
    scenario: Scenario | None = None,
) -> RecordArray:
    group = "controller" if scenario is None else controller.name
    shipped = controller.calibrations()
    name = str(settings.get("calibration", controller.default_calibration))
    if name not in shipped:
        mend = f"expected one of {', '.join(shipped)}"
        raise InputError(SET, f"{group}.calibration: {controller.name} has no {name}", mend)
    values = {key: value for key, value in shipped[name].items() if key != "source"}
    calibration = controller.calibration.parse(values, f"calibration {name} of {controller.name}")
    if scenario is not None:
        _apply(controller.calibration, calibration, scenario.supervisors[group], f"{group}.", scenario.where)
    changes = {key: value for key, value in settings.items() if key not in _CHOICES}
    _apply(controller.calibration, calibration, changes, f"{group}.")
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


def _rules(scenario: Scenario, plant: Plant) -> Iterator[StopRule]:
    if len(scenario.rules) > MOST_RULES:
        raise InputError(scenario.where, f"stop: got {len(scenario.rules)} rules", f"expected at most {MOST_RULES}")
    for place, rule in enumerate(scenario.rules):
        signal = plant.outputs.fields.get(str(rule["signal"]))
        if signal is None:
            mend = f"expected one of {', '.join(plant.outputs.fields)}"
            raise InputError(scenario.where, f"stop[{place}].signal: got {rule['signal']}", mend)
        side = "above" if "above" in rule else "below"
        try:
            limit = parse(rule[side], signal.unit)
        except UnitError as error:
            raise InputError(scenario.where, f"stop[{place}].{side}: {error}", signal.expected()) from None
        if not np.isfinite(limit):
            raise InputError(scenario.where, f"stop[{place}].{side}: got {rule[side]}", signal.expected())
        reason = str(rule.get("reason", f"{signal.name} went {side} {rule[side]}"))
        yield StopRule(str(rule["status"]), reason, signal.name, side == "above", limit, float(rule["hold"]))


def _imperfections(plant: Plant, controllers: Sequence[Controller], settings: Settings) -> Imperfections:
    measured = {name: field for each in controllers for name, field in each.measurement.fields.items()}
    values: dict[str, dict[str, float]] = {}
    for kind in _IMPERFECTIONS:
        values[kind] = {}
        for name, value in settings.group(kind).items():
            known = plant.inputs.fields if kind == "lag" else measured
            signal = known.get(name)
            if signal is None:
                raise InputError(SET, f"{kind}.{name}: unknown signal", f"expected one of {', '.join(known)}")
            found = number(f"{kind}.{name}", value, signal.unit if kind == "noise" else "s")
            if found < 0.0:
                raise InputError(SET, f"{kind}.{name}: got {value}", "expected 0 or more")
            values[kind][name] = found
    return Imperfections(**values)
