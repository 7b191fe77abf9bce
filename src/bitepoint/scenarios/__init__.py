"""Scenario files: which vehicle does what, on which road, and when the run ends."""

from bitepoint.scenarios.pedal import PedalLog, read_pedal_log
from bitepoint.scenarios.runs import LogSettings, Runs
from bitepoint.scenarios.scenario import Scenario, Timing, load_scenario, scenario_names

__all__ = ["LogSettings", "PedalLog", "Runs", "Scenario", "Timing", "load_scenario", "read_pedal_log", "scenario_names"]
