"""One step of the predictive launch controllers while the clutch slips: the programme beside the swarm."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import bitepoint
from benchmarks.results import Figure
from benchmarks.timing import side_by_side
from bitepoint.assembly import assemble

LANES = {"ddpc": 2000, "ddpc_pso": 20, "launch_mpc": 1000}
"""Lanes that one call steps, all from the same state."""

WARM_UP = 0.7
"""Time into the launch at which the state is taken, s: in the middle of slipping."""

ROUNDS = 9


def stepper(name: str) -> Callable[[], object]:
    """Return what steps the controller once in every lane."""
    part = assemble("dct-launch", {"controller": name}).system.controllers[0]
    assert part.work is not None
    recording = bitepoint.run("dct-launch", {"controller": name}).recording
    memory: list[Any] = [part.parameters, *(t.zeros() for t in (part.state, part.inputs, part.outputs, part.work))]
    part.init.run(*memory)
    every = round(part.period / float(recording.time[1] - recording.time[0]))
    for row in range(0, round(WARM_UP / part.period) * every, every):
        for signal in part.inputs.fields:
            memory[2][signal] = recording[signal][row]
        part.step.run(*memory, part.period)
    start = memory[1].copy()
    lanes = [memory[0], *(np.repeat(array, LANES[name]) for array in memory[1:])]

    def step() -> None:
        lanes[1][:] = start
        part.step.run(*lanes, part.period)

    return step


def measure() -> list[Figure]:
    """Return the time of one step of each, beside that of `ddpc`."""
    samples = side_by_side({name: stepper(name) for name in LANES}, ROUNDS)
    figures: list[Figure] = []
    base = samples.median("ddpc") / LANES["ddpc"]
    for name, lanes in LANES.items():
        value, ratio = 1e6 * samples.median(name) / lanes, samples.ratio(name, "ddpc") * LANES["ddpc"] / lanes
        against = (None, None) if name == "ddpc" else (ratio, f"ddpc, {1e6 * base:.3g} µs")
        figures.append(Figure(f"controller_step_{name}", value, "µs", *against))
    return figures
