"""A hundred broken vehicle files and more: each is refused in one line that names it, and nothing is written."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.mutations import DATA, TEXT, bomb, cases, replaced, written
from tests.conftest import Command, names_in

CASES = cases()


def test_there_are_a_hundred_different_files() -> None:
    assert len({content for _, content in CASES}) == len(CASES) >= 100
    assert cases() == CASES


@pytest.mark.parametrize("content", [TEXT.encode(), written(DATA)], ids=["text", "data"])
def test_what_the_broken_files_are_made_from_is_sound(bitepoint: Command, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "car.yaml"
    path.write_bytes(content)
    assert bitepoint("run", "dct-launch", "--set", f"vehicle={path}").status == 0


@pytest.mark.parametrize("content", [content for _, content in CASES], ids=[name for name, _ in CASES])
def test_a_broken_vehicle_file_is_refused_in_one_line(bitepoint: Command, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "car.yaml"
    path.write_bytes(content)
    done = bitepoint("run", "dct-launch", "--set", f"vehicle={path}", "--out", str(tmp_path / "out"))
    said = done.refusal(f"error: {path}: ", "; ")
    assert len(said) < len(str(path)) + 400
    assert names_in(tmp_path) == ["car.yaml"]


VAST = {
    "scalar": replaced("1600 kg", bomb(12)),
    "array": replaced("[3.2562, 1.7064, 1.2301, 0.8988, 0.6894]", bomb(12)),
    "source": replaced("source: Yang et al. 2020, table 1 and constraints of section 1.1.2", f"source: {bomb(12)}"),
    "merged": replaced("1600 kg", bomb(12, "{{<<: [{}]}}", "{a: 1}")),
    "deep": replaced("1600 kg", "[" * 100_000 + "]" * 100_000),
}
"""A few lines that stand for 10^12 numbers, and more depth than a stack has room for."""


@pytest.mark.parametrize("content", VAST.values(), ids=VAST)
def test_a_small_file_cannot_take_all_memory_or_time(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "car.yaml").write_bytes(content)
    program = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
sys.argv = ["bitepoint", "run", "dct-launch", "--set", "vehicle=car.yaml", "--out", "out"]
from bitepoint.cli import main
main()
"""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=15, check=False)
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, "", 1)
    assert done.stderr.startswith("error: car.yaml: ")
    assert names_in(tmp_path) == ["car.yaml"]
