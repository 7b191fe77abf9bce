"""Files of an export that are written once, with names put in."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from bitepoint.errors import InputError
from bitepoint.export.c.sources import Sources
from bitepoint.kernels import Kernel
from bitepoint.kernels.c99.host import EXACT
from bitepoint.kernels.c99.text import c_file
from bitepoint.simulation.system import argument_types
from bitepoint.version import __version__

LOOSE = {8: "1e-9", 4: "1e-3"}
"""What the self-test tolerates where functions of the maths library are in use, by the size of a float."""


@cache
def templates() -> Mapping[str, str]:
    """Return the text of each template by its path within the export."""
    root = Path(str(resources.files("bitepoint"))) / "export" / "c" / "templates"
    return {str(path.relative_to(root)): path.read_text("utf-8") for path in sorted(root.rglob("*")) if path.is_file()}


def filled(sources: Sources) -> dict[str, str]:
    """Return the files made of the templates for one part."""
    roles = [role for role in sources.records if role != "parameters"]
    words = {
        "name": sources.part.name,
        "prefix": sources.prefix,
        "real": sources.precision.real,
        "integer": sources.precision.integer,
        "tolerance": "0.0" if sources.translation.exact else LOOSE[sources.precision.size],
        "cmake_version": __version__,
        "exact": " ".join(EXACT),
        "instances": "\n".join(f"{sources.type(role)} {sources.instance(role)};" for role in roles),
        "clear": "\n".join(
            f"        (void)memset(&{sources.instance(role)}, 0, sizeof({sources.instance(role)}));" for role in roles
        ),
        "init_arguments": _arguments(sources, sources.part.init),
        "step_arguments": _arguments(sources, sources.part.step),
        **{role: sources.instance(role) for role in ("state", "inputs", "outputs")},
    }
    files: dict[str, str] = {}
    for name, text in templates().items():
        for key, word in words.items():
            text = text.replace(f"@{key}@", word)
        files[name] = c_file(text.splitlines()) if name.endswith((".c", ".h")) else text
    return files


def _arguments(sources: Sources, kernel: Kernel[..., Any]) -> str:
    roles = argument_types(sources.part)
    found: list[str] = []
    for parameter in kernel.parameters:
        if parameter.record is None:
            if parameter.kind != "float":
                raise InputError(kernel.name, f"takes {parameter.name}, a {parameter.kind}", "it takes records and dt")
            found.append("VECTORS_PERIOD")
        else:
            role = roles[parameter.record]
            found.append("sequence->parameters" if role == "parameters" else f"&{sources.instance(role)}")
    return ", ".join(found)
