"""What the scenario gives: what the driver does over time, and signals that stay as they are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.assembly.catalogue import PEDAL
from bitepoint.assembly.settings import SET, Settings, number
from bitepoint.errors import InputError, brief
from bitepoint.recording import Channel
from bitepoint.records import Field, Record
from bitepoint.scenarios import PedalLog, Scenario, SpeedLog, read_pedal_log, read_speed_log
from bitepoint.simulation.system import Profile
from bitepoint.units import UnitError, parse

LOGS = {PEDAL.name: PEDAL.name, "speed_target": "speed"}
"""The key that names a log of what the driver does, by its signal."""

SPEED_KEYS = ("column", "unit", "start", "end")
PEDAL_KEYS = ("column", "unit", "rest", "full", "start", "end")


def given_profiles(scenario: Scenario, settings: Settings, readers: Iterable[type[Record]]) -> Iterator[Profile]:
    """Yield what the driver does, then the constant signals of the scenario.

    Args:
        readers: record types of the inputs of all parts: they say what the signals are.

    Raises:
        InputError: an unknown intent, a log that cannot be read, or a signal that no part reads.
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
    """Return what the driver does: from a log where one is set, else the intent."""
    own = LOGS.get(scenario.signal)
    for key in LOGS.values():
        if key != own and (key in settings.choices or settings.group(key)):
            raise InputError(SET, f"{key}: scenario {scenario.name} has none", f"it gives {scenario.signal}")
    channel = _channel(scenario.signal, declared, scenario.where, "signal")
    if own is None or own not in settings.choices:
        if own is not None and settings.group(own):
            raise InputError(SET, f"{own}.{next(iter(settings.group(own)))}: no log", f"add --set {own}=FILE")
        times, values = _intended(scenario, settings)
    else:
        if "intent" in settings.choices:
            raise InputError(SET, f"intent: given with {own}=FILE", "leave one of them out")
        file = str(settings.choices[own])
        if own == PEDAL.name:
            times, values = read_pedal_log(_pedal_log(file, settings.group(own)))
        else:
            times, values = read_speed_log(_speed_log(file, settings.group(own)))
    return Profile(channel, np.array(times, float), np.array(values, float))


def _intended(scenario: Scenario, settings: Settings) -> Any:
    intent = str(settings.choices.get("intent", scenario.intent))
    if intent not in scenario.intents:
        raise InputError("intent", f"got {intent}", f"expected one of {', '.join(scenario.intents)}")
    return scenario.intents[intent]


def _window(key: str, file: str, settings: Mapping[str, Any], known: Sequence[str]) -> dict[str, float]:
    """Return the part of a log that the settings name, s, after a look at their keys."""
    for name in settings:
        if name not in known:
            raise InputError(SET, f"{key}.{name}: unknown key", f"expected one of {', '.join(known)}")
    if "column" not in settings:
        raise InputError(SET, f"{key}.column: missing", f"name the {key} column of {file}")
    return {name: number(f"{key}.{name}", settings[name], "s") for name in ("start", "end") if name in settings}


def _pedal_log(file: str, settings: Mapping[str, Any]) -> PedalLog:
    numbers = _window("pedal", file, settings, PEDAL_KEYS)
    numbers |= {key: number(f"pedal.{key}", settings[key], "percent") for key in ("rest", "full") if key in settings}
    unit = settings.get("unit")
    if unit not in (None, "percent", "ratio"):
        raise InputError(SET, f"pedal.unit: got {brief(unit)}", "expected percent or ratio")
    ratio = None if unit is None else unit == "ratio"
    return PedalLog(Path(file), str(settings["column"]), **numbers, ratio=ratio)


def _speed_log(file: str, settings: Mapping[str, Any]) -> SpeedLog:
    window = _window("speed", file, settings, SPEED_KEYS)
    unit = settings.get("unit")
    return SpeedLog(Path(file), str(settings["column"]), None if unit is None else str(unit), **window)
