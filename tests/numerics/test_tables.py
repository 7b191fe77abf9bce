"""Look-up in curves and maps against numpy.interp and scipy.interpolate."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator

from bitepoint.numerics.tables import lookup, lookup_map
from bitepoint.records import CURVE_POINTS, MAP_POINTS, Curve, Map
from tests.conftest import OTHER_LIVES


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


def reference(x: np.ndarray, y: np.ndarray, z: np.ndarray, at: np.ndarray) -> np.ndarray:
    inside = np.clip(at, [x[0], y[0]], [x[-1], y[-1]])
    return RegularGridInterpolator((x, y), z)(inside)


@settings(max_examples=200)
@given(st.integers(2, MAP_POINTS), st.integers(2, MAP_POINTS), st.integers(0, 2**32))
def test_a_map_agrees_with_scipy(rows: int, columns: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = (np.cumsum(rng.uniform(1e-3, 100.0, size)) - 400.0 for size in (rows, columns))
    z = rng.uniform(-1e3, 1e3, (rows, columns))
    inside = rng.uniform([x[0], y[0]], [x[-1], y[-1]], (20, 2))
    grid = np.column_stack([rng.choice(x, 10), rng.choice(y, 10)])
    beyond = rng.uniform([x[0] - 1e3, y[0] - 1e3], [x[-1] + 1e3, y[-1] + 1e3], (10, 2))
    at = np.vstack([inside, grid, beyond])
    found = lookup_map.run(Map.through(x.tolist(), y.tolist(), z.tolist()), at[:, 0].copy(), at[:, 1].copy())
    assert found == pytest.approx(reference(x, y, z, at), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("life", OTHER_LIVES)
def test_a_map_in_the_other_lives_has_the_same_bits(life: str) -> None:
    rng = np.random.default_rng(3)
    for rows, columns in ((2, 2), (2, MAP_POINTS), (MAP_POINTS, 3), (MAP_POINTS, MAP_POINTS)):
        x, y = (np.cumsum(rng.uniform(0.1, 2.0, size)) for size in (rows, columns))
        table = Map.through(x.tolist(), y.tolist(), rng.normal(size=(rows, columns)).tolist())
        odd = [-np.inf, np.inf, np.nan, -1.0, 1e30]
        values = [np.concatenate([axis, rng.uniform(axis[0], axis[-1], 20), odd]) for axis in (x, y)]
        across, along = (points.ravel() for points in np.meshgrid(*values))
        found = lookup_map.run(table, across, along, life=life)  # pyright: ignore
        assert found.tobytes() == lookup_map.run(table, across, along).tobytes()
        assert np.isfinite(found).all()


def test_beyond_a_map_its_edge_holds_and_nan_is_its_first_point() -> None:
    z = [[1.0, 2.0, 3.0], [5.0, 7.0, 11.0]]
    table = Map.through([0.0, 10.0], [0.0, 1.0, 2.0], z)
    at = [(-5.0, 0.5), (99.0, 1.5), (5.0, -np.inf), (np.inf, np.inf), (np.nan, 2.0), (10.0, np.nan), (np.nan, np.nan)]
    across, along = np.array(at).T.copy()
    assert lookup_map.run(table, across, along).tolist() == [1.5, 9.0, 3.0, 11.0, 3.0, 5.0, 1.0]
