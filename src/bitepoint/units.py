"""Unit conversion at the edges: text such as "1450 kg" or "20 %" to SI numbers. Inside, everything is SI.

The conversions themselves are pint's. They are remembered on disk, so that a warm start needs not import it.
"""

from __future__ import annotations

import contextlib
import json
import math
import re
from functools import cache
from typing import TYPE_CHECKING, Any

from bitepoint.cache import cache_folder, write_atomically
from bitepoint.errors import brief

if TYPE_CHECKING:
    from pathlib import Path

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall, m/s^2 (CGPM 1901)."""

_QUANTITY = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$")
_ALIASES = {"r/min": "rpm", "rev/min": "rpm", "U/min": "rpm", "kg m2": "kg*m^2", "kgm2": "kg*m^2"}
_SPELLINGS = ((re.compile(r"\bNms\b"), "N*m*s"), (re.compile(r"\bNm\b"), "N*m"), (re.compile(r"\bkgm\b"), "kg*m"))
"""What the field writes daily, and pint reads otherwise or not at all."""

_TOKEN = re.compile(r"\s+|\*\*|[()*/^·]|-?\d+|[^\W\d]\w*|[%°'\"]")
_ANGLES = frozenset({"deg", "degree", "degrees", "rad", "radian", "radians", "°"})


class UnitError(ValueError):
    """The text is no quantity of the wanted dimension. `str()` of it says what is wrong, in a few words."""


def parse(value: object, unit: str, assumed: str | None = None) -> float:
    """Return `value` as a number in `unit`.

    The result may be NaN or infinite only where the input says so.

    Args:
        value: a number (not a bool), or text such as "1600 kg".
        unit: the unit of the result, pint spelling; "1" means a plain ratio.
        assumed: the unit of a value that comes without one; None: `unit`.

    Raises:
        UnitError: not a number, or a unit of another dimension.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise UnitError(f"got {brief(value)}")
    number, text = _split(value) if isinstance(value, str) else (_number(value), "")
    if text == "" and assumed is not None:
        text = assumed
    if text in ("", unit):
        return number
    if unit == "1" and text in _ANGLES:
        raise UnitError(f"got an angle, {brief(value)}")
    text = _ALIASES.get(text, text).replace("²", "^2").replace("³", "^3")
    for pattern, spelling in _SPELLINGS:
        text = pattern.sub(spelling, text)
    scale, offset = _conversion(text, unit)
    if "rad" in unit and not _names_an_angle(text):
        raise UnitError(f"got unit {brief(text)}, which names no angle (rpm? rad/s?)")
    return number * scale + offset


def _names_an_angle(text: str) -> bool:
    """Return whether an angle is in the unit: 1/min and Hz would pass for rad/s without their factor of 2 pi."""
    words = {word.rstrip("s") for word in re.findall(r"[^\W\d]+|°", text)}
    return bool(words & {"rad", "radian", "deg", "degree", "°", "rpm", "turn", "revolution", "rotation", "cycle"})


def _split(text: str) -> tuple[float, str]:
    """Return the number and the unit of a text."""
    match = _QUANTITY.match(text)
    if match is not None:
        return float(match.group(1)), match.group(2)
    with contextlib.suppress(ValueError):
        return float(text), ""  # "nan" and "inf": the caller's range check names them
    raise UnitError(f"got {brief(text)}")


def _number(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


@cache
def _conversion(text: str, unit: str) -> tuple[float, float]:
    """Scale and offset from `text` to `unit`."""
    key = f"{text}|{unit}"
    memory = _memory()
    if key not in memory:
        memory[key] = _ask_pint(text, unit)
        with contextlib.suppress(OSError):
            write_atomically(_memory_file(), json.dumps(memory, ensure_ascii=False, indent=0).encode())
    scale, offset = memory[key]
    return scale, offset


def _ask_pint(text: str, unit: str) -> list[float]:
    import pint

    quantity: Any = _registry()
    if not _is_plain(text):
        raise UnitError(f"got unknown unit {brief(text)}")
    try:
        source, target = quantity.Unit(text), quantity.Unit("" if unit == "1" else unit)
        offset = float(quantity.Quantity(0.0, source).to(target).magnitude)
        scale = float(quantity.Quantity(1.0, source).to(target).magnitude) - offset
        twice = float(quantity.Quantity(2.0, source).to(target).magnitude)
    except pint.DimensionalityError:
        raise UnitError(f"got unit {brief(text)} of another dimension") from None
    except Exception:  # noqa: BLE001 - pint raises whatever its tokenizer met (tokenize, attribute, type errors)
        raise UnitError(f"got unknown unit {brief(text)}") from None
    if not math.isclose(twice, 2.0 * scale + offset, rel_tol=1e-9, abs_tol=1e-300):
        raise UnitError(f"got unit {brief(text)}, which is no factor")
    return [scale, offset]


def _is_plain(text: str) -> bool:
    """Return whether the unit is names with powers of one digit: pint would compute 9**9**9 for as long as it takes."""
    tokens = _TOKEN.findall(text)
    if len(text) > 60 or "".join(tokens) != text:
        return False
    words = [token for token in tokens if not token.isspace()]
    for before, word, after in zip(["", *words], words, [*words[1:], ""], strict=False):
        power = before in ("^", "**")
        if word[-1].isdigit() and not word[0].isalpha() and word not in ("1", "-1") and not power:
            return False
        if power and (len(word.lstrip("-")) > 1 or not word[-1].isdigit() or after in ("^", "**")):
            return False
    return True


@cache
def _registry() -> Any:
    import pint

    library: Any = pint
    return library.UnitRegistry(cache_folder=":auto:")


@cache
def _memory() -> dict[str, list[float]]:
    try:
        found = json.loads(_memory_file().read_text())
        return {str(key): [float(scale), float(offset)] for key, (scale, offset) in found.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


@cache
def _memory_file() -> Path:
    # a conversion factor is a fact: it does not change with the version of pint that told it
    return cache_folder() / "units-2.json"


def display(unit: str) -> str:
    """Return `unit` as a person reads it: "N*m" as "N m", "1" as nothing."""
    return {"1": ""}.get(unit, unit.replace("*", " ").replace("^2", "²").replace("^3", "³"))
