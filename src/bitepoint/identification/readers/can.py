"""Logs of CAN frames (candump, Vector ASC and BLF) with the databases that tell what is in them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.identification.readers.log import FileError, Log, library, said_by
from bitepoint.recording import Floats


def open_can(path: Path, databases: tuple[Path, ...]) -> Log:
    """Return a log of CAN frames; signals are named SIGNAL, and MESSAGE.SIGNAL where a name is in several messages.

    Frames that no database knows are passed over; a frame that does not fit its message is a fault.

    Raises:
        FileError: it cannot be read, or the databases know none of its frames.
        InputError: no database, one that cannot be read, or a missing library.
    """
    where = str(path)
    if not databases:
        raise InputError(where, "CAN frames without a database", "add --dbc FILE")
    can, cantools = library("can", "can", where), library("cantools", "can", where)
    messages = [message for file in databases for message in _messages(cantools, file)]
    try:
        frames = list(_frames(can, path))
    except Exception as error:  # noqa: BLE001 - the readers raise whatever they met in the bytes
        raise FileError(where, f"cannot be read ({said_by(error)})", "expected a candump, ASC or BLF file") from None
    find = _finder(messages)
    seen: dict[str, list[Any]] = {}
    known: dict[str, Any] = {}
    for frame in frames:
        message = find(frame.arbitration_id, frame.is_extended_id)
        if message is not None:
            known[message.name] = message
            seen.setdefault(message.name, []).append(frame)
    if not known:
        raise FileError(where, f"none of its {len(frames)} frames is in the database", "expected the log's own --dbc")
    owners = dict(_owners(known.values()))

    def read(name: str) -> tuple[Floats, Floats]:
        message, signal = owners[name]
        return _decoded(message, signal, seen[message.name], where)

    return Log(
        where, {name: message.get_signal_by_name(signal).unit for name, (message, signal) in owners.items()}, read
    )


def _frames(can: Any, path: Path) -> Iterator[Any]:
    kinds = {".log": (can.CanutilsLogReader, "r"), ".asc": (can.ASCReader, "r"), ".blf": (can.BLFReader, "rb")}
    reader, mode = kinds[path.suffix.lower()]
    with path.open(mode) as file:
        frames = reader(file)
        stated, there = getattr(frames, "file_size", 0), path.stat().st_size  # only BLF states its size
        if stated > there:
            raise ValueError(f"{there} of {stated} bytes: cut off")
        for frame in frames:
            if not (frame.is_error_frame or frame.is_remote_frame):
                yield frame


def _messages(cantools: Any, file: Path) -> list[Any]:
    """Return the messages of a database; real ones overlap here and there, so that is let pass."""
    try:
        return list(cantools.database.load_file(str(file), strict=False).messages)
    except FileNotFoundError:
        raise InputError(str(file), "no such file", "check the path") from None
    except Exception as error:  # noqa: BLE001 - its parsers raise whatever they met
        raise InputError(str(file), f"cannot be read ({said_by(error)})", "expected a DBC file") from None


def _finder(messages: list[Any]) -> Callable[[int, bool], Any]:
    """Return the search of a message by identifier: the same one, or the same J1939 group, whoever sent it."""
    exact = {(message.frame_id, message.is_extended_frame): message for message in messages}
    groups = {_group(message.frame_id): message for message in messages if message.is_extended_frame}

    def find(identifier: int, extended: bool) -> Any:
        other = groups.get(_group(identifier)) if extended else None
        return exact.get((identifier, extended), other)

    return find


def _group(identifier: int) -> int:
    """Return the J1939 parameter group of a 29-bit identifier: without priority, sender, and receiver if it has one."""
    group = (identifier >> 8) & 0x3FFFF
    return group if (group >> 8) & 0xFF >= 240 else group & 0x3FF00


def _owners(messages: Iterable[Any]) -> Iterator[tuple[str, tuple[Any, str]]]:
    """Yield each signal by the names that it can be asked for: SIGNAL where that is unique, and MESSAGE.SIGNAL."""
    pairs = [(message, signal.name) for message in messages for signal in message.signals]
    names = Counter(name for _, name in pairs)
    for message, name in pairs:
        yield f"{message.name}.{name}", (message, name)
        if names[name] == 1:
            yield name, (message, name)


def _decoded(message: Any, signal: str, frames: list[Any], where: str) -> tuple[Floats, Floats]:
    times: list[float] = []
    values: list[float] = []
    for frame in frames:
        try:
            found = message.decode(bytes(frame.data), decode_choices=False, allow_truncated=False)
        except Exception as error:  # noqa: BLE001 - its decoders raise whatever they met
            told = f"{message.name} at {frame.timestamp:g} s: {said_by(error)}"
            raise FileError(where, told, "use its own --dbc, and the whole log") from None
        if signal in found:  # a multiplexed signal is in some frames only
            times.append(frame.timestamp)
            values.append(float(found[signal]))
    return np.array(times), np.array(values)
