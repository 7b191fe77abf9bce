"""Transmission control of an automated gearbox: it launches on the clutch, shifts, and keeps the engine from stalling.

open: the vehicle stands or hardly rolls, the engine idles. launching: the clutch slips and holds the engine at its
launch speed,

    capacity = engine torque + J / launch_time (engine speed - launch speed)

until the gearbox input has caught up. driving: the clutch is closed. releasing: the torque is taken away, the clutch
follows it. shifting: the clutch is open, the gearbox changes gear, and the engine is brought to the speed of the input.
closing: the clutch removes what slip is left, and the torque returns,

    capacity = +-engine torque + J |slip| / closing_time            + while the engine is the faster

and at most a little more than what the driver asks for, so that the vehicle gets its torque back without a blow.
"""

from __future__ import annotations

import numpy as np

from bitepoint.controllers.controller import Controller, only_defaults
from bitepoint.kernels import clamp, is_finite, kernel, to_index
from bitepoint.parts.amt import GEARS
from bitepoint.records import Record, RecordArray, count, nested, quantity

OPEN, LAUNCHING, DRIVING, RELEASING, SHIFTING, CLOSING = range(6)
PHASES = ("open", "launching", "driving", "releasing", "shifting", "closing")

MOVING_TORQUE = 2.0
"""Torque that is wanted, N m, from which the vehicle is to move off; it is to stop moving off below 0."""

HOLDING_TORQUE = 0.5
"""Request with which the engine keeps its speed with the clutch open, N m: with none at all it falls to idle."""

DRIVING_SHARE = 0.97
"""Share of the launch speed that the input has to reach for the clutch to close."""

SLIPPING_SHARE = 0.93
"""The same, below which it slips again."""


class AmtControlCalibration(Record):
    """What can be set."""

    torque_time: float = quantity("s", 0.01, 5, "in which the highest torque is taken away, or returns", default=0.1)
    clutch_time: float = quantity("s", 0.01, 5, "in which the clutch goes from open to its limit", default=0.1)
    release_time: float = quantity("s", 0, 2, "longest time to wait for the torque to be gone", default=0.1)
    released_torque: float = quantity("N*m", 0.1, 500, "torque of the engine that counts as gone", default=15.0)
    matching_time: float = quantity("s", 0.01, 2, "in which the open engine comes to the input's speed", default=0.06)
    closing_time: float = quantity("s", 0.01, 2, "in which a slip falls to 1/e while the clutch closes", default=0.06)
    closing_share: float = quantity(
        "1",
        0.01,
        5,
        "share of the highest torque that the closing clutch may carry beyond what the driver asks",
        default=0.2,
    )
    launch_time: float = quantity("s", 0.01, 2, "in which the engine returns to its launch speed", default=0.1)
    closing_slip: float = quantity("rad/s", 0.1, 50, "slip below which the clutch counts as closed", default=5.0)
    opening_share: float = quantity("1", 1, 3, "input speed over idle speed below which the clutch opens", default=1.1)


class AmtControlParameters(Record):
    """What the step reads."""

    calibration: AmtControlCalibration = nested(AmtControlCalibration, "what can be set")
    torque_limit: float = quantity("N*m", 1, 10_000, "highest capacity of the clutch")
    engine_torque: float = quantity("N*m", 1, 5000, "highest torque of the engine")
    engine_inertia: float = quantity("kg*m^2", 0, 20, "of the engine")
    launch_speed: float = quantity("rad/s", 20, 500, "speed of the engine while the clutch slips", default=100.0)
    idle_speed: float = quantity("rad/s", 20, 300, "of the engine", default=80.0)


class AmtControlState(Record):
    """Memory between two steps."""

    phase: int = count(0, 5, "what the gearbox does", names=PHASES)
    gear: int = count(0, GEARS, "commanded gear")
    elapsed: float = quantity("s", 0, 1e6, "time in the phase")
    torque: float = quantity("N*m", -500, 5000, "last torque request")
    capacity: float = quantity("N*m", 0, 10_000, "last capacity of the clutch")


class AmtControlMeasurement(Record):
    """What it sees."""

    engine_torque_wanted: float = quantity("N*m", -500, 5000, "torque of the engine that the driver asks for")
    gear_wanted: float = quantity("1", 0, 8, "gear that the driver asks for; 0 keeps the one there is")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    clutch_speed: float = quantity("rad/s", -2000, 2000, "speed of the driven plate of the clutch")
    engine_torque: float = quantity("N*m", -500, 5000, "torque of the engine, as its control unit reports it")
    gear: float = quantity("1", 0, 8, "engaged gear; 0 while shifting")


