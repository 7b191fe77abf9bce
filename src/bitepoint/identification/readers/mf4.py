"""ASAM MDF files, version 3 and 4, by asammdf."""

from __future__ import annotations

import gc
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.identification.readers.log import FileError, Log, library, said_by
from bitepoint.recording import Floats


def open_mf4(path: Path) -> Log:
    """Return an MDF file as a log; where channels of one name are in several groups, the first one counts.

    Raises:
        FileError: it cannot be read.
        InputError: asammdf is not installed.
    """
    where = str(path)
    file, fault = _opened(library("asammdf", "mf4", where), path)
    if fault:
        raise FileError(where, f"cannot be read ({fault})", "expected an MDF file")
    places: dict[str, Any] = {name: groups[0] for name, groups in file.channels_db.items()}
    units = {name: _unit(file, place) for name, place in places.items()}

    def read(name: str) -> tuple[Floats, Floats]:
        group, index = places[name]
        try:
            signal = file.get(group=group, index=index)
            return np.asarray(signal.timestamps, float), np.asarray(signal.samples, float)
        except Exception as error:  # noqa: BLE001 - asammdf raises whatever it met in the bytes
            raise FileError(where, f"{name}: cannot be read ({said_by(error)})", "expected numbers") from None

    return Log(where, units, read)


def _opened(asammdf: Any, path: Path) -> tuple[Any, str]:
    """Return the file, or None and what is wrong with it.

    Of a broken file asammdf leaves an object behind that fails once more while it is taken away: it goes here, unheard.
    """
    fault, hook = "", sys.unraisablehook
    sys.unraisablehook = lambda _: None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return asammdf.MDF(path, raise_on_multiple_occurrences=False), ""
    except Exception as error:  # noqa: BLE001 - asammdf raises whatever it met in the bytes
        fault = said_by(error)
    finally:
        if fault:
            gc.collect()
        sys.unraisablehook = hook
    return None, fault


def _unit(file: Any, place: Any) -> str | None:
    group, index = place
    return file.get_channel_unit(group=group, index=index) or None
