"""Recordings: named channels with units over one time raster, simulated or measured; Parquet out and in."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """Name, unit (pint spelling, SI) and meaning of one signal."""

    name: str
    unit: str
    meaning: str = ""


@dataclass(frozen=True)
class Recording:
    """Signals over time.

    Attributes:
        time: s, shape (n,), strictly increasing.
        channels: what the rows of `data` are.
        data: shape (channels, n), SI.
        about: where it comes from: scenario, status, settings, version; values are text.
    """

    time: Floats
    channels: tuple[Channel, ...]
    data: Floats
    about: Mapping[str, str] = field(default_factory=dict[str, str])
    _rows: Mapping[str, int] = field(init=False, repr=False, compare=False, default_factory=dict[str, int])

    def __post_init__(self) -> None:
        if self.data.shape != (len(self.channels), len(self.time)):
            raise ValueError(f"data is {self.data.shape}, expected {(len(self.channels), len(self.time))}")
        if len({channel.name for channel in self.channels}) < len(self.channels):
            raise ValueError("two channels have one name")
        object.__setattr__(self, "_rows", {channel.name: row for row, channel in enumerate(self.channels)})

    def __repr__(self) -> str:
        """Return one line: length, duration and number of channels."""
        span = f"{self.time[0]:g}..{self.time[-1]:g} s" if len(self.time) else "empty"
        return f"<Recording of {len(self.channels)} channels, {len(self.time)} rows, {span}>"

    def __contains__(self, name: str) -> bool:
        return name in self._rows

    def __getitem__(self, name: str) -> Floats:
        """Return the channel `name`, shape (n,).

        Raises:
            KeyError: there is no such channel; the message names those that there are.
        """
        row = self._rows.get(name)
        if row is None:
            raise KeyError(f"no channel {name}; there are {', '.join(self._rows)}")
        return self.data[row]

    def rows(self, start: int, stop: int | None = None) -> Recording:
        """Return the rows from `start` up to `stop`, as a recording of its own."""
        return Recording(self.time[start:stop], self.channels, self.data[:, start:stop], self.about)

    def to_parquet(self, path: str | Path) -> None:
        """Write a Parquet file: a column `time` and one per channel, unit and meaning in each column's metadata."""
        pa, pq = _arrow()
        columns = [(Channel("time", "s", "time"), self.time), *zip(self.channels, self.data, strict=True)]
        fields = [pa.field(c.name, pa.float64(), False, {"unit": c.unit, "meaning": c.meaning}) for c, _ in columns]
        schema = pa.schema(fields, metadata={"bitepoint": json.dumps(dict(self.about))})
        stream = io.BytesIO()
        pq.write_table(pa.Table.from_arrays([pa.array(values) for _, values in columns], schema=schema), stream)
        write_atomically(Path(path), stream.getvalue())

    @staticmethod
    def from_parquet(path: str | Path) -> Recording:
        """Read what `to_parquet` wrote.

        Raises:
            InputError: no such file, no Parquet, or no column `time`.
        """
        pa, pq = _arrow()
        try:
            table = pq.read_table(Path(path))
        except FileNotFoundError:
            raise InputError(str(path), "no such file", "check the path") from None
        except (pa.ArrowException, OSError) as error:
            raise InputError(str(path), f"no Parquet file ({str(error).splitlines()[0][:60]})", "check it") from None
        if "time" not in table.column_names:
            raise InputError(str(path), "no column time", "expected a recording that bitepoint wrote")
        columns: list[Any] = list(table.schema)
        odd = [
            column.name
            for column in columns
            if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type))
        ]
        if odd:
            raise InputError(
                str(path), f"column {odd[0]} holds no numbers", "expected a recording that bitepoint wrote"
            )
        channels = tuple(_channel(column) for column in columns if column.name != "time")
        data = np.array([table[channel.name].to_numpy() for channel in channels], float)
        time = table["time"].to_numpy().astype(float)
        return Recording(time, channels, data.reshape(len(channels), len(time)), _about(table, str(path)))


def _about(table: Any, where: str) -> dict[str, str]:
    metadata: dict[bytes, bytes] = table.schema.metadata or {}
    try:
        found: object = json.loads(metadata.get(b"bitepoint", b"{}"))
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise InputError(where, "its notes cannot be read", "expected a recording that bitepoint wrote")
    return {str(key): str(value) for key, value in cast("dict[object, object]", found).items()}


def _arrow() -> tuple[Any, Any]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    return pa, pq


def _channel(arrow_field: Any) -> Channel:
    metadata: dict[bytes, bytes] = arrow_field.metadata or {}
    unit, meaning = metadata.get(b"unit", b"1").decode(), metadata.get(b"meaning", b"").decode()
    return Channel(arrow_field.name, unit, meaning)
