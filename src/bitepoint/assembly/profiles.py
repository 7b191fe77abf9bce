"""What the scenario gives: what the driver does over time, and signals that stay as they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.assembly.catalogue import PEDAL
from bitepoint.assembly.settings import SET, Settings, number
from bitepoint.errors import InputError, brief
from bitepoint.recording import Channel
from bitepoint.records import Field, Record
from bitepoint.scenarios import PedalLog, Scenario, read_pedal_log
from bitepoint.simulation.system import Profile
from bitepoint.units import UnitError, parse

PEDAL_KEYS = ("column", "unit", "rest", "full", "start", "end")


def given_profiles(scenario: Scenario, settings: Settings, readers: Iterable[type[Record]]) -> Iterator[Profile]:
    """Yield what the driver does, then the constant signals of the scenario.

    Args:
        readers: record types of the inputs of all parts: they say what the signals are.

    Raises:
        InputError: an unknown intent, a pedal log that cannot be read, or a signal that no part reads.
    """
    declared = {field.name: field for record in readers for field in record.fields.values()}
    yield _driver(scenario, settings, declared)
    for name, value in scenario.given.items():
        channel = _channel(name, declared, scenario.where, f"given.{name}")
        try:
            constant = parse(value, channel.unit)
        except UnitError as error:
            raise InputError(scenario.where, f"given.{name}: {error}", declared[name].expected()) from None
        if not declared[name].low <= constant <= declared[name].high:
            raise InputError(scenario.where, f"given.{name}: got {brief(value)}", declared[name].expected())
        yield Profile(channel, np.zeros(1), np.array([constant]))


def _channel(name: str, declared: Mapping[str, Field], where: str, key: str) -> Channel:
    if name == PEDAL.name:
        return PEDAL
    if name not in declared:
        raise InputError(where, f"{key}: no part reads {name}", f"expected one of {', '.join(declared)}")
    return Channel(name, declared[name].unit, declared[name].meaning)


def _driver(scenario: Scenario, settings: Settings, declared: Mapping[str, Field]) -> Profile:
    if scenario.signal == PEDAL.name:
        return _pedal(scenario, settings)
    if "pedal" in settings.choices or settings.group("pedal"):
        raise InputError(SET, f"pedal: scenario {scenario.name} has none", f"it gives {scenario.signal}")
    times, values = _intended(scenario, settings)
    channel = _channel(scenario.signal, declared, scenario.where, "signal")
    return Profile(channel, np.array(times, float), np.array(values, float))


def _intended(scenario: Scenario, settings: Settings) -> Any:
    intent = str(settings.choices.get("intent", scenario.intent))
    if intent not in scenario.intents:
        raise InputError("intent", f"got {intent}", f"expected one of {', '.join(scenario.intents)}")
    return scenario.intents[intent]


def _pedal(scenario: Scenario, settings: Settings) -> Profile:
    if "pedal" in settings.choices:
        if "intent" in settings.choices:
            raise InputError(SET, "intent: given with pedal=FILE", "leave one of them out")
        time, pedal = read_pedal_log(_pedal_log(str(settings.choices["pedal"]), settings.group("pedal")))
        return Profile(PEDAL, time, pedal)
    if settings.group("pedal"):
        raise InputError(SET, f"pedal.{next(iter(settings.group('pedal')))}: no log", "add --set pedal=FILE")
    times, values = _intended(scenario, settings)
    return Profile(PEDAL, np.array(times, float), np.array(values, float))


def _pedal_log(file: str, settings: Mapping[str, Any]) -> PedalLog:
    for key in settings:
        if key not in PEDAL_KEYS:
            raise InputError(SET, f"pedal.{key}: unknown key", f"expected one of {', '.join(PEDAL_KEYS)}")
    if "column" not in settings:
        raise InputError(SET, "pedal.column: missing", f"name the pedal column of {file}")
    numbers = {key: number(f"pedal.{key}", settings[key], "percent") for key in ("rest", "full") if key in settings}
    numbers |= {key: number(f"pedal.{key}", settings[key], "s") for key in ("start", "end") if key in settings}
    unit = settings.get("unit")
    if unit not in (None, "percent", "ratio"):
        raise InputError(SET, f"pedal.unit: got {brief(unit)}", "expected percent or ratio")
    ratio = None if unit is None else unit == "ratio"
    return PedalLog(Path(file), str(settings["column"]), **numbers, ratio=ratio)
