"""YAML without surprises: what a file does not say clearly is refused, in one line that names it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bitepoint.files import find, library_folder, library_names, library_yaml, parse_yaml, parse_yaml_value, read_yaml
from tests.conftest import Refused


def test_a_file_is_read_as_a_mapping_with_text_keys(tmp_path: Path) -> None:
    path = tmp_path / "good.yaml"
    path.write_text("\ufeffmass: 1600 kg  # gross\nµ: [1, 2.5]\n3: {a: null}\n", encoding="utf-8")
    assert read_yaml(path) == {"mass": "1600 kg", "µ": [1, 2.5], "3": {"a": None}}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\na: 2", "key a is given twice, again in line 2"),
        ("a: 1\n'a': 2", "key a is given twice, again in line 2"),
        ("b: 0\nblock:\n  a: 1\n  c: 1\n  a: 2", "key a is given twice, again in line 5"),
        ("b: {a: 1, a: 1}", "key a is given twice"),
        ("b: [{a: 1, a: 1}]", "key a is given twice"),
        ("\ta: 1", "line 1"),
        ("a:\n\tb: 1", "line 2"),
        ("a: [1, 2", "not YAML"),
        ("a: {b: 1", "not YAML"),
        ("a: 'text", "not YAML"),
        ("a: b: c", "line 1"),
        ("a: 1\n b: 2", "line 2"),
        ("a: *nowhere", "an alias"),
        ("a: &a [*a]", "an alias"),
        ("a: 1\n---\nb: 2", "another document"),
        ("a: !own 1", "!own"),
        ("a: !!python/object:os.system 1", "python/object:os.system"),
        ("a: \x01", "control characters are not allowed"),
        ("%YAML 9.9\n---\na: 1", "incompatible YAML document"),
        ("a: 2020-99-99", "month must be in 1..12"),
        ("a: " + "9" * 5000, "not YAML"),
        ("? [a, b]\n: 1", "not YAML"),
        ("{a: 1}: 2", "not YAML"),
        ('a: !!int ""', "not YAML"),
        ('a: !!float ""', "not YAML"),
        ("a: !!bool perhaps", "not YAML"),
        ("a: !!timestamp later", "not YAML"),
        ("a: !!map [1]", "not YAML"),
        ("a: " + "[" * 900 + "]" * 900, "not YAML"),
        ("", "holds nothing"),
        (" \n\n", "holds nothing"),
        ("# only a comment", "holds nothing"),
        ("null", "holds nothing"),
        ("- a\n- b", "holds a list"),
        ("1600 kg", "holds a str"),
        ("3", "holds a int"),
    ],
)
def test_what_is_no_clear_mapping_is_refused(text: str, said: str, refused: Refused) -> None:
    message = refused(lambda: parse_yaml(text, "car.yaml"), "car.yaml: ", said)
    assert len(message) < 300


@pytest.mark.parametrize("content", [b"\xff\xfea\x00:\x00", b"a: \xe9", b"\x00\x01\x02\xfe\xff", b"PK\x03\x04\xa0"])
def test_what_is_no_utf_8_is_refused(tmp_path: Path, content: bytes, refused: Refused) -> None:
    path = tmp_path / "binary.yaml"
    path.write_bytes(content)
    refused(lambda: read_yaml(path), str(path), "not a text file", "UTF-8")


def test_no_file_and_a_folder_are_refused(tmp_path: Path, refused: Refused) -> None:
    refused(lambda: read_yaml(tmp_path / "nothing.yaml"), "nothing.yaml", "no such file")
    refused(lambda: read_yaml(tmp_path), str(tmp_path), "cannot be read")


def test_deep_nesting_is_refused_and_does_not_break_the_process() -> None:
    program = """
from bitepoint.errors import InputError
from bitepoint.files import parse_yaml
for bracket in ("[", "{a: ", "- "):
    try:
        parse_yaml(("a:\\n  " if bracket == "- " else "a: ") + bracket * 100_000, "deep.yaml")
    except InputError as error:
        print(len(str(error).splitlines()))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr, done.stdout.split()) == (0, "", ["1"] * 3)


def test_a_value_of_any_kind_can_be_read() -> None:
    assert parse_yaml_value("[1, 2 kg]", "f") == [1, "2 kg"]
    assert parse_yaml_value("{a: 1}", "f") == {"a": 1}
    assert parse_yaml_value("", "f") is None


def test_a_library_name_goes_before_a_file_of_that_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dct-t240").write_text("plant: other")
    assert find("vehicles", "dct-t240", "vehicle") == library_folder("vehicles") / "dct-t240.yaml"


@pytest.mark.parametrize("name", ["mine.yaml", "mine.yml", "folder/mine.yaml"])
def test_the_path_of_a_yaml_file_is_taken_as_it_is(name: str) -> None:
    assert find("vehicles", name, "vehicle") == Path(name)


def test_a_file_that_exists_may_have_any_name(tmp_path: Path) -> None:
    (tmp_path / "car.txt").write_text("plant: dct")
    assert find("vehicles", str(tmp_path / "car.txt"), "vehicle") == tmp_path / "car.txt"


@pytest.mark.parametrize("name", ["dct-t241", "DCT-T240", "a" * 300, "\0"])
def test_an_unknown_name_is_refused_with_those_that_there_are(name: str, refused: Refused) -> None:
    refused(lambda: find("vehicles", name, "vehicle"), "no such vehicle", "dct-na190, dct-t240")


def test_the_library_is_complete_and_sorted() -> None:
    for room in ("vehicles", "scenarios"):
        names = library_names(room)
        assert names == sorted(names)
        assert names
        assert all(library_yaml(room, f"{name}.yaml") for name in names)
