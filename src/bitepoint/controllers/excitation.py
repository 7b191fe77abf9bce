"""Excitation for identification: an open-loop launch whose clutch torque jumps between levels.

The engine revs up with the clutch open, the clutch torque rises until the vehicle has moved off and the engine's torque
is balanced, and from then on a pseudo-random sequence of levels is added to it. Throttle and base torque are constant,
so no control ties the signals to each other.

    base torque = max(engine torque at hold_speed, margin * torque at which the vehicle moved off)

The sequence is a Lehmer generator, x(n+1) = 1716 x(n) mod 8191 with the residue of least magnitude. 1716 generates all
residues of the prime 8191, so the period is 8190; every product is exact in float64 and in float32.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bitepoint.controllers.controller import Controller
from bitepoint.controllers.engine_speed import idle_throttle
from bitepoint.kernels import EPSILON, clamp, is_finite, kernel
from bitepoint.parts.engine import engine_torque, throttle_effect
from bitepoint.records import Record, RecordArray, count, nested, quantity

WAITING = 0
REVVING = 1
CLOSING = 2
EXCITING = 3
PHASES = ("waiting", "revving", "closing", "exciting")

MULTIPLIER = 1716.0
MODULUS = 8191.0
LARGEST = 4095.0

MOVING = 0.02
"""Wheel speed above which the vehicle has moved off, rad/s (chosen: 6 mm/s at a car's wheel)."""

START_MARGIN = 1.1
"""Least engine speed at which the clutch begins to close, over the idle speed (chosen)."""


class ExcitationCalibration(Record):
    """What can be set."""

    throttle: float = quantity("1", 0, 1, "throttle at the fully pressed pedal", default=0.3)
    hold_speed: float = quantity("rad/s", 20, 1000, "engine speed at which the base torque balances", default=160.0)
    margin: float = quantity("1", 0.5, 10, "base torque over the torque that moved the vehicle, at least", default=1.0)
    clutch_rate: float = quantity("N*m/s", 1, 1e5, "how fast the base torque rises", default=700.0)
    amplitude: float = quantity(
        "N*m", 0, 1000, "highest level of the sequence; the lowest is its negative", default=8.0
    )
    dwell_min: float = quantity("s", 0.001, 10, "shortest time at a level", default=0.04)
    dwell_max: float = quantity("s", 0.001, 10, "longest time at a level", default=0.15)
    sequence: int = count(0, 4000, "number of the sequence: another one gives other levels", default=0)
    pedal_threshold: float = quantity("1", 0.001, 0.2, "pedal above which it begins", default=0.01)


class ExcitationParameters(Record):
    """What the step reads."""

    calibration: ExcitationCalibration = nested(ExcitationCalibration, "what can be set")
    start_speed: float = quantity("rad/s", 0, 1000, "engine speed at which the clutch begins to close")
    balance_torque: float = quantity("N*m", 0, 10_000, "torque of the engine at hold_speed, without friction")
    idle_throttle: float = quantity("1", 0, 1, "throttle that holds the idle speed, clutch open")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest clutch torque")
    rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the clutch torque")


class ExcitationState(Record):
    """Memory between two steps."""

    phase: int = count(0, 3, "phase of the excitation", names=PHASES)
    random: float = quantity("1", -4095, 4095, "the random number, a whole one")
    goal: float = quantity("N*m", 0, 10_000, "base torque to rise to; 0 while the vehicle stands")
    base: float = quantity("N*m", 0, 10_000, "risen part of the base torque")
    level: float = quantity("N*m", -1000, 1000, "level of the sequence")
    dwell: float = quantity("s", -1, 10, "time left at this level")
    clutch_torque: float = quantity("N*m", 0, 10_000, "commanded clutch torque")


class ExcitationMeasurement(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    wheel_speed: float = quantity("rad/s", -500, 500, "speed of the driven wheels")


class ExcitationCommand(Record):
    """What it commands, and what it does."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of clutch 1")
    excitation_phase: float = quantity("1", 0, 3, "phase of the excitation", names=PHASES)


@kernel
def next_random(s: ExcitationState) -> float:
    """Draw the next random number; return it scaled to -1..1."""
    product = MULTIPLIER * s.random
    turns = product / MODULUS + 1.5 / EPSILON - 1.5 / EPSILON  # what lies between is a whole number: the nearest
    s.random = clamp(product - MODULUS * turns, -LARGEST, LARGEST)
    return s.random / LARGEST


@kernel
def next_level(c: ExcitationCalibration, s: ExcitationState, dt: float) -> float:
    """Return the level of the sequence for the next dt (s), N m."""
    s.dwell = clamp(s.dwell - dt, -1.0, 10.0)
    if s.dwell < 0.5 * dt:
        height = next_random(s)
        length = next_random(s)
        s.level = c.amplitude * height
        s.dwell = clamp(c.dwell_min + 0.5 * (1.0 + length) * (c.dwell_max - c.dwell_min), 0.0, 10.0)
    return s.level


@kernel
def next_phase(p: ExcitationParameters, s: ExcitationState, m: ExcitationMeasurement) -> int:
    """Return the phase after this measurement; letting the pedal go ends everything."""
    phase = s.phase
    if m.pedal <= p.calibration.pedal_threshold:
        phase = WAITING
    elif s.phase == WAITING:
        phase = REVVING
    elif s.phase == REVVING and m.engine_speed >= p.start_speed:
        phase = CLOSING
    elif s.phase == CLOSING and s.goal > 0.0 and s.base >= s.goal:
        phase = EXCITING
    return phase


@kernel
def raise_base(p: ExcitationParameters, s: ExcitationState, wheel_speed: float, dt: float) -> None:
    """Raise the base torque: without end until the vehicle has moved off, from then on to the goal."""
    if s.goal == 0.0 and wheel_speed > MOVING:
        s.goal = clamp(max(p.balance_torque, p.calibration.margin * s.base), 1.0, p.torque_limit)
    limit = s.goal if s.goal > 0.0 else p.torque_limit
    s.base = clamp(s.base + p.calibration.clutch_rate * dt, 0.0, limit)


@kernel
def rest(p: ExcitationParameters, s: ExcitationState) -> None:
    """Forget everything, and begin the sequence anew."""
    s.phase = WAITING
    s.random = float(p.calibration.sequence) + 1.0
    s.goal = 0.0
    s.base = 0.0
    s.level = 0.0
    s.dwell = 0.0


@kernel
def init(p: ExcitationParameters, s: ExcitationState, m: ExcitationMeasurement, c: ExcitationCommand) -> None:
    """Start with the clutch open and the engine idling."""
    rest(p, s)
    s.clutch_torque = 0.0
    c.throttle = p.idle_throttle
    c.clutch_torque_command = 0.0
    c.excitation_phase = 0.0


@kernel
def step(p: ExcitationParameters, s: ExcitationState, m: ExcitationMeasurement, c: ExcitationCommand, dt: float) -> int:
    """Command throttle and clutch for the next dt (s); return 0, or 1 where a measurement is no number.

    A measurement that is no number leaves the commands as they are.
    """
    status = 1
    if is_finite(m.pedal) and is_finite(m.engine_speed) and is_finite(m.wheel_speed):
        status = 0
        s.phase = next_phase(p, s, m)
        c.throttle = clamp(m.pedal, 0.0, 1.0) * p.calibration.throttle
        torque = 0.0
        if s.phase == WAITING:
            rest(p, s)
            c.throttle = p.idle_throttle
        elif s.phase >= CLOSING:
            raise_base(p, s, m.wheel_speed, dt)
            torque = s.base
        if s.phase == EXCITING:
            level = next_level(p.calibration, s, dt)
            torque = s.base + level
        change = p.rate_limit * dt
        torque = clamp(torque, s.clutch_torque - change, s.clutch_torque + change)
        s.clutch_torque = clamp(torque, 0.0, p.torque_limit)
        c.clutch_torque_command = s.clutch_torque
        c.excitation_phase = float(s.phase)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (blocks engine and clutch), one record per calibration.

    The clutch begins to close so far below hold_speed that the engine arrives there as its torque is balanced:
    while the clutch torque rises at a rate r to the balance T, the engine gains T^2 / (2 r J).
    """
    parameters = ExcitationParameters.zeros(len(calibration))
    engine = np.repeat(vehicle["engine"], len(calibration))
    hold, idle = calibration["hold_speed"].copy(), engine["idle_speed"].copy()
    effect = throttle_effect.run(engine, calibration["throttle"].copy(), life="interpreted")
    torque = engine_torque.run(engine, effect, hold, life="interpreted") - engine["friction"] * hold
    parameters["calibration"] = calibration
    rate = np.minimum(calibration["clutch_rate"], vehicle["clutch"]["torque_rate_limit"])
    gain = torque**2 / (2.0 * rate * (engine["inertia"] + engine["transient_loss"]))
    parameters["balance_torque"] = np.clip(torque, 0.0, vehicle["clutch"]["torque_limit"])
    parameters["start_speed"] = np.maximum(hold - gain, START_MARGIN * idle)
    parameters["idle_throttle"] = idle_throttle(engine)
    parameters["torque_limit"] = vehicle["clutch"]["torque_limit"]
    parameters["rate_limit"] = vehicle["clutch"]["torque_rate_limit"]
    return parameters


def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the one calibration, all defaults: amplitude and dwell as a prototype of this bench had them, chosen."""
    return {"default": {}}


CONTROLLER = Controller(
    name="excitation",
    meaning="open loop: constant throttle, clutch torque on pseudo-random levels, for identification",
    plants=("dct",),
    calibration=ExcitationCalibration,
    calibrations=calibrations,
    default_calibration="default",
    parameters=ExcitationParameters,
    state=ExcitationState,
    measurement=ExcitationMeasurement,
    command=ExcitationCommand,
    design=design,
    init=init,
    step=step,
)
