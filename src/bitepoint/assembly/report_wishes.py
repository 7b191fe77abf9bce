"""What `report.*` asks for beside the figures of a single run: its bound, and the times of its controller."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from bitepoint.assembly.settings import SET, Settings
from bitepoint.errors import InputError, brief
from bitepoint.kernels import Life
from bitepoint.metrics import Metric, Metrics
from bitepoint.planning.bounds_program import load_casadi
from bitepoint.recording import Recording
from bitepoint.simulation.step_times import step_times
from bitepoint.simulation.system import Part


class ReportWishes(NamedTuple):
    """Which of them are set."""

    bound: bool
    solve_time: bool


def report_wishes(settings: Settings, family: str, batch: bool) -> ReportWishes:
    """Return what is set; refuse it in a batch, and bounds in an installation that cannot compute them.

    Args:
        family: of the figures of the scenario.
    """
    report = settings.group("report")
    for key in report:
        if key not in ReportWishes._fields:
            known = ", ".join(f"report.{name}" for name in ReportWishes._fields)
            raise InputError(SET, f"report.{key}: unknown key", f"expected one of {known}")
    wishes = ReportWishes(*(_flag(name, report.get(name, False)) for name in ReportWishes._fields))
    for name, wanted in wishes._asdict().items():
        if wanted and batch:
            raise InputError(SET, f"report.{name}: in a batch", "expected a single run")
    if wishes.bound and family == "launch":
        load_casadi()
    return wishes


def _flag(name: str, value: Any) -> bool:
    wanted = {"true": True, "false": False}.get(str(value).lower())
    if wanted is None:
        raise InputError(SET, f"report.{name}: got {brief(value)}", "expected true or false")
    return wanted


def solve_times(controller: Part, recording: Recording, life: Life) -> Metrics:
    """Return the median of the times of the controller's steps in a run, and what one in 1000 of them exceeds, s."""
    seconds = step_times(controller, recording, life).seconds
    shares = {"solve_time_p50": 0.5, "solve_time_p999": 0.999}
    return {name: Metric(float(np.quantile(seconds, share, method="higher")), "s") for name, share in shares.items()}
