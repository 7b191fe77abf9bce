"""What there is: all plants and controllers by name, and their signals, keys and kernels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bitepoint.controllers import (
    amt_control,
    damping_mpc,
    damping_shaping,
    ddpc,
    ddpc_pso,
    excitation,
    launch_intent,
    launch_mpc,
    launch_pid,
    none,
    pedal_driver,
    speed_driver,
    torque_split,
    undamped,
)
from bitepoint.controllers.controller import Controller
from bitepoint.kernels import Kernel
from bitepoint.numerics.filters import butterworth_forward_backward
from bitepoint.plants import conventional, dct, p2_hybrid
from bitepoint.plants.plant import Plant
from bitepoint.recording import Channel
from bitepoint.records import Field
from bitepoint.scenarios import LogSettings, Timing
from bitepoint.simulation.loop import run_lane

PLANTS: Mapping[str, Plant] = {plant.name: plant for plant in (dct.PLANT, p2_hybrid.PLANT, conventional.PLANT)}
"""All plants, by name."""

CONTROLLERS: Mapping[str, Controller] = {
    **{
        module.CONTROLLER.name: module.CONTROLLER
        for module in (
            none,
            launch_pid,
            ddpc,
            ddpc_pso,
            launch_mpc,
            excitation,
            damping_mpc,
            damping_shaping,
            amt_control,
        )
    },
    "undamped": undamped.CONTROLLER,
}
"""All controllers, by name; that of a hybrid that does nothing stands as undamped, since `none` is that of a launch."""

SUPERVISORS: Mapping[str, Controller] = {
    module.CONTROLLER.name: module.CONTROLLER for module in (speed_driver, torque_split, pedal_driver)
}
"""Parts between driver and controller, by name."""


def controllers_for(plant: str) -> dict[str, Controller]:
    """Return the controllers that can drive a plant, by the name that a scenario gives them."""
    return {each.name: each for each in CONTROLLERS.values() if plant in each.plants}


ADVISERS: Mapping[str, Controller] = {block.name: block for block in (launch_intent.CONTROLLER,)}
"""Blocks that run beside a controller and tell it something, by name."""

PEDAL = Channel("pedal", "1", "accelerator pedal, 0 released, 1 fully pressed")
"""The signal that every scenario gives."""


def signals() -> list[Channel]:
    """Return every signal that plants and controllers show, each once."""
    records = [plant.outputs for plant in PLANTS.values()]
    blocks = (*CONTROLLERS.values(), *SUPERVISORS.values(), *ADVISERS.values())
    records += [block.command for block in blocks]
    found = {f.name: Channel(f.name, f.unit, f.meaning) for record in records for f in record.fields.values()}
    return [PEDAL, *found.values()]


def keys() -> Iterator[tuple[str, Field]]:
    """Yield every dotted key that `--set` takes for a number, a curve or a map, with what is declared of it."""
    for plant in PLANTS.values():
        yield from plant.parameters.table()
    for controller in CONTROLLERS.values():
        yield from controller.calibration.table("controller.")
    for name, supervisor in SUPERVISORS.items():
        yield from supervisor.calibration.table(f"{name}.")
    yield from Timing.table("timing.")
    yield from LogSettings.table("log.")


def all_kernels() -> list[Kernel[..., Any]]:
    """Return every kernel that is compiled for itself: those of all parts, the loop and the filters."""
    parts = [*PLANTS.values(), *CONTROLLERS.values(), *SUPERVISORS.values(), *ADVISERS.values()]
    kernels: list[Kernel[..., Any]] = [kernel for part in parts for kernel in (part.init, part.step)]
    return [*kernels, run_lane, butterworth_forward_backward]
