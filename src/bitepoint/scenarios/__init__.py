"""Scenario files: which vehicle does what, on which road, and when the run ends."""

from bitepoint.scenarios.cycles import CYCLES, cycle_trace
from bitepoint.scenarios.pedal import PedalLog, read_pedal_log
from bitepoint.scenarios.runs import LogSettings, Runs
from bitepoint.scenarios.scenario import Scenario, Timing, load_scenario, scenario_names
from bitepoint.scenarios.speed import SpeedLog, read_speed_log

__all__ = [
    "CYCLES", "LogSettings", "PedalLog", "Runs", "Scenario", "SpeedLog", "Timing", "cycle_trace", "load_scenario",
    "read_pedal_log", "read_speed_log", "scenario_names",
]  # fmt: skip
