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

from bitepoint.controllers.launch_intent import BY_NETWORK, SLOW, URGENT
from bitepoint.identification.intent.decisions import Windows, calibration, windows
from bitepoint.identification.intent.launches import draw_launches

pytestmark = pytest.mark.real_data

STRETCH = 1.33
"""True time over time stamp."""

MOVING, LONGEST = 3.0, 2.0
"""Speed above which a press is no launch, m/s, and time of it that is looked at, s."""

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
    """Pedal and speed, at 100 Hz, of each press out of a released pedal that lasts `LONGEST`, shape (n, samples)."""
    path = folder / "pedal_torque" / "openxc_short_drive_events.csv"
    time, percent = signal(path, "accelerator_pedal_position")
    raster = np.arange(time[0], time[-1], 0.01)
    pedal = np.interp(raster, time, percent / 100.0)
    speed_time, kph = signal(path, "vehicle_speed")
    speed = np.interp(raster, speed_time, kph / 3.6)
    before, after = 10, round(LONGEST / 0.01)
    onsets = np.flatnonzero((pedal[1:] > 0.01) & (pedal[:-1] <= 0.01)) + 1
    kept = [k for k in onsets if k + after <= len(pedal) and (pedal[k : k + after] > 0.01).all()]
    cut = [slice(k - before, k + after) for k in kept]
    return np.array([pedal[part] for part in cut]), np.array([speed[part] for part in cut])


@pytest.fixture(scope="module")
def measured(data_folder: Path) -> Windows:
    return windows(calibration(), *presses(data_folder))


def test_every_measured_press_is_decided_by_the_network(measured: Windows) -> None:
    assert len(measured.intention) >= 8
    assert (measured.status[:, 27:] == BY_NETWORK).all()
    print(
        np.stack(
            [
                measured.highest_pedal[:, -1],
                measured.highest_rate[:, -1],
                measured.intention[:, 27],
                measured.intention[:, -1],
            ],
            axis=1,
        ).round(2)
    )


def test_gentle_presses_are_slow_and_none_of_this_calm_drive_is_urgent_at_once(measured: Windows) -> None:
    last, deepest = measured.intention[:, -1], measured.highest_pedal[:, -1]
    assert (last[deepest < 0.14] == SLOW).all()
    assert (last == URGENT).mean() < 0.5


def test_measured_presses_lie_among_the_generated_ones(measured: Windows) -> None:
    """Depth and highest rate of the measured presses stay within what generated drivers do."""
    launches = draw_launches(5, 100, 10)
    made = windows(calibration(), launches.pedal, launches.speed)
    for name in ("highest_pedal", "highest_rate"):
        low, high = np.quantile(getattr(made, name)[:, -1], [0.005, 0.995])
        values = getattr(measured, name)[:, -1]
        print(name, low, high, values.round(2))
        assert ((values > low) & (values < high)).mean() > 0.7
