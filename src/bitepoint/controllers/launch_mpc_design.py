"""Design of the controller `launch_mpc`: from a vehicle, or a model identified from its logs, to parameters."""

from __future__ import annotations

import numpy as np

from bitepoint.controllers.launch_mpc_records import (
    ENDS,
    MOVES,
    ROWS,
    SEGMENTS,
    SOLVER,
    STEP,
    STEPS,
    LaunchMpcParameters,
)
from bitepoint.errors import InputError
from bitepoint.estimation.engine_torque import design_engine_observer
from bitepoint.estimation.road_torque import design_road_observer
from bitepoint.models.arx import ArxModel
from bitepoint.models.launch import LaunchModel
from bitepoint.recording import Floats
from bitepoint.records import RecordArray
from bitepoint.units import STANDARD_GRAVITY

PERIOD = 0.01
"""Time between two steps, s."""

MOVING_SPEED = 0.03
"""Wheel speed, filtered, above which the vehicle moves, rad/s (chosen: 9 mm/s for a car)."""


def responses() -> tuple[Floats, Floats]:
    """Return the torque after each step per rate of each segment, and its integral; (STEPS, SEGMENTS), s, s^2."""
    ends = STEP * np.array(ENDS)
    starts = np.concatenate([[0.0], ends[:-1]])
    after = (STEP * np.arange(1, STEPS + 1))[:, np.newaxis]
    inside: Floats = np.clip(after - starts, 0.0, ends - starts).astype(np.float64)
    return inside, 0.5 * inside**2 + inside * np.maximum(after - ends, 0.0)


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle on its reduced launch model, one record per calibration."""
    return _designed(vehicle, calibration, LaunchModel.of(vehicle))


def design_on(vehicle: RecordArray, calibration: RecordArray, model: ArxModel) -> RecordArray:
    """Return the parameters with the inertias of an identified model, one record per calibration.

    Raises:
        InputError: the model is of other signals, or has a response of the wrong sign.
    """
    return _designed(vehicle, calibration, LaunchModel.of(vehicle).identified(model))


def _designed(vehicle: RecordArray, calibration: RecordArray, model: LaunchModel) -> RecordArray:
    body = vehicle["vehicle"]
    parameters = LaunchMpcParameters.zeros(len(calibration))
    parameters["calibration"], parameters["engine"] = calibration, vehicle["engine"]
    parameters["road"] = design_road_observer(vehicle, PERIOD, moving_speed=MOVING_SPEED)
    parameters["road"]["slipping_inertia"] = model.inertia * model.ratio**2
    parameters["torque"] = design_engine_observer(model, PERIOD)
    parameters["inertia"], parameters["metres_per_radian"] = model.inertia, model.metres_per_radian
    parameters["weight_radius"] = body["mass"] * body["wheel_radius"]
    parameters["rolling_torque"] = body["rolling_resistance"] * STANDARD_GRAVITY * parameters["weight_radius"]
    parameters["torque_limit"], parameters["rate_limit"] = model.torque_limit, model.torque_rate_limit
    risen, summed = responses()
    at_ends = [end - 1 for end in ENDS]
    clutch, engine = -summed / model.engine_inertia, summed / model.engine_inertia
    slip = np.hstack([clutch - summed * model.efficiency / model.inertia, engine])
    speed = np.hstack([clutch, engine])[at_ends]
    parameters["lengths"] = np.diff([0.0, *ENDS]) * STEP
    parameters["risen"], parameters["slip"], parameters["speed"] = risen, slip, speed
    parameters["matrices"] = _matrices(calibration, slip, risen, speed)
    return parameters


def _matrices(calibration: RecordArray, slip: Floats, risen: Floats, speed: Floats) -> RecordArray:
    matrices = SOLVER.matrices.zeros(len(calibration))
    matrices["variables"], matrices["rows"] = MOVES, ROWS
    tracking = np.zeros((MOVES, MOVES))
    tracking[:SEGMENTS, :SEGMENTS] = risen.T @ risen
    none = np.zeros((SEGMENTS, SEGMENTS))
    at_ends = risen[[end - 1 for end in ENDS]]
    for lane, values in enumerate(calibration):
        rates = np.repeat([values["clutch_rate_weight"], values["engine_rate_weight"]], SEGMENTS)
        matrices["hessian"][lane] = slip.T @ slip + values["torque_weight"] * tracking + np.diag(rates)
    matrices["constraints"] = np.vstack([np.eye(MOVES), np.hstack([at_ends, none]), np.hstack([none, at_ends]), speed])
    if SOLVER.factorise.run(matrices, life="interpreted").any():
        raise InputError("controller", "the weights make no programme that can be solved", "raise the rate weights")
    return matrices
