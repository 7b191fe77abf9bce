"""Units of logged signals: stated by the file, by the end of a header, or by whoever asks."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bitepoint.units import UnitError, parse

SPELLINGS = {
    "rpm": "rpm", "radps": "rad/s", "rad_s": "rad/s", "rad_per_s": "rad/s", "rads": "rad/s",
    "nm": "N*m", "n_m": "N*m", "kmh": "km/h", "kph": "km/h", "km_h": "km/h", "mps": "m/s", "m_s": "m/s", "mph": "mph",
    "s": "s", "sec": "s", "ms": "ms", "us": "us", "min": "min", "pct": "percent", "percent": "percent",
    "cc_per_s": "cc/s", "cc_s": "cc/s", "ml_per_s": "mL/s", "ml_s": "mL/s", "l_per_h": "L/h", "l_h": "L/h",
    "g_per_s": "g/s", "g_s": "g/s", "kg_per_s": "kg/s", "kg_s": "kg/s", "kg_per_h": "kg/h", "kg_h": "kg/h",
    "deg_s": "deg/s", "bar": "bar", "pa": "Pa", "kpa": "kPa", "deg": "deg", "m": "m", "km": "km", "ft": "ft",
    "mi": "mi", "km_per_h": "km/h", "m_per_s": "m/s", "secs": "s", "g_per_h": "g/h", "g_h": "g/h",
}  # fmt: skip
"""Units as they stand at the end of a header, after an underscore."""

_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\])]*)[\])]$")


def split_header(header: str) -> tuple[str, str | None]:
    """Return name and unit of a header with brackets, `engine speed [rpm]`; None where it has none."""
    match = _BRACKETS.match(header)
    return (header, None) if match is None else (match["name"], match["unit"].strip())


def header_unit(header: str, names: Sequence[str]) -> str | None:
    """Return the unit that a header of one of `names` states, "" where it states none; None for another header.

    `engine_speed`, `engine_speed [rpm]`, `engine_speed (rpm)` and `engine_speed_rpm` all are `engine_speed`; capitals
    do not matter.
    """
    name, unit = split_header(header)
    name = name.lower()
    if name in names:
        return unit or ""
    ends = [name.removeprefix(f"{each}_") for each in names if name.startswith(f"{each}_")]
    return next((SPELLINGS[end] for end in ends if end in SPELLINGS), None) if unit is None else None


def conversion(unit: str, wanted: str) -> tuple[float, float]:
    """Return scale and offset from `unit` to the unit `wanted`, SI.

    Raises:
        UnitError: no unit, or one of another dimension.
    """
    if not unit.strip():
        raise UnitError("got an empty unit")
    offset = parse(0.0, wanted, unit)
    return parse(1.0, wanted, unit) - offset, offset
