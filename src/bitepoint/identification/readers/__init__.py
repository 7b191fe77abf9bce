"""Readers of logs, one file per kind; each gives a `Log`."""

from __future__ import annotations

from pathlib import Path

from bitepoint.errors import InputError
from bitepoint.identification.readers.log import FileError, Log

__all__ = ["SUFFIXES", "FileError", "Log", "open_log"]

SUFFIXES = (".csv", ".txt", ".parquet", ".mf4", ".mdf", ".log", ".asc", ".blf")
"""What is read, by the end of the file's name."""


def open_log(path: Path, databases: tuple[Path, ...] = (), time: str | None = None) -> Log:
    """Return the log at `path`; the end of its name says what it is.

    Args:
        databases: DBC files that tell what CAN frames hold.
        time: name of the column of the time in tables, a unit may follow after a blank; None: it is found by its name.

    Raises:
        FileError: it cannot be read.
        InputError: no such file, a kind that is not read here, frames without a database, or a missing library.
    """
    if not path.is_file():
        raise InputError(str(path), "no such file", "check the path")
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise InputError(str(path), f"a {path.suffix or 'nameless'} file", f"expected one of {', '.join(SUFFIXES)}")
    if kind == "mf4":
        from bitepoint.identification.readers.mf4 import open_mf4

        return open_mf4(path)
    if kind == "can":
        from bitepoint.identification.readers.can import open_can

        return open_can(path, databases)
    from bitepoint.identification.readers.table import open_table

    return open_table(path, time)


_KINDS = {
    **dict.fromkeys((".csv", ".txt", ".parquet"), "table"),
    **dict.fromkeys((".mf4", ".mdf"), "mf4"),
    **dict.fromkeys((".log", ".asc", ".blf"), "can"),
}
