"""One declaration gives layout, validation and documentation; whatever a record does not take is named in one line."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.errors import InputError
from bitepoint.records import (
    CURVE_POINTS,
    MAP_POINTS,
    Curve,
    Field,
    FloatArray,
    IntArray,
    Map,
    Record,
    RecordElements,
    characteristic_map,
    count,
    curve,
    nested,
    quantity,
)
from tests.conftest import Refused

_TORQUE = ("torque", "N*m", -50, 900)


class Shaft(Record):
    """A nested record."""

    stiffness: float = quantity("N*m/rad", 1, 1e7, "torque per twist")
    damping: float = quantity("N*m*s/rad", 0, 1e5, "torque per twisting speed", default=13.6)


class Extras(Record):
    """A nested record that a file may leave out."""

    scale: float = quantity("1", 0.5, 2, "scale", default=1.0)
    gear: int = count(1, 8, "gear", default=1)


class Car(Record):
    """One field of each kind."""

    mass: float = quantity("kg", 100, 60_000, "mass of the loaded vehicle")
    slip: float = quantity("rad/s", -2000, 2000, "slip at the start", default=-5.0)
    efficiency: float = quantity("1", 0, 1, "efficiency")
    seats: int = count(1, 9, "seats")
    switches: IntArray = count(0, 1, "switches", shape=(2,))
    weights: FloatArray = quantity("kg", 0, 100, "weights", shape=(2, 3))
    speeds: FloatArray = quantity("rad/s", 0, 1000, "speeds", shape=(3,))
    ratios: FloatArray = quantity("1", 0, 50, "gear ratios", shape=(4,), padded=True)
    full_load: Curve = curve(("speed", "rad/s", 0, 1200), _TORQUE, "full-load torque")
    fuel: Map = characteristic_map(("speed", "rad/s", 0, 1200), _TORQUE, ("flow", "kg/s", 0, 0.1), "fuel flow")
    shaft: Shaft = nested(Shaft, "the shaft")
    extras: Extras = nested(Extras, "what can be left out")


class Fleet(Record):
    """Records inside a record that no file gives."""

    tick: int = count(0, 100, "tick")
    cars: RecordElements[Shaft] = nested(Shaft, "shafts", shape=(3,))


GOOD: dict[str, Any] = {
    "mass": "1.6 t",
    "slip": "-60 rpm",
    "efficiency": "93 %",
    "seats": 5,
    "switches": [0, 1],
    "weights": [[1, "2000 g", 3], [4.0, 5, 6]],
    "speeds": {"unit": "rpm", "values": [60, 120, "10 rad/s"]},
    "ratios": [3.2, 1.7],
    "full_load": {"speed": {"unit": "rpm", "values": [0, 60, 120]}, "torque": [-1, "0.1 kN*m", 2.5]},
    "fuel": {
        "speed": {"unit": "rpm", "values": [60, 120, 180]},
        "torque": [-50, "0.9 kN*m"],
        "flow": {"unit": "g/s", "values": [[0, 10], ["0.02 kg/s", 30], [40, 50]]},
    },
    "shaft": {"stiffness": 4000},
}

MISSING = object()


def changed(key: str, value: object) -> dict[str, Any]:
    """The good mapping with one key, dotted where it is nested, set or taken out."""
    data = copy.deepcopy(GOOD)
    *blocks, last = key.split(".")
    block = data
    for name in blocks:
        block = block[name]
    if value is MISSING:
        del block[last]
    else:
        block[last] = value
    return data


def test_every_unit_and_default_arrives_in_si() -> None:
    (car,) = Car.parse(GOOD, "car.yaml")
    assert car["mass"] == 1600.0
    assert car["slip"] == pytest.approx(-2 * math.pi, rel=1e-15)
    assert (car["efficiency"], car["seats"]) == (0.93, 5)
    assert car["switches"].tolist() == [0, 1]
    assert car["weights"].tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    assert car["speeds"] == pytest.approx([2 * math.pi, 4 * math.pi, 10.0], rel=1e-15)
    assert car["ratios"].tolist() == [3.2, 1.7, 0.0, 0.0]
    assert car["shaft"].tolist() == (4000.0, 13.6)
    assert car["extras"].tolist() == (1.0, 1)


def test_a_curve_keeps_its_points_and_repeats_the_last() -> None:
    load = Car.parse(GOOD, "car.yaml")["full_load"][0]
    assert load["points"] == 3
    assert load["x"] == pytest.approx([0.0, 2 * math.pi] + [4 * math.pi] * (CURVE_POINTS - 2), rel=1e-15)
    assert load["y"].tolist() == [-1.0, 100.0] + [2.5] * (CURVE_POINTS - 2)


def test_a_map_keeps_a_row_for_each_x_and_repeats_the_last() -> None:
    fuel = Car.parse(GOOD, "car.yaml")["fuel"][0]
    assert (fuel["x_points"], fuel["y_points"]) == (3, 2)
    assert fuel["x"] == pytest.approx([2 * math.pi, 4 * math.pi] + [6 * math.pi] * (MAP_POINTS - 2), rel=1e-15)
    assert fuel["y"].tolist() == [-50.0] + [900.0] * (MAP_POINTS - 1)
    first, second, *others = fuel["z"]
    assert first == pytest.approx([0.0] + [0.01] * (MAP_POINTS - 1), rel=1e-15)
    assert second == pytest.approx([0.02] + [0.03] * (MAP_POINTS - 1), rel=1e-15)
    assert len(others) == MAP_POINTS - 2
    for row in others:
        assert row == pytest.approx([0.04] + [0.05] * (MAP_POINTS - 1), rel=1e-15)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_numbers_of_numpy_are_numbers(kind: Any) -> None:
    (car,) = Car.parse(changed("mass", kind(1600)), "f")
    assert car["mass"] == 1600.0


@pytest.mark.parametrize("kind", [np.float64, np.int64, str])
@pytest.mark.parametrize("unit", ["rpm", "rad/s"])
def test_the_unit_of_a_list_holds_for_its_numbers_of_any_kind(kind: Any, unit: str) -> None:
    block = {"unit": unit, "values": [kind(60), kind(120), kind(180)]}
    (car,) = Car.parse(changed("speeds", block), "f")
    factor = 2 * math.pi / 60 if unit == "rpm" else 1.0
    assert car["speeds"] == pytest.approx(np.array([60, 120, 180]) * factor, rel=1e-15)


def test_arrays_of_numpy_are_lists() -> None:
    (car,) = Car.parse(changed("weights", np.arange(6.0).reshape(2, 3)), "f")
    assert car["weights"].tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]


RANGE_OF_MASS = "expected a number in 100..60000 kg"
RANGE_OF_RATIOS = "expected up to 4 times a number in 0..50"


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("masss", 5, ["masss: unknown key", "expected one of mass, slip, efficiency"]),
        ("shaft.stifness", 5, ["shaft.stifness: unknown key", "stiffness, damping"]),
        ("full_load.power", [1, 2], ["full_load.power: unknown key", "speed and torque"]),
        ("mass", MISSING, ["mass: missing", RANGE_OF_MASS]),
        ("shaft", MISSING, ["shaft: missing", "expected a block of keys"]),
        ("shaft.stiffness", MISSING, ["shaft.stiffness: missing", "1..1e+07 N m/rad"]),
        ("full_load", MISSING, ["full_load: missing", "speed (rad/s) and torque (N*m)"]),
        ("full_load.torque", MISSING, ["full_load.torque: missing", "speed (rad/s) and torque (N*m)"]),
        ("ratios", MISSING, ["ratios: missing", RANGE_OF_RATIOS]),
        ("mass", "5 s", ["mass: got unit 's' of another dimension", RANGE_OF_MASS]),
        ("mass", "1600 kgs", ["mass: got unknown unit 'kgs'", RANGE_OF_MASS]),
        ("efficiency", "5 deg", ["efficiency: got an angle, '5 deg'", "expected a number in 0..1"]),
        ("shaft.stiffness", "5 N", ["shaft.stiffness: got unit 'N' of another dimension"]),
        ("mass", 99.999, ["mass: got 99.999", RANGE_OF_MASS]),
        ("mass", "61 t", ["mass: got '61 t'", RANGE_OF_MASS]),
        ("mass", -1, ["mass: got -1", RANGE_OF_MASS]),
        ("efficiency", "101 %", ["efficiency: got '101 %'", "0..1"]),
        ("mass", math.nan, ["mass: got nan", RANGE_OF_MASS]),
        ("mass", math.inf, ["mass: got inf", RANGE_OF_MASS]),
        ("slip", -math.inf, ["slip: got -inf", "-2000..2000 rad/s"]),
        ("mass", "nan", ["mass: got 'nan'", RANGE_OF_MASS]),
        ("mass", "1e400 kg", ["mass: got '1e400 kg'", RANGE_OF_MASS]),
        ("mass", 10**400, ["mass: got 1000", "...", RANGE_OF_MASS]),
        ("mass", True, ["mass: got True", RANGE_OF_MASS]),
        ("mass", np.True_, ["mass: got True", RANGE_OF_MASS]),
        ("mass", None, ["mass: got nothing", RANGE_OF_MASS]),
        ("mass", [1600], ["mass: got [1600]", RANGE_OF_MASS]),
        ("mass", {"a": 1}, ["mass: got {'a': 1}", RANGE_OF_MASS]),
        ("mass", "heavy", ["mass: got 'heavy'", RANGE_OF_MASS]),
        ("seats", 2.5, ["seats: got 2.5", "expected a whole number in 1..9"]),
        ("seats", 0, ["seats: got 0", "expected a whole number in 1..9"]),
        ("seats", "5 kg", ["seats: got unit 'kg'", "expected a whole number in 1..9"]),
        ("seats", True, ["seats: got True", "expected a whole number in 1..9"]),
        ("seats", math.nan, ["seats: got nan", "expected a whole number in 1..9"]),
        ("switches", [0, 2], ["switches: got 2", "expected 2 times a whole number in 0..1"]),
        ("switches", [0, 0.5], ["switches: got", "0.5", "expected 2 times a whole number in 0..1"]),
        ("weights", [[1, 2], [3, 4]], ["weights[0]: got 2 values", "expected 2 x 3 times a number in 0..100 kg"]),
        ("weights", [1, 2, 3], ["weights: got 3 values", "2 x 3 times"]),
        ("weights", [[1, 2, 3], [4, 5]], ["weights[1]: got 2 values", "2 x 3 times"]),
        ("weights", [[1, 2, 3], [4, 5, "101 kg"]], ["weights[1]: got '101 kg'", "0..100 kg"]),
        ("speeds", [1, 2], ["speeds: got 2 values", "expected 3 times a number in 0..1000 rad/s"]),
        ("speeds", [1, 2, math.nan], ["speeds: got", "nan", "3 times a number"]),
        ("speeds", [1, 2, None], ["speeds: got nothing", "3 times a number"]),
        ("speeds", [1, 2, True], ["speeds: got True", "3 times a number"]),
        ("speeds", 5, ["speeds: got 5", "3 times a number", "as a list or {unit: ..., values: [...]}"]),
        ("speeds", "1, 2, 3", ["speeds: got '1, 2, 3'", "as a list"]),
        ("speeds", {"unit": "rpm"}, ["speeds: got keys unit", "expected unit and values"]),
        ("speeds", {}, ["speeds: got keys none", "expected unit and values"]),
        ("speeds", {"unit": "rpm", "value": [1, 2, 3]}, ["speeds: got keys unit, value", "expected unit and values"]),
        ("speeds", {"unit": "rpm", "values": [1, 2, 3], "offset": 0}, ["speeds: got keys unit, values, offset"]),
        ("speeds", {"unit": "kg", "values": [1, 2, 3]}, ["speeds: got unit 'kg' of another dimension"]),
        ("speeds", {"unit": None, "values": [1, 2, 3]}, ["speeds: got unknown unit 'None'"]),
        ("ratios", [1, 2, 3, 4, 5], ["ratios: got 5 values", RANGE_OF_RATIOS]),
        ("ratios", [], ["ratios: got 0 values", RANGE_OF_RATIOS]),
        ("ratios", [1, [2]], ["ratios: got", "[2]", RANGE_OF_RATIOS]),
        ("ratios", [1, "51"], ["ratios: got '51", RANGE_OF_RATIOS]),
        ("full_load", 5, ["full_load: got 5", "expected a block with speed (rad/s) and torque (N*m)"]),
        ("full_load", None, ["full_load: got nothing", "expected a block with speed"]),
        ("full_load", [1, 2], ["full_load: got [1, 2]", "expected a block with speed"]),
        ("full_load.speed", 5, ["full_load.speed: got 5", "a number in 0..1200 rad/s", "as a list"]),
        ("full_load.speed", [0, 1], ["full_load.torque: got 3 values", "2 times a number in -50..900 N m"]),
        ("full_load", {"speed": [0], "torque": [0]}, ["full_load.speed: got 1 points", "expected 2 to 32"]),
        (
            "full_load",
            {"speed": [*range(33)], "torque": [*range(33)]},
            ["full_load.speed: got 33 points", "expected 2 to 32"],
        ),
        ("full_load.speed", [0, 2, 1], ["full_load.speed: not strictly increasing", "sort the points"]),
        ("full_load.speed", [0, 1, 1], ["full_load.speed: not strictly increasing", "remove repeated ones"]),
        ("full_load.speed", [0, 1, math.nan], ["full_load.speed: got", "nan", "0..1200 rad/s"]),
        ("full_load.speed", [0, 1, 1201], ["full_load.speed: got", "1201", "0..1200 rad/s"]),
        ("full_load.torque", [0, 1, "2 kg"], ["full_load.torque: got unit 'kg'", "-50..900 N m"]),
        ("fuel", MISSING, ["fuel: missing", "speed (rad/s), torque (N*m) and flow (kg/s)"]),
        ("fuel", 5, ["fuel: got 5", "expected a block with speed (rad/s), torque"]),
        ("fuel.flow", MISSING, ["fuel.flow: missing", "torque (N*m) and flow (kg/s)"]),
        ("fuel.power", [1, 2], ["fuel.power: unknown key", "expected speed, torque and flow"]),
        ("fuel.speed", [1], ["fuel.speed: got 1 points", "expected 2 to 16"]),
        ("fuel.torque", [*range(17)], ["fuel.torque: got 17 points", "expected 2 to 16"]),
        ("fuel.torque", [5, 5], ["fuel.torque: not strictly increasing", "sort the points"]),
        ("fuel.speed", [0, 1, 1201], ["fuel.speed: got 1201", "0..1200 rad/s"]),
        ("fuel.speed", [0, 1], ["fuel.flow: got 3 values", "2 x 2 times a number in 0..0.1 kg/s"]),
        ("fuel.torque", [0, 1, 2], ["fuel.flow[0]: got 2 values", "3 x 3 times"]),
        ("fuel.flow", [[0, 0], [0, 0], [0]], ["fuel.flow[2]: got 1 values", "3 x 2 times"]),
        ("fuel.flow", [0, 0, 0], ["fuel.flow[0]: got 0", "3 x 2 times"]),
        ("fuel.flow", [[0, 0], [0, "101 g/s"], [0, 0]], ["fuel.flow[1]: got '101 g/s'", "0..0.1 kg/s"]),
        ("fuel.flow", [[0, 0], [0, 0], [0, math.nan]], ["fuel.flow[2]: got nan", "0..0.1 kg/s"]),
        ("fuel.flow.unit", "kg", ["fuel.flow[0]: got unit 'kg' of another dimension", "0..0.1 kg/s"]),
        ("shaft", 5, ["shaft: got 5", "expected a block of keys"]),
        ("shaft", None, ["shaft: got nothing", "expected a block of keys"]),
        ("shaft", [{"stiffness": 1}], ["shaft: got [", "expected a block of keys"]),
        ("extras", {"gear": 9}, ["extras.gear: got 9", "expected a whole number in 1..8"]),
    ],
)
def test_an_error_names_file_key_and_what_was_expected(
    key: str, value: object, said: list[str], refused: Refused
) -> None:
    message = refused(lambda: Car.parse(changed(key, value), "car.yaml"), "car.yaml: ", *said)
    assert len(message) < 200


@pytest.mark.parametrize("data", [None, [], "mass: 5", 5])
def test_what_is_no_block_is_refused(data: object, refused: Refused) -> None:
    refused(lambda: Car.parse(data, "car.yaml"), "car.yaml: Car: got", "expected a block of keys")
    refused(lambda: Car.parse(data, "car.yaml", "body"), "car.yaml: body: got", "expected a block of keys")


def test_the_key_of_the_block_leads_the_key_of_the_error(refused: Refused) -> None:
    refused(
        lambda: Car.parse(changed("shaft.stiffness", 0), "car.yaml", "rear"), "car.yaml: rear.shaft.stiffness: got 0"
    )


def test_the_ends_of_a_range_belong_to_it() -> None:
    for value in (100, 60_000):
        assert Car.parse(changed("mass", value), "f")["mass"][0] == value


def test_a_record_of_defaults_may_be_left_out_or_be_empty() -> None:
    assert Extras.is_optional()
    assert not Shaft.is_optional()
    assert Car.parse(changed("extras", {}), "f")[0] == Car.parse(GOOD, "f")[0]


def _axis(values: st.SearchStrategy[float], points: int) -> st.SearchStrategy[list[float]]:
    return st.lists(values, min_size=points, max_size=points, unique=True).map(sorted)


curves = st.lists(st.floats(0, 1200), min_size=2, max_size=CURVE_POINTS, unique=True).flatmap(
    lambda xs: st.fixed_dictionaries(
        {"speed": st.just(sorted(xs)), "torque": st.lists(st.floats(-50, 900), min_size=len(xs), max_size=len(xs))}
    )
)
maps: st.SearchStrategy[dict[str, Any]] = st.tuples(st.integers(2, MAP_POINTS), st.integers(2, MAP_POINTS)).flatmap(
    lambda points: st.fixed_dictionaries(
        {
            "speed": _axis(st.floats(0, 1200), points[0]),
            "torque": _axis(st.floats(-50, 900), points[1]),
            "flow": st.integers(0, 2**32).map(
                lambda seed: np.random.default_rng(seed).uniform(0.0, 0.1, points).tolist()
            ),
        }
    )
)
cars: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {
        "mass": st.floats(100, 60_000),
        "slip": st.floats(-2000, 2000),
        "efficiency": st.floats(0, 1),
        "seats": st.integers(1, 9),
        "switches": st.lists(st.integers(0, 1), min_size=2, max_size=2),
        "weights": st.lists(st.lists(st.floats(0, 100), min_size=3, max_size=3), min_size=2, max_size=2),
        "speeds": st.lists(st.floats(0, 1000), min_size=3, max_size=3),
        "ratios": st.lists(st.floats(0, 50), min_size=4, max_size=4),
        "full_load": curves,
        "fuel": maps,
        "shaft": st.fixed_dictionaries({"stiffness": st.floats(1, 1e7), "damping": st.floats(0, 1e5)}),
        "extras": st.fixed_dictionaries({"scale": st.floats(0.5, 2), "gear": st.integers(1, 8)}),
    }
)


@given(cars)
def test_a_record_and_its_mapping_say_the_same(mapping: dict[str, Any]) -> None:
    car = Car.parse(mapping, "f")
    told = Car.to_mapping(car[0])
    assert told == mapping
    assert Car.parse(told, "f").tobytes() == car.tobytes()


def test_the_layout_is_aligned_and_holds_only_doubles_and_long_integers() -> None:
    def leaves(dtype: np.dtype[Any]) -> set[str]:
        if dtype.subdtype is not None:
            return leaves(dtype.subdtype[0])
        if dtype.names is None:
            return {dtype.str}
        return set().union(*(leaves(dtype[name]) for name in dtype.names))

    assert Fleet.dtype.isalignedstruct
    assert Car.dtype.isalignedstruct
    assert leaves(Car.dtype) | leaves(Fleet.dtype) == {np.dtype(np.float64).str, np.dtype(np.int64).str}
    assert Fleet.zeros(2).shape == (2,)
    assert Fleet.dtype.itemsize == 8 + 3 * 16
    assert list(Car.fields) == list(Car.dtype.names or ())
    assert not hasattr(Car, "mass")


def test_markdown_has_a_row_per_number_curve_and_map() -> None:
    class Small(Record):
        """A small record."""

        ratio: float = quantity("1", 0, 1, "a ratio", default=0.25)
        extras: Extras = nested(Extras, "nested")
        shaft: Shaft = nested(Shaft, "nested")
        load: Curve = curve(("pedal", "1", 0, 1), ("torque", "N*m", 0, 900), "torque over pedal")
        fuel: Map = characteristic_map(("speed", "rad/s", 0, 9), _TORQUE, ("flow", "kg/s", 0, 0.1), "fuel flow")

    assert Small.markdown().splitlines() == [
        "| name | unit | range | default | meaning |",
        "| --- | --- | --- | --- | --- |",
        "| `ratio` | – | 0 .. 1 | 0.25 | a ratio |",
        "| `extras.scale` | – | 0.5 .. 2 | 1 | scale |",
        "| `extras.gear` | – | 1 .. 8 | 1 | gear |",
        "| `shaft.stiffness` | N m/rad | 1 .. 1e+07 | – | torque per twist |",
        "| `shaft.damping` | N m s/rad | 0 .. 100000 | 13.6 | torque per twisting speed |",
        "| `load` | torque (N m) over pedal (ratio) | 0 .. 900 | – | torque over pedal |",
        "| `fuel` | flow (kg/s) over speed (rad/s) and torque (N m) | 0 .. 0.1 | – | fuel flow |",
    ]


NUMBER = quantity("kg", 0, 1, "a number")


@pytest.mark.parametrize(
    ("annotation", "declared", "said"),
    [
        ("int", NUMBER, "Bad.x is annotated int but declared float"),
        (int, NUMBER, "Bad.x is annotated int but declared float"),
        ("float", count(0, 1, ""), "Bad.x is annotated float but declared int"),
        ("FloatArray", NUMBER, "Bad.x is annotated FloatArray but declared float"),
        ("float", quantity("kg", 0, 1, "", shape=(2,)), "Bad.x is annotated float but declared FloatArray"),
        ("FloatArray", count(0, 1, "", shape=(2,)), "Bad.x is annotated FloatArray but declared IntArray"),
        ("Curve", nested(Shaft, ""), "Bad.x is annotated Curve but declared Shaft"),
        ("Shaft", nested(Shaft, "", shape=(2,)), r"annotated Shaft but declared RecordElements\[Shaft\]"),
        ("RecordElements[Shaft]", nested(Shaft, ""), "declared Shaft"),
        ("float", curve(("a", "1", 0, 1), ("b", "1", 0, 1), ""), "Bad.x is annotated float but declared Curve"),
        (
            "Curve",
            characteristic_map(("a", "1", 0, 1), ("b", "1", 0, 1), ("c", "1", 0, 1), ""),
            "Bad.x is annotated Curve but declared Map",
        ),
        ("float", 5.0, "Bad.x must be declared by quantity"),
        ("float", None, "Bad.x must be declared by quantity"),
    ],
)
def test_an_annotation_that_is_not_what_is_declared_raises(annotation: object, declared: object, said: str) -> None:
    with pytest.raises(TypeError, match=said):
        type("Bad", (Record,), {"__annotations__": {"x": annotation}, "x": declared})


def test_a_field_without_annotation_raises() -> None:
    with pytest.raises(TypeError, match=r"Bad\.x"):
        type("Bad", (Record,), {"x": NUMBER})


def test_a_field_knows_what_it_expects() -> None:
    assert Field("x", "float", "", "N*m", -1, 1).expected() == "expected a number in -1..1 N m"
    assert Car.fields["weights"].expected() == "expected 2 x 3 times a number in 0..100 kg"


def test_values_with_names_tell_them_in_their_meaning() -> None:
    assert count(-1, 1, "sense", names=("back", "still", "ahead")).meaning == "sense: -1 back, 0 still, 1 ahead"
    assert quantity("1", 0, 1, "gate", names=("shut", "open")).meaning == "gate: 0 shut, 1 open"


@pytest.mark.parametrize("names", [("back",), ("back", "still", "ahead"), ("back", "back")])
def test_names_that_do_not_fit_the_range_are_refused(names: tuple[str, ...]) -> None:
    with pytest.raises(TypeError, match=r"a different one for each value in 0\.\.1"):
        count(0, 1, "sense", names=names)


class Modes(Record):
    """A flag and a mode."""

    active: int = count(0, 1, "on", default=0)
    mode: int = count(2, 4, "mode", default=2, names=("low", "middle", "high"))


@pytest.mark.parametrize(("given", "found"), [("true", 1), (True, 1), ("False", 0), (1, 1), ("0", 0)])
def test_a_flag_is_true_or_false(given: object, found: int) -> None:
    assert Modes.parse({"active": given}, "x")["active"][0] == found


@pytest.mark.parametrize(("given", "found"), [("middle", 3), (4, 4), ("2", 2)])
def test_a_mode_is_given_by_name_or_number(given: object, found: int) -> None:
    assert Modes.parse({"mode": given}, "x")["mode"][0] == found


@pytest.mark.parametrize("block", [{"mode": "highest"}, {"mode": True}, {"mode": 5}, {"active": "yes"}, {"active": 2}])
def test_what_is_no_mode_and_no_flag_is_refused(block: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"expected (one of low, middle, high|a whole number in 0\.\.1)"):
        Modes.parse(block, "x")
