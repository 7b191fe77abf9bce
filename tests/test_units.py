"""Text with units becomes SI, exactly, or is refused in a few words."""

from __future__ import annotations

import functools
import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from bitepoint import units
from bitepoint.units import UnitError, display, parse

ROUNDING = 4e-16
"""Relative: a conversion is one product and one sum; its factor is rounded once."""

UNRESOLVED_POWER = "9**9**9**9"
"""An exponent that no machine can work out."""


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("1600 kg", "kg", 1600.0),
        ("1.6 t", "kg", 1600.0),
        ("1600kg", "kg", 1600.0),
        ("  1600   kg ", "kg", 1600.0),
        ("+1.6e3 kg", "kg", 1600.0),
        (".5 m", "m", 0.5),
        ("5. m", "m", 5.0),
        ("289 mm", "m", 0.289),
        ("36 km/h", "m/s", 10.0),
        ("60 rpm", "rad/s", 2 * math.pi),
        ("180 deg/s", "rad/s", math.pi),
        ("240 N m", "N*m", 240.0),
        ("240 N*m", "N*m", 240.0),
        ("0.25 kg*m²", "kg*m^2", 0.25),
        ("20 degC", "K", 293.15),
        ("-40 °C", "K", 233.15),
        ("20 %", "1", 0.2),
        ("20 percent", "1", 0.2),
        ("14.1 %", "percent", 14.1),
        ("2 ms", "s", 0.002),
        ("1 kW*h", "J", 3.6e6),
    ],
)
def test_text_with_a_unit_is_converted(text: str, unit: str, expected: float) -> None:
    assert parse(text, unit) == pytest.approx(expected, rel=ROUNDING, abs=0)


@pytest.mark.parametrize("value", [3, 3.0, "3", " 3 ", "3.0 "])
def test_a_number_without_a_unit_is_in_the_wanted_unit(value: object) -> None:
    assert parse(value, "rad/s") == 3.0


@given(st.floats(allow_nan=False))
def test_a_number_is_taken_to_the_bit(number: float) -> None:
    for value in (number, repr(number), f"{number!r} kg" if math.isfinite(number) else number):
        assert parse(value, "kg") == number


@given(st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-300))
@example(0.0)
@example(-0.0)
def test_conversion_and_back(number: float) -> None:
    turned = parse(f"{number!r} rpm", "rad/s")
    assert turned == pytest.approx(number * 2 * math.pi / 60, rel=ROUNDING, abs=0)
    assert parse(f"{turned!r} rad/s", "rpm") == pytest.approx(number, rel=4 * ROUNDING, abs=0)


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e400", "1e400 kg", 10**400, -(10**400), math.nan])
def test_what_is_not_finite_is_passed_on_for_the_range_check_to_name(value: object) -> None:
    assert not math.isfinite(parse(value, "kg"))


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("5 s", "got unit 's' of another dimension"),
        ("5 %", "got unit '%' of another dimension"),
        ("5 pears", "got unknown unit 'pears'"),
        ("5 (", "got unknown unit '('"),
        ("5 kg; import os", "got unknown unit 'kg; import os'"),
        ("1,5 kg", "got unknown unit ',5 kg'"),
        ("1_000 kg", "got unknown unit '_000 kg'"),
        ("heavy", "got 'heavy'"),
        ("", "got ''"),
        ("--5 kg", "got '--5 kg'"),
        ("inf kg", "got 'inf kg'"),
        (True, "got True"),
        (None, "got nothing"),
        ([5], "got [5]"),
        ({"a": 5}, "got {'a': 5}"),
        (5j, "got 5j"),
    ],
)
def test_what_is_no_mass_is_refused_in_a_few_words(value: object, said: str) -> None:
    with pytest.raises(UnitError) as caught:
        parse(value, "kg")
    assert str(caught.value) == said


@pytest.mark.parametrize("text", ["5 deg", "5 degrees", "0.1 rad", "5 °"])
def test_an_angle_is_no_ratio(text: str) -> None:
    with pytest.raises(UnitError, match="got an angle"):
        parse(text, "1")


