"""A scenario of many runs: what differs between them, and the logs that are made of them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from bitepoint.errors import InputError, brief
from bitepoint.records import Record, quantity

MOST_RUNS = 10_000
"""Most runs of one scenario."""

HIGHEST_NUMBER = 4000
"""The number of a run is below this."""


class LogSettings(Record):
    """How a run is logged."""

    period: float = quantity("s", 1e-4, 1, "raster of the log", default=0.01)
    noise: float = quantity(
        "rad/s", 0, 1000, "standard deviation of the speeds' noise; of the wheels' at the clutch", default=0.1
    )


@dataclass(frozen=True)
class Runs:
    """The runs of a scenario.

    Attributes:
        vary: dotted keys of plant or controller with their values: one run for each combination.
        number: dotted key that takes a number drawn for each run, or "".
    """

    vary: Mapping[str, Sequence[Any]]
    number: str

    def lanes(self, settings: Mapping[str, Any], own_controller: bool, seed: int) -> dict[str, list[Any]]:
        """Return the dotted keys that still vary, each with one value per run.

        Args:
            settings: a key that is set does not vary, and a set number is the same for all runs.
            own_controller: False: the keys of the controller are those of another one, and are left out.
            seed: of the numbers.
        """
        free = {
            key: values
            for key, values in self.vary.items()
            if key not in settings and (own_controller or not key.startswith("controller."))
        }
        rows = list(itertools.product(*free.values()))
        lanes: dict[str, list[Any]] = {key: [row[n] for row in rows] for n, key in enumerate(free)}
        if self.number and self.number not in settings and own_controller:
            lanes[self.number] = np.random.default_rng([seed, 1]).integers(0, HIGHEST_NUMBER, len(rows)).tolist()
        return lanes


def parse_runs(value: object, where: str) -> Runs:
    """Return the runs that the block `runs` of a scenario file describes.

    Raises:
        InputError: it is no such block.
    """
    if not isinstance(value, Mapping):
        raise InputError(where, f"runs: got {brief(value)}", "expected a block with vary and perhaps number")
    block = {str(key): item for key, item in cast("Mapping[object, Any]", value).items()}
    unknown = set(block) - {"vary", "number"}
    vary = block.get("vary")
    if unknown or not isinstance(vary, Mapping):
        raise InputError(where, f"runs: got keys {', '.join(block)}", "expected vary, a block, and perhaps number")
    keys = {str(key): cast("Any", values) for key, values in cast("Mapping[object, object]", vary).items()}
    for key, values in keys.items():
        if not isinstance(values, list) or not cast("list[Any]", values) or "." not in key:
            got = brief(cast("object", values))
            raise InputError(where, f"runs.vary.{key}: got {got}", "expected a dotted key with a list")
    count = int(np.prod([len(values) for values in keys.values()], dtype=float))
    if count > MOST_RUNS:
        raise InputError(where, f"runs.vary: {count} combinations", f"expected at most {MOST_RUNS}")
    number = block.get("number", "")
    if not isinstance(number, str) or (number and "." not in number):
        raise InputError(where, f"runs.number: got {brief(number)}", "expected a dotted key")
    return Runs(keys, number)
