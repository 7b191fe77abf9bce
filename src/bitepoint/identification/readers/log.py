"""What every reader gives: named signals, each with its own times and the unit that the file states."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bitepoint.errors import InputError
from bitepoint.recording import Floats


class FileError(InputError):
    """A file is broken, or is not what was asked for: it is left out, and named in a warning."""


@dataclass(frozen=True)
class Log:
    """A log, opened.

    Attributes:
        where: the file, for errors.
        units: name of each signal -> its unit as the file states it, None where it states none.
        read: name of a signal -> its times, s, and its values, both shape (n,), as they stand in the file.
    """

    where: str
    units: Mapping[str, str | None]
    read: Callable[[str], tuple[Floats, Floats]]


def said_by(error: Exception) -> str:
    """Return the first line of what a library says of bytes that it cannot read, without what no screen can show."""
    line = (str(error).splitlines() or [type(error).__name__])[0]
    return "".join(letter if letter.isprintable() else "?" for letter in line)[:80]


def library(name: str, extra: str, where: str) -> Any:
    """Return an optional library.

    Raises:
        InputError: it is not installed; the message names the extra.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(where, f"needs {name}, which is not installed", f"pip install 'bitepoint[{extra}]'") from None