def test_a_ratio_has_no_dimension() -> None:
    with pytest.raises(UnitError, match="of another dimension"):
        parse("5 kg", "1")


def test_a_refusal_of_something_long_is_short_and_one_line() -> None:
    for value in ("x" * 1000, "5 " + "x" * 1000, "x\n" * 100, list(range(1000))):
        with pytest.raises(UnitError) as caught:
            parse(value, "kg")
        assert len(str(caught.value)) < 80
        assert len(str(caught.value).splitlines()) == 1


def test_a_unit_cannot_keep_the_machine_busy() -> None:
    program = f"""
from bitepoint.units import UnitError, parse
for text in ("1 {UNRESOLVED_POWER}", "1 kg*{UNRESOLVED_POWER}", "1 kg**9**9**9", "1 kg*9^9^9^9"):
    try:
        parse(text, "kg")
    except UnitError:
        print("refused")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=10, check=True)
    assert done.stdout.split() == ["refused"] * 4


@pytest.fixture
def memory_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of remembered conversions, in a folder of its own."""
    file = tmp_path / "units.json"
    monkeypatch.setattr(units, "_memory_file", lambda: file)
    forget(monkeypatch)
    return file


def forget(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the module as it is in a new process."""
    monkeypatch.setattr(units, "_memory", functools.cache(units._memory.__wrapped__))
    monkeypatch.setattr(units, "_conversion", functools.cache(units._conversion.__wrapped__))


def no_pint(text: str, unit: str) -> Any:
    raise AssertionError(f"asked pint for {text} in {unit}")


def test_a_conversion_is_remembered_so_that_a_warm_start_needs_no_pint(
    memory_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert parse("20 degC", "K") == 293.15
    assert json.loads(memory_file.read_text()) == {"degC|K": [1.0, 273.15]}
    forget(monkeypatch)
    monkeypatch.setattr(units, "_ask_pint", no_pint)
    assert parse("30 degC", "K") == 303.15


def test_a_logarithmic_unit_is_not_taken_for_a_factor(memory_file: Path) -> None:
    with pytest.raises(UnitError):
        parse("3 dB", "1")
    assert not memory_file.exists()


def test_a_refusal_is_not_remembered(memory_file: Path) -> None:
    with pytest.raises(UnitError):
        parse("5 pears", "kg")
    assert not memory_file.exists()


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"3", b'{"t|kg": 3}', b'{"t|kg": [1]}', b'{"t|kg": ["a", 0]}', b"\xff"]
)
def test_a_broken_memory_is_forgotten(memory_file: Path, content: bytes) -> None:
    memory_file.write_bytes(content)
    assert parse("1.6 t", "kg") == 1600.0
    assert json.loads(memory_file.read_text())["t|kg"] == [1000.0, 0.0]


def test_a_memory_that_cannot_be_written_does_no_harm(memory_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    memory_file.write_text("{}")
    monkeypatch.setattr(units, "_memory_file", lambda: memory_file / "under a file")
    assert parse("1.6 t", "kg") == 1600.0


@pytest.mark.parametrize(
    ("unit", "shown"), [("1", ""), ("N*m", "N m"), ("kg*m^2", "kg m²"), ("m/s^3", "m/s³"), ("rad/s", "rad/s")]
)
def test_units_as_a_person_reads_them(unit: str, shown: str) -> None:
    assert display(unit) == shown


def test_standard_gravity_is_the_defined_one() -> None:
    assert units.STANDARD_GRAVITY == 9.80665


@pytest.mark.parametrize("text", ["800 1/min", "50 Hz", "3 1/s"])
def test_a_speed_without_an_angle_is_refused(text: str) -> None:
    with pytest.raises(UnitError, match="names no angle"):
        parse(text, "rad/s")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("280 Nm", "N*m", 280.0), ("30 r/min", "rad/s", math.pi), ("60 rev/min", "rad/s", 2 * math.pi)],
)
def test_spellings_of_the_field_are_taken(text: str, unit: str, value: float) -> None:
    assert parse(text, unit) == pytest.approx(value)
