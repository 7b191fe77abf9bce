"""A part in C with entries of its own, to be built into a library that counts what runs."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path

from bitepoint.export.c.driving import Entry
from bitepoint.export.c.sources import Sources
from bitepoint.kernels.c99.host import FLAGS, INCLUDES, entry
from bitepoint.kernels.c99.translate import TYPES
from bitepoint.kernels.kernel import ENTRY


def probe_text(sources: Sources) -> tuple[list[str], range]:
    """Return the lines of the part in C with the entries probe_init and probe_step, and which of them are its own."""
    part, translation = sources.part, sources.translation
    head = [TYPES, INCLUDES, translation.types, translation.prototypes]
    entries = [*entry(part.init, translation, "probe_init"), *entry(part.step, translation, "probe_step"), ""]
    first = len("\n".join(head).splitlines()) + 1
    last = first + len(translation.source.splitlines())
    return "\n".join([*head, translation.source, *entries]).splitlines(), range(first, last + 1)


def build_probe(folder: Path, flags: Sequence[str], files: Sequence[str]) -> ctypes.CDLL:
    """Return the library of files in a folder, built with more flags than C has here."""
    compile_here(folder, [*flags, "-shared", "-fPIC", "-o", "probe.so", *files, "-lm"])
    return ctypes.CDLL(str(folder / "probe.so"))


def compile_here(folder: Path, arguments: Sequence[str]) -> None:
    """Run gcc in a folder with the flags that C has here, and more."""
    subprocess.run(["gcc", *FLAGS, *arguments], cwd=folder, check=True, capture_output=True)


def probe_entries(library: ctypes.CDLL) -> tuple[Entry, Entry]:
    """Return the entries of init and step in a library that was built from `probe_text`."""
    init, step = (ctypes.cast(getattr(library, f"probe_{name}"), ctypes.c_void_p).value for name in ("init", "step"))
    return ENTRY(init or 0), ENTRY(step or 0)
