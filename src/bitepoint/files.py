"""Reading files: YAML and JSON without surprises, and the library that ships with the package; JSON out."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, cast

import yaml

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError, brief

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


DEEPEST = 30
"""Levels of nesting that a file may have."""


class _StrictLoader(_Loader):
    """YAML that refuses a key given twice."""


def _strict_mapping(loader: Any, node: yaml.MappingNode) -> dict[object, object]:
    seen: set[str] = set()
    for key_node, _ in node.value:
        key = str(key_node.value)
        if key in seen:
            line = key_node.start_mark.line + 1
            raise yaml.MarkedYAMLError(problem=f"key {key} is given twice, again in line {line}")
        seen.add(key)
    loader.flatten_mapping(node)
    return dict(loader.construct_pairs(node, deep=True))


_StrictLoader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _strict_mapping)


def read_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping that a YAML file holds.

    Raises:
        InputError: no such file, no YAML, or no mapping.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(str(path), "no such file", "check the path") from None
    except UnicodeDecodeError:
        raise InputError(str(path), "not a text file", "expected YAML in UTF-8") from None
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", "check the path and its rights") from None
    return parse_yaml(text, str(path))


def parse_yaml(text: str, where: str) -> dict[str, Any]:
    """Return the mapping that a YAML text holds; `where` is named in errors."""
    data = parse_yaml_value(text, where)
    if not isinstance(data, Mapping):
        what = "nothing" if data is None else f"a {type(data).__name__}"
        raise InputError(where, f"holds {what}", "expected a YAML mapping of keys to values")
    return {str(key): value for key, value in cast("Mapping[object, Any]", data).items()}


def parse_yaml_value(text: str, where: str) -> Any:
    """Return the value that a YAML text holds; `where` is named in errors.

    Nesting is limited and aliases are refused: with them, a few lines can stand for more than any machine holds.
    """
    try:
        _check_events(text, where)
        return yaml.load(text, _StrictLoader)
    except yaml.MarkedYAMLError as error:
        mark = "" if error.problem_mark is None else f" in line {error.problem_mark.line + 1}"
        raise InputError(where, f"not YAML: {error.problem}{mark}", "mend the syntax") from None
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001 - the library's constructors raise whatever they meet
        text = " ".join(str(error).split())[:120]
        raise InputError(where, f"not YAML: {text}", "mend the syntax") from None


def read_json(path: Path, mend: str) -> Any:
    """Return the value that a JSON file holds; `mend` is what errors say was expected.

    Raises:
        InputError: no such file, or no JSON.
    """
    try:
        return json.loads(path.read_bytes())
    except FileNotFoundError:
        raise InputError(str(path), "no such file", "check the path") from None
    except (OSError, ValueError):
        raise InputError(str(path), "cannot be read as JSON", mend) from None


def write_json(path: Path, value: Any) -> None:
    """Write a value as JSON, whole or not at all.

    Raises:
        OSError: the file cannot be written.
    """
    write_atomically(path, (json.dumps(value, indent=2, allow_nan=False) + "\n").encode())


def save_json(path: str | Path, value: Any) -> None:
    """Write a value as JSON where a user wants it.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        write_json(Path(path), value)
    except OSError as error:
        raise InputError(str(path), f"cannot be written ({error.strerror})", "choose another place") from None


def _check_events(text: str, where: str) -> None:
    depth = 0
    for event in cast("Iterator[Any]", yaml.parse(text, _Loader)):
        if isinstance(event, yaml.AliasEvent):
            line = event.start_mark.line + 1
            raise InputError(where, f"not YAML that is read here: an alias (*) in line {line}", "write the value out")
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > DEEPEST:
            raise InputError(where, f"not YAML that is read here: nested deeper than {DEEPEST}", "mend the syntax")


def library_folder(room: str) -> Path:
    """Return the folder of the library files of a room, such as "vehicles"."""
    return Path(str(resources.files("bitepoint"))) / room


def library_names(room: str) -> list[str]:
    """Return the names of the library files of a room."""
    return sorted(path.stem for path in library_folder(room).glob("*.yaml"))


@cache
def library_yaml(room: str, file: str) -> dict[str, Any]:
    """Return the content of a library file."""
    return read_yaml(library_folder(room) / file)


def find(room: str, name: str, noun: str) -> Path:
    """Return the library file `name` of a room, or the file at the path `name`.

    Raises:
        InputError: neither is there.
    """
    if name in library_names(room):
        return library_folder(room) / f"{name}.yaml"
    path = Path(name)
    with contextlib.suppress(OSError, ValueError):  # a name that no file can have
        if path.suffix in (".yaml", ".yml") or path.exists():
            return path
    raise InputError(
        brief(name).strip("'"), f"no such {noun}", f"expected a YAML file or one of {', '.join(library_names(room))}"
    )
