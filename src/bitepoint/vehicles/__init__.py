"""Vehicle files: a block of parameters per component, each with its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

from bitepoint.errors import InputError, brief
from bitepoint.files import find, library_names, read_yaml

__all__ = ["Vehicle", "load_vehicle", "vehicle_names"]


@dataclass(frozen=True)
class Vehicle:
    """A vehicle file, its numbers not yet validated: which blocks it needs is its plant's business.

    Attributes:
        where: the file, for errors.
        blocks: block name -> its keys; the key `source` of each block is taken out.
        sources: block name -> where its numbers come from.
    """

    name: str
    plant: str
    meaning: str
    where: str
    blocks: Mapping[str, Any]
    sources: Mapping[str, str]


def vehicle_names() -> list[str]:
    """Return the names of the vehicles in the library."""
    return library_names("vehicles")


def load_vehicle(name: str) -> Vehicle:
    """Return the library vehicle `name`, or the one in the YAML file at that path.

    Raises:
        InputError: no such vehicle, or not a vehicle file.
    """
    path = find("vehicles", name, "vehicle")
    data = read_yaml(path)
    where = str(path)
    plant = data.pop("plant", None)
    if not isinstance(plant, str):
        raise InputError(where, "plant: missing or no name", "expected the name of a plant, such as: plant: dct")
    meaning = data.pop("meaning", "")
    if not isinstance(meaning, str):
        raise InputError(where, f"meaning: got {brief(meaning)}", "expected text")
    blocks: dict[str, Any] = {}
    sources: dict[str, str] = {}
    for key, block in data.items():
        blocks[key] = block
        if isinstance(block, Mapping):
            numbers = dict(cast("Mapping[str, Any]", block))
            source = numbers.pop("source", "")
            if not isinstance(source, str):
                raise InputError(
                    where, f"{key}.source: got {brief(source)}", "expected text that says where it is from"
                )
            sources[key], blocks[key] = source, numbers
    for block, key in (("road", "grade"), ("start", "speed")):
        if block in blocks:
            mend = f"set it in the scenario, or by --set {block}.{key}"
            raise InputError(where, f"{block}: does not belong to a vehicle", mend)
    return Vehicle(path.stem, plant, meaning, where, blocks, sources)
