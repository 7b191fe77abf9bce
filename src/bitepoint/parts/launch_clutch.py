"""Friction clutch of an automated gearbox, with which a vehicle moves off: it slips below the engine's launch speed."""

from __future__ import annotations

from bitepoint.records import Record, quantity


class LaunchClutch(Record):
    """The clutch, commanded by torque capacity."""

    torque_limit: float = quantity("N*m", 1, 10_000, "highest capacity that can be commanded")
    launch_speed: float = quantity("rad/s", 20, 500, "lowest speed of the engine in gear; below, the clutch slips")
