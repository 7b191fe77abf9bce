"""The driver's launch intention: slow, normal or urgent, and from it the rate at which the slip is to decay.

It runs beside a launch controller and moves nothing. A network of long short-term memory [1] reads the pedal, its rate
and the vehicle speed once per 10 ms from pedal onset on, so its memory is the window since then. The first decision
falls when the window is `window_shortest` long; it is revised until `window_longest` and held from then on, until the
pedal is let go. Where there is no network's decision, a rule over depth and rate of the pedal decides:

    score = highest pedal + rule_lead * highest pedal rate;  slow < rule_normal < normal < rule_urgent < urgent

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014: the slip decays by 1 - D1 per step of 10 ms, D1 by intention.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from bitepoint.controllers.controller import Controller
from bitepoint.files import library_yaml
from bitepoint.kernels import clamp, is_finite, kernel
from bitepoint.numerics.lstm import LstmState, LstmWeights, highest_score, lstm_reset, lstm_step
from bitepoint.records import FloatArray, Record, RecordArray, count, nested, quantity

SLOW, NORMAL, URGENT = 0, 1, 2
INTENTIONS = ("slow", "normal", "urgent")

BY_NETWORK, INCOMPLETE, UNUSABLE = 0, 1, 2
"""Values of `intention_status`."""

FASTEST_PEDAL, FASTEST_LAUNCH = 20.0, 10.0
"""Pedal rate (1/s) and vehicle speed (m/s) to which the inputs are limited."""


class LaunchIntentCalibration(Record):
    """What an engineer tunes, and the trained network."""

    slip_decay: FloatArray = quantity("1", 0.01, 0.99, "D1 for slow, normal and urgent", shape=(3,))
    window_shortest: float = quantity("s", 0.01, 10, "time from pedal onset to the network's first decision")
    window_longest: float = quantity("s", 0.01, 10, "time from pedal onset to its last one")
    switch_margin: float = quantity("1", 0, 10, "lead in the network's score that another intention needs")
    fastest_start: float = quantity("m/s", 0, FASTEST_LAUNCH, "speed at pedal onset above which the rule decides")
    pedal_threshold: float = quantity("1", 0.001, 0.2, "pedal above which the driver wants to move off")
    rate_time: float = quantity("s", 0, 1, "time constant of the filter of the pedal rate")
    rule_lead: float = quantity("s", 0, 10, "pedal per pedal rate")
    rule_normal: float = quantity("1", 0, 10, "score above which the intention is normal")
    rule_urgent: float = quantity("1", 0, 10, "score above which it is urgent")
    network: LstmWeights = nested(LstmWeights, "inputs: pedal, pedal rate in 1/s, vehicle speed in m/s")


class LaunchIntentParameters(Record):
    """What the step reads."""

    calibration: LaunchIntentCalibration = nested(LaunchIntentCalibration, "what an engineer tunes")


class LaunchIntentState(Record):
    """Memory between two steps."""

    time: float = quantity("s", 0, 1e9, "length of the window: time since pedal onset")
    known: int = count(0, 1, "1 where the last pedal was usable")
    broken: int = count(0, 1, "1 where the network cannot use the window")
    intention: int = count(0, 2, "intention", names=INTENTIONS)
    pedal: float = quantity("1", 0, 1, "last pedal")
    pedal_rate: float = quantity("1/s", -FASTEST_PEDAL, FASTEST_PEDAL, "filtered")
    highest_pedal: float = quantity("1", 0, 1, "in the window")
    highest_rate: float = quantity("1/s", 0, FASTEST_PEDAL, "in the window")
    network: LstmState = nested(LstmState, "memory of the network")


class LaunchIntentMeasurement(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")
    vehicle_speed: float = quantity("m/s", -200, 200, "vehicle speed")


class LaunchIntentCommand(Record):
    """What it tells."""

    slip_decay: float = quantity("1", 0.01, 0.99, "D1: share of the slip to be removed in 10 ms")
    launch_intention: float = quantity("1", 0, 2, "intention of the driver", names=INTENTIONS)
    intention_status: float = quantity(
        "1",
        0,
        2,
        "0 by the network; 1 window not complete: by the rule; 2 measurement not usable by it: by the rule, or held",
    )


@kernel
def open_window(s: LaunchIntentState) -> None:
    """Wait for the next pedal onset with an empty window."""
    s.time = 0.0
    s.broken = 0
    s.intention = SLOW
    s.highest_pedal = 0.0
    s.highest_rate = 0.0
    lstm_reset(s.network)


@kernel
def follow_pedal(c: LaunchIntentCalibration, s: LaunchIntentState, pedal: float, dt: float) -> None:
    """Take in a usable pedal; after one that was not, the rate stays as it was."""
    if s.known == 1:
        rate = clamp((pedal - s.pedal) / dt, -FASTEST_PEDAL, FASTEST_PEDAL)
        s.pedal_rate = s.pedal_rate + (rate - s.pedal_rate) * (dt / (c.rate_time + dt))
    s.pedal = pedal
    s.known = 1


@kernel
def widen_window(c: LaunchIntentCalibration, s: LaunchIntentState, speed: float, dt: float) -> None:
    """Take the sample into the window: into what the rule looks at, and into the network's memory.

    A speed that is no number, or a start faster than any in training, leaves the window to the rule.
    """
    starting = s.time < 1.5 * dt
    s.highest_pedal = max(s.highest_pedal, s.pedal)
    s.highest_rate = max(s.highest_rate, s.pedal_rate)
    if not is_finite(speed) or (starting and speed > c.fastest_start):
        s.broken = 1
    if s.broken == 0:
        s.network.inputs[0] = s.pedal
        s.network.inputs[1] = s.pedal_rate
        s.network.inputs[2] = clamp(speed, 0.0, FASTEST_LAUNCH)
        lstm_step(c.network, s.network)


@kernel
def rule_intention(c: LaunchIntentCalibration, s: LaunchIntentState) -> int:
    """Return what the rule makes of the window."""
    score = s.highest_pedal + c.rule_lead * s.highest_rate
    intention = SLOW
    if score > c.rule_urgent:
        intention = URGENT
    elif score > c.rule_normal:
        intention = NORMAL
    return intention


@kernel
def decide(c: LaunchIntentCalibration, s: LaunchIntentState, dt: float) -> int:
    """Write the intention of the window and return the status."""
    best = highest_score(s.network)
    first = s.time < c.window_shortest + 0.5 * dt
    status = BY_NETWORK
    if s.broken == 1:
        status = UNUSABLE
    elif s.time < c.window_shortest - 0.5 * dt:
        status = INCOMPLETE
    if status != BY_NETWORK:
        s.intention = rule_intention(c, s)
    elif first or s.network.scores[best] > s.network.scores[s.intention] + c.switch_margin:
        s.intention = best
    return status


@kernel
def tell(p: LaunchIntentParameters, s: LaunchIntentState, c: LaunchIntentCommand, status: int) -> None:
    """Write the command."""
    c.slip_decay = p.calibration.slip_decay[s.intention]
    c.launch_intention = float(s.intention)
    c.intention_status = float(status)


@kernel
def init(p: LaunchIntentParameters, s: LaunchIntentState, m: LaunchIntentMeasurement, c: LaunchIntentCommand) -> None:
    """Wait for the pedal."""
    open_window(s)
    s.known = 0
    s.pedal = 0.0
    s.pedal_rate = 0.0
    tell(p, s, c, INCOMPLETE)


@kernel
def step(
    p: LaunchIntentParameters, s: LaunchIntentState, m: LaunchIntentMeasurement, c: LaunchIntentCommand, dt: float
) -> int:
    """Tell the intention for the next dt (s), 10 ms as in training; return 0.

    It advises, so it never ends a run: a pedal that is no number holds the intention, and a pedal or speed that is
    none, or too fast a start, leaves the window to the rule; `intention_status` says so.
    """
    status = UNUSABLE
    if not is_finite(m.pedal):
        s.broken = 1
        s.known = 0
    else:
        follow_pedal(p.calibration, s, clamp(m.pedal, 0.0, 1.0), dt)
        if s.pedal <= p.calibration.pedal_threshold:
            open_window(s)
            status = INCOMPLETE
        else:
            s.time = clamp(s.time + dt, 0.0, 1e9)
            if s.time < p.calibration.window_longest + 0.5 * dt:
                widen_window(p.calibration, s, m.vehicle_speed, dt)
            status = decide(p.calibration, s, dt)
    tell(p, s, c, status)
    return 0


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters, one record per calibration; they are the same for every vehicle."""
    parameters = LaunchIntentParameters.zeros(len(calibration))
    parameters["calibration"] = calibration
    return parameters


@cache
def calibrations() -> Mapping[str, Mapping[str, Any]]:
    """Return the calibrations that ship, with their sources, by name."""
    shared = library_yaml("controllers", "launch_intent.yaml")
    trained = library_yaml("controllers", "launch_intent_trained.yaml")
    common = {"network": trained["network"], **trained["rule"]}
    return {name: {**common, **values} for name, values in shared.items()}


CONTROLLER = Controller(
    name="launch_intent",
    meaning="the driver's intention from the pedal, by a trained network; runs beside a launch controller",
    plants=("dct",),
    calibration=LaunchIntentCalibration,
    calibrations=calibrations,
    default_calibration="trained",
    parameters=LaunchIntentParameters,
    state=LaunchIntentState,
    measurement=LaunchIntentMeasurement,
    command=LaunchIntentCommand,
    design=design,
    init=init,
    step=step,
)
