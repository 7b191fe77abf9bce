"""Records of the driver with an accelerator and a brake: what can be set, what is read, kept, seen and asked for."""

from __future__ import annotations

from bitepoint.controllers.plan_table import PlanTable
from bitepoint.controllers.stop_lines import STOP_LINES, StopLines
from bitepoint.models.shift_map import ShiftMap
from bitepoint.parts.amt import GEARS, AutomatedGearbox
from bitepoint.parts.torque_engine import TorqueEngine
from bitepoint.records import Record, count, nested, quantity

TARGET, PLAN, SPEEDS = range(3)
MODES = ("target", "plan", "speeds")
"""What the driver follows."""


class PedalDriverCalibration(Record):
    """What can be set."""

    mode: int = count(0, 2, "what the driver follows", default=0, names=MODES)
    throttle_gain: float = quantity("s/m", 0, 10, "throttle per error of the speed", default=0.288)
    integral_gain: float = quantity("1/m", 0, 10, "rate of the throttle per error of the speed", default=0.036)
    throttle_limit: float = quantity("1", 0.01, 1, "most throttle", default=0.7)
    brake_rest: float = quantity("1", 0, 1, "how far the driver wants to be off the throttle to brake", default=0.1)
    brake_gain: float = quantity("m/s^2", 0, 50, "deceleration by the brake per wish beyond that", default=4.3)
    hold_rate: float = quantity("m/s^2", 0, 20, "deceleration that the brake at a standstill would give", default=3.0)
    standstill_speed: float = quantity("m/s", 0, 3, "below which the vehicle may be held", default=0.3)
    shift_up_low: float = quantity("rad/s", 50, 1500, "engine speed to shift up at no throttle", default=178.0)
    shift_up_high: float = quantity("rad/s", 50, 1500, "the same at full throttle, linear between", default=366.0)
    shift_down_share: float = quantity(
        "1", 0.1, 1, "speed of the engine in the gear below, over that to shift up, to shift down", default=0.8
    )
    schedule: int = count(0, 1, "1: gears follow the shift map; 0: the line of the engine speed", default=0)
    shift_pause: float = quantity("s", 0, 10, "shortest time in a gear", default=0.5)
    hold_time: float = quantity("s", 0.01, 10, "in which the brake that holds is applied", default=1.0)
    release_time: float = quantity("s", 0.01, 10, "in which it is released, once the clutch bites", default=0.3)
    gear_preview: float = quantity("s", 0, 5, "how far ahead the gear of the plan is taken", default=0.2)
    feed_forward: int = count(0, 1, "1: the torque of the plan is fed forward", default=1)


class PedalDriverParameters(Record):
    """What the step reads."""

    calibration: PedalDriverCalibration = nested(PedalDriverCalibration, "what can be set")
    engine: TorqueEngine = nested(TorqueEngine, "the engine, whose full load and drag the throttle parts")
    gearbox: AutomatedGearbox = nested(AutomatedGearbox, "the gears there are")
    plan: PlanTable = nested(PlanTable, "the plan")
    stop_lines: StopLines = nested(StopLines, "the stop lines")
    shift_map: ShiftMap = nested(ShiftMap, "the shift map")
    launch_speed: float = quantity("rad/s", 20, 500, "lowest speed of the engine in gear", default=100.0)
    brake_limit: float = quantity("N*m", 0, 1e5, "highest torque of the brake")
    slowing_torque: float = quantity("N*m", 0, 1e6, "torque of the brake per m/s^2 that it slows the vehicle down by")
    hold_torque: float = quantity("N*m", 0, 1e5, "torque of the brake at a standstill")
    gears: int = count(1, GEARS, "number of gears", default=1)


class PedalDriverState(Record):
    """Memory between two steps."""

    gear: int = count(0, GEARS, "gear that the driver wants")
    elapsed: float = quantity("s", 0, 1e6, "time in the gear")
    integral: float = quantity("1", -1, 1, "integral part of the throttle")
    throttle: float = quantity("1", 0, 1, "last throttle")
    passed: int = count(0, STOP_LINES, "stop lines that are left behind")
    stopping: int = count(0, 1, "1: the driver brakes for the next stop line, or stands at it")
    slowing_more: float = quantity("m/s^2", -20, 20, "deceleration by the brake beyond the one told for the line")
    stood: float = quantity("s", 0, 1e6, "time for which the vehicle has been standing at it")
    holding: float = quantity("N*m", 0, 1e5, "torque of the brake as it is applied to hold, and released")


class PedalDriverMeasurement(Record):
    """What the driver sees."""

    speed_target: float = quantity("m/s", 0, 100, "speed to follow")
    vehicle_speed: float = quantity("m/s", -150, 150, "speed of the vehicle")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")
    distance: float = quantity("m", -1e6, 1e6, "way since the start")
    gear: float = quantity("1", 0, 8, "engaged gear; 0 while shifting")


class PedalDriverCommand(Record):
    """What the driver asks for."""

    throttle: float = quantity("1", 0, 1, "throttle opening")
    engine_torque_wanted: float = quantity("N*m", -500, 5000, "torque of the engine that the driver asks for")
    brake_torque_command: float = quantity("N*m", 0, 1e5, "torque of the brake, all wheels together")
    gear_wanted: float = quantity("1", 0, 8, "gear that the driver asks for; 0 keeps the one there is")
    speed_wanted: float = quantity("m/s", 0, 100, "speed that the driver follows: the target's, or the plan's")
