"""Generated C on this machine: compiled into a library, and run over batches like every other life."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from bitepoint.cache import cache_folder, write_atomically
from bitepoint.errors import InputError
from bitepoint.kernels.c99.precision import FLOAT64, Precision
from bitepoint.kernels.c99.translate import TYPES, Translation, translate
from bitepoint.kernels.kernel import Kernel

EXACT = ("-ffp-contract=off", "-fno-math-errno", "-fno-builtin-pow")
"""What the last bits depend on, for every compiler and every processor."""

FLAGS = ("-std=c99", "-O2", *EXACT)
"""How generated C is compiled here: in its standard, without fused multiply-add, every power by the library."""

STRICT = ("-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Werror")
"""What it also compiles under, without a single warning; tests and self-tests hold that."""

ENTRY_NAME = "bitepoint_entry"
"""Name of the entry in a library of one kernel."""

INCLUDES = "#include <float.h>\n#include <math.h>\n"


_LAUNCHERS = ("ccache", "distcc", "sccache")
_ALIKE = {"arm64": "aarch64", "amd64": "x86_64"}


def _is_native(program: str) -> bool:
    """Return whether a compiler makes code for this machine, as far as it says."""
    done = subprocess.run([program, "-dumpmachine"], capture_output=True, text=True, check=False)
    target, own = done.stdout.strip().partition("-")[0].lower(), platform.machine().lower()
    return done.returncode == 0 and (not target or _ALIKE.get(target, target) == _ALIKE.get(own, own))


@cache
def compiler() -> str:
    """Return the path of this machine's C compiler: $CC where that compiles for this machine, or gcc, clang or cc.

    Raises:
        InputError: there is none.
    """
    words = [word for word in os.environ.get("CC", "").split() if Path(word).name not in _LAUNCHERS and word[0] != "-"]
    for candidate in (*words[:1], "gcc", "clang", "cc"):
        found = shutil.which(candidate)
        if found is not None and _is_native(found):
            return found
    raise InputError("C compiler", "none of gcc, clang and cc is on the path", "install one, such as Debian's gcc")


@cache
def host_entry(kernel: Kernel[..., Any], precision: Precision = FLOAT64) -> int:
    """Return the address of the C life of `kernel`: see `kernels.kernel` for the calling convention.

    In float32 the records have the layout of `precision.layout`, floats and integers have 4 bytes.
    """
    translation = translate("kernel", {f"{kernel.name}_in_c": kernel}, precision)
    text = program(kernel, translation)
    path = _library(kernel.name, text)
    library = ctypes.CDLL(str(path))
    address = ctypes.cast(getattr(library, ENTRY_NAME), ctypes.c_void_p).value
    assert address is not None
    return address


def program(kernel: Kernel[..., Any], translation: Translation) -> str:
    """Return the generated C of a kernel with an entry that runs it over a batch."""
    head = [TYPES, INCLUDES, translation.types, translation.prototypes, translation.source]
    return "\n".join([*head, *entry(kernel, translation, ENTRY_NAME), ""])


def entry(kernel: Kernel[..., Any], translation: Translation, name: str) -> Iterator[str]:
    """Yield the lines of the function `name` that runs a kernel over a batch."""
    arguments: list[str] = []
    for k, parameter in enumerate(kernel.parameters):
        place = f"(arguments[{k}] + (lane * steps[{k}]))"
        if parameter.record is not None:
            arguments.append(f"({translation.type_names[parameter.record]} *)(void *){place}")
        else:
            kind = translation.precision.real if parameter.kind == "float" else translation.precision.integer
            arguments.append(f"*({kind} *)(void *){place}")
    call = f"{translation.functions[kernel]}({', '.join(arguments)})"
    if kernel.result != "none":
        last = len(kernel.parameters)
        kind = translation.precision.real if kernel.result == "float" else translation.precision.integer
        call = f"*({kind} *)(void *)(arguments[{last}] + (lane * steps[{last}])) = {call}"
    yield f"void {name}(char **arguments, const intptr_t *steps, intptr_t lanes);"
    yield f"void {name}(char **arguments, const intptr_t *steps, intptr_t lanes)"
    yield from ("{", "    for (intptr_t lane = 0; lane < lanes; lane++)", "    {", f"        {call};", "    }", "}")


def _library(name: str, text: str) -> Path:
    """Return the shared library of a C text, compiled if it is not in the cache."""
    key = hashlib.sha256("\0".join([text, *FLAGS, _version()]).encode()).hexdigest()[:20]
    path = cache_folder() / "c" / f"{name}-{key}.so"
    if not path.exists():
        write_atomically(path.with_suffix(".c"), text.encode())
        with tempfile.TemporaryDirectory() as folder:
            built = Path(folder) / "kernel.so"
            command = [compiler(), *FLAGS, "-shared", "-fPIC", "-o", str(built), str(path.with_suffix(".c")), "-lm"]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise RuntimeError(f"{path.with_suffix('.c')} does not compile:\n{done.stderr}")
            write_atomically(path, built.read_bytes())
    return path


@cache
def _version() -> str:
    done = subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=False)
    return f"{compiler()}\n{done.stdout}"
