"""The optimal launch as a nonlinear programme: direct collocation in two phases, solved by IPOPT through CasADi.

Held, until the clutch torque reaches what the vehicle starts to move at, and moving, until engine and clutch turn as
one. States are engine speed, clutch speed, clutch torque and engine torque, controls the change rates of both torques,
constant over each interval. The states follow the Hermite-Simpson rule [1], of order 4 and exact for all but the
engine's friction and the air.

[1] Hargraves, Paris: Direct trajectory optimization using nonlinear programming and collocation, J. Guidance 10 (1987)
    4, doi:10.2514/3.20223
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.launch_vehicle import LaunchVehicle
from bitepoint.recording import Floats

SCALE = 100.0
"""What states are divided by, rad/s and N m."""

CORNER = 0.5
"""Range over which the corners of the engine's torque limits are rounded, rad/s."""

HELD_SHARE = 8
"""One interval of the held phase for so many of the moving one."""

OPTIONS: Mapping[str, Any] = {
    "print_time": False,
    "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 400, "tol": 1e-8, "bound_relax_factor": 0.0},
}
"""Of CasADi and IPOPT; without relaxed bounds a solution keeps its limits to the last digit."""


@dataclass(frozen=True)
class Task:
    """What is asked of one launch; None where it is free.

    Attributes:
        jerk: largest magnitude, m/s^3.
        latest: when engine and clutch have to be as one, s; no earlier either where the vehicle rolls off by itself.
        end_speed: of the vehicle at that moment, m/s.
        work_weight (1/J), time_weight (1/s), smoothing (1/s): the sum of work, time and roughness that is to be least.
            Roughness is the sum of the squares of both slews, each over its limit, integrated over time, s: with a
            small weight it picks a smooth one of launches that are as good, and ends the search sooner.
    """

    jerk: float
    latest: float | None
    end_speed: float | None
    work_weight: float
    time_weight: float
    smoothing: float


@dataclass(frozen=True)
class Solution:
    """What IPOPT found.

    Attributes:
        status: of IPOPT, "Solve_Succeeded" for an optimum; solved: whether it is one.
        violation: largest distance of a constraint to its bounds, in scaled units.
        iterations: of IPOPT.
        time: s, shape (points,); states: engine speed, clutch speed, clutch torque, engine torque, shape (4, points).
        friction_work: J; launch_time: s; moving_time: s, its last part.
        raw: the point itself, scaled, to start another search from.
    """

    status: str
    solved: bool
    violation: float
    iterations: int
    time: Floats
    states: Floats
    friction_work: float
    launch_time: float
    moving_time: float
    raw: Floats


@dataclass(frozen=True)
class _Phase:
    """One phase in symbols: scaled variables with bounds, constraints with bounds, and what the objective needs."""

    variables: Any
    lower: Floats
    upper: Floats
    constraints: Sequence[tuple[Any, float, float]]
    states: Any
    last_rates: Any
    duration: Any
    work: Any
    effort: Any


