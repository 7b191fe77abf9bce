"""Design of `damping_mpc`: the programme, condensed to what changes from step to step.

All that the programme needs of the future is linear in 15 numbers: the observed state x (8), both shaped torques with
the requests that they follow, and the last command of the motor. Trajectories are kept as matrices of one row per step
and one column per number; `_Future` builds them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from bitepoint.controllers.damping_mpc_records import (
    DISCRETISATIONS,
    PAST,
    SOLVER,
    TORQUE_SCALE,
    WEIGHT_SCALE,
    DampingMpcParameters,
)
from bitepoint.errors import InputError
from bitepoint.estimation.driveline import STATES, design_driveline_observer
from bitepoint.estimation.motor_delay import DELAYS
from bitepoint.models.driveline import ENGINE_TORQUE, DrivelineModel
from bitepoint.parts.amt import GEARS
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

PERIOD = 0.01
"""Time between two steps, s."""

RIDGE = 1e-11
"""Share of the Hessian's trace that is added to its diagonal: nothing beside rounding, but for weights that leave moves
undetermined, and for a model that explodes."""

FIRST, SECOND, REQUEST, ENGINE_FIRST, ENGINE_SECOND, ENGINE_REQUEST, MOTOR_COMMAND = range(STATES, PAST)
"""Places of the numbers behind the state."""


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle with the blocks of a `p2_hybrid`, one record per calibration.

    Raises:
        InputError: forward Euler asked for where it is not stable.
    """
    gears = [n + 1 for n in range(GEARS) if vehicle["gearbox"]["ratios"][0, n] > 0.0]
    models = {gear: DrivelineModel.of(vehicle, gear) for gear in gears}
    parameters = DampingMpcParameters.zeros(len(calibration))
    motor = vehicle["motor"]
    any_gear = models[gears[0]]
    parameters["calibration"] = calibration
    parameters["gear"]["matrices"]["variables"] = 1  # of a gear that there is not
    parameters["motor_share"] = 1.0 - np.exp(-PERIOD / any_gear.motor_lag)
    parameters["motor_delay"] = min(round(float(motor["delay"][0]) / PERIOD), DELAYS - 1)
    parameters["torque_limit"], parameters["rate_limit"] = motor["torque_limit"], motor["torque_rate_limit"]
    parameters["wheel_radius"] = vehicle["vehicle"]["wheel_radius"]
    parameters["rolling_torque"] = any_gear.rolling_torque
    parameters["engine_torque_limit"] = vehicle["engine"]["full_load"]["y"].max()
    for lane, chosen in enumerate(calibration):
        _design_one(parameters[lane : lane + 1], chosen, models)
    matrices = np.ascontiguousarray(parameters["gear"]["matrices"]).reshape(-1)
    SOLVER.factorise.run(matrices)
    parameters["gear"]["matrices"] = matrices.reshape(len(calibration), GEARS)
    for gear in gears:
        if (parameters["gear"]["matrices"]["usable"][:, gear - 1] != 1).any():
            mend = "expected r or rho above 0, or a prediction horizon that every move shows in"
            raise InputError("controller", f"the programme has no unique answer in gear {gear}", mend)
    return parameters


def _design_one(parameters: RecordArray, calibration: np.void, models: dict[int, DrivelineModel]) -> None:
    horizon = int(calibration["prediction_horizon"])
    moves = min(int(calibration["control_horizon"]), horizon)
    shape_engine = bool(calibration["shape_engine"])
    time = float(calibration["engine_shaping_time" if shape_engine else "shaping_time"])
    share = 1.0 - np.exp(-PERIOD / time) if time > 0.0 else 1.0
    parameters["moves"], parameters["shaping_time"], parameters["shaping_share"] = moves, time, share
    weights = (float(calibration["q"]), float(calibration["r"]), float(calibration["rho"]))
    engine, motor, wheel = (float(calibration[f"{name}_speed_noise"]) for name in ("engine", "motor", "wheel"))
    for gear, model in models.items():
        euler = _euler(int(calibration["discretisation"]), gear, model)
        each = parameters["gear"][:, gear - 1]
        each["observer"] = _observer(model, (engine, motor, wheel), euler)
        each["ratio"] = model.ratio
        each["clutch_twist"] = 1.0 / model.clutch_stiffness
        each["halfshaft_twist"] = model.ratio / model.halfshaft_stiffness
        each["open_twist_speed"] = model.opened().twist_speed
        future = _Future(model, horizon, share if time > 0.0 else None, shape_engine, euler)
        _programme(each, future, moves, weights)


def _euler(discretisation: int, gear: int, model: DrivelineModel) -> bool:
    name, limit = DISCRETISATIONS[discretisation], model.euler_limit()
    if name == "euler" and limit < PERIOD:
        raise InputError(
            "controller.discretisation",
            f"forward Euler is stable below {1e3 * limit:.1f} ms in gear {gear}, and the period is {1e3 * PERIOD:g} ms",
            "expected zero_order_hold; euler_unchecked shows what happens",
        )
    return name != "zero_order_hold"


@cache
def _observer(model: DrivelineModel, noise: tuple[float, float, float], euler: bool) -> RecordArray:
    return design_driveline_observer(model, PERIOD, noise, euler=euler)[0]


@cache
def _difference(model: DrivelineModel, euler: bool) -> tuple[Floats, Floats]:
    return model.difference(PERIOD, euler=euler)


