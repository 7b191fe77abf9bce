"""Random vehicles: how a controller designed on the nominal one does on a thousand others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from bitepoint.api import run_batch
from bitepoint.assembly import CONTROLLERS
from bitepoint.recording import Floats

RANGES: Mapping[str, tuple[float, float]] = {
    "vehicle.mass": (1400.0, 1900.0),
    "road.grade": (0.0, 0.2),
    "clutch.friction_gain": (0.85, 1.15),
    "engine.torque_gain": (0.9, 1.0),
    "engine.lag": (0.0, 0.1),
}
"""Uniform over these; SI."""

DELAYS = (0.0, 0.004, 0.01, 0.02)
"""Dead times of all speeds, s; a quarter of the vehicles has each."""

SPEEDS = ("engine_speed", "clutch_speed", "wheel_speed")

LIMITS: Mapping[str, tuple[float, float]] = {
    "launch_time": (0.0, 3.0),
    "engine_speed_min": (75.0, np.inf),
    "jerk_peak_settled": (0.0, 12.0),
    "friction_work": (0.0, 15_000.0),
}
"""What a launch has to keep, SI."""


@dataclass(frozen=True)
class Variations:
    """The outcome for one controller.

    Attributes:
        over: what differed, by key, shape (n,) each; delay: dead time, s.
        launched: which launched; metrics: figures by name, NaN where one does not exist.
        kept: which launched and kept each limit, by the name of the figure.
    """

    over: Mapping[str, Floats]
    delay: Floats
    launched: npt.NDArray[np.bool_]
    metrics: Mapping[str, Floats]
    kept: Mapping[str, npt.NDArray[np.bool_]]

    @property
    def share(self) -> float:
        """Share of the vehicles whose launch keeps all limits."""
        return float(np.array(list(self.kept.values())).all(axis=0).mean())


def vary(
    settings: Mapping[str, Any], lanes: int = 1000, seed: int = 1, progress: Callable[[int], None] | None = None
) -> Variations:
    """Run the scenario `dct-launch` with settings on `lanes` random vehicles, the same ones for every controller.

    Args:
        lanes: a multiple of 4: each dead time gets a quarter.
        seed: of the vehicles.
        progress: called with the number of vehicles that have just been run.
    """
    rng = np.random.default_rng(seed)
    over: dict[str, Floats] = {key: rng.uniform(low, high, lanes) for key, (low, high) in RANGES.items()}
    delay = np.repeat(DELAYS, lanes // len(DELAYS))
    parts: list[Any] = []
    for time in DELAYS:
        chosen = {key: values[delay == time] for key, values in over.items()}
        wired = {f"delay.{signal}": f"{time} s" for signal in _seen(settings)} if time > 0.0 else {}
        parts.append(run_batch("dct-launch", chosen, {**settings, **wired}, progress=progress))
    metrics = {name: np.concatenate([part.metrics[name] for part in parts]) for name in parts[0].metrics}
    launched = np.concatenate([part.launched for part in parts])
    with np.errstate(invalid="ignore"):
        kept = {
            name: launched & (metrics[name] >= low) & (metrics[name] <= high) for name, (low, high) in LIMITS.items()
        }
    return Variations(over, delay, launched, metrics, kept)


def _seen(settings: Mapping[str, Any]) -> list[str]:
    measured = CONTROLLERS[str(settings["controller"])].measurement.fields
    return [signal for signal in SPEEDS if signal in measured]
