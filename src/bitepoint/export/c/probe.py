"""A part in C, built into a library that counts what runs, and driven in this process."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.export.c.driving import Driver, Entry
from bitepoint.export.c.driving import Sequence as Inputs
from bitepoint.export.c.sources import Sources
from bitepoint.kernels.c99.host import FLAGS, INCLUDES, entry
from bitepoint.kernels.c99.translate import TYPES
from bitepoint.kernels.kernel import ENTRY

Counts = np.ndarray[Any, np.dtype[np.int64]]

UNLIMITED = 2**62
"""Basic blocks that no sequence takes."""

_COUNTER = """\
#include <stdint.h>

void __sanitizer_cov_trace_pc(void);
void probe_step(char **arguments, const intptr_t *steps, intptr_t lanes);
intptr_t probe_rows(
    char **arguments, const intptr_t *steps, intptr_t many, intptr_t rows, int64_t *counts, int64_t most);

static int64_t blocks;

void __sanitizer_cov_trace_pc(void)
{
    blocks++;
}

intptr_t probe_rows(
    char **arguments, const intptr_t *steps, intptr_t many, intptr_t rows, int64_t *counts, int64_t most)
{
    intptr_t row = 0;
    while (row < rows && most > 0)
    {
        blocks = 0;
        probe_step(arguments, steps, 1);
        counts[row] = blocks;
        most -= blocks;
        row++;
        for (intptr_t k = 0; k < many; k++)
        {
            arguments[k] += steps[k];
        }
    }
    return row;
}
"""
"""Compiled without the flag that makes every basic block of the part call it."""


class BlockCounter:
    """A part in C, built so that it counts the basic blocks that it runs through.

    Attributes:
        texts: the lines of its source; own: the numbers of those that are the part's own.
    """

    def __init__(self, sources: Sources, folder: Path, flags: Sequence[str] = (), more: str = "") -> None:
        """Build it in a folder, with flags of gcc and C code besides its own."""
        self.driver = Driver(sources.part, sources.precision)
        self.texts, self.own = probe_text(sources)
        (folder / "probe.c").write_text("\n".join([*self.texts, more]), encoding="utf-8")
        (folder / "counter.c").write_text(_COUNTER, encoding="utf-8")
        _compile_here(folder, ["-fPIC", "-c", "counter.c"])
        inputs = ["probe.c", "counter.o", "-lm"]
        counting = ["-fsanitize-coverage=trace-pc", *flags]
        _compile_here(folder, [*counting, "-shared", "-fPIC", "-o", "probe.so", *inputs])
        self.library = ctypes.CDLL(str(folder / "probe.so"))
        self.library.probe_rows.restype = ctypes.c_ssize_t
        address = ctypes.cast(self.library.probe_init, ctypes.c_void_p).value
        self.init: Entry = ENTRY(address or 0)

    def count(self, sequence: Inputs, most: int = UNLIMITED) -> Counts:
        """Return how many basic blocks each step of a sequence runs through, up to the one that goes beyond `most`.

        Returns:
            shape (steps,); a sequence has a row more than it has steps.
        """
        part = self.driver.part
        rows = np.ascontiguousarray(self.driver.begin(sequence, self.init)[1:])
        arguments = self.driver.arguments(part.step)
        strides, counts = np.zeros(len(arguments), np.int64), np.zeros(len(rows), np.int64)
        for k, parameter in enumerate(part.step.parameters):
            if parameter.record is part.inputs:
                arguments[k], strides[k] = rows.ctypes.data, rows.strides[0]
        places = [ctypes.c_void_p(array.ctypes.data) for array in (arguments, strides, counts)]
        sizes = [ctypes.c_ssize_t(size) for size in (len(arguments), len(rows))]
        taken = self.library.probe_rows(*places[:2], *sizes, places[2], ctypes.c_int64(most))
        return counts[:taken]


def probe_text(sources: Sources) -> tuple[list[str], range]:
    """Return the lines of the part in C with the entries probe_init and probe_step, and which of them are its own."""
    translation = sources.translation
    head = "\n".join([TYPES, INCLUDES, translation.types, translation.prototypes]).splitlines()
    own = translation.source.splitlines()
    return [*head, *own, *_entries(sources)], range(len(head) + 1, len(head) + len(own) + 1)


def _entries(sources: Sources) -> Iterator[str]:
    yield from entry(sources.part.init, sources.translation, "probe_init")
    yield from entry(sources.part.step, sources.translation, "probe_step")


def _compile_here(folder: Path, arguments: Sequence[str]) -> None:
    """Run gcc in a folder with the flags that C has here, and more."""
    subprocess.run(["gcc", *FLAGS, *arguments], cwd=folder, check=True, capture_output=True)
