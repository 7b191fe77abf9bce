"""How each plant is driven in the contracts: by the inputs that it has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Inputs = dict[str, Any]


@dataclass(frozen=True)
class Driving:
    """Inputs of one plant.

    Attributes:
        move_off: from the number of the tick, 2 ms: moves off briskly, also on a grade of 20 %, and ends in gear.
        steady, gentle: keep it moving.
        overrun: lets the vehicle drive the engine.
        plausible: from random numbers and the number of lanes: anything that an actuator may be told.
    """

    move_off: Callable[[int], Inputs]
    steady: Inputs
    gentle: Inputs
    overrun: Inputs
    plausible: Callable[[np.random.Generator, int], Inputs]


def dct_plausible(rng: np.random.Generator, lanes: int) -> Inputs:
    return {"throttle": rng.uniform(0, 1, lanes), "clutch_torque_command": sometimes(rng, lanes, 0.7, 0, 300)}


def p2_plausible(rng: np.random.Generator, lanes: int) -> Inputs:
    return {
        "engine_torque_request": rng.uniform(-200, 600, lanes),
        "motor_torque_command": rng.uniform(-400, 400, lanes),
        "clutch_torque_command": sometimes(rng, lanes, 0.7, 0, 600),
        "brake_torque_command": sometimes(rng, lanes, 0.3, 0, 6000),
        "gear_command": np.round(sometimes(rng, lanes, 0.05, 0, 8)),
    }


def conventional_plausible(rng: np.random.Generator, lanes: int) -> Inputs:
    return {
        "engine_torque_request": rng.uniform(-200, 400, lanes),
        "clutch_torque_command": sometimes(rng, lanes, 0.7, 0, 500),
        "brake_torque_command": sometimes(rng, lanes, 0.3, 0, 8000),
        "gear_command": np.round(sometimes(rng, lanes, 0.05, 0, 8)),
    }


def sometimes(rng: np.random.Generator, lanes: int, share: float, low: float, high: float) -> np.ndarray:
    """Uniform numbers in a share of the lanes, 0 in the others."""
    return rng.uniform(low, high, lanes) * (rng.random(lanes) < share)


DRIVING: Mapping[str, Driving] = {
    "dct": Driving(
        move_off=lambda k: {"throttle": 0.6, "clutch_torque_command": min(0.1 * k, 130.0)},
        steady={"throttle": 0.5, "clutch_torque_command": 100.0},
        gentle={"throttle": 0.3, "clutch_torque_command": 50.0},
        overrun={"throttle": 0.0, "clutch_torque_command": 200.0},
        plausible=dct_plausible,
    ),
    "p2_hybrid": Driving(
        move_off=lambda k: {
            "engine_torque_request": min(0.2 * k, 250.0),
            "motor_torque_command": 150.0,
            "clutch_torque_command": min(0.25 * k, 600.0),
        },
        steady={"engine_torque_request": 200.0, "clutch_torque_command": 250.0, "brake_torque_command": 100.0},
        gentle={"engine_torque_request": 50.0, "motor_torque_command": -20.0, "clutch_torque_command": 100.0},
        overrun={"engine_torque_request": -100.0, "motor_torque_command": 0.0, "clutch_torque_command": 600.0},
        plausible=p2_plausible,
    ),
    "conventional": Driving(
        move_off=lambda k: {
            "engine_torque_request": min(0.6 * k, 350.0),
            "clutch_torque_command": min(0.25 * k, 300.0),
            "brake_torque_command": 6000.0 if k < 750 else 0.0,
        },
        steady={"engine_torque_request": 150.0, "clutch_torque_command": 120.0, "brake_torque_command": 100.0},
        gentle={"engine_torque_request": 50.0, "clutch_torque_command": 40.0},
        overrun={"engine_torque_request": -100.0, "clutch_torque_command": 500.0},
        plausible=conventional_plausible,
    ),
}
