"""What a measurement and calibration tool does with ASAP2 text: parse it strictly, and read memory by it alone.

The parser is a2ltool, a program of its own. It prints the structures that it has parsed; here they become dictionaries.
Nothing here knows how the text was made.
"""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Tree = dict[str, Any]

TYPES = {"Slong": "<i4", "AInt64": "<i8", "Float32Ieee": "<f4", "Float64Ieee": "<f8"}
ALIGNMENTS = {"Slong": "long", "AInt64": "int64", "Float32Ieee": "float32_ieee", "Float64Ieee": "float64_ieee"}

_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|(?<![\w.])[A-Za-z_]\w*(?P<opens> (?={)|(?=\())?(?P<key>:)?')


def a2ltool(*arguments: str | Path) -> str:
    """Run a2ltool, which must succeed; return what it printed."""
    program = shutil.which("a2ltool", path=sysconfig.get_path("scripts"))
    if program is None:
        pytest.skip("a2ltool is not installed: it has no wheel for this machine")
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout[-2000:] + done.stderr
    return done.stdout


def parsed(text: str, folder: Path) -> Tree:
    """Return the one module of an ASAP2 text, which must pass strict parsing and all checks without a word."""
    file = folder / "parsed.a2l"
    file.write_text(text, "ascii")
    assert a2ltool("--strict", "--check", file) == "Consistency check complete. No problems found.\n"
    printed = a2ltool("--strict", "--debug-print", file)
    literal = _WORD.sub(_as_python, printed[printed.index("A2lFile {") :].rstrip("=\n"))
    tree = _plain(ast.literal_eval(literal))
    assert tree["asap2_version"] == {"version_no": 1, "upgrade_no": 70}
    (module,) = tree["project"]["module"]
    assert module["name"] == tree["project"]["name"]
    return module


def _as_python(match: re.Match[str]) -> str:
    word = match[0]
    if word.startswith('"') or word == "None":
        return word
    if match["opens"] is not None:  # the name of a structure, or Some
        return ""
    return f'"{word[:-1]}":' if match["key"] else f'"{word}"'


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):  # Some(value)
        return _plain(value[0])
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return _plain(value["items"]) if set(value) == {"items", "map"} else {k: _plain(v) for k, v in value.items()}
    return value


def by_name(items: list[Tree]) -> dict[str, Tree]:
    """Return blocks by their names, which must differ."""
    found = {item["name"]: item for item in items}
    assert len(found) == len(items)
    return found


def objects(module: Tree) -> dict[str, Tree]:
    """Return all CHARACTERISTIC and MEASUREMENT blocks by name."""
    return by_name([*module["characteristic"], *module["measurement"]])


def address(item: Tree) -> int:
    """Return where an object lies."""
    return item["address"] if "address" in item else item["ecu_address"]["address"]


def unit(module: Tree, conversion: str) -> str:
    """Return the unit that a conversion shows."""
    return by_name(module["compu_method"])[conversion]["unit"]


def states(module: Tree, item: Tree) -> dict[int, str]:
    """Return the names that an object shows in the place of its values."""
    method = by_name(module["compu_method"])[item["conversion"]]
    assert method["conversion_type"] == "TabVerb"
    table = by_name(module["compu_vtab"])[method["compu_tab_ref"]["conversion_table"]]
    assert table["number_value_pairs"] == len(table["value_pairs"])
    return {int(pair["in_val"]): pair["out_val"] for pair in table["value_pairs"]}


def dimensions(item: Tree) -> tuple[int, ...]:
    """Return the dimensions of an array, x first; () for a single number."""
    return tuple(item["matrix_dim"]["dim_list"]) if item["matrix_dim"] else ()


class Memory:
    """Memory of an ECU as an image of bytes that begins at an address."""

    def __init__(self, module: Tree, start: int, image: bytes) -> None:
        self.module, self.start, self.image = module, start, image
        self.layouts = by_name(module["record_layout"])
        assert module["mod_common"]["byte_order"]["byte_order"] == "MsbLast"
        assert module["mod_common"]["deposit"]["mode"] == "Absolute"

    def numbers(self, place: int, datatype: str, count: int = 1) -> list[Any]:
        """Return numbers at an address, which must be aligned."""
        assert place % self.module["mod_common"][f"alignment_{ALIGNMENTS[datatype]}"]["alignment_border"] == 0
        return np.frombuffer(self.image, TYPES[datatype], count, place - self.start).tolist()

    def measured(self, measurement: Tree) -> Any:
        """Return the value of a MEASUREMENT: a number, or lists with x innermost."""
        sizes = dimensions(measurement)
        values = self.numbers(address(measurement), measurement["datatype"], int(np.prod(sizes, dtype=int)))
        assert len(sizes) < 2 or measurement["layout"]["index_mode"] == "RowDir"
        return np.array(values).reshape(sizes[::-1]).tolist()

    def calibrated(self, characteristic: Tree) -> Any:
        """Return the value of a CHARACTERISTIC: a number, lists with x innermost, (x, y) of a curve, or a map.

        Of a map it is (x, y, z) with a row of z for each x. Its x counts the columns: ROW_DIR has x run fastest, as in
        a table whose rows are y, COLUMN_DIR has y run fastest. A static layout leaves gaps of the points not in use.
        """
        layout = self.layouts[characteristic["deposit"]]
        values = layout["fnc_values"]
        if characteristic["characteristic_type"] == "Curve":
            found = dict(self._components(characteristic, layout))
            points = found["no_axis_pts_x"][0]
            return found["axis_pts_x"][:points], found["fnc_values"][:points]
        if characteristic["characteristic_type"] == "Map":
            found = dict(self._components(characteristic, layout))
            x, y = (found[f"axis_pts_{name}"][: found[f"no_axis_pts_{name}"][0]] for name in "xy")
            most_x, most_y = (axis["max_axis_points"] for axis in characteristic["axis_descr"])
            strides = {"RowDir": (1, most_x), "ColumnDir": (most_y, 1)}[values["index_mode"]]
            z = [[found["fnc_values"][i * strides[0] + j * strides[1]] for j in range(len(y))] for i in range(len(x))]
            return x, y, z
        assert values["position"] == 1
        assert (characteristic["characteristic_type"] == "ValBlk") == bool(dimensions(characteristic))
        assert (values["index_mode"], values["address_type"]) == ("RowDir", "Direct")
        numbers = self.numbers(address(characteristic), values["datatype"], int(np.prod(dimensions(characteristic))))
        return np.array(numbers).reshape(dimensions(characteristic)[::-1]).tolist()

    def _components(self, table: Tree, layout: Tree) -> Iterator[tuple[str, list[Any]]]:
        """Yield what a record layout puts one after the other, each with its room for the most axis points."""
        axes = table["axis_descr"]
        assert {axis["attribute"] for axis in axes} == {"StdAxis"}
        assert layout["static_record_layout"] is not None
        room = {f"axis_pts_{name}": axis["max_axis_points"] for name, axis in zip("xy", axes, strict=False)}
        room["fnc_values"] = int(np.prod(list(room.values())))
        names = [name for name, item in layout.items() if isinstance(item, dict) and "position" in item]
        assert set(names) == {*room, *(f"no_{name}" for name in room if name != "fnc_values")}
        assert sorted(layout[name]["position"] for name in names) == list(range(1, len(names) + 1))
        place = address(table)
        for name in sorted(names, key=lambda name: layout[name]["position"]):
            datatype = layout[name]["datatype"]
            count = room.get(name, 1)
            yield name, self.numbers(place, datatype, count)
            place += count * np.dtype(TYPES[datatype]).itemsize
