"""`bitepoint export a2l`: from the names on the command line to the addresses of a real program."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from bitepoint.export.c import export_c
from bitepoint.export.subject import Options
from tests.conftest import Command, names_in, needs_target


def test_without_a_program_all_addresses_are_zero(bitepoint: Command, tmp_path: Path) -> None:
    out = tmp_path / "new" / "launch_pid.a2l"
    done = bitepoint("export", "a2l", "launch_pid", "--out", str(out))
    assert done.status == 0
    assert "addresses in it are 0" in done.out
    text = out.read_text()
    assert "ASAP2_VERSION 1 70" in text
    assert "FLOAT64_IEEE" in text
    assert "CURVE 0x0 " in text
    assert set(re.findall(r"\bVALUE (0x[0-9A-F]+)", text)) == {"0x0"}


@needs_target
def test_addresses_are_those_of_the_exported_image(bitepoint: Command, tmp_path: Path) -> None:
    folder, out = tmp_path / "c", tmp_path / "launch_pid.a2l"
    export_c(Options("launch_pid", precision="float32"), folder)
    assert subprocess.run(["make", "-s", "-C", str(folder), "target"], capture_output=True, check=False).returncode == 0
    elf = folder / "build" / "image-cortex-m7.elf"
    done = bitepoint("export", "a2l", "launch_pid", "--precision", "float32", "--elf", str(elf), "--out", str(out))
    assert done.status == 0
    table = subprocess.run(["arm-none-eabi-nm", str(elf)], capture_output=True, text=True, check=True).stdout
    symbols = {line.split()[2]: int(line.split()[0], 16) for line in table.splitlines()}
    text = out.read_text()
    offset = 260  # of target_rise_time: behind the first curve, of 32 points in single precision
    address = symbols["launch_pid_parameters"] + offset
    assert "launch_pid_parameters.calibration.target_rise_time" in text
    assert re.search(rf"target_rise_time \"[^\"]*\" VALUE 0x{address:X} ", text)
    version = re.search(r'VERSION "([^"]+)"', text)
    assert version is not None
    assert version[1] in (folder / "launch_pid.c").read_text()
    assert f"ADDR_EPK 0x{symbols['launch_pid_version_text']:X}" in text
    bitepoint("export", "a2l", "launch_pid", "--elf", str(elf), "--out", str(tmp_path / "wide.a2l")).refusal(
        "image-cortex-m7.elf", "takes 848 bytes instead of 1696", "another precision"
    )
    assert not (tmp_path / "wide.a2l").exists()


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["launch"], ["got launch", "launch_pid"]),
        (["launch_pid", "--precision", "double"], ["--precision", "float64"]),
        (["launch_pid", "--vehicle", "bus"], ["bus"]),
        (["launch_pid", "--elf", "missing.elf"], ["missing.elf", "cannot be read"]),
        (["launch_pid", "--elf", "."], ["cannot be read"]),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(
    bitepoint: Command, tmp_path: Path, arguments: list[str], parts: list[str]
) -> None:
    bitepoint("export", "a2l", *arguments, "--out", str(tmp_path / "x.a2l")).refusal(*parts)
    assert names_in(tmp_path) == []


def test_a_folder_in_its_place_is_left_alone(bitepoint: Command, tmp_path: Path) -> None:
    (tmp_path / "x.a2l").mkdir()
    bitepoint("export", "a2l", "none", "--out", str(tmp_path / "x.a2l")).refusal("x.a2l", "cannot be written")
    assert names_in(tmp_path) == ["x.a2l"]


def test_only_a_description_is_written_over(bitepoint: Command, tmp_path: Path) -> None:
    out = tmp_path / "x.a2l"
    for _ in range(2):
        assert bitepoint("export", "a2l", "none", "--out", str(out)).status == 0
    other = tmp_path / "program.elf"
    other.write_bytes(b"\x7fELF and more")
    bitepoint("export", "a2l", "none", "--out", str(other)).refusal("program.elf", "no ASAP2 description")
    assert other.read_bytes() == b"\x7fELF and more"
