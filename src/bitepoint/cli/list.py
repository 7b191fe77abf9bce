"""`bitepoint list`: what there is."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Annotated

import typer

from bitepoint.errors import InputError


def list_parts(
    what: Annotated[
        str | None, typer.Argument(help="vehicles, scenarios, controllers (all three by default), signals or keys.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object: names by kind.")] = False,
) -> None:
    """List vehicles, scenarios, controllers, the signals that they are wired by, and the keys of --set."""
    if what is not None and what not in _KINDS:
        raise InputError("list", f"got {what}", f"expected one of {', '.join(_KINDS)}")
    kinds = [kind for kind in _KINDS if kind == what or (what is None and kind in _DEFAULT)]
    found = {kind: _KINDS[kind]() for kind in kinds}
    if as_json:
        typer.echo(json.dumps({kind: list(items) for kind, items in found.items()}, ensure_ascii=False))
        return
    for kind, items in found.items():
        typer.echo(kind)
        for name, meaning in items.items():
            typer.echo(f"  {name:<22} {meaning}")


def _vehicles() -> Mapping[str, str]:
    from bitepoint.vehicles import load_vehicle, vehicle_names

    return {name: load_vehicle(name).meaning for name in vehicle_names()}


def _scenarios() -> Mapping[str, str]:
    from bitepoint.scenarios import load_scenario, scenario_names

    return {name: load_scenario(name).meaning for name in scenario_names()}


def _controllers() -> Mapping[str, str]:
    from bitepoint.assembly import CONTROLLERS

    found: dict[str, str] = {}
    for controller in CONTROLLERS.values():
        meaning = f"{controller.meaning}; calibrations: {', '.join(controller.calibrations())}"
        said = f"{', '.join(controller.plants)}: {meaning}"
        found[controller.name] = f"{found[controller.name]}. {said}" if controller.name in found else said
    return found


def _signals() -> Mapping[str, str]:
    from bitepoint.assembly import signals
    from bitepoint.units import display

    return {channel.name: f"{display(channel.unit):<8} {channel.meaning}" for channel in signals()}


def _keys() -> Mapping[str, str]:
    from bitepoint.assembly import keys

    return {key: f"{field.meaning}; {field.expected().removeprefix('expected ')}" for key, field in keys()}


_DEFAULT = ("vehicles", "scenarios", "controllers")

_KINDS: Mapping[str, Callable[[], Mapping[str, str]]] = {
    "vehicles": _vehicles,
    "scenarios": _scenarios,
    "controllers": _controllers,
    "signals": _signals,
    "keys": _keys,
}
