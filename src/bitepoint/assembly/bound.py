"""How close a run came to the physical optimum: the figure that `report.bound=true` adds."""

from __future__ import annotations

import numpy as np

from bitepoint.metrics import LEAST_STEP, Metric, Metrics
from bitepoint.models.driveline import DrivelineModel
from bitepoint.models.launch_vehicle import LaunchVehicle
from bitepoint.planning.bounds import least_friction_work
from bitepoint.planning.damping_bound import least_torsional_speed
from bitepoint.recording import Recording
from bitepoint.records import RecordArray

LEAST_WORK = 1.0
"""Least friction work, J, that a ratio is formed with: downhill, a launch can do without any."""


def bound_ratio(parameters: RecordArray, status: str, metrics: Metrics, recording: Recording) -> Metric:
    """Return how a run compares with the physical optimum, 1 being the optimum.

    Of a launch: friction work over the least one at the run's own launch time, end speed and jerk. Of a driveline:
    torsional speed over the least possible one when the engine follows the largest step of the driver unshaped.

    Args:
        parameters: of the plant, one record, as the run had them.
        status: of the run; metrics: its figures.
    """
    if "torsional_speed_peak" in metrics:
        return _damping_ratio(parameters, metrics["torsional_speed_peak"].value, recording)
    return _launch_ratio(parameters, status, metrics)


def _damping_ratio(parameters: RecordArray, peak: float | None, recording: Recording) -> Metric:
    request = recording["torque_request"]
    steps = np.abs(np.diff(request))
    if peak is None or steps.size == 0 or steps.max() < LEAST_STEP:
        return Metric(None, "1", f"no step of the driver of {LEAST_STEP:g} N m")
    place = int(steps.argmax())
    motor = parameters["motor"][0]
    best = least_torsional_speed(
        DrivelineModel.of(parameters, int(parameters["gearbox"]["gear"][0])),
        float(request[place]),
        float(request[place + 1]),
        float(motor["torque_limit"]),
        float(motor["torque_rate_limit"]),
        delay=float(motor["delay"]),
    )
    return Metric(peak / best.peak, "1")


def _launch_ratio(parameters: RecordArray, status: str, metrics: Metrics) -> Metric:
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
