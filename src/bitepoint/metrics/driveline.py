"""Figures of a driveline that is excited by changes of torque: how it oscillates, and what damping it costs.

Definitions follow page 2 of the specification's source, made unambiguous: amplitudes are largest magnitudes over the
whole run; jerk is that of `jerk`, but for `jerk_peak_raw`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from bitepoint.metrics.jerk import jerk, raw_jerk
from bitepoint.metrics.metric import Metric, Metrics, energy_residual, existing
from bitepoint.metrics.speed_trace import speed_error_rms, within_tolerance
from bitepoint.recording import Floats, Recording
from bitepoint.records import Record, RecordArray, quantity

LEAST_STEP = 100.0
"""Change of the request between two samples from which it is a step, N m."""

STEP_HOLD = 1.0
"""How long the request must then stay for the step to count, s."""

RESPONSE = 0.9
"""Share of the step that the response has covered at the response time."""


class CostWeights(Record):
    """Weights of the total cost: that of the torque, of the highest jerk, and of the mean jerk."""

    correction_torque: float = quantity("1/(N*m)", 0, 1e6, "of the root mean square of the correction", default=1.0)
    jerk_peak: float = quantity("s^3/m", 0, 1e6, "of the highest jerk", default=1.0)
    mean_absolute_jerk: float = quantity("s^3/m", 0, 1e6, "of the mean magnitude of the jerk", default=1.0)


DRIVELINE_UNITS: Mapping[str, str] = {
    "torsional_speed_peak": "rad/s",
    "acceleration_peak": "m/s^2",
    "jerk_peak": "m/s^3",
    "jerk_peak_raw": "m/s^3",
    "mean_absolute_jerk": "m/s^3",
    "correction_torque_rms": "N*m",
    "mean_acceleration": "m/s^2",
    "torque_response_time": "s",
    "motor_energy": "J",
    "fuel_used": "kg",
    "tyre_slip_peak": "1",
    "speed_error_rms": "m/s",
    "within_tolerance": "1",
    "distance": "m",
    "total_cost": "1",
    "energy_residual": "1",
    "solve_time_p50": "s",
    "solve_time_p999": "s",
}
"""The figures and their units."""

WALL_TIME = "a wall time, of a single run with report.solve_time=true"
"""Why a recording alone has no times of the controller."""


def driveline(recording: Recording, settings: RecordArray) -> Metrics:
    """Return the figures; those whose channels are missing are None."""
    with np.errstate(invalid="ignore", over="ignore"):  # of a run that left the finite numbers
        values = _values(recording)
    parts = [(values[name], float(settings[weight][0])) for name, weight in _COST]
    if all(value is not None for value, _ in parts):
        values["total_cost"] = sum(weight * value for value, weight in parts if value is not None)
    figures = {name: Metric(existing(values.get(name)), unit) for name, unit in DRIVELINE_UNITS.items()}
    if values["torque_response_time"] is None:
        reason = f"no step of {LEAST_STEP:g} N m that is held for {STEP_HOLD:g} s and answered within this time"
        figures["torque_response_time"] = Metric(None, "s", reason)
    return figures | {name: Metric(None, "s", WALL_TIME) for name in ("solve_time_p50", "solve_time_p999")}


_SINCE_START = (("motor_energy", "electric_energy"), ("fuel_used", "fuel_used"), ("distance", "distance"))

_COST = (
    ("correction_torque_rms", "correction_torque"),
    ("jerk_peak", "jerk_peak"),
    ("mean_absolute_jerk", "mean_absolute_jerk"),
)


def _values(recording: Recording) -> dict[str, float | None]:
    time, end = recording.time, float(recording.time[-1])
    values: dict[str, float | None] = {"energy_residual": energy_residual(recording)}
    for name, channel in (
        ("torsional_speed_peak", "torsional_speed"),
        ("acceleration_peak", "vehicle_acceleration"),
        ("tyre_slip_peak", "tyre_slip"),
    ):
        values[name] = float(np.abs(recording[channel]).max()) if channel in recording else None
    smooth, raw = jerk(recording, end), raw_jerk(recording, end)
    values["jerk_peak"] = float(np.abs(smooth).max()) if smooth.size else None
    values["mean_absolute_jerk"] = float(np.abs(smooth).mean()) if smooth.size else None
    values["jerk_peak_raw"] = float(np.abs(raw).max()) if raw.size else None
    speed = recording["vehicle_speed"]
    values["mean_acceleration"] = float(speed[-1] - speed[0]) / (end - float(time[0])) if end > time[0] else None
    values["correction_torque_rms"] = None
    if "correction_torque" in recording:
        values["correction_torque_rms"] = float(np.sqrt(np.mean(recording["correction_torque"] ** 2)))
    values["speed_error_rms"] = speed_error_rms(recording)
    values["within_tolerance"] = within_tolerance(recording)
    for name, channel in _SINCE_START:
        values[name] = float(recording[channel][-1] - recording[channel][0]) if channel in recording else None
    values["torque_response_time"] = torque_response_time(recording)
    return values


def torque_response_time(recording: Recording) -> float | None:
    """Return the longest time, s, from a step of the request until 90 % of it are there, or None.

    What has to be there is the torque of engine and motor together, so that nobody wins by delaying the driver. A step
    counts where the request has changed by 100 N m between two samples and then stays for 1 s; one that is not
    answered within this time makes it None.
    """
    needed = ("torque_request", "engine_torque", "motor_torque")
    if not all(name in recording for name in needed):
        return None
    request, engine, motor = (recording[name] for name in needed)
    times = list(_responses(recording.time, request, engine + motor))
    return max(times) if times and np.isfinite(times).all() else None


def _responses(time: Floats, request: Floats, torque: Floats) -> Iterator[float]:
    for n in np.flatnonzero(np.abs(np.diff(request)) >= LEAST_STEP):
        held = (time >= time[n + 1]) & (time <= time[n + 1] + STEP_HOLD)
        if time[-1] < time[n + 1] + STEP_HOLD or np.abs(request[held] - request[n + 1]).max() > 1e-6:
            continue
        change = request[n + 1] - request[n]
        there = held & ((torque - request[n]) / change >= RESPONSE)
        yield float(time[there][0] - time[n + 1]) if there.any() else np.inf
