"""The ASAP2 description of an exported part as a file."""

from __future__ import annotations

from pathlib import Path

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError
from bitepoint.export.a2l import a2l_text, symbol_sizes
from bitepoint.export.c.sources import Sources
from bitepoint.export.elf import symbol_addresses
from bitepoint.export.subject import Options, chosen_precision, find_subject


def write_a2l(options: Options, out: Path, elf: Path | None = None) -> None:
    """Write the description of what `options` name to the file `out`, whole or not at all.

    Args:
        elf: the linked program that addresses are taken from; None: they are 0.

    Raises:
        InputError: an unknown name, vehicle, setting or precision; a program that does not fit; a file that cannot be
            written.
        SubsetError: a kernel that cannot be translated.
    """
    precision = chosen_precision(options)
    found = find_subject(options)
    _refuse_other(out)
    sources = Sources(found.part, precision, found.meaning, found.origin)
    addresses = None
    if elf is not None:
        sizes = symbol_sizes(found.part, precision) | {sources.version_symbol: sources.version_size}
        addresses = symbol_addresses(elf, sizes, {sources.version_symbol: f"{sources.version}\0".encode()})
    epk = None if addresses is None else addresses.pop(sources.version_symbol)
    text = a2l_text(found.part, precision, addresses, meaning=found.meaning, version=sources.version, epk=epk)
    try:
        write_atomically(out, text.encode())
    except OSError as error:
        raise InputError(str(out), f"cannot be written ({error.strerror})", "choose another file") from None


def _refuse_other(out: Path) -> None:
    """Raise InputError where another kind of file would be lost."""
    try:
        with out.open("rb") as stream:
            known = b"ASAP2_VERSION" in stream.read(4096)
    except OSError:
        return  # nothing there; what else is wrong shows when it is written
    if not known:
        raise InputError(str(out), "is there, and is no ASAP2 description", "choose another file, or remove it first")