class AmtControlCommand(Record):
    """What it commands."""

    engine_torque_request: float = quantity("N*m", -500, 5000, "torque that the engine is asked for")
    clutch_torque_command: float = quantity("N*m", 0, 10_000, "commanded capacity of the clutch; 0 opens it")
    gear_command: float = quantity("1", 0, 8, "gear to be engaged")
    shift_phase: float = quantity("1", 0, 5, "what the gearbox does", names=PHASES)


@kernel
def enter(s: AmtControlState, phase: int) -> None:
    """Begin a phase."""
    s.phase = max(min(phase, 5), 0)
    s.elapsed = 0.0


@kernel
def phase_in_gear(p: AmtControlParameters, m: AmtControlMeasurement) -> int:
    """Return the phase that a vehicle in gear, with the clutch open, goes to: what speed and driver ask for."""
    phase = OPEN
    if m.clutch_speed >= DRIVING_SHARE * p.launch_speed:
        phase = CLOSING
    elif m.engine_torque_wanted > MOVING_TORQUE:
        phase = LAUNCHING
    return phase


@kernel
def leave_slipping(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement) -> None:
    """Leave the phases in which the clutch slips, closing and launching, where their time has come."""
    closed = abs(m.engine_speed - m.clutch_speed) < p.calibration.closing_slip
    slow = m.clutch_speed < p.calibration.opening_share * p.idle_speed
    stays = m.engine_torque_wanted >= 0.0
    if closed and (s.phase == CLOSING or m.clutch_speed >= DRIVING_SHARE * p.launch_speed):
        enter(s, DRIVING)
    elif (s.phase == CLOSING and slow) or (s.phase == LAUNCHING and not stays):
        enter(s, OPEN)


@kernel
def leave_driving(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement) -> None:
    """Leave driving where the engine would turn too slowly."""
    if m.clutch_speed < p.calibration.opening_share * p.idle_speed:
        enter(s, OPEN)
    elif m.clutch_speed < SLIPPING_SHARE * p.launch_speed and m.engine_torque_wanted > MOVING_TORQUE:
        enter(s, LAUNCHING)


@kernel
def choose_phase(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement, dt: float) -> None:
    """Advance the phase."""
    s.elapsed = min(s.elapsed + dt, 1e6)
    gear = to_index(m.gear + 0.5, 0, GEARS)
    wanted = to_index(m.gear_wanted + 0.5, 0, GEARS)
    another = wanted != 0 and wanted != s.gear
    if s.phase == SHIFTING:
        if gear == s.gear:
            enter(s, phase_in_gear(p, m))
    elif s.phase == RELEASING:
        if s.capacity <= 0.0:
            s.gear = wanted if another else s.gear
            enter(s, SHIFTING)
    elif another and s.phase != CLOSING:
        enter(s, RELEASING)
    elif s.phase == OPEN:
        enter(s, phase_in_gear(p, m))
    elif s.phase == DRIVING:
        leave_driving(p, s, m)
    else:
        leave_slipping(p, s, m)


@kernel
def wanted_torque(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement) -> float:
    """Return the torque, N m, to ask of the engine in this phase; the driver's, unless a shift takes it away."""
    torque = clamp(m.engine_torque_wanted, -500.0, 5000.0)
    if s.phase == OPEN:
        torque = 0.0
    elif s.phase == RELEASING:
        torque = -p.engine_torque
    elif s.phase == SHIFTING:
        missing = clamp(m.clutch_speed, p.idle_speed, 2000.0) - clamp(m.engine_speed, -2000.0, 2000.0)
        torque = p.engine_inertia * missing / p.calibration.matching_time
        if missing > -p.calibration.closing_slip:
            torque = max(torque, HOLDING_TORQUE)
    return clamp(torque, -p.engine_torque, p.engine_torque)


