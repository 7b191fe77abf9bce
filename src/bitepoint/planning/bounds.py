"""The physical optimum of a launch: what no controller can beat on the reduced launch model.

Everything is known beforehand and actuators obey at once. What limits the launch: the range of the engine's torque over
its speed and its change rate, the torque and the torque rate of the clutch, an engine that stays at or above idle, the
jerk. The vehicle is held until the clutch pulls harder than the road, and engine and clutch meet at equal acceleration,
so that the torque goes through the lock without a step.

    least friction work   min W = integral of Tc (we - wc) dt   at a launch time, an end speed and a jerk
    least time            min t                                 at a jerk, and an end speed or none

Both are problems of optimal control on `LaunchVehicle`, solved in `bounds_program`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.launch_vehicle import LaunchVehicle
from bitepoint.planning.bounds_program import LaunchProgram, Solution, Task, program
from bitepoint.recording import Floats

ENGINE_TORQUE_RATE = 800.0
"""Fastest change of the engine torque, N m/s (chosen: intake and turbocharger, no spark)."""

INTERVALS = 60
"""Intervals of the moving phase; twice as many change the friction work by less than 0.1 %."""

KILOJOULE = 1e-3
WORK_TO_TIME = 1e-6
"""Weights of a joule, 1/J: where work is what counts, and in the least time, where of launches that are as fast one
with little heat is to be found."""

SMOOTH_WORK, SMOOTH_TIME = 1e-3, 1e-5
"""Weights of the roughness: they cost 0.01 % of the friction work, and less than 0.1 ms of the time."""


def _nothing() -> Floats:
    return np.empty(0)


@dataclass(frozen=True)
class Bound:
    """An optimal launch, or why there is none: then figures are NaN and trajectories empty.

    Attributes:
        status: "optimal", "infeasible", or "not solved" where the search ended without an answer.
        reason: a sentence.
        launch_time: s, from the pedal to sync; friction_work: J; end_speed: of the vehicle at sync, m/s.
        waiting: part of the launch time in which the engine idles and the clutch is open, s: to start later is a way
            to heat the clutch less, where time is left.
        time: s, shape (points,), and over it engine_speed and clutch_speed (rad/s), clutch_torque and engine_torque
            (N m, steady, viscous friction not taken off), acceleration of the vehicle (m/s^2).
    """

    status: str
    reason: str
    launch_time: float = math.nan
    friction_work: float = math.nan
    end_speed: float = math.nan
    waiting: float = math.nan
    time: Floats = field(default_factory=_nothing)
    engine_speed: Floats = field(default_factory=_nothing)
    clutch_speed: Floats = field(default_factory=_nothing)
    clutch_torque: Floats = field(default_factory=_nothing)
    engine_torque: Floats = field(default_factory=_nothing)
    acceleration: Floats = field(default_factory=_nothing)

    @property
    def optimal(self) -> bool:
        """Whether there is a launch."""
        return self.status == "optimal"


def least_friction_work(
    vehicle: LaunchVehicle,
    launch_time: float,
    end_speed: float,
    jerk: float,
    *,
    engine_torque_rate: float = ENGINE_TORQUE_RATE,
    intervals: int = INTERVALS,
) -> Bound:
    """Return the launch that heats the clutch least.

    Args:
        launch_time: s, from the pedal to sync; end_speed: of the vehicle at sync, m/s; jerk: its largest magnitude,
            m/s^3.
        engine_torque_rate: fastest change of the engine torque, N m/s.
        intervals: of the moving phase.

    Raises:
        InputError: a figure that is not above 0, or no CasADi.
    """
    _refuse(launch_time=launch_time, end_speed=end_speed, jerk=jerk, engine_torque_rate=engine_torque_rate)
    search = program(vehicle, engine_torque_rate, intervals)
    task = Task(jerk, launch_time, end_speed, KILOJOULE, 0.0, SMOOTH_WORK)
    quick = 1.5 * _shortest(vehicle, end_speed, jerk)
    found = search.solve(task, search.guess(min(quick, 0.98 * launch_time), 0.01, end_speed))
    if not found.solved:
        fastest = _fastest(search, jerk, end_speed)
        if fastest.solved and fastest.launch_time > launch_time:
            least = f"a jerk of {jerk:.3g} m/s^3 and an end speed of {end_speed:.3g} m/s"
            return Bound("infeasible", f"{least} take {fastest.launch_time:.3f} s or more, got {launch_time:.3f} s")
        if not fastest.solved:
            return _failed(vehicle, fastest, end_speed)
        found = search.solve(task, fastest.raw)
    return _bound(vehicle, found, launch_time) if found.solved else _failed(vehicle, found, end_speed)


def least_time(
    vehicle: LaunchVehicle,
    jerk: float,
    end_speed: float | None = None,
    *,
    engine_torque_rate: float = ENGINE_TORQUE_RATE,
    intervals: int = INTERVALS,
) -> Bound:
    """Return the fastest launch; arguments and errors as in `least_friction_work`, `end_speed` None: whichever."""
    _refuse(end_speed=1.0 if end_speed is None else end_speed, jerk=jerk, engine_torque_rate=engine_torque_rate)
    found = _fastest(program(vehicle, engine_torque_rate, intervals), jerk, end_speed)
    return _bound(vehicle, found, found.launch_time) if found.solved else _failed(vehicle, found, end_speed)


def _fastest(search: LaunchProgram, jerk: float, end_speed: float | None) -> Solution:
    vehicle = search.vehicle
    speed = end_speed or 1.1 * vehicle.idle_speed * vehicle.model.metres_per_radian
    task = Task(jerk, None, end_speed, WORK_TO_TIME, 1.0, SMOOTH_TIME)
    for slowness in (1.5, 2.5):
        found = search.solve(task, search.guess(slowness * _shortest(vehicle, speed, jerk), 0.01, speed))
        if found.solved:
            break
    return found


def _shortest(vehicle: LaunchVehicle, end_speed: float, jerk: float) -> float:
    """Return a time that no launch is shorter than, s: at the largest jerk, and at the largest torque."""
    model = vehicle.model
    load = (vehicle.grade_torque + vehicle.rolling_torque) / model.ratio
    pull = model.efficiency * min(max(vehicle.highest_torque), model.torque_limit) - load
    at_torque = end_speed / model.metres_per_radian * model.inertia / max(pull, 1.0)
    return max(math.sqrt(2.0 * end_speed / jerk), at_torque)


def _bound(vehicle: LaunchVehicle, found: Solution, launch_time: float) -> Bound:
    model, waiting = vehicle.model, launch_time - found.launch_time
    time, states = found.time + waiting, found.states
    if waiting > 1e-6:
        time, states = np.append(0.0, time), np.column_stack((states[:, 0], states))
    engine, clutch, capacity, torque = states
    load = vehicle.grade_torque + vehicle.rolling_torque + vehicle.air_coefficient * (clutch / model.ratio) ** 2
    pull = np.where(time > time[-1] - found.moving_time - 1e-9, model.efficiency * capacity - load / model.ratio, 0.0)
    scale = model.metres_per_radian
    figures = (launch_time, found.friction_work, scale * float(clutch[-1]), waiting)
    trajectories = (time, engine, clutch, capacity, torque, scale * pull / model.inertia)
    return Bound("optimal", f"found in {found.iterations} iterations", *figures, *trajectories)


def _failed(vehicle: LaunchVehicle, found: Solution, end_speed: float | None) -> Bound:
    lowest = vehicle.idle_speed * vehicle.model.metres_per_radian
    if end_speed is not None and end_speed < lowest:
        return Bound("infeasible", f"an engine at idle meets the clutch at {lowest:.3g} m/s, got {end_speed:.3g} m/s")
    status = "infeasible" if found.status == "Infeasible_Problem_Detected" else "not solved"
    return Bound(status, f"IPOPT ended with {found.status} after {found.iterations} iterations")


def _refuse(**figures: float) -> None:
    for name, figure in figures.items():
        if not 0.0 < figure < math.inf:
            raise InputError("bounds", f"{name}: got {figure:g}", "expected a number above 0")
