"""`bitepoint show`: a library file, to start one's own from."""

from __future__ import annotations

from typing import Annotated

import typer

from bitepoint.errors import InputError
from bitepoint.files import library_folder, library_names


def show(
    name: Annotated[str, typer.Argument(help="A vehicle or a scenario of the library, as `bitepoint list` has it.")],
) -> None:
    """Print a library file: `bitepoint show dct-t240 > my-car.yaml`."""
    for room in ("vehicles", "scenarios"):
        if name in library_names(room):
            typer.echo((library_folder(room) / f"{name}.yaml").read_text(encoding="utf-8"), nl=False)
            return
    known = ", ".join([*library_names("vehicles"), *library_names("scenarios")])
    raise InputError("show", f"got {name}", f"expected one of {known}")
