"""The lots of launches for training, validation and test, and the figures of network and baselines on the test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bitepoint.identification.intent.baselines import discriminant
from bitepoint.identification.intent.decisions import Windows, windows
from bitepoint.identification.intent.figures import INSTANTS, figures
from bitepoint.identification.intent.launches import PERIOD, Launches, draw_launches
from bitepoint.records import RecordArray

EACH = 25
DRIVERS = {"training": 800, "validation": 60, "test": 100}
SEEDS = {"training": 1, "validation": 2, "test": 3}
"""Launches of each driver, drivers, and seeds of the generator, by purpose. No driver is in two lots."""


@dataclass(frozen=True)
class Lot:
    """Launches for one purpose with their windows."""

    launches: Launches
    windows: Windows


def draw_lot(purpose: str, settings: RecordArray) -> Lot:
    """Return the launches for "training", "validation" or "test", with the windows that a calibration makes of them."""
    launches = draw_launches(SEEDS[purpose], DRIVERS[purpose], EACH)
    return Lot(launches, windows(settings, launches.pedal, launches.speed))


def first_decision(settings: RecordArray) -> int:
    """Return the sample of the window at which the network of a calibration decides first."""
    return round(float(settings["window_shortest"][0]) / PERIOD) - 1


def assess(network: RecordArray, rule: RecordArray) -> dict[str, Any]:
    """Return the figures on the test launches of the step function with the network, and with the rule alone.

    Args:
        network: calibration of `launch_intent`, shape (1,).
        rule: the same, with a window that is never complete.
    """
    lot, by_rule = draw_lot("test", network), draw_lot("test", rule)
    first = first_decision(network)
    return {
        "instants": [round((sample + 1) * PERIOD, 2) for sample in INSTANTS],
        "network": figures(lot.windows.intention, lot.launches, first, first).summary(),
        "rule": figures(by_rule.windows.intention, lot.launches, first, 0).summary(),
    }


def assess_discriminant(training: Lot, test: Lot) -> list[float]:
    """Return the share of test launches that the discriminant decides rightly at each instant."""
    truth = training.launches.intention
    decided = [discriminant(training.windows, truth, test.windows, sample) for sample in INSTANTS]
    return [round(float((found == test.launches.intention).mean()), 4) for found in decided]
