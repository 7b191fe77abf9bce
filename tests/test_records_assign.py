"""Setting one field of records that are there: all lanes at once, one value per lane, or not at all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bitepoint.records import (
    Curve,
    FloatArray,
    Map,
    Record,
    RecordArray,
    characteristic_map,
    count,
    curve,
    nested,
    quantity,
)
from tests.conftest import Refused


class Inner(Record):
    """A nested record."""

    gain: float = quantity("1", 0, 10, "gain", default=1.0)
    mode: int = count(0, 3, "mode", default=0)


class Outer(Record):
    """A record with one field of each kind that can be set."""

    mass: float = quantity("kg", 0, 5000, "mass", default=1000)
    row: FloatArray = quantity("m", 0, 10, "row", shape=(3,))
    inner: Inner = nested(Inner, "inner")
    load: Curve = curve(("x", "s", 0, 10), ("y", "m", 0, 10), "load")
    fuel: Map = characteristic_map(("x", "s", 0, 10), ("y", "m", 0, 10), ("z", "kg", 0, 10), "fuel")


@pytest.fixture
def lanes() -> RecordArray:
    """Three equal records."""
    data = {
        "row": [1, 2, 3],
        "load": {"x": [0, 1], "y": [0, 1]},
        "fuel": {"x": [0, 1], "y": [0, 1], "z": [[0, 1], [2, 3]]},
    }
    return np.repeat(Outer.parse(data, "f"), 3)


@pytest.mark.parametrize("value", [1600, 1600.0, "1600 kg", "1.6 t", np.float64(1600)])
def test_one_value_goes_to_every_lane(lanes: RecordArray, value: object) -> None:
    Outer.assign(lanes, "mass", value, "--set")
    assert lanes["mass"].tolist() == [1600.0] * 3


@pytest.mark.parametrize("values", [[1, "2 t", 3], (1, "2 t", 3), np.array([1.0, 2000.0, 3.0])])
def test_a_sequence_is_one_value_per_lane(lanes: RecordArray, values: object) -> None:
    Outer.assign(lanes, "mass", values, "over")
    assert lanes["mass"].tolist() == [1.0, 2000.0, 3.0]


def test_a_nested_number_is_set_by_its_dotted_key(lanes: RecordArray) -> None:
    Outer.assign(lanes, "inner.gain", [1, 2, 3], "over")
    Outer.assign(lanes, "inner.mode", 2, "over")
    assert lanes["inner"].tolist() == [(1.0, 2), (2.0, 2), (3.0, 2)]


def test_a_list_for_an_array_goes_to_every_lane(lanes: RecordArray) -> None:
    Outer.assign(lanes, "row", [4, "500 cm", 6], "--set")
    assert lanes["row"].tolist() == [[4.0, 5.0, 6.0]] * 3


def test_curves_maps_and_blocks_are_set_whole(lanes: RecordArray) -> None:
    Outer.assign(lanes, "load", {"x": [0, 1, 2], "y": [0, 3, 9]}, "--set")
    Outer.assign(lanes, "fuel", {"x": [0, 1], "y": [0, 1, 2], "z": [[1, 2, 3], [4, "5000 g", 6]]}, "--set")
    Outer.assign(lanes, "inner", {"gain": "50 %"}, "--set")
    assert lanes["load"]["points"].tolist() == [3] * 3
    assert lanes["load"]["y"][:, :3].tolist() == [[0.0, 3.0, 9.0]] * 3
    assert lanes["fuel"]["y_points"].tolist() == [3] * 3
    assert lanes["fuel"]["z"][:, :2, :3].tolist() == [[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]] * 3
    assert lanes["inner"].tolist() == [(0.5, 0)] * 3


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("mas", 1, ["mas: unknown key", "mass, row, inner, load, fuel"]),
        ("inner.gan", 1, ["gan: unknown key", "gain, mode"]),
        ("", 1, ["unknown key"]),
        ("inner.", 1, ["inner"]),
        ("mass.x", 1, ["mass.x: mass has no keys of its own", "expected a number in 0..5000 kg"]),
        ("load.x", [0, 1], ["load.x: load has no keys of its own", "expected a block with x (s) and y (m)"]),
        ("fuel.z", [[0]], ["fuel.z: fuel has no keys of its own", "a block with x (s), y (m) and z (kg)"]),
        ("fuel", {"x": [0, 1], "y": [0, 1], "z": [[0, 1], [2, 11]]}, ["fuel.z[1]: got 11", "0..10 kg"]),
        ("mass", [1, 2], ["mass: got 2 values", "expected 3 values, one per lane"]),
        ("mass", [1, 2, 3, 4], ["mass: got 4 values", "expected 3 values, one per lane"]),
        ("mass", [], ["mass: got 0 values", "expected 3 values, one per lane"]),
        ("mass", [1, 2, 5001], ["mass: got 5001", "0..5000 kg"]),
        ("mass", [1, 2, np.nan], ["mass: got nan", "0..5000 kg"]),
        ("mass", "5 s", ["mass: got unit 's'", "0..5000 kg"]),
        ("inner.mode", [0, 1, 1.5], ["inner.mode: got 1.5", "a whole number in 0..3"]),
        ("inner", 5, ["inner: got 5", "expected a block of keys"]),
        ("inner", {"gain": 5, "mode": 4}, ["inner.mode: got 4", "a whole number in 0..3"]),
        ("row", [1, 2, 11], ["row: got", "11", "0..10 m"]),
        ("row", [1, 2], ["row: got 2 values", "3 times"]),
        ("load", {"x": [1, 0], "y": [0, 1]}, ["load.x: not strictly increasing"]),
    ],
)
def test_what_is_refused_changes_nothing(
    lanes: RecordArray, key: str, value: Any, said: list[str], refused: Refused
) -> None:
    before = lanes.tobytes()
    refused(lambda: Outer.assign(lanes, key, value, "--set"), "--set: ", *said)
    assert lanes.tobytes() == before


def test_an_unknown_nested_key_is_named_in_full(lanes: RecordArray, refused: Refused) -> None:
    refused(lambda: Outer.assign(lanes, "inner.gan", 1, "--set"), "--set: inner.gan: unknown key")


def test_locate_gives_a_view(lanes: RecordArray) -> None:
    field, view = Outer.locate(lanes, "inner.gain", "f")
    view[1] = 7.0
    assert (field.name, field.high) == ("gain", 10)
    assert lanes["inner"]["gain"].tolist() == [1.0, 7.0, 1.0]