def _programme(gear: RecordArray, future: _Future, moves: int, weights: tuple[float, float, float]) -> None:
    """Write the programme in the moves z, in units of TORQUE_SCALE: the motor gives feed forward + z."""
    q, r, rho = weights
    response, error = future.response[:, :moves].copy(), future.error
    response[:, -1] = future.response[:, moves - 1 :].sum(axis=1)
    held = np.ones(moves)
    held[-1] = len(error) - moves + 1
    change = np.eye(moves) - np.eye(moves, k=-1)
    unit = (TORQUE_SCALE / WEIGHT_SCALE) ** 2
    scaled = TORQUE_SCALE * response
    first = change @ future.feed_forward[:moves]  # changes of the torque, should all moves be 0
    first[0, MOTOR_COMMAND] -= 1.0
    gear["feed_forward"][0, :moves] = future.feed_forward[:moves, ENGINE_TORQUE:MOTOR_COMMAND]
    gear["gradient"][0, :moves] = q * scaled.T @ error + r * unit / TORQUE_SCALE * change.T @ first
    hessian = q * scaled.T @ scaled + unit * (r * change.T @ change + rho * np.diag(held))
    matrices = gear["matrices"]
    matrices["variables"], matrices["rows"] = moves, 2 * moves
    matrices["hessian"][0, :moves, :moves] = hessian + RIDGE * np.trace(hessian) * np.eye(moves)
    matrices["constraints"][0, : 2 * moves, :moves] = np.vstack([np.eye(moves), change])


@dataclass(frozen=True)
class _Future:
    """What is foreseen over the horizon.

    Attributes:
        model, horizon: steps of PERIOD.
        share: that each shaping filter answers per step; None where nothing is shaped.
        shape_engine: whether the engine is asked for the shaped torque.
        euler: whether the prediction is by forward Euler.
    """

    model: DrivelineModel
    horizon: int
    share: float | None
    shape_engine: bool
    euler: bool

    @cached_property
    def response(self) -> Floats:
        """Torsional speed after each step per torque of the motor in each, rad/s per N m, shape (horizon, horizon)."""
        return self._responses[1]

    @cached_property
    def feed_forward(self) -> Floats:
        """Torque of the motor that the shaped torque needs in each step, shape (horizon, PAST)."""
        return self._references[0]

    @cached_property
    def error(self) -> Floats:
        """Torsional speed less what is wanted, after each step, with the feed forward alone, (horizon, PAST)."""
        engine, _ = self._responses
        feed_forward, wanted, request = self._references
        free = np.zeros((self.horizon, PAST))
        free[:, :STATES] = self._free
        return free + engine @ request + self.response @ feed_forward - wanted

    @cached_property
    def _free(self) -> Floats:
        a, _ = _difference(self.model, self.euler)
        rows = [self.model.output]
        for _ in range(self.horizon):
            rows.append(rows[-1] @ a)
        return np.array(rows[1:])

    @cached_property
    def _responses(self) -> tuple[Floats, Floats]:
        """Torsional speed after each step per request of engine and motor in each, both (horizon, horizon)."""
        _, b = _difference(self.model, self.euler)
        impulse = np.vstack([self.model.output, self._free[:-1]]) @ b
        lower = np.subtract.outer(np.arange(self.horizon), np.arange(self.horizon))
        engine, motor = (np.where(lower >= 0, impulse[np.abs(lower), n], 0.0) for n in range(2))
        return engine, motor

    @cached_property
    def _references(self) -> tuple[Floats, Floats, Floats]:
        """Feed forward of the motor, torsional speed that is wanted, and request of the engine, by step."""
        unit = np.eye(PAST)
        if self.share is None:
            base = np.tile(unit[REQUEST] - unit[ENGINE_REQUEST], (self.horizon, 1))
            return base, np.zeros_like(base), np.tile(unit[ENGINE_REQUEST], (self.horizon, 1))
        first, second = self._shaped(unit[FIRST], unit[SECOND], unit[REQUEST])
        engine_first, engine_second = self._shaped(unit[ENGINE_FIRST], unit[ENGINE_SECOND], unit[ENGINE_REQUEST])
        time = -PERIOD / np.log(1.0 - self.share)
        rate = (first - second)[1:] / time
        if self.shape_engine:
            request = engine_second[1:]
            torque = self._lagged(request)
            feed_forward = second[1:] - engine_second[1:]
            rate += (request - torque[1:]) / self.model.engine_lag - (engine_first - engine_second)[1:] / time
        else:
            request = np.tile(unit[ENGINE_REQUEST], (self.horizon, 1))
            torque = self._lagged(request)
            feed_forward = 0.5 * (second[:-1] + second[1:] - torque[:-1] - torque[1:])
        return feed_forward, self.model.twist_speed * rate, request

    def _shaped(self, first: Floats, second: Floats, request: Floats) -> tuple[Floats, Floats]:
        """Return both filters from now on, shape (horizon + 1, PAST) each."""
        assert self.share is not None
        firsts, seconds = [first], [second]
        for _ in range(self.horizon):
            firsts.append(firsts[-1] + self.share * (request - firsts[-1]))
            seconds.append(seconds[-1] + self.share * (firsts[-1] - seconds[-1]))
        return np.array(firsts), np.array(seconds)

    def _lagged(self, request: Floats) -> Floats:
        """Return the engine's torque from now on, shape (horizon + 1, PAST)."""
        share = 1.0 - np.exp(-PERIOD / self.model.engine_lag)
        torque = [np.eye(PAST)[ENGINE_TORQUE]]
        for row in request:
            torque.append(torque[-1] + share * (row - torque[-1]))
        return np.array(torque)