def load_casadi() -> Any:
    """Return the module casadi.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module("casadi")
    except ImportError:
        raise InputError("bounds", "need CasADi to be computed", "pip install 'bitepoint[bounds]'") from None


@lru_cache(maxsize=8)
def program(vehicle: LaunchVehicle, engine_torque_rate: float, intervals: int) -> LaunchProgram:
    """Return the programme of a vehicle, built once."""
    return LaunchProgram(vehicle, engine_torque_rate, intervals)


class LaunchProgram:
    """All launches of one vehicle, as one programme whose bounds and weights are data.

    Args:
        engine_torque_rate: fastest change of the engine torque, N m/s.
        intervals: of the moving phase.
    """

    def __init__(self, vehicle: LaunchVehicle, engine_torque_rate: float, intervals: int) -> None:
        self._casadi = casadi = load_casadi()
        self.vehicle, self.rates = vehicle, (vehicle.model.torque_rate_limit, engine_torque_rate)
        self.counts = (max(intervals // HELD_SHARE, 2), intervals)
        jerk, work_weight, time_weight, smoothing = weights = casadi.SX.sym("weights", 4).elements()
        held, moving = (self._phase(count, held=k == 0, jerk=jerk) for k, count in enumerate(self.counts))
        model, end = vehicle.model, moving.states[:, -1]
        start = np.array([vehicle.idle_speed, 0.0, 0.0, model.engine_friction * vehicle.idle_speed])
        launch_time, work = held.duration + moving.duration, held.work + moving.work
        constraints = [
            *held.constraints,
            *moving.constraints,
            ((held.states[:, 0] - start) / SCALE, 0.0, 0.0),
            ((held.states[:, -1] - moving.states[:, 0]) / SCALE, 0.0, 0.0),
            ((held.states[2, -1] - vehicle.release_torque) / SCALE, 0.0, 0.0),
            ((end[0] - end[1]) / SCALE, 0.0, 0.0),
            ((moving.last_rates[0] - moving.last_rates[1]) / SCALE, 0.0, 0.0),
            (launch_time, 0.0, np.inf),
            (end[1] * model.metres_per_radian, 0.0, np.inf),
        ]
        self.lower, self.upper = (
            np.concatenate([np.full(expression.numel(), row[k]) for expression, *row in constraints]) for k in (0, 1)
        )
        self.variables = [np.concatenate(pair) for pair in ((held.lower, moving.lower), (held.upper, moving.upper))]
        variables = casadi.vertcat(held.variables, moving.variables)
        problem = {
            "x": variables,
            "p": casadi.vertcat(*weights),
            "f": work_weight * work + time_weight * launch_time + smoothing * (held.effort + moving.effort),
            "g": casadi.vertcat(*(casadi.vec(expression) for expression, *_ in constraints)),
        }
        self.solver = casadi.nlpsol("launch", "ipopt", problem, dict(OPTIONS))
        self.figures = casadi.Function("figures", [variables], [work, held.duration, moving.duration])

    def _phase(self, count: int, *, held: bool, jerk: Any) -> _Phase:
        casadi, vehicle, model = self._casadi, self.vehicle, self.vehicle.model
        states, slews = casadi.SX.sym("x", 4, count + 1), casadi.SX.sym("u", 2, count)
        duration = casadi.SX.sym("duration")
        x, u, h = SCALE * states, casadi.diag(casadi.DM(self.rates)) @ slews, duration / count
        before, after = x[:, :-1], x[:, 1:]
        first, last = self._rates(before, u, held=held), self._rates(after, u, held=held)
        middle = (before + after) / 2 + h / 8 * (first - last)
        steps = after - before - h / 6 * (first + 4 * self._rates(middle, u, held=held) + last)
        work = h / 6 * casadi.sum2(_heat(before) + 4 * _heat(middle) + _heat(after))
        highest, lowest = (self._corners(x[0, :], torque) for torque in (vehicle.highest_torque, vehicle.lowest_torque))
        constraints = [
            (steps / SCALE, 0.0, 0.0),
            ((x[3, :] - highest) / SCALE, -np.inf, 0.0),
            ((x[3, :] - lowest) / SCALE, 0.0, np.inf),
        ]
        if not held:
            constraints.append(((x[0, :] - x[1, :]) / SCALE, 0.0, np.inf))
            constraints += [
                (self._jerk(at, u, rates) / jerk, -1.0, 1.0) for at, rates in ((before, first), (after, last))
            ]
        torque = vehicle.release_torque if held else model.torque_limit
        longest = np.inf if not held or vehicle.release_torque > 0.0 else 0.0
        low = np.array([vehicle.idle_speed, 0.0, 0.0, -np.inf]) / SCALE
        high = np.array([vehicle.speed_limit, np.inf, torque, np.inf]) / SCALE
        return _Phase(
            casadi.vertcat(casadi.vec(states), casadi.vec(slews), duration),
            np.concatenate((np.tile(low, count + 1), np.full(2 * count, -1.0), [0.0])),
            np.concatenate((np.tile(high, count + 1), np.full(2 * count, 1.0), [longest])),
            constraints, x, last[:, -1], duration, work, h * casadi.sumsqr(slews),
        )  # fmt: skip

    def _rates(self, x: Any, u: Any, *, held: bool) -> Any:
        """Return dx/dt, column by column; held, the vehicle stands."""
        vehicle, model = self.vehicle, self.vehicle.model
        engine = (x[3, :] - x[2, :] - model.engine_friction * x[0, :]) / model.engine_inertia
        air = vehicle.air_coefficient * (x[1, :] / model.ratio) ** 2
        load = (vehicle.grade_torque + vehicle.rolling_torque + air) / model.ratio
        clutch = 0.0 * x[1, :] if held else (model.efficiency * x[2, :] - load) / model.inertia
        return self._casadi.vertcat(engine, clutch, u)

    def _jerk(self, x: Any, u: Any, rates: Any) -> Any:
        """Return the jerk of the vehicle, m/s^3: the derivative of its acceleration."""
        model = self.vehicle.model
        air = 2.0 * self.vehicle.air_coefficient * x[1, :] * rates[1, :] / model.ratio**3
        return model.metres_per_radian * (model.efficiency * u[0, :] - air) / model.inertia

    def _corners(self, speed: Any, torque: Sequence[float]) -> Any:
        """Return the torque over speed: linear between its points, its corners rounded."""
        known = self.vehicle.engine_speeds
        slopes = (np.diff(torque) / np.diff(known)).tolist()
        value = torque[0] + slopes[0] * (speed - known[0])
        for at, (before, after) in zip(known[1:], pairwise(slopes), strict=False):
            if abs(after - before) > 1e-9:
                past = speed - at
                value = value + (after - before) * 0.5 * (past + self._casadi.sqrt(past**2 + CORNER**2))
        return value

    def solve(self, task: Task, start: Floats) -> Solution:
        """Return what IPOPT finds from a starting point, scaled as `Solution.raw` is."""
        lower, upper = self.lower.copy(), self.upper.copy()
        if task.latest is not None:
            upper[-2] = task.latest
            if self.vehicle.rolls_off:
                lower[-2] = task.latest
        if task.end_speed is not None:
            lower[-1] = upper[-1] = task.end_speed
        found = self.solver(
            x0=start, p=[task.jerk, task.work_weight, task.time_weight, task.smoothing],
            lbx=self.variables[0], ubx=self.variables[1], lbg=lower, ubg=upper,
        )  # fmt: skip
        stats, values = self.solver.stats(), np.array(found["g"]).ravel()
        raw = np.array(found["x"]).ravel()
        work, held, moving = (float(figure) for figure in self.figures(raw))
        times, states = zip(*self._unpack(raw), strict=True)
        return Solution(
            str(stats["return_status"]), bool(stats["success"]),
            float(np.maximum(lower - values, values - upper).max()), int(stats["iter_count"]),
            np.concatenate((times[0][:-1] * held, held + times[1] * moving)),
            np.concatenate((states[0][:, :-1], states[1]), axis=1), work, held + moving, moving, raw,
        )  # fmt: skip

    def _unpack(self, raw: Floats) -> list[tuple[Floats, Floats]]:
        """Return, for each phase, its raster over its duration, and its states."""
        parts: list[tuple[Floats, Floats]] = []
        first = 0
        for count in self.counts:
            states = raw[first : first + 4 * (count + 1)].reshape(count + 1, 4).T * SCALE
            parts.append((np.linspace(0.0, 1.0, count + 1), states))
            first += 4 * (count + 1) + 2 * count + 1
        return parts

    def guess(self, moving_time: float, held_time: float, end_speed: float) -> Floats:
        """Return a starting point: a torque that rises to a constant one, an engine that stays ahead of the clutch."""
        vehicle, model = self.vehicle, self.vehicle.model
        final = end_speed / model.metres_per_radian
        share = np.linspace(0.0, 1.0, self.counts[1] + 1)
        rise = np.minimum(share / 0.4, 1.0)
        clutch = final * np.cumsum(rise) / rise.sum()
        torque = vehicle.release_torque + model.inertia * final / moving_time / model.efficiency * rise / rise.mean()
        engine = np.maximum(np.hypot(clutch, 5.0), vehicle.idle_speed)
        drive = (
            torque + model.engine_friction * engine + model.engine_inertia * np.gradient(engine, moving_time * share)
        )
        held = np.linspace(0.0, vehicle.release_torque, self.counts[0] + 1)
        friction = model.engine_friction * vehicle.idle_speed
        phases = (
            (np.array([0.0 * held + vehicle.idle_speed, 0.0 * held, held, held + friction]), held_time),
            (np.array([engine, clutch, torque, drive]), moving_time),
        )
        pieces: list[Floats] = []
        for states, duration in phases:
            step = max(duration, 1e-3) / (states.shape[1] - 1)
            slews = np.diff(states[2:], axis=1) / step / np.array(self.rates)[:, np.newaxis]
            pieces += [states.T.ravel() / SCALE, slews.T.ravel().clip(-0.9, 0.9), np.array([duration])]
        return np.concatenate(pieces)


def _heat(x: Any) -> Any:
    """Return the power that turns to heat in the clutch, W."""
    return x[2, :] * (x[0, :] - x[1, :])
