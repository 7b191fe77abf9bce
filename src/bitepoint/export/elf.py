"""Addresses of variables in a linked program, from the symbol table of its ELF file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from bitepoint.errors import InputError


def symbol_addresses(
    path: str | Path, sizes: Mapping[str, int], contents: Mapping[str, bytes] | None = None
) -> dict[str, int]:
    """Return the address of each of the named variables in a linked program.

    Args:
        path: an ELF file, little-endian, linked to run at the addresses that it names.
        sizes: how many bytes each variable takes, as `a2l.symbol_sizes` tells of a part in a precision.
        contents: what some of the variables must hold in the file.

    Raises:
        InputError: no such file, or none in ELF; it is not linked, or has no symbols; a variable is missing, is there
            more than once, or has another size, as in a program of another precision or version; no pyelftools.
    """
    where = str(path)
    try:
        with Path(path).open("rb") as stream:
            found, held = _variables(stream, where, contents or {})
    except OSError as error:
        raise InputError(where, f"cannot be read ({error.strerror or error})", "name the linked program") from None
    except ValueError:  # a path with a null character
        raise InputError(repr(where), "is no path", "name the linked program") from None
    addresses = {name: _address(name, size, found.get(name, set()), where) for name, size in sizes.items()}
    for name, content in (contents or {}).items():
        if held.get(name) != content:
            mend = "build the program from an export of this version, or describe that one"
            raise InputError(where, f"{name} is that of another version", mend)
    return addresses


def _address(name: str, size: int, found: set[tuple[int, int]], where: str) -> int:
    if not found:
        raise InputError(where, f"{name}: no such variable", "link it with the exported C, and see that it is kept")
    if len(found) > 1:
        raise InputError(where, f"{name}: {len(found)} variables of that name", "keep one of them")
    address, got = next(iter(found))
    if got != size:
        problem = f"{name}: takes {got} bytes instead of {size}"
        raise InputError(
            where, problem, "the program has another precision or version of it: build it from this export"
        )
    return address


def _variables(
    stream: IO[bytes], where: str, contents: Mapping[str, bytes]
) -> tuple[dict[str, set[tuple[int, int]]], dict[str, bytes]]:
    """Return (address, size) of all variables, by name, and what those named in `contents` hold."""
    try:
        from elftools.common.exceptions import ELFError
        from elftools.elf.elffile import ELFFile
    except ImportError:
        raise InputError(where, "needs pyelftools to be read", "pip install 'bitepoint[export]'") from None
    library: Any = ELFFile
    try:
        elf = library(stream)
        if elf["e_type"] != "ET_EXEC":
            problem = "is not linked to fixed addresses"
            raise InputError(where, problem, "name the linked program; link it without -pie and -shared")
        if not elf.little_endian:
            raise InputError(where, "is big-endian", "the description says little-endian: it cannot serve this program")
        table = elf.get_section_by_name(".symtab")
        if table is None:
            raise InputError(where, "has no symbols", "do not strip it")
        found: dict[str, set[tuple[int, int]]] = {}
        held: dict[str, bytes] = {}
        for symbol in table.iter_symbols():
            if symbol["st_info"]["type"] == "STT_OBJECT" and symbol["st_shndx"] != "SHN_UNDEF":
                name = str(symbol.name)
                found.setdefault(name, set()).add((int(symbol["st_value"]), int(symbol["st_size"])))
                if name in contents:
                    section = elf.get_section(symbol["st_shndx"])
                    first = int(symbol["st_value"]) - int(section["sh_addr"])
                    held[name] = bytes(section.data()[first : first + len(contents[name])])
    except (ELFError, ValueError, LookupError, OverflowError, AttributeError, AssertionError, TypeError) as error:
        raise InputError(where, f"is no sound ELF file ({error})", "name the linked program") from None
    return found, held
