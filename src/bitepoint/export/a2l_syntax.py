"""Pieces of ASAP2 text: strings, numbers, formats, identifiers, blocks (ASAM MCD-2 MC 1.7).

All text is ASCII, so that no reader has to guess an encoding.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable, Iterator

from bitepoint.kernels.c99.text import plain

DIGITS = 7
"""Digits that a value is shown with."""

LEAST_DECIMALS, MOST_DECIMALS = 3, 9
"""Fewest and most of them behind the point: a range may be far wider than what happens in it."""


def quoted(text: str) -> str:
    """Return a text as a string literal: one line of ASCII, with quotes and backslashes escaped."""
    spelled = "".join(_spelled(character) for character in text)
    line = " ".join(plain(spelled).split())
    printable = "".join(character for character in line if character.isprintable())
    escaped = printable.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _spelled(character: str) -> str:
    """Return the name of a Greek letter, and anything else as it is."""
    name = "" if character.isascii() else unicodedata.name(character, "")
    match = re.match(r"GREEK (?:SMALL|CAPITAL) LETTER (?:FINAL )?(\w+)", name)
    if match is not None:
        return "lambda" if match.group(1) == "LAMDA" else match.group(1).lower()
    return "deg" if character == "°" else character


def number(value: float) -> str:
    """Return a finite number such that it reads back as the same float64."""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def identifier(text: str) -> str:
    """Return an identifier that resembles a text such as a unit: "N*m*s/rad" as "N_m_s_per_rad"."""
    return re.sub(r"[\W_]+", "_", text.replace("/", "_per_").replace("^", ""), flags=re.ASCII).strip("_")


def display_format(low: float, high: float, whole: bool) -> str:
    """Return the format, as a string literal, that shows a value of this range: "%width.decimals".

    Args:
        whole: whether values are integers.
    """
    largest = max(abs(low), abs(high), 1.0)
    digits = min(int(math.log10(largest)) + 1, DIGITS + MOST_DECIMALS)
    decimals = 0
    if not whole:
        near = min((abs(limit) for limit in (low, high) if limit != 0.0), default=1.0)
        finest = 1 - math.floor(math.log10(near))  # shows the limit that is nearest to 0 with two digits
        decimals = min(max(DIGITS - digits, finest, LEAST_DECIMALS), MOST_DECIMALS)
    width = digits + (decimals + 1 if decimals else 0) + (1 if low < 0.0 else 0)
    return f'"%{width}.{decimals}"'


def block(keyword: str, head: str, body: Iterable[str] = ()) -> Iterator[str]:
    """Yield the lines of a block: its keyword with the parameters that must be there, and what may follow."""
    yield f"/begin {keyword} {head}".rstrip()
    yield from (f"  {line}" if line else line for line in body)
    yield f"/end {keyword}"
