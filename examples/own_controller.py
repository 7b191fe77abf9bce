"""A controller of one's own: a centrifugal clutch, whose torque grows with the square of the engine speed.

State and command are those of the controller `none`: a torque to remember, a throttle and a torque to command.
"""

from dataclasses import replace

from bitepoint import metrics
from bitepoint.assembly import assemble
from bitepoint.controllers.none import OpenLoopCommand, OpenLoopState
from bitepoint.kernels import clamp, kernel
from bitepoint.records import Record, RecordArray, quantity
from bitepoint.simulation.run import Simulation
from bitepoint.simulation.system import Part


class Parameters(Record):
    """What the step reads."""

    engage_speed: float = quantity("rad/s", 0, 1000, "engine speed at which the shoes touch")
    gain: float = quantity("N*m*s^2/rad^2", 0, 1, "torque over the square of the speed, beyond that at engagement")


class Measurement(Record):
    """What it sees: signals by name."""

    pedal: float = quantity("1", 0, 1, "accelerator pedal")
    engine_speed: float = quantity("rad/s", -2000, 2000, "engine speed")


@kernel
def init(s: OpenLoopState, m: Measurement, c: OpenLoopCommand) -> None:
    """Start with the shoes in."""
    s.clutch_torque = 0.0
    c.throttle = clamp(m.pedal, 0.0, 1.0)
    c.clutch_torque_command = 0.0


@kernel
def step(p: Parameters, s: OpenLoopState, m: Measurement, c: OpenLoopCommand, dt: float) -> int:
    """Follow the centrifugal force, at 750 N m/s at most; return 0."""
    torque = p.gain * clamp(m.engine_speed**2 - p.engage_speed**2, 0.0, 1e6)
    s.clutch_torque = s.clutch_torque + clamp(torque - s.clutch_torque, -750.0 * dt, 750.0 * dt)
    c.throttle = clamp(m.pedal, 0.0, 1.0)
    c.clutch_torque_command = s.clutch_torque
    return 0


def design(vehicle: RecordArray) -> RecordArray:
    """Return the parameters for a vehicle: the shoes touch 20 % above idle speed."""
    return Parameters.parse({"engage_speed": 1.2 * vehicle["engine"]["idle_speed"][0], "gain": 0.005}, "design")


if __name__ == "__main__":
    system = assemble("dct-launch", {"intent": "normal"}).system
    types = {"parameters_type": Parameters, "state": OpenLoopState, "inputs": Measurement, "outputs": OpenLoopCommand}
    part = Part("centrifugal", init, step, design(system.plant.parameters), **types, work=None, period=0.002)
    lane = Simulation(replace(system, controllers=[part])).run(metrics.launch)[0]
    print(lane.status, lane.reason, *(f"{name} {metric}" for name, metric in lane.figures.items()), sep="\n")
