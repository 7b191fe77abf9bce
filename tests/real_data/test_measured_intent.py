"""Measured presses of the pedal: what the intention block makes of feet that were not generated.

No log says what its driver intended, so this shows that measured presses are taken up and told apart by their depth
and rate, not how many are told rightly. Logs: OpenXC "Short drive" (Ford; CC BY 4.0), whose time stamps count messages
and are about 1.33 times too short, as its moved distance tells.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pyarrow import csv

from bitepoint.controllers.launch_intent import BY_NETWORK, SLOW, UNUSABLE, URGENT
from bitepoint.identification.intent.decisions import Windows, calibration, windows
from bitepoint.identification.intent.launches import draw_launches

pytestmark = pytest.mark.real_data

STRETCH = 1.33
"""True time over time stamp."""

LENGTH = 1.3
"""Time from pedal onset that is looked at, s."""

Floats = npt.NDArray[np.float64]


def signal(path: Path, name: str) -> tuple[Floats, Floats]:
    """True time and values of one signal of the log."""
    if not path.is_file():
        pytest.skip(f"no {path.parent.name}/{path.name} in the folder of measured data")
    table = csv.read_csv(path, convert_options=csv.ConvertOptions(column_types={"value": "string"}))
    names = np.array(table["signal"].to_pylist())
    chosen = np.flatnonzero(names == name)
    time = table["time_s"].to_numpy()[chosen] * STRETCH
    return time, np.array([float(table["value"][int(k)].as_py()) for k in chosen])


def presses(folder: Path) -> tuple[Floats, Floats]:
    """Pedal and speed, at 100 Hz, of each press out of a released pedal that lasts `LENGTH`, shape (n, samples)."""
    path = folder / "pedal_torque" / "openxc_short_drive_events.csv"
    time, percent = signal(path, "accelerator_pedal_position")
    raster = np.arange(time[0], time[-1], 0.01)
    pedal = np.interp(raster, time, percent / 100.0)
    speed_time, kph = signal(path, "vehicle_speed")
    speed = np.interp(raster, speed_time, kph / 3.6)
    before, after = 10, round(LENGTH / 0.01)
    onsets = np.flatnonzero((pedal[1:] > 0.01) & (pedal[:-1] <= 0.01)) + 1
    kept = [k for k in onsets if k + after <= len(pedal) and (pedal[k : k + after] > 0.01).all()]
    cut = [slice(k - before, k + after) for k in kept]
    return np.array([pedal[part] for part in cut]), np.array([speed[part] for part in cut])


@pytest.fixture(scope="module")
def measured(data_folder: Path) -> Windows:
    return windows(calibration(), *presses(data_folder))


LAST = round(LENGTH / 0.01) - 1


def test_starts_are_decided_by_the_network_and_presses_at_speed_by_the_rule(measured: Windows) -> None:
    status = measured.status[:, 27 : LAST + 1]
    assert (status == status[:, :1]).all()
    assert (status[:, 0] == BY_NETWORK).sum() >= 5
    assert (status[:, 0] == UNUSABLE).sum() >= 5


def test_no_start_of_this_calm_drive_ends_as_urgent_and_the_gentlest_are_slow(measured: Windows) -> None:
    starts = measured.status[:, LAST] == BY_NETWORK
    told, depth = measured.intention[starts, LAST], measured.highest_pedal[starts, LAST]
    assert not (told == URGENT).any()
    assert (told[np.argsort(depth)[:2]] == SLOW).all()


def test_measured_presses_lie_among_the_generated_ones(measured: Windows) -> None:
    """Depth and highest rate of measured presses stay within what generated drivers do, at its gentle end."""
    launches = draw_launches(5, 100, 10)
    made = windows(calibration(), launches.pedal, launches.speed)
    for name in ("highest_pedal", "highest_rate"):
        low, high = np.quantile(getattr(made, name)[:, LAST], [0.002, 0.998])
        values = getattr(measured, name)[:, LAST]
        assert ((values > low) & (values < high)).mean() > 0.8
