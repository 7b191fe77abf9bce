"""How close a run came to the physical optimum: the figure that `report.bound=true` adds."""

from __future__ import annotations

from bitepoint.assembly.settings import SET, Settings
from bitepoint.errors import InputError, brief
from bitepoint.metrics import Metric, Metrics
from bitepoint.models.launch_vehicle import LaunchVehicle
from bitepoint.planning.bounds import least_friction_work
from bitepoint.planning.bounds_program import load_casadi
from bitepoint.records import RecordArray

LEAST_WORK = 1.0
"""Least friction work, J, that a ratio is formed with: downhill, a launch can do without any."""


def bound_wanted(settings: Settings, batch: bool) -> bool:
    """Return whether `report.bound` is set; then refuse a batch, and an installation that cannot compute bounds."""
    report = settings.group("report")
    for key in report:
        if key != "bound":
            raise InputError(SET, f"report.{key}: unknown key", "expected report.bound")
    wanted = {"true": True, "false": False}.get(str(report.get("bound", False)).lower())
    if wanted is None:
        raise InputError(SET, f"report.bound: got {brief(report['bound'])}", "expected true or false")
    if wanted and batch:
        raise InputError(SET, "report.bound: in a batch", "expected a single run")
    if wanted:
        load_casadi()
    return wanted


def bound_ratio(parameters: RecordArray, status: str, metrics: Metrics) -> Metric:
    """Return the friction work over the least one at the run's own launch time, end speed and jerk.

    Args:
        parameters: of the plant, one record, as the run had them.
        status: of the run; metrics: figures of a launch.
    """
    time, work, speed, jerk = (
        metrics[name].value for name in ("launch_time", "friction_work", "end_speed", "jerk_peak")
    )
    if status != "launched" or time is None or work is None or speed is None or jerk is None:
        return Metric(None, "1", "not launched")
    bound = least_friction_work(LaunchVehicle.of(parameters), time, speed, jerk)
    if not bound.optimal:
        return Metric(None, "1", f"{bound.status}: {bound.reason}")
    if bound.friction_work < LEAST_WORK:
        return Metric(None, "1", f"the least friction work is {bound.friction_work:.1f} J")
    return Metric(work / bound.friction_work, "1")
