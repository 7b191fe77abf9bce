"""What a report says of lines that no vector reached: their reason, only where their source gives one."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

from bitepoint.export.c import coverage

SOURCE = """\
static int f(int a, int b)
{
    int y = 0;
    /* a remark; never: a is positive, which
     * is a long story */
    if (a < 0)
    {
        y = 1;
        if (b > 0)
        {
            y = 2;
        }
    }
    else if (b > 3)
    {
        y = 3;
    }
    else
    {
        y = 4;
    }
    /* never: b above 7 */
    if ((a > 5) ||
        (b > 7))
    {
        y = 5;
    }
    return y;
}
"""


def missing(folder: Path, counts: dict[int, int], halves: tuple[int, ...] = ()) -> dict[int, str]:
    """The reasons of the lines that are missing, where the `counts` of lines are these and `halves` of tests lack."""
    lines = [
        {"line_number": number, "count": count, "branches": [{"count": 1}, {"count": int(number not in halves)}]}
        for number, count in counts.items()
    ]
    (folder / "f.c").write_text(SOURCE)
    (folder / "f.json.gz").write_bytes(gzip.compress(json.dumps({"files": [{"file": "f.c", "lines": lines}]}).encode()))
    found = coverage.read(folder / "f.json.gz", folder / "f.c")
    assert found.reached == found.lines_reached + found.branches_reached
    return {item.line: item.reason for item in found.missing}


def test_a_reason_holds_for_its_test_and_for_what_lies_inside(tmp_path: Path) -> None:
    reasons = missing(tmp_path, {3: 9, 6: 9, 8: 0, 9: 0, 11: 0, 14: 9}, (6, 9))
    assert reasons == dict.fromkeys((6, 8, 9, 11), "a is positive, which is a long story")


def test_a_reason_holds_for_nothing_else(tmp_path: Path) -> None:
    reasons = missing(tmp_path, {6: 9, 8: 2, 9: 2, 11: 0, 14: 7, 16: 0, 20: 0, 28: 0}, (9, 14))
    assert reasons == dict.fromkeys((9, 11, 14, 16, 20, 28), "")


def test_a_test_over_two_lines_has_the_reason_above_it(tmp_path: Path) -> None:
    assert missing(tmp_path, {23: 9, 24: 9, 26: 0}, (24,)) == dict.fromkeys((24, 26), "b above 7")


def test_what_is_reached_needs_no_reason_and_its_reason_does_no_harm(tmp_path: Path) -> None:
    assert missing(tmp_path, {6: 9, 8: 2, 23: 9}) == {}
