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
    addresses = None if elf is None else symbol_addresses(elf, symbol_sizes(found.part, precision))
    version = Sources(found.part, precision, found.meaning, found.origin).version
    text = a2l_text(found.part, precision, addresses, meaning=found.meaning, version=version)
    try:
        write_atomically(out, text.encode())
    except OSError as error:
        raise InputError(str(out), f"cannot be written ({error.strerror})", "choose another file") from None
