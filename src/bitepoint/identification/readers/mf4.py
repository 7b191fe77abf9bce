"""ASAM MDF files, version 3 and 4, by asammdf."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.identification.readers.log import FileError, Log, library
from bitepoint.recording import Floats


def open_mf4(path: Path) -> Log:
    """Return an MDF file as a log; where channels of one name are in several groups, the first one counts.

    Raises:
        FileError: it cannot be read.
        InputError: asammdf is not installed.
    """
    where = str(path)
    asammdf = library("asammdf", "mf4", where)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            file = asammdf.MDF(path, raise_on_multiple_occurrences=False)
            places: dict[str, Any] = {name: groups[0] for name, groups in file.channels_db.items()}
            units = {name: _unit(file, place) for name, place in places.items()}
    except Exception as error:  # noqa: BLE001 - asammdf raises whatever it met in the bytes
        raise FileError(where, f"cannot be read ({_first_line(error)})", "expected an MDF file") from None

    def read(name: str) -> tuple[Floats, Floats]:
        group, index = places[name]
        try:
            signal = file.get(group=group, index=index)
            return np.asarray(signal.timestamps, float), np.asarray(signal.samples, float)
        except Exception as error:  # noqa: BLE001 - asammdf raises whatever it met in the bytes
            raise FileError(where, f"{name}: cannot be read ({_first_line(error)})", "expected numbers") from None

    return Log(where, units, read)


def _unit(file: Any, place: Any) -> str | None:
    group, index = place
    return file.get_channel_unit(group=group, index=index) or None


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:80]
