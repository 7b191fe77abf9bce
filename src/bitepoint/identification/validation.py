"""How well a model tells what was measured: one step ahead, and on its own from the first rows on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bitepoint.identification.regression import Run
from bitepoint.models.arx import ArxModel


@dataclass(frozen=True)
class ChannelErrors:
    """Errors of one output over several runs, in its unit: root mean square, and largest magnitude.

    A free run that leaves the finite numbers has infinite errors.
    """

    one_step_rms: float
    one_step_max: float
    free_run_rms: float
    free_run_max: float


def errors_of(model: ArxModel, runs: Sequence[Run]) -> Mapping[str, ChannelErrors]:
    """Return the errors by output."""
    first = model.warm_up
    with np.errstate(over="ignore", invalid="ignore"):
        one = np.abs(np.vstack([(run.y - model.one_step(run.y, run.u, run.d))[first:] for run in runs]))
        free = np.abs(np.vstack([(run.y - model.free_run(run.y, run.u, run.d))[first:] for run in runs]))
        free[~np.isfinite(free)] = np.inf
        return {
            name: ChannelErrors(
                float(np.sqrt((one[:, n] ** 2).mean())), float(one[:, n].max()),
                float(np.sqrt((free[:, n] ** 2).mean())), float(free[:, n].max()),
            )
            for n, name in enumerate(model.outputs)
        }  # fmt: skip
