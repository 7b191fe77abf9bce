"""The text, as a measurement and calibration tool takes it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bitepoint.assembly import CONTROLLERS, PLANTS, SUPERVISORS
from bitepoint.export.a2l import a2l_text, symbol_sizes
from bitepoint.export.a2l_syntax import display_format, identifier, number, quoted
from bitepoint.fields import Field
from bitepoint.kernels.c99 import FLOAT32, FLOAT64, PRECISIONS, Precision
from bitepoint.records import Record, RecordArray
from bitepoint.simulation.system import Part, argument_types
from bitepoint.units import display
from tests.conftest import Refused
from tests.export import mcd
from tests.export.parts import AWKWARD, CASES, PARTS, filled, leaves

each_case = pytest.mark.parametrize(("part", "precision"), CASES, ids=[f"{p.name}-{q.name}" for p, q in CASES])

START = 0x2000_0000
"""Where the made-up memory begins."""


class Target:
    """A part in memory: its records one after the other, filled with numbers, as C would hold them."""

    def __init__(self, part: Part, precision: Precision) -> None:
        self.precision = precision
        self.records: dict[str, tuple[type[Record], RecordArray]] = {}
        self.addresses: dict[str, int] = {}
        self.image = b""
        for symbol, (record, role) in zip(symbol_sizes(part, precision), argument_types(part).items(), strict=True):
            array = part.parameters[:1] if role == "parameters" else filled(record, len(self.image))
            self.records[symbol] = record, precision.convert(array, record)
            self.addresses[symbol] = START + len(self.image)
            self.image += self.records[symbol][1].tobytes()
            self.image += bytes(-len(self.image) % 64)
        self.parameters = next(iter(self.records))

    def expected(self) -> Iterator[tuple[str, Field, int, Any]]:
        """Yield path, field, address and value of everything that the text must describe."""
        for symbol, (record, array) in self.records.items():
            for path, field, view in leaves(array, record, symbol):
                address = self.addresses[symbol] + view.ctypes.data - array.ctypes.data
                if field.axes and symbol != self.parameters:
                    assert field.record is not None
                    axes = dict(zip("xyz", field.axes, strict=False))
                    for name, member in field.record.fields.items():
                        member = replace(member, meaning=field.meaning)
                        if name in axes:
                            axis = axes[name]
                            member = replace(member, unit=axis.unit, low=axis.low, high=axis.high)
                        place = address + view[name].ctypes.data - view.ctypes.data
                        yield f"{path}.{name}", member, place, view[name][0].tolist()
                else:
                    yield path, field, address, view[0] if field.axes else view[0].tolist()


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """(target, parsed text) of a part in a precision, with addresses."""
    found: dict[tuple[str, str], tuple[Target, mcd.Tree]] = {}

    def get(part: Part, precision: Precision) -> tuple[Target, mcd.Tree]:
        key = part.name, precision.name
        if key not in found:
            target = Target(part, precision)
            text = a2l_text(part, precision, target.addresses, meaning=AWKWARD)
            found[key] = target, mcd.parsed(text, tmp_path_factory.mktemp("a2l"))
        return found[key]

    return get


def test_every_controller_and_plant_is_tried() -> None:
    assert set(PARTS) == {*CONTROLLERS, *SUPERVISORS, *PLANTS, "made_up"}


def clipped(field: Any, precision: Precision) -> tuple[float, float]:
    return max(field.low, -precision.largest), min(field.high, precision.largest)


@each_case
def test_every_number_is_there_once_and_as_declared(part: Part, precision: Precision, described: Any) -> None:
    target, module = described(part, precision)
    assert len(module["characteristic"]) + len(module["measurement"]) == len(mcd.objects(module))
    left = mcd.objects(module)
    reals, integers = {4: ("Float32Ieee", "Slong"), 8: ("Float64Ieee", "AInt64")}[precision.size]
    for path, field, address, _ in target.expected():
        item = left.pop(path)
        symbol = path.partition(".")[0]
        assert mcd.address(item) == address, path
        link = {"symbol_name": symbol, "offset": address - target.addresses[symbol]}
        assert item["symbol_link"] == link, path
        value = field.axes[-1] if field.axes else field
        assert (item["lower_limit"], item["upper_limit"]) == clipped(value, precision), path
        assert mcd.unit(module, item["conversion"]) == display(value.unit).replace("²", "^2").replace("³", "^3"), path
        assert mcd.dimensions(item) == field.shape[::-1], path
        layout = mcd.by_name(module["record_layout"]).get(item.get("deposit", ""), {"fnc_values": item})
        assert layout["fnc_values"]["datatype"] == (integers if field.kind == "int" else reals), path
        for axis, wanted in zip(item.get("axis_descr", []), field.axes[:-1], strict=True):
            assert (axis["lower_limit"], axis["upper_limit"]) == clipped(wanted, precision), path
            assert mcd.unit(module, axis["conversion"]) == display(wanted.unit), path
            assert axis["max_axis_points"] == {2: 32, 3: 16}[len(field.axes)], path
    assert not left


@each_case
def test_memory_read_by_the_text_alone_is_the_records(part: Part, precision: Precision, described: Any) -> None:
    target, module = described(part, precision)
    memory = mcd.Memory(module, START, target.image)
    items = mcd.objects(module)
    calibrated = {item["name"] for item in module["characteristic"]}
    for path, field, _, value in target.expected():
        if field.kind == "map":
            rows, columns = int(value["x_points"]), int(value["y_points"])
            x, y, z = value["x"][:rows].tolist(), value["y"][:columns].tolist(), value["z"][:rows, :columns].tolist()
            assert memory.calibrated(items[path]) == (x, y, z), path
        elif field.kind == "curve":
            points = int(value["points"])
            expected = value["x"][:points].tolist(), value["y"][:points].tolist()
            assert memory.calibrated(items[path]) == expected, path
        elif path in calibrated:
            assert memory.calibrated(items[path]) == value, path
        else:
            assert memory.measured(items[path]) == value, path
        assert (path in calibrated) == path.startswith(f"{target.parameters}."), path


@each_case
def test_groups_are_a_tree_that_shows_every_object_once(part: Part, precision: Precision, described: Any) -> None:
    _, module = described(part, precision)
    groups = mcd.by_name(module["group"])
    (root,) = [group["name"] for group in module["group"] if group["root"] is not None]
    shown: list[str] = []
    open_groups = [root]
    while open_groups:
        group = groups.pop(open_groups.pop())
        for kind in ("ref_characteristic", "ref_measurement"):
            shown += group[kind]["identifier_list"] if group[kind] else []
        open_groups += group["sub_group"]["identifier_list"] if group["sub_group"] else []
    assert not groups
    assert sorted(shown) == sorted(mcd.objects(module))


def test_names_are_those_of_the_exported_c(described: Any) -> None:
    target, module = described(PARTS["launch_pid"], FLOAT64)
    assert list(target.records) == [
        "launch_pid_parameters", "launch_pid_state", "launch_pid_measurement", "launch_pid_command"
    ]  # fmt: skip
    items = mcd.objects(module)
    assert items["launch_pid_parameters.calibration.clutch_kp"]["long_identifier"].startswith("clutch torque per")
    assert "launch_pid_state.engine_speed.throttle" in items


@pytest.mark.parametrize(
    ("part", "table", "quantities"),
    [
        ("launch_pid", "launch_pid_parameters.calibration.clutch_torque", ["launch_pid_measurement.pedal"]),
        ("dct", "dct_parameters.engine.full_load", ["NO_INPUT_QUANTITY"]),
        ("made_up", "made_up_parameters.over_slip", ["made_up_inputs.slip"]),
        ("made_up", "made_up_parameters.over_speed", ["NO_INPUT_QUANTITY"]),
        ("made_up", "made_up_parameters.over_both", ["made_up_inputs.slip", "made_up_inputs.pedal"]),
        ("made_up", "made_up_parameters.slots[1].surface", ["made_up_inputs.pedal", "NO_INPUT_QUANTITY"]),
    ],
)
def test_axes_name_the_input_that_they_are_over(part: str, table: str, quantities: list[str], described: Any) -> None:
    _, module = described(PARTS[part], FLOAT32)
    axes = mcd.objects(module)[table]["axis_descr"]
    assert [axis["input_quantity"] for axis in axes] == quantities


@pytest.mark.parametrize(
    ("part", "name", "names"),
    [
        ("launch_pid", "launch_pid_state.phase", ["waiting", "slipping", "closing", "driving"]),
        ("launch_pid", "launch_pid_command.launch_phase", ["waiting", "slipping", "closing", "driving"]),
        ("launch_mpc", "launch_mpc_command.launch_phase", ["waiting", "slipping", "closing", "driving"]),
        ("excitation", "excitation_command.excitation_phase", ["waiting", "revving", "closing", "exciting"]),
    ],
)
def test_values_that_have_names_show_them(part: str, name: str, names: list[str], described: Any) -> None:
    _, module = described(PARTS[part], FLOAT64)
    item = mcd.objects(module)[name]
    assert mcd.states(module, item) == dict(enumerate(names))
    assert all(f"{n} {text}" in item["long_identifier"] for n, text in enumerate(names))


def test_no_other_value_has_names(described: Any) -> None:
    _, module = described(PARTS["made_up"], FLOAT64)
    assert [table["name"] for table in module["compu_vtab"]] == ["made_up_parameters.mode.states"]
    mode = mcd.objects(module)["made_up_parameters.mode"]
    assert mcd.states(module, mode) == {-1: "back", 0: "still", 1: "ahead"}


def test_awkward_meanings_become_one_line_of_ascii(described: Any) -> None:
    _, module = described(PARTS["made_up"], FLOAT64)
    plain = 'a "quoted" C:\\path, lambda = 5 um^2 at 20 degC - / * no comment * / / / no comment, >= 0 ...'
    items = mcd.objects(module)
    assert items["made_up_parameters.tiny"]["long_identifier"] == plain
    assert items["made_up_parameters.slots[1].weight"]["long_identifier"] == "weight of the slot"
    assert items["made_up_parameters.cube"]["long_identifier"] == ""
    assert module["long_identifier"] == plain


@pytest.mark.parametrize(
    "character", ['"', "\\", "\n", "\r", "\t", "\x00", "\x1b", "é", "Ω", "漢", "*/", "\u2028", '\\"']
)
@pytest.mark.parametrize("text", ["{}", "{}{}", "before {} after", "ends with {}"])
def test_any_text_can_be_quoted(character: str, text: str, tmp_path: Path) -> None:
    text = text.replace("{}", character)
    module = mcd.parsed(a2l_text(PARTS["none"], FLOAT64, meaning=text, version=text), tmp_path)
    unquoted = quoted(text)[1:-1].replace('\\"', '"').replace("\\\\", "\\")
    assert module["long_identifier"] == unquoted
    assert module["mod_par"]["version"]["version_identifier"] == unquoted
    assert unquoted.isprintable()


def test_version_and_period_are_told(tmp_path: Path) -> None:
    module = mcd.parsed(a2l_text(PARTS["launch_pid"], FLOAT32, version="0.1.0+abc"), tmp_path)
    assert module["mod_par"]["version"] == {"version_identifier": "0.1.0+abc"}
    assert module["mod_par"]["system_constant"] == [{"name": "LAUNCH_PID_PERIOD", "value": "0.01"}]


@pytest.mark.parametrize("precision", PRECISIONS.values(), ids=PRECISIONS)
def test_without_a_program_all_addresses_are_0_and_a_comment_says_so(precision: Precision, tmp_path: Path) -> None:
    part = PARTS["launch_pid"]
    text = a2l_text(part, precision)
    assert text.startswith("/* launch_pid in float")
    assert "NO ADDRESSES" in text.partition("*/")[0]
    assert "NO ADDRESSES" not in a2l_text(part, precision, Target(part, precision).addresses)
    assert {mcd.address(item) for item in mcd.objects(mcd.parsed(text, tmp_path)).values()} == {0}
    assert len(re.findall(r"\b0x\w+", text)) == 1 + len(mcd.objects(mcd.parsed(text, tmp_path)))


@pytest.mark.parametrize(
    "change", [None, -1, 2**32, 2**32 - 3], ids=["missing", "negative", "beyond", "across the end"]
)
def test_addresses_must_be_there_and_have_32_bits(change: int | None, refused: Refused) -> None:
    part = PARTS["launch_pid"]
    addresses = Target(part, FLOAT32).addresses
    del addresses["launch_pid_command"]
    if change is not None:
        addresses["launch_pid_command"] = change
    problem = "missing" if change is None else "32 bits"
    refused(lambda: a2l_text(part, FLOAT32, addresses), "addresses of launch_pid", "launch_pid_command", problem)


def test_numbers_read_back_and_formats_show_them() -> None:
    for value in (0.0, -0.0, 1.0, -2000.0, 0.1, 1e-6, 1e15, 1e300, FLOAT32.largest, -FLOAT64.largest, 1 / 3):
        assert float(number(value)) == value
    assert display_format(0, 1, whole=False) == '"%8.6"'
    assert display_format(-2000, 2000, whole=False) == '"%9.3"'
    assert display_format(1e-6, 0.002, whole=False) == '"%9.7"'
    assert display_format(0, 1e9, whole=False) == '"%14.3"'
    assert display_format(-1, 8, whole=True) == '"%2.0"'
    assert identifier("N*m*s^2/rad^2") == "N_m_s2_per_rad2"
    assert identifier("1/(kg*m^2)") == "1_per_kg_m2"
    assert np.isfinite(float(number(FLOAT64.largest)))
