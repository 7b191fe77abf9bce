"""Launches of the plant as an observer sees them: columns over lanes at 100 Hz."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import bitepoint
from bitepoint.assembly import PLANTS
from bitepoint.estimation.road_torque import RoadObserverState, observer_reset, observer_step
from bitepoint.kernels import Life
from bitepoint.recording import Recording
from bitepoint.records import RecordArray
from tests.contracts.harness import nominal

GRADES, MASSES = (0.0, 0.05, 0.1, 0.15, 0.2), (1400.0, 1600.0, 1900.0)
EVERY = 5
"""Ticks of 2 ms in a period of 10 ms."""


@cache
def launch(grade: float, mass: float, *more: tuple[str, Any]) -> Recording:
    settings = {"road.grade": grade, "vehicle.mass": mass, **dict(more)}
    result = bitepoint.run("dct-launch", intent="normal", **settings)
    assert result.status == "launched"
    return result.recording


def vehicles(masses: Sequence[float]) -> RecordArray:
    p = np.repeat(nominal(PLANTS["dct"], "dct-t240"), len(masses))
    p["vehicle"]["mass"] = masses
    return p


def column(recordings: Sequence[Recording], name: str) -> np.ndarray:
    """A signal, shape (rows, lanes); lanes that end early stay at their last value."""
    columns = [recording[name][::EVERY] for recording in recordings]
    rows = max(len(values) for values in columns)
    padded = [np.concatenate([values, np.full(rows - len(values), values[-1])]) for values in columns]
    return np.ascontiguousarray(np.array(padded).T)


@dataclass(frozen=True)
class Observed:
    """What came out: estimate, its error, and flags, shape (rows, lanes)."""

    estimate: np.ndarray
    error: np.ndarray
    moving: np.ndarray
    locked: np.ndarray

    def __post_init__(self) -> None:
        assert self.moving[-1].all()

    def slipping(self, recordings: Sequence[Recording], settling: int = 40) -> list[np.ndarray]:
        """The error of each lane from `settling` rows after the motion was seen until the clutch locked."""
        locked = column(recordings, "clutch_locked")
        spans = [(np.argmax(self.moving[:, k]) + settling, np.argmax(locked[:, k])) for k in range(locked.shape[1])]
        return [self.error[start:end, k] for k, (start, end) in enumerate(spans)]

    def driving(self, recordings: Sequence[Recording], settling: int = 40) -> list[np.ndarray]:
        """The error of each lane from `settling` rows after the lock until its recording ends."""
        locked = column(recordings, "clutch_locked")
        starts = np.argmax(locked, axis=0) + settling
        ends = [len(recording.time[::EVERY]) for recording in recordings]
        return [self.error[start:end, k] for k, (start, end) in enumerate(zip(starts, ends, strict=True))]


def observe(
    recordings: Sequence[Recording],
    observer: RecordArray,
    prior: np.ndarray | float = 0.0,
    *,
    clutch: np.ndarray | None = None,
    sigma: float = 0.0,
    seed: int = 0,
    life: Life = "compiled",
) -> Observed:
    """Step an observer through launches; `clutch` is what it takes for the clutch torque, else the command."""
    rng = np.random.default_rng(seed)
    names = ("engine_speed", "wheel_speed", "engine_torque", "road_torque")
    engine_speed, wheel_speed, engine, truth = (column(recordings, name) for name in names)
    if clutch is None:
        clutch = column(recordings, "clutch_torque_command")
    rows, lanes = truth.shape
    state = RoadObserverState.zeros(lanes)
    observer_reset.run(state, prior, life=life)
    out = np.zeros((3, rows, lanes))
    out[0, 0] = prior
    for row in range(1, rows):
        noise = sigma * rng.standard_normal((2, lanes))
        speeds = (engine_speed[row] + noise[0], wheel_speed[row] + noise[1])
        out[0, row] = observer_step.run(observer, state, *speeds, clutch[row - 1], engine[row], life=life)
        out[1, row], out[2, row] = state["moving"], state["locked"]
    return Observed(out[0], out[0] - truth, out[1], out[2])
