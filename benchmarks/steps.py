"""One step of the controller launch_pid: called from Python, through its bare entry, and inside compiled code.

All of them get the measurements of the nominal launch, one every 10 ms, from the controller's initial state on.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from benchmarks.launches import TOLERANCE, DisagreementError, Libraries, nothing, two_seconds
from benchmarks.plain_loop import PlainController, parameters_of
from benchmarks.results import Figure
from benchmarks.timing import Samples, side_by_side
from bitepoint.assembly import Assembly
from bitepoint.controllers.launch_pid import (
    CONTROLLER,
    LaunchPidCommand,
    LaunchPidMeasurement,
    LaunchPidState,
)
from bitepoint.kernels import Life
from bitepoint.kernels.kernel import ENTRY, addresses_of
from bitepoint.recording import Floats
from bitepoint.records import RecordArray
from bitepoint.simulation.run import Simulation

PERIOD = CONTROLLER.period
COMMANDS = tuple(LaunchPidCommand.fields)


@dataclass(frozen=True)
class Series:
    """What the controller meets in one launch: its parameters, and a measurement per step."""

    assembly: Assembly
    parameters: RecordArray
    measurements: RecordArray
    commands: Floats

    @property
    def steps(self) -> int:
        """How many steps there are."""
        return len(self.measurements)


def series() -> Series:
    """Return the measurements and the commands, shape (steps, 4), of the nominal launch of 2 s."""
    assembly = two_seconds()
    recording = Simulation(assembly.system).run(nothing)[0].recording
    assert recording is not None
    every = round(PERIOD / assembly.system.tick)
    measurements = LaunchPidMeasurement.zeros(len(recording.time[::every]))
    for name in LaunchPidMeasurement.fields:
        measurements[name] = recording[name][::every]
    commands = np.array([recording[name][::every] for name in COMMANDS]).T
    return Series(assembly, assembly.system.controllers[0].parameters, measurements, commands)


class Runner:
    """Runs the series through one life of the kernel, in three ways."""

    def __init__(self, given: Series, life: Life = "compiled") -> None:
        self.given = given
        self.life: Life = life
        self.start = LaunchPidState.zeros()
        CONTROLLER.init.run(given.parameters, self.start, LaunchPidMeasurement.zeros(), LaunchPidCommand.zeros())
        self.state = self.start.copy()
        self.commands = LaunchPidCommand.zeros(given.steps)
        self.rows = [(given.measurements[n : n + 1], self.commands[n : n + 1]) for n in range(given.steps)]
        self.statuses, self.period = np.zeros(given.steps, np.int64), np.array([PERIOD])
        arrays = [given.parameters, self.state, given.measurements, self.commands, self.period, self.statuses]
        self.addresses = addresses_of(arrays)
        sizes = [0, 0, given.measurements.itemsize, self.commands.itemsize, 0, 8]
        self.strides = np.array(sizes, np.int64)
        self.moved = self.addresses + np.arange(given.steps)[:, None] * self.strides
        self.calls = [(row.ctypes.data, self.strides.ctypes.data, 1) for row in self.moved]
        self.entry: Callable[..., Any] = ENTRY(CONTROLLER.step.entry(life))

    def through_run(self) -> None:
        """Call `Kernel.run` once per step."""
        self.state[:] = self.start
        for measurement, command in self.rows:
            CONTROLLER.step.run(self.given.parameters, self.state, measurement, command, PERIOD, life=self.life)

    def through_entry(self) -> None:
        """Call the entry once per step, its addresses prepared."""
        self.state[:] = self.start
        for call in self.calls:
            self.entry(*call)

    def inside(self) -> None:
        """Call the entry once for all steps: the loop is compiled."""
        self.state[:] = self.start
        self.entry(self.addresses.ctypes.data, self.strides.ctypes.data, self.given.steps)


class CRunner:
    """Runs the series through the controller of the yardstick."""

    def __init__(self, given: Series, library: ctypes.CDLL) -> None:
        self.given, self.commands = given, LaunchPidCommand.zeros(given.steps)
        self.state = np.zeros(16)  # more than the C struct has
        parameters, state = (ctypes.c_void_p(a.ctypes.data) for a in (given.parameters, self.state))
        measured, commands = given.measurements, self.commands
        self.step, self.period = library.controller_step, ctypes.c_double(PERIOD)
        self.start = partial(library.controller_init, parameters, state, ctypes.c_void_p(commands.ctypes.data))
        self.calls = [
            (
                parameters, state, ctypes.c_void_p(measured.ctypes.data + n * measured.itemsize),
                ctypes.c_void_p(commands.ctypes.data + n * commands.itemsize), self.period,
            )
            for n in range(given.steps)
        ]  # fmt: skip
        ends = self.calls[0][2:4]
        self.loop = partial(library.controller_steps, parameters, *ends, ctypes.c_int64(given.steps), self.period)

    def through_ctypes(self) -> None:
        """Call the C function once per step."""
        self.start()
        for call in self.calls:
            self.step(*call)

    def inside(self) -> None:
        """Call the C function that loops over all steps."""
        self.loop()


def _plain(given: Series) -> Callable[[], Floats]:
    parameters, (pedal, engine, clutch) = parameters_of(given.assembly)[1], _columns(given.measurements)

    def run() -> Floats:
        controller = PlainController(parameters)
        return np.array([controller.step(*row, PERIOD) for row in zip(pedal, engine, clutch, strict=True)])

    return run


def _columns(measurements: RecordArray) -> list[list[float]]:
    return [[float(number) for number in measurements[name]] for name in LaunchPidMeasurement.fields]


def measure(compiled: Libraries | None) -> list[Figure]:
    """Return the figures of one controller step."""
    given = series()
    ours, interpreted = Runner(given), Runner(given, "interpreted")
    ways: dict[str, tuple[Callable[[], None], RecordArray]] = {
        "run": (ours.through_run, ours.commands),
        "entry": (ours.through_entry, ours.commands),
        "inside": (ours.inside, ours.commands),
        "interpreted": (interpreted.inside, interpreted.commands),
    }
    if compiled is not None:
        c = CRunner(given, compiled.fast(given.assembly).library)
        ways |= {"c entry": (c.through_ctypes, c.commands), "c inside": (c.inside, c.commands)}
    for name, (way, commands) in ways.items():
        commands[:] = 0
        way()
        _hold(given, name, np.array([commands[field] for field in COMMANDS]).T)
    plain = _plain(given)
    _hold(given, "plain", plain())
    candidates: dict[str, Callable[[], object]] = {"plain": plain}
    for name, (way, _) in ways.items():
        candidates[name] = way
    slow = side_by_side(candidates, rounds=80)
    inside = {name: way for name, way in candidates.items() if name.endswith("inside")}
    return _figures(given.steps, slow, side_by_side(inside, rounds=60, calls=200))


def _figures(steps: int, slow: Samples, fast: Samples) -> list[Figure]:
    def of(samples: Samples, name: str, other: str, what: str, scale: float, unit: str) -> tuple[Any, ...]:
        value = scale * samples.median(name) / steps
        if other not in samples.seconds:
            return value, unit, None, None
        against = f"{what}: {scale * samples.median(other) / steps:.3g} {unit}"
        return value, unit, samples.ratio(name, other), against

    plain = "a step in plain Python"
    return [
        Figure("controller_step_kernel_run", *of(slow, "run", "plain", plain, 1e6, "µs")),
        Figure("controller_step_entry", *of(slow, "entry", "plain", plain, 1e6, "µs")),
        Figure("controller_step_entry_vs_c", *of(slow, "entry", "c entry", "the C function, ctypes", 1e6, "µs")),
        Figure("controller_step_interpreted", *of(slow, "interpreted", "plain", plain, 1e6, "µs")),
        Figure("controller_step_in_loop", *of(fast, "inside", "c inside", "a step in a loop in C", 1e9, "ns")),
    ]


def _hold(given: Series, name: str, commands: Floats) -> None:
    difference = np.abs(commands - given.commands).max(axis=0)
    if not (difference <= TOLERANCE * np.abs(given.commands).max(axis=0)).all():
        raise DisagreementError(f"controller step, {name}: commands differ by {difference}")
