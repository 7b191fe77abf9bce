"""Look-up in curves against numpy.interp."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bitepoint.numerics.tables import lookup
from bitepoint.records import CURVE_POINTS, Curve


def curve(x: list[float], y: list[float]) -> np.ndarray:
    return Curve.through(x, y)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=CURVE_POINTS, unique=True),
    st.data(),
    st.lists(st.floats(-2e3, 2e3), min_size=1, max_size=8),
)
def test_agrees_with_numpy(points: list[float], data: st.DataObject, at: list[float]) -> None:
    x = sorted(round(value, 3) for value in points)
    if len(set(x)) < len(x):
        return
    y = data.draw(st.lists(st.floats(-1e3, 1e3), min_size=len(x), max_size=len(x)))
    found = lookup.run(curve(x, y), np.array(at))
    assert found == pytest.approx(np.interp(at, x, y), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("life", ["compiled", "interpreted"])
def test_ends_points_and_nan(life: str) -> None:
    for points in (2, 3, 31, CURVE_POINTS):
        x = [float(value) for value in range(points)]
        y = [value**2 for value in x]
        at = np.array([-1.0, *x, points + 5.0, 0.5, points - 1.5, np.nan])
        found = lookup.run(curve(x, y), at, life=life)  # pyright: ignore
        assert found[:-1] == pytest.approx(np.interp(at[:-1], x, y))
        assert found[-1] == y[0]
