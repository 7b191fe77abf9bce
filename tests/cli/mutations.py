"""Broken vehicle files, made from a library vehicle so that every one of them is wrong in exactly one way.

The random choices come from a generator with a fixed seed: every run makes the same files.
"""

from __future__ import annotations

import copy
import datetime
import math
import random
from collections.abc import Callable, Iterator
from typing import Any

import yaml

from bitepoint.files import library_folder
from bitepoint.plants.dct import DctParameters
from bitepoint.records import Field

SEED = 20
TEXT = (library_folder("vehicles") / "dct-t240.yaml").read_text(encoding="utf-8")
DATA: dict[str, Any] = yaml.safe_load(TEXT)
BLOCKS = [key for key in DATA if key not in ("meaning", "plant")]
FIELDS = {path: field for path, field in DctParameters.table() if path.split(".")[0] in BLOCKS}
SCALARS = [path for path, field in FIELDS.items() if field.kind == "float" and not field.shape]
POSITIVE = [path for path in SCALARS if FIELDS[path].low >= 0.0]
REQUIRED = [path for path, field in FIELDS.items() if field.default is None]

Case = tuple[str, bytes]


def cases() -> list[Case]:
    """All broken files, each with a name that says what was done to it."""
    choose = random.Random(SEED)
    makers: list[Callable[[random.Random], Iterator[Case]]] = [
        _truncated, _missing, _unknown, _units, _numbers, _kinds, _blocks, _curves, _shapes, _plants, _texts, _bytes,
        _yaml, _contradictions,
    ]  # fmt: skip
    return [case for maker in makers for case in maker(choose)]


def written(data: object) -> bytes:
    """The YAML of a mapping."""
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True).encode()


def with_value(path: str, value: object) -> bytes:
    """The vehicle with one key set."""
    data = copy.deepcopy(DATA)
    *blocks, last = path.split(".")
    block = data
    for name in blocks:
        block = block[name]
    block[last] = value
    return written(data)


def without(path: str) -> bytes:
    """The vehicle with one key or block taken out."""
    data = copy.deepcopy(DATA)
    *blocks, last = path.split(".")
    block = data
    for name in blocks:
        block = block[name]
    del block[last]
    return written(data)


def replaced(old: str, new: str) -> bytes:
    """The text of the vehicle with one piece exchanged, which must be there once."""
    assert TEXT.count(old) == 1, old
    return TEXT.replace(old, new).encode()


def _truncated(choose: random.Random) -> Iterator[Case]:
    last_block = TEXT.index("halfshaft:")  # what ends before it lacks a required block
    for place in sorted(choose.sample(range(1, last_block), 10)):
        yield f"cut after {place} characters", TEXT[:place].encode()


def _missing(choose: random.Random) -> Iterator[Case]:
    for path in choose.sample(REQUIRED, 8):
        yield f"without {path}", without(path)
    for block in choose.sample(BLOCKS, 3):
        yield f"without block {block}", without(block)


def _unknown(choose: random.Random) -> Iterator[Case]:
    for path in choose.sample(SCALARS, 4):
        yield f"unknown key {path}s", with_value(f"{path}s", 1)
    yield "unknown key in a curve", with_value("engine.full_load.power", [1, 2])
    yield "unknown block", with_value("chassis", {"mass": 1600})
    yield "number as a key", with_value("engine", {**DATA["engine"], 3: 4})


def _units(choose: random.Random) -> Iterator[Case]:
    for unit in ("mol", "cd*m", "K/s", "pears", "N*m*pears", "kg^", "(", "$"):
        path = choose.choice(SCALARS)
        yield f"unit {unit} for {path}", with_value(path, f"1 {unit}")
    yield "unit mol for a curve", with_value("engine.full_load.speed.unit", "mol")


def _numbers(choose: random.Random) -> Iterator[Case]:
    for value in (math.nan, math.inf, -math.inf, "nan", "1e400", "-1e400 kg", 10**400, "1,5 kg", "twelve", ""):
        path = choose.choice(SCALARS)
        yield f"{str(value)[:8]} for {path}", with_value(path, value)
    for path in choose.sample(POSITIVE, 4):
        yield f"negative {path}", with_value(path, -1)
    for path in choose.sample(SCALARS, 4):
        yield f"{path} above its range", with_value(path, _above(FIELDS[path]))
    yield "NaN in an array", with_value("gearbox.ratios", [3.2, math.nan])
    yield "half a gear", with_value("gearbox.gear", 1.5)


def _above(field: Field) -> float:
    return field.high * 1.001


def _kinds(choose: random.Random) -> Iterator[Case]:
    odd: list[object] = [[1600], [], {"value": 1600}, {}, None, True, False, "~", datetime.date(2024, 1, 1), b"\x00"]
    for value in odd:
        path = choose.choice(SCALARS)
        yield f"{type(value).__name__} for {path}", with_value(path, value)


def _blocks(choose: random.Random) -> Iterator[Case]:
    for value in (5, "heavy", None, [1, 2], True):
        block = choose.choice(BLOCKS)
        yield f"{value} for block {block}", with_value(block, value)


