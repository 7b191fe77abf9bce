"""Pieces of C text: literals, comments, indentation, long lines."""

from __future__ import annotations

import math
import re
import textwrap
import unicodedata
from collections.abc import Iterable, Iterator, Sequence

from bitepoint.kernels.c99.precision import Precision

WIDTH = 120
"""Most characters of a line."""

_SOFT = 100
"""Where the next word would have gone beyond so many characters, a line of a docstring was ended for want of room."""

_FEWEST_WORDS = 3
"""Fewer words than these do not stay by themselves in the last line of a paragraph."""

_SPELLINGS = {"²": "^2", "³": "^3", "·": "*", "–": "-", "—": "-", "≤": "<=", "≥": ">=", "±": "+-", "→": "->", "µ": "u"}


def plain(text: str) -> str:
    """Return a text in ASCII that cannot end, or begin, a comment."""
    for character, spelling in _SPELLINGS.items():
        text = text.replace(character, spelling)
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return text.replace("*/", "* /").replace("/*", "/ *").replace("//", "/ /")


def comment(text: str, level: int = 0) -> Iterator[str]:
    """Yield the lines of a comment that is to be indented by `level`; an empty text gives none."""
    lines: list[str] = []
    for paragraph in _paragraphs(plain(text)):
        indent = " " * (len(paragraph) - len(paragraph.lstrip()))
        lines += _wrapped(paragraph.strip(), indent, WIDTH - len("/*  */") - 4 * level) or [""]
    while lines and not lines[-1]:
        lines.pop()
    for number, line in enumerate(lines):
        head = "/* " if number == 0 else " * "
        tail = " */" if number == len(lines) - 1 else ""
        yield (head + line).rstrip() + tail


def _paragraphs(text: str) -> Iterator[str]:
    """Yield the lines of a text, those joined again that were parted for want of room alone."""
    held: list[str] = []
    for line in text.splitlines():
        words = line.split(maxsplit=1)
        full = bool(held and words) and len(held[-1]) + 1 + len(words[0]) > _SOFT
        if held and not (full and _indent(line) == _indent(held[0])):
            yield _joined(held)
            held = []
        held.append(line)
    yield _joined(held)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _joined(lines: Sequence[str]) -> str:
    return " ".join([line.strip() if number else line.rstrip() for number, line in enumerate(lines)])


def _wrapped(text: str, indent: str, width: int) -> list[str]:
    """Return a paragraph in as few lines as can be, and no single word or two alone in the last one."""
    best = textwrap.wrap(text, width, initial_indent=indent, subsequent_indent=indent)
    for narrower in range(width, width // 2, -1):
        lines = textwrap.wrap(text, narrower, initial_indent=indent, subsequent_indent=indent)
        if len(lines) > len(best):
            break
        if len(lines) <= 1 or len(lines[-1].split()) >= _FEWEST_WORDS:
            return lines
    return best


def indented(lines: Iterable[str], levels: int = 1) -> Iterator[str]:
    """Yield lines moved to the right; preprocessor lines and empty ones stay."""
    for line in lines:
        yield line if not line or line.startswith("#") else "    " * levels + line


_ATOM = re.compile(r"""
    "(?:[^"\\]|\\.)*" | '(?:[^'\\]|\\.)*'         # text and characters
    | (?P<word>[A-Za-z_]\w*)?(?P<open>[(\[{])   # a call, an index, a group
    | (?P<close>[)\]}])
    | (?P<after>[,;][ ])                        # a line can end behind these
    | [ ](?P<before>[?:]|&&|\|\||[<>=!]=|[<>]|[-+*/])(?=[ ])  # and before these
""", re.VERBOSE)  # fmt: skip
_RANKS = {word: rank for rank, words in enumerate((", ;", "? :", "|| &&", "< > <= >= == !=", "+ -", "* /"))
          for word in words.split()}  # fmt: skip
_CALL = max(_RANKS.values()) + 1
_STATEMENTS = frozenset({"if", "for", "while", "return", "sizeof"})


def c_file(lines: Iterable[str]) -> str:
    """Return the content of a C file, lines that are too long broken where they are held together least."""
    text = "\n".join(lines).rstrip("\n").splitlines()
    return "\n".join(part for line in text for part in _folded(line)) + "\n"


def _folded(line: str) -> Iterator[str]:
    indent = " " * (_indent(line) + 4)
    while len(line) > WIDTH and not line.lstrip().startswith(("/*", "*", "#")):
        place = _break(line)
        if place is None:
            break
        yield line[:place].rstrip()
        line = indent + line[place:].lstrip()
    yield line


def _break(line: str) -> int | None:
    """Return where a line is best broken: at the outermost level, at what binds least there, as late as fits."""
    depth, found = 0, list[tuple[int, int, int]]()
    for match in _ATOM.finditer(line, _indent(line)):
        place = match.start()
        if match["open"]:
            if match["word"] and match["open"] == "(" and match["word"] not in _STATEMENTS:
                found.append((depth, _CALL, -match.end()))
            depth += 1
        elif match["close"]:
            depth -= 1
        elif match["after"]:
            found.append((depth, _RANKS[match["after"].strip()], -match.end()))
        elif match["before"]:
            found.append((depth, _RANKS[match["before"]], -place))
    fitting = [item for item in found if _indent(line) < -item[2] <= WIDTH]
    return -min(fitting)[2] if fitting else None


def real_literal(value: float, precision: Precision) -> str:
    """Return a float literal that reads back as `value` in this precision.

    Raises:
        OverflowError: the precision has no such number: it would be infinite, or zero.
    """
    if math.isfinite(value) and abs(value) > precision.largest:
        raise OverflowError
    if not math.isfinite(value):
        cast = "" if precision.size == 4 else f"({precision.real})"  # the macros of C are of type float
        return f"{'-' if value < 0.0 else ''}{cast}{'NAN' if math.isnan(value) else 'INFINITY'}"
    number = precision.real_dtype.type(value)
    if number == 0.0 and value != 0.0:
        raise OverflowError
    text = str(number)
    if "e" not in text and "." not in text:
        text += ".0"
    return text + precision.literal
