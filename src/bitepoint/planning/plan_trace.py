"""The steps of a programme as a plan: point by point, with what the engine does between them."""

from __future__ import annotations

import numpy as np

from bitepoint.models.plan import Floats, SpeedPlan
from bitepoint.parts.torque_engine import fuel_flow
from bitepoint.planning.speed_program import Answer
from bitepoint.planning.speed_stage import Stage, coast_end, coast_length, drive_stage, shift_fuel
from bitepoint.records import RecordArray


def trace(task: RecordArray, answer: Answer, dwell: float) -> SpeedPlan:
    """Return the plan that drives the steps of an answer, its figures of the grid left open.

    Args:
        task: one record `SpeedTask`, with the price that the answer was found at.
        dwell: time at each stop line, s, which the engine idles; it stands in the point after the stop.
    """
    steps, stations = answer.steps, answer.stations
    tasks, shift = np.repeat(task, len(steps.start)), steps.shift.astype(bool)
    tasks["road"]["grade"] = stations.grade[steps.start]
    speed = np.sqrt(steps.before)
    rolled = np.where(shift, coast_length.run(tasks, steps.before), 0.0)
    after = np.where(shift, coast_end.run(tasks, speed), speed)
    spin = np.where(shift, shift_fuel.run(tasks, steps.old, steps.gear, speed), 0.0)
    tasks["road"]["grade"] = stations.grade[steps.end - 1]
    length = (stations.distance[steps.end] - stations.distance[steps.start]).round(9) - rolled
    stage = Stage.zeros(len(length))
    drive_stage.run(tasks, steps.gear, np.where(shift, after**2, steps.before), steps.after, length, stage)
    return _plan(task, answer, dwell, _rows(task, answer, stage, rolled, after, spin, length))


def _rows(
    task: RecordArray, answer: Answer, stage: RecordArray, rolled: Floats, after: Floats, spin: Floats, length: Floats
) -> Floats:
    """Return a row per stretch: rolling in neutral, where there is a shift, and driving.

    Columns: length, v at its start and end, time, fuel, gear, shifting, torque, engine speed, brake force, force.
    """
    steps, n = answer.steps, len(length)
    v0, v1, tau = np.sqrt(steps.before), np.sqrt(steps.after), np.full(n, task["shift_time"][0])
    zero, one = np.zeros(n), np.ones(n)
    radius, ratios = task["model"]["vehicle"]["wheel_radius"], task["model"]["gearbox"]["ratios"][0]
    ratio = 0.5 * (ratios[steps.old - 1] + ratios[steps.gear - 1]) * task["model"]["gearbox"]["final_drive"]
    engine = np.maximum(ratio * v0 / radius, task["model"]["launch_speed"])
    rolling = np.column_stack((rolled, v0, after, tau, spin, steps.gear, one, zero, engine, zero, zero))
    names = ("engine_torque", "engine_speed", "brake_force", "force")
    parts = [stage[name] for name in names]
    driving = np.column_stack((length, after, v1, stage["time"], stage["fuel"], steps.gear, zero, *parts))
    rows: Floats = np.stack((rolling, driving), axis=1).reshape(2 * n, -1).astype(np.float64)
    return rows[np.column_stack((steps.shift > 0, one > 0)).ravel()]


def _plan(task: RecordArray, answer: Answer, dwell: float, rows: Floats) -> SpeedPlan:
    distance = np.append(0.0, np.cumsum(rows[:, 0]))
    held = np.vstack((rows, rows[-1]))
    speed = np.append(rows[:, 1], rows[-1, 2])
    time, fuel = np.append(0.0, np.cumsum(rows[:, 3])), np.append(0.0, np.cumsum(rows[:, 4]))
    engine = task["model"]["engine"]
    at_stop = np.interp(distance, answer.stations.distance, answer.stations.stops.astype(np.float64)) > 1.0 - 1e-6
    waits = dwell * np.concatenate(([0.0], np.cumsum(at_stop[:-1])))
    idle = float(fuel_flow.run(engine, engine["idle_speed"][0], 0.0)[0])
    return SpeedPlan(
        "optimal",
        f"{len(answer.stations.distance)} stations, {int(answer.steps.shift.sum())} shifts",
        distance,
        speed,
        time + waits,
        fuel + idle * waits,
        held[:, 5].astype(np.int64),
        held[:, 6] > 0.0,
        np.append(np.diff(speed**2) / (2.0 * np.maximum(rows[:, 0], 1e-9)), 0.0),
        *(np.ascontiguousarray(held[:, k]) for k in (7, 8, 9, 10)),
        time_price=float(task["time_price"][0]),
        cost=answer.cost + float(waits[-1]) * (idle + float(task["time_price"][0])),
    )