def _curves(choose: random.Random) -> Iterator[Case]:
    points: list[tuple[str, object, object]] = [
        ("unsorted curve", [0, 300, 200], [0, 1, 2]),
        ("repeated point", [0, 200, 200], [0, 1, 2]),
        ("one point", [0], [0]),
        ("no point", [], []),
        ("curve of two lengths", [0, 100, 200], [0, 1]),
        ("too many points", [*range(33)], [*range(33)]),
        ("text in a curve", [0, "fast"], [0, 1]),
        ("list in a curve", [0, [100]], [0, 1]),
        ("curve beyond its range", [0, 1501], [0, 1]),
        ("scalar for an axis", 100, [0, 1]),
    ]
    for name, speed, torque in points:
        yield name, with_value("engine.full_load", {"speed": speed, "torque": torque})
    yield "curve without an axis", without("engine.full_load.torque")
    yield "axis without values", without("engine.full_load.speed.values")


def _shapes(choose: random.Random) -> Iterator[Case]:
    wrong: list[object] = [3.2, "3.2, 1.7", [], [1.0] * 9, [[3.2, 1.7]], [3.2, [1.7]], {"values": [3.2]}, None]
    for value in wrong:
        yield f"{str(value)[:12]} for ratios", with_value("gearbox.ratios", value)


def _plants(choose: random.Random) -> Iterator[Case]:
    for value in ("boat", "", 3, None, ["dct"], "DCT"):
        yield f"plant {value}", with_value("plant", value)
    yield "no plant", without("plant")


def _texts(choose: random.Random) -> Iterator[Case]:
    yield "empty", b""
    yield "blank", b"  \n\n \n"
    yield "comment only", b"# a vehicle\n"
    yield "list at the top", written([DATA])
    yield "text at the top", b"dct\n"
    yield "two documents", TEXT.encode() + b"---\n" + TEXT.encode()
    yield "tabs", TEXT.replace("\n  ", "\n\t").encode()
    yield "one tab", replaced("  mass:", "\tmass:")
    yield "wrong indent", replaced("  mass:", " mass:")
    yield "unclosed list", replaced("0.6894]", "0.6894")
    yield "unclosed quote", replaced("mass: 1600 kg", "mass: '1600 kg")
    yield "two colons", replaced("mass: 1600 kg", "mass: 1600: kg")
    yield "key given twice", replaced("  mass: 1600 kg\n", "  mass: 1600 kg\n  mass: 1600 kg\n")
    yield "block given twice", TEXT.encode() + b"clutch: {}\n"


def _bytes(choose: random.Random) -> Iterator[Case]:
    yield "random bytes", b"\xff" + choose.randbytes(2000)
    yield "zero bytes", bytes(100)
    yield "Latin-1", replaced("compact car", "compact \u00e9").decode().encode("latin-1")
    yield "UTF-16", TEXT.encode("utf-16")
    yield "a picture", b"\x89PNG\r\n\x1a\n" + choose.randbytes(200)


def _yaml(choose: random.Random) -> Iterator[Case]:
    yield "alias to nowhere", replaced("1600 kg", "*mass")
    yield "alias to itself", replaced("1600 kg", "&mass [*mass]")
    yield "tag of Python", replaced("1600 kg", "!!python/object/apply:os.getcwd []")
    yield "unknown tag", replaced("1600 kg", "!weight 1600")
    yield "empty float", replaced("1600 kg", '!!float ""')
    yield "odd bool", replaced("1600 kg", "!!bool heavy")
    yield "list as a key", replaced("  mass: 1600 kg", "  mass: 1600 kg\n  ? [a, b]\n  : 1")
    yield "deep lists", replaced("1600 kg", "[" * 5000 + "]" * 5000)
    yield "deep blocks", replaced("1600 kg", "{a: " * 600 + "1" + "}" * 600)
    yield "lists of aliases", replaced("1600 kg", bomb(4))
    yield "blocks of aliases", replaced("1600 kg", bomb(4, "{{k: [{}]}}"))
    yield "lists of aliases for ratios", replaced("[3.2562, 1.7064, 1.2301, 0.8988, 0.6894]", bomb(4))
    yield "merge of a list", replaced("  mass: 1600 kg", "  <<: [1, 2]\n  mass: 1600 kg")


def bomb(levels: int, layer: str = "[{}]", core: str = "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0]") -> str:
    """YAML that stands for ten times as much on every level, by aliases to the level below."""
    text = core
    for level in range(1, levels):
        text = layer.format(f"&a{level} {text}" + f", *a{level}" * 9)
    return text


def _contradictions(choose: random.Random) -> Iterator[Case]:
    yield "gear without a ratio", with_value("gearbox.gear", 6)
    yield "first gear without a ratio", with_value("gearbox.ratios", [0, 1.7])
    yield "idle above the speed limit", with_value("engine", {**DATA["engine"], "idle_speed": 250, "speed_limit": 200})
