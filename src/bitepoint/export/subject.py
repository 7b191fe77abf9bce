"""What is exported: a controller or a plant, as the scenarios of the library put it together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bitepoint.assembly import ADVISERS, CONTROLLERS, PLANTS, SUPERVISORS, Assembly, assemble
from bitepoint.controllers.controller import Controller
from bitepoint.errors import InputError
from bitepoint.kernels.c99 import PRECISIONS, Precision
from bitepoint.scenarios import load_scenario, scenario_names
from bitepoint.simulation.system import Part
from bitepoint.vehicles import load_vehicle


@dataclass(frozen=True)
class Options:
    """What is asked for.

    Attributes:
        name: of a controller, of a supervisor before one, of an adviser beside one, or of a plant.
        vehicle: library vehicle or vehicle file that it is designed for; None: the scenario's own.
        settings: as `bitepoint run --set` takes them.
        precision: "float64" or "float32".
    """

    name: str
    vehicle: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict[str, Any])
    precision: str = "float64"


@dataclass(frozen=True)
class Subject:
    """A part with what it does, what its parameters were designed from, and every loop that it stands in, by name."""

    part: Part
    meaning: str
    origin: str
    loops: Sequence[tuple[str, Assembly]]


def chosen_precision(options: Options) -> Precision:
    """Return the precision that the options name.

    Raises:
        InputError: there is none of that name.
    """
    if options.precision not in PRECISIONS:
        raise InputError("--precision", f"got {options.precision}", f"expected one of {', '.join(PRECISIONS)}")
    return PRECISIONS[options.precision]


def find_subject(options: Options) -> Subject:
    """Return the part that the options name, with its loops in every library scenario that it fits.

    Raises:
        InputError: an unknown name, vehicle or setting.
    """
    options = _for_its_plant(options)
    blocks = {**CONTROLLERS, **SUPERVISORS, **ADVISERS}
    controller = blocks.get(options.name)
    if controller is None and options.name not in PLANTS:
        raise InputError("export", f"got {options.name}", f"expected one of {', '.join([*blocks, *PLANTS])}")
    settings = dict(options.settings)
    for key in {"controller", "vehicle"} & set(settings):
        mend = "it is the part that is exported" if key == "controller" else "use --vehicle"
        raise InputError("--set", f"{key}: cannot be set here", mend)
    if controller is not None:
        settings |= _as_controller(options.name, controller, settings)
    fitting = (options.name,) if controller is None else controller.plants
    if options.vehicle is not None:
        settings["vehicle"] = options.vehicle
        kind = load_vehicle(options.vehicle).plant
        if kind not in fitting:
            mend = f"expected one for {options.name}: plant {' or '.join(fitting)}"
            raise InputError(options.vehicle, f"is a vehicle with plant {kind}", mend)
        fitting = (kind,)
    loops = list(_loops(fitting, settings))
    if controller is not None:
        loops = [loop for loop in loops if any(part.name == controller.name for part in loop[1].system.controllers)]
    first = loops[0][1]
    said = {key: Path(value).name if key in ("pedal", "speed") else value for key, value in options.settings.items()}
    changes = ", ".join(f"{key}={value}" for key, value in said.items())
    origin = f"vehicle {first.vehicle.name}" + (f", {changes}" if changes else "")
    if controller is None:
        return Subject(first.system.plant, f"plant {options.name}", origin, loops)
    part = next(part for part in first.system.controllers if part.name == controller.name)
    return Subject(replace(part, name=options.name), controller.meaning, origin, loops)


def _for_its_plant(options: Options) -> Options:
    """Return the options with the controller of that name that fits the vehicle: each plant has its own `none`."""
    if options.vehicle is None or options.name not in CONTROLLERS:
        return options
    kind = load_vehicle(options.vehicle).plant
    fitting = [key for key, each in CONTROLLERS.items() if each.name == options.name and kind in each.plants]
    return replace(options, name=fitting[0]) if fitting else options


def _as_controller(name: str, block: Controller, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that put a block into a loop.

    As the controller; beside the first one that it advises; supervisors stand in their loops already.
    """
    if name in CONTROLLERS:
        return {"controller": block.name}
    for key in settings:
        if key.startswith("controller."):
            raise InputError("--set", f"{key}: is none of {name}", f"expected keys such as {name}.KEY, if it has any")
    if name in SUPERVISORS:
        return {}
    told = set(block.command.fields)
    advised = next(each for each, other in CONTROLLERS.items() if told & set(other.measurement.fields))
    return {"controller": advised, "controller.intention": "network"}


def _loops(plants: Sequence[str], settings: Mapping[str, Any]) -> Iterator[tuple[str, Assembly]]:
    """Yield each library scenario with a fitting plant, in each of its intents, the scenario's own first.

    Those that drive to a plan are left out: planning takes seconds, and the parts in their loop are the same.
    """
    for name in scenario_names():
        scenario = load_scenario(name)
        if scenario.plant not in plants or scenario.planning is not None:
            continue
        if {"intent", "pedal", "speed"} & set(settings):
            yield f"{name} as set", assemble(name, settings)
        else:
            for intent in dict.fromkeys([scenario.intent, *scenario.intents]):
                yield f"{name}, {intent}", assemble(name, {**settings, "intent": intent})
