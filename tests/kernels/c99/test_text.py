"""Lines of C: how long ones are broken, and comments made of docstrings."""

from __future__ import annotations

import pytest

from bitepoint.kernels.c99 import FLOAT32, FLOAT64
from bitepoint.kernels.c99.text import WIDTH, c_file, comment, real_literal

LONG = "some_quite_long_name"
CALL = f"{LONG}({LONG}, {LONG} + 1.0F)"


@pytest.mark.parametrize(
    ("line", "ends"),
    [
        (f"    const float x = ({CALL} * {LONG}) + ({CALL} / {LONG});", [")", "+ "]),
        (f"    const float x = {LONG}({CALL}, {CALL}, 0.0F);", ["(", "some"]),
        (f"    if (({CALL} > 0.0F) && ({CALL} > 0.0F))", [")", "&& "]),
        (f"    return ({LONG} > 0.0F) ? {CALL} : {CALL};", [")", ": "]),
        (f'    print("{LONG}, {LONG} && {LONG} + {LONG}", {LONG}, {LONG});', ["(", '"']),
        (f"    {{{', '.join(['-1.2345678e-12F'] * 12)}}},", [",", "-1"]),
    ],
)
def test_long_lines_are_broken_where_they_bind_least(line: str, ends: list[str]) -> None:
    first, *others = c_file([line]).splitlines()
    assert len(line) > WIDTH >= max(map(len, [first, *others]))
    assert first.endswith(ends[0])
    assert others[0].startswith(f"        {ends[1]}")
    assert "".join("".join([first, *others]).split()) == "".join(line.split())


def test_a_line_that_cannot_be_broken_stays() -> None:
    line = f"x = {'y' * WIDTH};"
    assert c_file([line, "short;"]) == f"{line}\nshort;\n"


def test_a_comment_joins_what_was_parted_for_want_of_room() -> None:
    full = "word " * 21 + "word"
    docstring = f"{full}\nnext of the same sentence.\n\nShort line.\nAnother one.\n    a = b\n    c = d\n"
    lines = [line.lstrip(" /*").removesuffix(" */") for line in comment(docstring)]
    assert lines[0].startswith("word word")
    assert " ".join(lines[:2]) == f"{full} next of the same sentence."
    assert lines[2:] == ["", "Short line.", "Another one.", "a = b", "c = d"]


@pytest.mark.parametrize("level", [0, 3])
@pytest.mark.parametrize("length", range(90, 260, 3))
def test_no_word_of_a_comment_is_left_alone(length: int, level: int) -> None:
    text = ("a word of five and so on " * 20)[:length].strip()
    lines = list(comment(text, level))
    assert max(map(len, lines)) + 4 * level <= WIDTH
    assert len(lines[-1].removesuffix(" */").removeprefix(" * ").split()) >= 3
    assert " ".join(line.removeprefix("/* ").removeprefix(" * ").removesuffix(" */") for line in lines) == text


@pytest.mark.parametrize(("value", "sign"), [(float("nan"), ""), (float("inf"), ""), (-float("inf"), "-")])
def test_what_is_no_number_has_the_type_of_the_precision(value: float, sign: str) -> None:
    name = "NAN" if value != value else "INFINITY"
    assert real_literal(value, FLOAT32) == f"{sign}{name}"
    assert real_literal(value, FLOAT64) == f"{sign}(float64_t){name}"
