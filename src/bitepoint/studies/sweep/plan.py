"""The plan of a sweep: what is run, and what two sweeps have to share to be one."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import bitepoint
from bitepoint.assembly import PLANTS, keys, signals
from bitepoint.errors import InputError, brief
from bitepoint.files import find
from bitepoint.recording import Channel
from bitepoint.scenarios import Scenario, load_scenario
from bitepoint.studies.sweep.grid import OVER, Axis, Grid
from bitepoint.units import UnitError, parse
from bitepoint.version import __version__

SEED = "seed"
"""The key of the noise's seed."""

_FILES = ("vehicle", "pedal", "speed", "controller.model")
"""Keys whose value may be a file."""

_ABOVE = ("__init__.py", "__main__.py", "api", "cli", "export", "report", "studies")
"""What stands above the room `assembly`, and changes no figure."""


@cache
def code_digest() -> str:
    """Return a digest of the sources and library files that a run depends on: those of `assembly` and below."""
    package = Path(bitepoint.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*")):
        part = path.relative_to(package)
        if path.suffix in (".py", ".yaml") and part.parts[0] not in _ABOVE:
            digest.update(f"{part.as_posix()}\0{_digest(path)}\n".encode())
    return digest.hexdigest()[:16]


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@dataclass(frozen=True)
class Swept:
    """A swept key as a column.

    Attributes:
        kind: "float" or "int": numbers in SI; "text": as they were given.
        values: by place in the axis.
        lane: whether its values can stand side by side in one batch.
    """

    axis: Axis
    channel: Channel
    kind: str
    values: Sequence[Any]
    lane: bool


@dataclass(frozen=True)
class Plan:
    """A sweep, read and checked, except for what its runs have to say.

    Attributes:
        name: of the scenario, as it was given.
        settings: what all rows share, as `--set` takes it; seed: of the noise of all rows where it is not swept.
    """

    name: str
    grid: Grid
    settings: Mapping[str, Any]
    seed: int

    def __post_init__(self) -> None:
        """Refuse a scenario of many runs, a key that is set and swept, a number of another dimension, an odd seed."""
        if self.scenario.runs is not None:
            mend = "expected a scenario of one run"
            raise InputError(self.name, "a scenario of many runs cannot be swept", mend)
        for axis in self.grid.axes:
            if axis.key in self.settings:
                raise InputError(OVER, f"{axis.key}: given in --set too", "leave one of them out")
        seeds = next((swept.values for swept in self.swept if swept.axis.key == SEED), [self.seed])
        odd = next((seed for seed in seeds if not isinstance(seed, int) or not 0 <= seed < 1 << 63), None)
        if odd is not None:
            raise InputError(SEED, f"got {brief(odd)}", "expected a whole number of 0 or more")

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario file."""
        return load_scenario(self.name)

    @cached_property
    def swept(self) -> tuple[Swept, ...]:
        """What is swept, in the order of the grid."""
        plant = PLANTS.get(self.scenario.plant)
        blocks = (SEED, "controller", *(() if plant is None else plant.parameters.fields))
        return tuple(_swept(axis, blocks) for axis in self.grid.axes)

    def row(self, number: int) -> tuple[dict[str, Any], int]:
        """Return the settings of a row with what is swept, and its seed."""
        settings = {**self.settings, **self.grid.row(number)}
        return settings, _whole(settings.pop(SEED, self.seed))

    def lanes(self, rows: Sequence[int]) -> tuple[dict[str, Any], dict[str, list[Any]], list[int]]:
        """Return for rows of one group: the settings that they share, keys with one value per row, and their seeds."""
        found = [self.row(number) for number in rows]
        beside = [swept.axis.key for swept in self.swept if swept.lane and swept.axis.key != SEED]
        shared = {key: value for key, value in found[0][0].items() if key not in beside}
        return shared, {key: [row[key] for row, _ in found] for key in beside}, [seed for _, seed in found]

    def groups(self, rows: Sequence[int]) -> list[list[int]]:
        """Return rows in groups that can be run as one batch."""
        return self.grid.groups(rows, {swept.axis.key: not swept.lane for swept in self.swept})

    def identity(self) -> dict[str, Any]:
        """Return all that the rows depend on, as JSON takes it: files by content, code by version and content."""
        values = [*self.settings.items(), *((axis.key, value) for axis in self.grid.axes for value in axis.values)]
        files = {str(value): Path(str(value)) for key, value in values if key in _FILES}
        return {
            "scenario": self.name,
            "scenario_sha256": _digest(find("scenarios", self.name, "scenario")),
            "settings": dict(self.settings),
            "over": {axis.key: list(axis.values) for axis in self.grid.axes},
            "seed": self.seed,
            "files_sha256": {name: _digest(path) for name, path in files.items() if path.is_file()},
            "version": __version__,
            "code": code_digest(),
        }


def text_of(value: Any) -> str:
    """Return a value as `--set` takes it."""
    return value if isinstance(value, str) else json.dumps(value)


def _swept(axis: Axis, blocks: Sequence[str]) -> Swept:
    declared = list(_declared(axis.key))
    channel, kind = declared[0] if declared else (Channel(axis.key, "1", "as given"), "text")
    if kind not in ("float", "int") or any((other.unit, k) != (channel.unit, kind) for other, k in declared):
        return Swept(axis, replace(channel, unit="1"), "text", [text_of(value) for value in axis.values], False)
    numbers = [_number(axis.key, value, channel.unit) for value in axis.values]
    lane = axis.key.partition(".")[0] in blocks
    if kind == "int" and all(number == math.floor(number) for number in numbers if math.isfinite(number)):
        return Swept(axis, channel, "int", [int(number) for number in numbers], lane)
    return Swept(axis, channel, "float", numbers, lane)


def _declared(key: str) -> Iterator[tuple[Channel, str]]:
    """Yield what is declared of a key, and its kind, for each part that has the key."""
    kind, _, name = key.partition(".")
    if key == SEED:
        yield Channel(key, "1", "seed of the noise"), "int"
    if kind in ("lag", "delay"):
        yield Channel(key, "s", f"{kind} of {name}"), "float"
    elif kind == "noise":
        yield from ((Channel(key, one.unit, f"noise of {name}"), "float") for one in signals() if one.name == name)
    for known, field in keys():
        if known == key:
            yield Channel(key, field.unit, field.meaning), "array" if field.shape else field.kind


def _number(key: str, value: Any, unit: str) -> float:
    try:
        return parse(value, unit)
    except UnitError as error:
        raise InputError(OVER, f"{key}: {error}", f"expected numbers in {unit}") from None


def _whole(seed: Any) -> int:
    return int(float(seed))
