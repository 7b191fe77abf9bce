"""Addresses from a program, and the text against the compiler's own account of the same program."""

from __future__ import annotations

import builtins
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

from bitepoint.errors import InputError
from bitepoint.export.a2l import a2l_text, symbol_sizes
from bitepoint.export.elf import symbol_addresses
from bitepoint.kernels.c99 import FLOAT32, FLOAT64, Precision, translate
from bitepoint.kernels.c99.translate import TYPES
from bitepoint.simulation.system import Part, argument_types
from tests.conftest import Refused, needs
from tests.export import mcd
from tests.export.parts import CASES, PARTS

TARGET = ["-mcpu=cortex-m7", "-mthumb", "-nostdlib", "-Wl,-e,main", "-Wl,-Ttext=0x08000000", "-Wl,-Tdata=0x20000000"]

COMPILERS = {
    "gcc": pytest.param(["gcc", "-no-pie"], marks=needs("gcc", "nm", packages="gcc"), id="host"),
    "arm": pytest.param(
        ["arm-none-eabi-gcc", *TARGET], marks=needs("arm-none-eabi-gcc", packages="gcc-arm-none-eabi"), id="target"
    ),
}
on_host_and_target = pytest.mark.parametrize("compiler", COMPILERS.values())
each_case = pytest.mark.parametrize(("part", "precision"), CASES, ids=[f"{p.name}-{q.name}" for p, q in CASES])
needs_gcc = needs("gcc", packages="gcc")


def build(compiler: list[str], part: Part, precision: Precision, folder: Path, *options: str, more: str = "") -> Path:
    """Compile and link a program that has the records of a part, as the export has them."""
    public: dict[str, Any] = {f"{part.name}_init": part.init, f"{part.name}_step": part.step}
    types = translate(part.name, public, precision, argument_types(part)).types
    instances = [
        f"{'const ' * (place == 0)}{symbol}_t {symbol} = {{0}};"
        for place, symbol in enumerate(symbol_sizes(part, precision))
    ]
    text = "\n".join([TYPES, types, *instances, more, "int main(void) { return 0; }\n"])
    source, program = folder / "program.c", folder / "program.elf"
    source.write_text(text)
    subprocess.run([*compiler, "-g", str(source), "-o", str(program), *options], check=True)
    return program


@on_host_and_target
@each_case
def test_the_compilers_account_of_the_program_agrees(
    part: Part, precision: Precision, compiler: list[str], tmp_path: Path
) -> None:
    """Every path, type, dimension and address, by the debug information that a2ltool reads."""
    program = build(compiler, part, precision, tmp_path)
    own = a2l_text(part, precision, symbol_addresses(program, symbol_sizes(part, precision)))
    addresses = {name: mcd.address(item) for name, item in mcd.objects(mcd.parsed(own, tmp_path)).items()}
    found, updated = tmp_path / "found.a2l", tmp_path / "updated.a2l"
    by_symbol = a2l_text(part, precision)
    by_path = re.sub(r"\n *SYMBOL_LINK .*", "", by_symbol)
    # where there are several dimensions, a2ltool expects the first one of C first
    by_path = re.sub(r"MATRIX_DIM (.*)", lambda match: f"MATRIX_DIM {' '.join(match[1].split()[::-1])}", by_path)
    for text, mode in ((by_path, ["--update-mode", "STRICT"]), (by_symbol, [])):
        found.write_text(text)
        mcd.a2ltool("--strict", found, "--elffile", program, "--update", "ADDRESSES", *mode, "--output", updated)
        theirs = mcd.objects(mcd.parsed(updated.read_text(), tmp_path))
        assert {name: mcd.address(item) for name, item in theirs.items()} == addresses


@on_host_and_target
@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64], ids=["float32", "float64"])
def test_addresses_are_those_of_nm(compiler: list[str], precision: Precision, tmp_path: Path) -> None:
    part = PARTS["launch_pid"]
    program = build(compiler, part, precision, tmp_path)
    listed = subprocess.run(
        [compiler[0].replace("gcc", "nm"), str(program)], check=True, capture_output=True, text=True
    ).stdout
    lines = [line.split() for line in listed.splitlines()]
    expected = {line[2]: int(line[0], 16) for line in lines if len(line) == 3 and line[2].startswith("launch_pid_")}
    assert symbol_addresses(program, symbol_sizes(part, precision)) == expected
    assert len(expected) == 4


@needs_gcc
def test_a_program_of_another_precision_is_refused(tmp_path: Path, refused: Refused) -> None:
    part = PARTS["launch_pid"]
    program = build(["gcc", "-no-pie"], part, FLOAT32, tmp_path)
    refused(
        lambda: symbol_addresses(program, symbol_sizes(part, FLOAT64)),
        "program.elf", "launch_pid_parameters", "takes 848 bytes instead of 1696", "precision",
    )  # fmt: skip


@needs_gcc
def test_a_program_without_the_variable_is_refused(tmp_path: Path, refused: Refused) -> None:
    part = PARTS["launch_pid"]
    program = build(["gcc", "-no-pie"], PARTS["none"], FLOAT32, tmp_path)
    sizes = symbol_sizes(part, FLOAT32)
    refused(lambda: symbol_addresses(program, sizes), "program.elf", "launch_pid_parameters: no such variable")
    refused(lambda: symbol_addresses(program, {"main": 4}), "main: no such variable")