@kernel
def wanted_capacity(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement) -> float:
    """Return the capacity, N m, that the clutch is to have in this phase."""
    given = clamp(m.engine_torque, -500.0, 5000.0)
    slip = clamp(m.engine_speed - m.clutch_speed, -4000.0, 4000.0)
    capacity = 0.0
    if s.phase == DRIVING:
        capacity = p.torque_limit
    elif s.phase == LAUNCHING:
        excess = clamp(m.engine_speed, -2000.0, 2000.0) - p.launch_speed
        capacity = given + p.engine_inertia * excess / p.calibration.launch_time
    elif s.phase == CLOSING:
        carried = given if slip > 0.0 else -given
        most = abs(clamp(m.engine_torque_wanted, -500.0, 5000.0)) + p.calibration.closing_share * p.engine_torque
        capacity = min(carried + p.engine_inertia * abs(slip) / p.calibration.closing_time, most)
    elif s.phase == RELEASING:
        gone = abs(given) < p.calibration.released_torque or s.elapsed >= p.calibration.release_time
        capacity = 0.0 if gone else min(abs(given) + p.calibration.released_torque, s.capacity)
    return clamp(capacity, 0.0, p.torque_limit)


@kernel
def command(
    p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement, c: AmtControlCommand, dt: float
) -> None:
    """Write the commands of the phase: no change is faster than its time."""
    change = p.engine_torque / p.calibration.torque_time * dt
    torque = wanted_torque(p, s, m)
    limited = clamp(torque, s.torque - change, s.torque + change)
    s.torque = torque if s.phase == SHIFTING else clamp(limited, -500.0, 5000.0)
    change = p.torque_limit / p.calibration.clutch_time * dt
    s.capacity = clamp(wanted_capacity(p, s, m), s.capacity - change, s.capacity + change)
    s.capacity = clamp(s.capacity, 0.0, p.torque_limit)
    c.engine_torque_request = s.torque
    c.clutch_torque_command = s.capacity
    c.gear_command = float(s.gear)
    c.shift_phase = float(s.phase)


@kernel
def init(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement, c: AmtControlCommand) -> None:
    """Take over in the gear there is: closed where the clutch does not slip, slipping where it carries torque."""
    s.gear = to_index(m.gear + 0.5, 0, GEARS)
    s.torque = clamp(m.engine_torque, -500.0, p.engine_torque)
    s.capacity = 0.0
    enter(s, OPEN)
    closed = abs(m.engine_speed - m.clutch_speed) < p.calibration.closing_slip
    if closed and m.clutch_speed >= p.calibration.opening_share * p.idle_speed:
        enter(s, DRIVING)
        s.capacity = p.torque_limit
    elif s.torque > 0.0 and m.clutch_speed > 0.0:
        enter(s, LAUNCHING)
        s.capacity = min(s.torque, p.torque_limit)
    c.engine_torque_request = s.torque
    c.clutch_torque_command = s.capacity
    c.gear_command = float(s.gear)
    c.shift_phase = float(s.phase)


@kernel
def step(p: AmtControlParameters, s: AmtControlState, m: AmtControlMeasurement, c: AmtControlCommand, dt: float) -> int:
    """Command engine, clutch and gear; return 0, or 1 where a measurement is no number, and leave the commands."""
    status = 1
    wishes = m.engine_torque_wanted + m.gear_wanted
    if is_finite(wishes) and is_finite(m.engine_speed + m.clutch_speed) and is_finite(m.engine_torque + m.gear):
        status = 0
        choose_phase(p, s, m, dt)
        command(p, s, m, c, dt)
    return status


def design(vehicle: RecordArray, calibration: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle (blocks engine and clutch), one record per calibration."""
    parameters = AmtControlParameters.zeros(len(calibration))
    engine, clutch = vehicle["engine"], vehicle["clutch"]
    curve = engine["full_load"][0]
    parameters["calibration"] = calibration
    parameters["torque_limit"] = clutch["torque_limit"]
    parameters["engine_torque"] = np.max(curve["y"][: curve["points"]])
    parameters["engine_inertia"] = engine["inertia"]
    parameters["launch_speed"] = clutch["launch_speed"]
    parameters["idle_speed"] = engine["idle_speed"]
    return parameters


CONTROLLER = Controller(
    name="amt_control",
    meaning="transmission control: launch on the clutch, shifts with a torque cut, no stall",
    plants=("conventional",),
    calibration=AmtControlCalibration,
    calibrations=only_defaults,
    default_calibration="default",
    parameters=AmtControlParameters,
    state=AmtControlState,
    measurement=AmtControlMeasurement,
    command=AmtControlCommand,
    design=design,
    init=init,
    step=step,
)
