"""Which signal of a log is the wanted channel, and in which unit."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

from bitepoint.identification.readers.log import FileError, Log
from bitepoint.identification.units import conversion, header_unit, split_header
from bitepoint.recording import Channel
from bitepoint.units import UnitError


@dataclass(frozen=True)
class Column:
    """A signal of a log: SI value = scale * value + offset; `volume` where its unit is one of volume, not of mass."""

    name: str
    scale: float
    offset: float
    volume: bool = False


def find_column(
    log: Log, channel: Channel, wish: str | None = None, aliases: tuple[str, ...] = (), density: float | None = None
) -> Column:
    """Return the signal that is the channel.

    Without a wish it is the one of that name, a unit may be part of it (`engine_speed_rpm`, `engine_speed [rpm]`). The
    unit is, in this order: the one wished for, the one that the file states, the one in the name, SI.

    Args:
        wish: name of the signal; a unit may follow after a blank.
        aliases: other names of the channel, which count where there is none of its own.
        density: kg/m^3, of a flow of mass that may be logged as one of volume; None: it may not.

    Raises:
        FileError: no such signal, several, or a unit of another dimension.
    """
    name, unit = _named(log, channel, aliases) if wish is None else _wished(log, channel, wish)
    names = (channel.name, *aliases)
    stated = unit or log.units[name] or header_unit(name, names) or split_header(name)[1] or channel.unit
    try:
        return Column(name, *conversion(stated, channel.unit))
    except UnitError as error:
        if density is not None:
            with contextlib.suppress(UnitError):
                scale, offset = conversion(stated, "m^3/s")
                return Column(name, scale * density, offset * density, volume=True)
        where = f"{log.where}: {name}"
        raise FileError(where, f"{error}", f"expected a unit such as {channel.unit}, see --column") from None


def _named(log: Log, channel: Channel, aliases: tuple[str, ...]) -> tuple[str, str | None]:
    if channel.name in log.units:
        return channel.name, None
    own = [name for name in log.units if header_unit(name, (channel.name,)) is not None]
    found = own or [name for name in log.units if header_unit(name, aliases) is not None]
    if len(found) > 1:
        raise FileError(log.where, f"{' and '.join(found[:3])} all are {channel.name}", _mend(channel))
    if not found:
        raise FileError(log.where, f"no channel {channel.name}", f"it has {_some(log)}; {_mend(channel)}")
    return found[0], None


def _wished(log: Log, channel: Channel, wish: str) -> tuple[str, str | None]:
    words = wish.split(" ")
    for count in range(len(words), 0, -1):
        name, unit = " ".join(words[:count]), " ".join(words[count:])
        if name in log.units:
            return name, unit.strip() or None
    raise FileError(log.where, f"no channel {wish} for {channel.name}", f"it has {_some(log)}")


def _some(log: Log) -> str:
    names = list(log.units)
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _mend(channel: Channel) -> str:
    return f"name one by --column {channel.name}=NAME"
