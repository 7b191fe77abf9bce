"""A planned launch, played open loop on the real plant."""

from __future__ import annotations

import dataclasses

import numpy as np

from bitepoint import metrics
from bitepoint.assembly import assemble
from bitepoint.parts.engine import throttle_for
from bitepoint.planning.bounds import Bound
from bitepoint.recording import Channel, Recording
from bitepoint.simulation.run import Simulation
from bitepoint.simulation.system import Profile


def replay(bound: Bound, settings: dict[str, object]) -> Recording:
    """Return what the plant does, fed with the planned clutch torque, and the throttle for the planned torque.

    The clutch closes once the launch is planned to be over, and the throttle stays as it is then.
    """
    system = assemble("dct-launch", {"controller": "none", **settings}).system
    raster = np.arange(0.0, bound.launch_time, 0.002)
    engine = system.plant.parameters["engine"].copy()
    torque, speed = (np.interp(raster, bound.time, values) for values in (bound.engine_torque, bound.engine_speed))
    throttle = throttle_for.run(engine, torque, speed)
    closing = [bound.launch_time + 0.01, bound.launch_time + 0.4]
    clutch = np.concatenate((bound.clutch_torque, bound.clutch_torque[-1:], [280.0]))
    profiles = [
        Profile(Channel("throttle", "1"), raster, throttle),
        Profile(Channel("clutch_torque_command", "N*m"), np.concatenate((bound.time, closing)), clutch),
    ]
    played = dataclasses.replace(system, controllers=[], profiles=profiles)
    recording = Simulation(played).run(metrics.launch)[0].recording
    assert recording is not None
    return recording
