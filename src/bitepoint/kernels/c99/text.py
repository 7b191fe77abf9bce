"""Pieces of C text: literals, comments, indentation."""

from __future__ import annotations

import math
import textwrap
import unicodedata
from collections.abc import Iterable, Iterator

from bitepoint.kernels.c99.precision import Precision

WIDTH = 110
_SPELLINGS = {"²": "^2", "³": "^3", "·": "*", "–": "-", "—": "-", "≤": "<=", "≥": ">=", "±": "+-", "→": "->", "µ": "u"}


def plain(text: str) -> str:
    """Return a text in ASCII that cannot end, or begin, a comment."""
    for character, spelling in _SPELLINGS.items():
        text = text.replace(character, spelling)
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return text.replace("*/", "* /").replace("/*", "/ *").replace("//", "/ /")


def comment(text: str) -> Iterator[str]:
    """Yield the lines of a comment; an empty text gives none."""
    lines: list[str] = []
    for paragraph in plain(text).splitlines():
        indent = " " * (len(paragraph) - len(paragraph.lstrip()))
        lines += textwrap.wrap(paragraph.strip(), WIDTH - 3, initial_indent=indent, subsequent_indent=indent) or [""]
    while lines and not lines[-1]:
        lines.pop()
    for number, line in enumerate(lines):
        head = "/* " if number == 0 else " * "
        tail = " */" if number == len(lines) - 1 else ""
        yield (head + line).rstrip() + tail


def indented(lines: Iterable[str], levels: int = 1) -> Iterator[str]:
    """Yield lines moved to the right; preprocessor lines and empty ones stay."""
    for line in lines:
        yield line if not line or line.startswith("#") else "    " * levels + line


def real_literal(value: float, precision: Precision) -> str:
    """Return a float literal that reads back as `value` in this precision.

    Raises:
        OverflowError: the precision has no such number: it would be infinite, or zero.
    """
    if math.isfinite(value) and abs(value) > precision.largest:
        raise OverflowError
    if not math.isfinite(value):
        return "NAN" if math.isnan(value) else ("INFINITY" if value > 0.0 else "-INFINITY")
    number = precision.real_dtype.type(value)
    if number == 0.0 and value != 0.0:
        raise OverflowError
    text = str(number)
    if "e" not in text and "." not in text:
        text += ".0"
    return text + precision.literal