@needs_gcc
def test_a_variable_of_another_program_is_refused(tmp_path: Path, refused: Refused) -> None:
    library, source = tmp_path / "library.so", tmp_path / "library.c"
    source.write_text("int elsewhere = 1;\n")
    subprocess.run(["gcc", "-shared", "-fPIC", str(source), "-o", str(library)], check=True)
    more = "extern int elsewhere; int use(void) { return elsewhere; }"
    program = build(["gcc", "-no-pie", "-fPIC"], PARTS["none"], FLOAT32, tmp_path, str(library), more=more)
    refused(lambda: symbol_addresses(program, {"elsewhere": 4}), "elsewhere: no such variable")


@needs_gcc
def test_a_program_that_has_the_variable_twice_is_refused(tmp_path: Path, refused: Refused) -> None:
    other = tmp_path / "other.c"
    other.write_text("static int twice = 2; int *use(void) { return &twice; }\n")
    more = "static int twice = 1; int *twice_user(void) { return &twice; }"
    program = build(["gcc", "-no-pie"], PARTS["none"], FLOAT32, tmp_path, str(other), more=more)
    refused(lambda: symbol_addresses(program, {"twice": 4}), "twice: 2 variables")


@needs_gcc
@pytest.mark.parametrize(
    ("option", "problem"), [("-s", "has no symbols"), ("-c", "is not linked"), ("-pie", "is not linked to fixed")]
)
def test_a_program_without_addresses_is_refused(option: str, problem: str, tmp_path: Path, refused: Refused) -> None:
    program = build(["gcc", "-no-pie"], PARTS["none"], FLOAT32, tmp_path, option)
    refused(lambda: symbol_addresses(program, symbol_sizes(PARTS["none"], FLOAT32)), "program.elf", problem)


@needs_gcc
def test_a_damaged_file_is_refused_or_read_right(tmp_path: Path, refused: Refused) -> None:
    program = build(["gcc", "-no-pie"], PARTS["none"], FLOAT32, tmp_path)
    whole, sizes = program.read_bytes(), symbol_sizes(PARTS["none"], FLOAT32)
    right = symbol_addresses(program, sizes)
    for length in (0, 3, 4, 15, 16, 63, 64, 200, len(whole) // 2, len(whole) - 3000, len(whole) - 1):
        program.write_bytes(whole[:length])
        refused(lambda: symbol_addresses(program, sizes), "program.elf")
    for place in range(4, 64):  # the header of the file
        program.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            found = symbol_addresses(program, sizes)
        except InputError:
            continue
        assert found == right


@pytest.mark.parametrize("content", [b"", b"hello", b"\x7fELF", b"\x7fELF" + bytes(60), bytes(1000)])
def test_a_file_that_is_no_elf_is_refused(content: bytes, tmp_path: Path, refused: Refused) -> None:
    file = tmp_path / "notes.txt"
    file.write_bytes(content)
    refused(lambda: symbol_addresses(file, {"a": 1}), "notes.txt", "is no sound ELF file", "name the linked program")


def test_no_file_is_refused(tmp_path: Path, refused: Refused) -> None:
    refused(
        lambda: symbol_addresses(tmp_path / "no.elf", {"a": 1}), "no.elf", "No such file", "name the linked program"
    )
    refused(lambda: symbol_addresses(tmp_path, {"a": 1}), tmp_path.name, "directory")
    refused(lambda: symbol_addresses("nul\0.elf", {"a": 1}), "nul", "is no path")


def test_the_extra_is_named_where_its_library_is_missing(
    tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, original = tmp_path / "a.elf", builtins.__import__
    file.write_bytes(b"")

    def without(name: str, *rest: Any) -> Any:
        if name.startswith("elftools"):
            raise ImportError(name)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    refused(lambda: symbol_addresses(file, {"a": 1}), "a.elf", "pyelftools", "pip install 'bitepoint[export]'")


@needs("arm-none-eabi-gcc", packages="gcc-arm-none-eabi")
def test_a_big_endian_program_is_refused(tmp_path: Path, refused: Refused) -> None:
    source, program = tmp_path / "big.c", tmp_path / "big.elf"
    source.write_text("int here = 1; int main(void) { return here; }\n")
    flags = ["-mbig-endian", "-mcpu=cortex-m4", "-mthumb", "-nostdlib", "-Wl,-e,main"]
    subprocess.run(["arm-none-eabi-gcc", *flags, "-o", str(program), str(source)], check=True)
    refused(lambda: symbol_addresses(program, {"here": 4}), "big.elf", "big-endian")


@needs_gcc
def test_a_variable_that_holds_something_else_is_refused(tmp_path: Path, refused: Refused) -> None:
    more = 'const char text[] = "1.0+old";'
    program = build(["gcc", "-no-pie"], PARTS["none"], FLOAT32, tmp_path, more=more)
    assert symbol_addresses(program, {"text": 8}, {"text": b"1.0+old\0"})["text"] > 0
    refused(lambda: symbol_addresses(program, {"text": 8}, {"text": b"1.0+new\0"}), "text is that of another version")
