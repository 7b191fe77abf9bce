"""Fuel of a car on a chassis dynamometer: fitted on two cycles, tested on a third that it never saw."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import bitepoint
from bitepoint.api import FuelIdentification
from bitepoint.identification.fuel.engine_map import EnginePoints, read_points, relative_weight, smooth_map
from bitepoint.identification.fuel.measured import with_points
from bitepoint.identification.fuel.steady import fit_willans, vehicle_for, willans_columns
from bitepoint.numerics.tables import lookup_map
from bitepoint.records import Map
from tests.conftest import REPOSITORY, Command

pytestmark = pytest.mark.real_data

TRAIN = ("camry2018_61811012_udds.csv", "camry2018_61811013_hwfet_x2.csv")
UNSEEN = "camry2018_61811014_us06_run1.csv"


@pytest.fixture(scope="module")
def folder(data_folder: Path) -> Path:
    return data_folder / "fuel_dyno"


@pytest.fixture(scope="module")
def found(folder: Path) -> FuelIdentification:
    car = REPOSITORY / "examples" / "camry-2018.yaml"
    return bitepoint.identify_fuel([folder / name for name in TRAIN], validate=folder / UNSEEN, vehicle=car)


def test_the_unseen_cycle_is_met(bitepoint: Command, folder: Path) -> None:
    logs = [str(folder / name) for name in TRAIN]
    done = bitepoint("identify", *logs, "--model", "fuel", "--validate", str(folder / UNSEEN), "--json")
    errors = json.loads(done.out)["errors"]["validation"]
    assert abs(errors["total_percent"]) <= 2.0
    assert errors["r2"] >= 0.83
    assert errors["rows"] == 645


def test_the_spike_of_the_urban_cycle_is_left_out(found: FuelIdentification) -> None:
    dropped = found.dropped()
    assert {(row["file"], row["time"]) for row in dropped} >= {(TRAIN[0], 311.0)}
    assert len(dropped) < 0.02 * len(found.drive)


def test_what_the_other_models_are_worth_there(found: FuelIdentification) -> None:
    errors = {(each.kind, each.name): each.errors["validation"] for each in found.tried}
    steady = next(error for (kind, _), error in errors.items() if kind == "steady")
    corrected = max(error.r2 for (kind, _), error in errors.items() if kind == "steady and correction")
    assert steady.r2 > 0.83
    assert corrected > 0.83
    assert -9.0 < steady.total_percent < -5.0  # harder driving takes more than the two cycles can tell
    assert errors["plain", "cubic"].total_percent < -20.0  # held at the edge of its hull


def test_the_steady_engine_is_one_that_could_exist(found: FuelIdentification) -> None:
    steady = next(each.model for each in found.tried if each.kind == "steady").vehicle
    assert steady is not None
    engine = steady["engine"][0]
    speed, torque, flow = engine["fuel"]["x"], engine["fuel"]["y"], engine["fuel"]["z"]
    power = speed[:, None] * torque[None, :]
    efficiency = power / (flow * 42.67e6)
    assert 0.30 < efficiency.max() < 0.46
    idle = float(flow[0, 0])
    assert 5e-5 < idle < 2.5e-4


@pytest.mark.parametrize(
    ("engine", "most"),
    [("saturn_1p9_dohc_gasoline", 0.03), ("vw_1p9_tdi_diesel", 0.045), ("heywood_6p5_di_diesel", 0.015)],
)
def test_a_map_through_two_thirds_of_its_points_meets_the_others(data_folder: Path, engine: str, most: float) -> None:
    """Points of published engine maps below full load, rms over their mean fuel; a Willans line misses more."""
    folder = data_folder / "engine_maps"
    found = read_points(folder / f"{engine}_fuel_map.csv")
    load = np.genfromtxt(folder / f"{engine}_full_load.csv", delimiter=",", skip_header=1)
    below = found.torque <= 1.02 * np.interp(found.speed, load[:, 0] * np.pi / 30.0, load[:, 1])
    left = below & (np.random.default_rng(0).random(found.speed.size) < 0.3)
    some, others = (EnginePoints(found.speed[k], found.torque[k], found.fuel[k]) for k in (below & ~left, left))
    speeds = np.linspace(found.speed[below].min(), found.speed[below].max(), 16)
    torques = np.linspace(0.0, 1.1 * load[:, 1].max(), 16)
    coefficients = fit_willans(some.speed, some.torque, some.fuel, relative_weight(some.fuel))
    x, y = (each.ravel() for each in np.meshgrid(speeds, torques, indexing="ij"))
    base = (willans_columns(x, y) @ coefficients).reshape(16, 16)
    flow = smooth_map(some, speeds, torques, base)[0]
    record = np.repeat(Map.through(speeds.tolist(), torques.tolist(), flow.tolist()), others.speed.size)
    errors = lookup_map.run(record, others.speed, others.torque) - others.fuel
    line = willans_columns(others.speed, others.torque) @ coefficients - others.fuel
    mean = others.fuel.mean()
    assert np.sqrt(np.mean(errors**2)) < most * mean
    assert np.sqrt(np.mean(errors**2)) < 0.7 * np.sqrt(np.mean(line**2))


@pytest.mark.parametrize("engine", ["saturn_1p9_dohc_gasoline", "vw_1p9_tdi_diesel", "heywood_6p5_di_diesel"])
def test_beyond_its_points_a_map_idles_as_these_would(data_folder: Path, engine: str) -> None:
    """At 1000 r/min, against a straight line through the two points of least torque, up to 120 N m off."""
    found = read_points(data_folder / "engine_maps" / f"{engine}_fuel_map.csv")
    car = with_points(vehicle_for(str(REPOSITORY / "examples" / "camry-2018.yaml")), found, engine).vehicle
    turning = 1000.0 * np.pi / 30.0
    row = np.flatnonzero(np.isclose(found.speed, turning))
    low, next_low = row[np.argsort(found.torque[row])[:2]]
    slope = (found.fuel[next_low] - found.fuel[low]) / (found.torque[next_low] - found.torque[low])
    idle = lookup_map.run(car["engine"]["fuel"], np.array([turning]), np.array([0.0]))[0]
    assert idle == pytest.approx(found.fuel[low] - slope * found.torque[low], rel=0.15)
