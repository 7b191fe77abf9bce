"""Constants that float32 absorbs are found, with file and line; none that it holds, or that change nothing anyway."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bitepoint.assembly import CONTROLLERS, PLANTS
from bitepoint.kernels import EPSILON, kernel
from bitepoint.kernels.c99 import PRECISIONS, Precision, translate

SMALL = 1e-12
NONE = 0.0


@kernel
def absorbing(x: float) -> float:
    """Return numbers whose constants are gone in float32: next to one, by name, in one of larger magnitude."""
    a = min(x, 1.0 - 1e-12)
    b = x * (1.0 + SMALL)
    c = x + (3.0 * 7.0 - -SMALL)
    return a + b + c


@kernel
def holding(x: float) -> float:
    """Return numbers whose constants are what they seem, and some that are no constants."""
    SMALL = x * 2.0  # noqa: N806 (a local of the same name as the constant)
    a = min(x, 1.0 - EPSILON) + (1.0 - SMALL)
    b = x * (1.0 + 1e-6) + (1.0 + NONE) + 1.0 * 1e-12 + (1.0 - 1e-30)
    return a + b + x - 1e-12


@pytest.mark.parametrize("precision", PRECISIONS.values(), ids=PRECISIONS.keys())
def test_what_float32_absorbs_is_found(precision: Precision) -> None:
    found = translate("sample", {"absorbing_c": absorbing}, precision).absorbed
    assert [item.expression for item in found] == ["1.0 - 1e-12", "1.0 + SMALL", "3.0 * 7.0 - -SMALL"]
    assert {item.file for item in found} == {"tests/kernels/c99/test_absorbed.py"}
    lines = Path(__file__).read_text("utf-8").splitlines()
    assert [item.expression.split()[-1].strip("-") in lines[item.line - 1] for item in found] == [True] * 3


def test_what_float32_holds_is_not() -> None:
    assert list(translate("sample", {"holding_c": holding}, PRECISIONS["float32"]).absorbed) == []


@pytest.mark.parametrize("part", [*CONTROLLERS.values(), *PLANTS.values()], ids=lambda part: part.name)
def test_no_part_has_such_a_constant(part: Any) -> None:
    public = {"part_init": part.init, "part_step": part.step}
    assert list(translate("sample", public, PRECISIONS["float32"]).absorbed) == []
