"""Addresses of variables in a linked program, from the symbol table of its ELF file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from bitepoint.errors import InputError


def symbol_addresses(path: str | Path, sizes: Mapping[str, int]) -> dict[str, int]:
    """Return the address of each of the named variables in a linked program.

    Args:
        path: an ELF file, of 32 or 64 bits, in either byte order.
        sizes: how many bytes each variable takes, as `a2l.symbol_sizes` tells of a part in a precision.

    Raises:
        InputError: no such file, or none in ELF; it is not linked, or has no symbols; a variable is missing, is there
            more than once, or has another size, as in a program of another precision or version; no pyelftools.
    """
    where = str(path)
    try:
        with Path(path).open("rb") as stream:
            found = _variables(stream, where)
    except OSError as error:
        raise InputError(where, f"cannot be read ({error.strerror or error})", "name the linked program") from None
    except ValueError:  # a path with a null character
        raise InputError(repr(where), "is no path", "name the linked program") from None
    return {name: _address(name, size, found.get(name, set()), where) for name, size in sizes.items()}


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


def _variables(stream: IO[bytes], where: str) -> dict[str, set[tuple[int, int]]]:
    """Return (address, size) of all variables, by name."""
    try:
        from elftools.common.exceptions import ELFError
        from elftools.elf.elffile import ELFFile
    except ImportError:
        raise InputError(where, "needs pyelftools to be read", "pip install 'bitepoint[export]'") from None
    library: Any = ELFFile
    try:
        elf = library(stream)
        if elf["e_type"] not in ("ET_EXEC", "ET_DYN"):
            raise InputError(where, "is not linked, so that nothing in it has an address", "name the linked program")
        table = elf.get_section_by_name(".symtab")
        if table is None:
            raise InputError(where, "has no symbols", "do not strip it")
        found: dict[str, set[tuple[int, int]]] = {}
        for symbol in table.iter_symbols():
            if symbol["st_info"]["type"] == "STT_OBJECT" and symbol["st_shndx"] != "SHN_UNDEF":
                found.setdefault(str(symbol.name), set()).add((int(symbol["st_value"]), int(symbol["st_size"])))
    except (ELFError, ValueError, KeyError, OverflowError, AttributeError, AssertionError) as error:
        raise InputError(where, f"is no sound ELF file ({error})", "name the linked program") from None
    return found
