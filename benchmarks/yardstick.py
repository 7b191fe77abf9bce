"""The yardstick: the launch in hand-written C (folder `c`), compiled here, called through ctypes, held to bitepoint."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.assembly import Assembly
from bitepoint.controllers.launch_pid import LaunchPidCommand, LaunchPidMeasurement
from bitepoint.plants.dct import DctParameters
from bitepoint.recording import Floats
from bitepoint.records import RecordArray
from bitepoint.simulation.run import Simulation

FAST = ("-O3", "-march=native")
"""How the yardstick is compiled."""

PORTABLE = ("-O2", "-ffp-contract=off")
"""How it is compiled for comparison: any x86-64 or ARM processor, no fused multiply-add, as bitepoint's code."""

FIGURES = (
    "launch_time",
    "friction_work",
    "jerk_peak",
    "jerk_peak_settled",
    "engine_speed_min",
    "end_speed",
    "energy_residual",
)
"""The figures of merit, in the yardstick's order."""

STATUSES = {0: "launched", 1: "stalled", 2: "rolled back", -2: "timed out", -3: "not finite"}
"""What its statuses are called by bitepoint."""

_SOURCES = Path(__file__).parent / "c"
_OUTCOME = np.dtype([("status", np.int64), ("rows", np.int64)])


class NoCompilerError(Exception):
    """There is no C compiler, or it does not compile the yardstick."""


class _Manoeuvre(ctypes.Structure):
    _fields_ = (
        ("ticks", ctypes.c_int64), ("controller_every", ctypes.c_int64), ("rules", ctypes.c_int64),
        ("locked_hold", ctypes.c_int64), ("tick", ctypes.c_double), ("stall_speed", ctypes.c_double),
        ("rollback_speed", ctypes.c_double), ("pedal", ctypes.c_void_p),
    )  # fmt: skip


class _Outcome(ctypes.Structure):
    _fields_ = (("status", ctypes.c_int64), ("rows", ctypes.c_int64))


@dataclass(frozen=True)
class Launches:
    """What a batch of the yardstick gave: status and rows per lane, figures of shape (lanes, 7) or None."""

    outcomes: np.ndarray[Any, Any]
    figures: Floats | None


class Yardstick:
    """The compiled C, ready to run the launches of one assembled scenario.

    Its arguments are bitepoint's own arrays: the parameters of plant and controller, the pedal on the raster of ticks.
    """

    def __init__(self, library: ctypes.CDLL, assembly: Assembly) -> None:
        system = assembly.system
        self.library = library
        library.run_launch.restype = _Outcome
        self.vehicles: RecordArray = system.plant.parameters
        self.calibration: RecordArray = system.controllers[0].parameters
        if self.calibration.shape != (1,) or any(not c.ideal for c in Simulation(system).layout.connections):
            raise ValueError("the yardstick knows one calibration and no lag, delay or noise")
        _hold_sizes(library, self.vehicles, self.calibration)
        ticks = round(system.duration / system.tick)
        profile = system.profiles[0]
        self.pedal = np.interp(np.arange(ticks + 1) * system.tick, profile.time, profile.values)
        rules = {rule.status: rule for rule in system.rules}
        every = round(system.controllers[0].period / system.tick)
        hold = round(rules["launched"].hold / system.tick) if rules else 0
        limits = [rules[status].limit if rules else 0.0 for status in ("stalled", "rolled back")]
        self.manoeuvre = _Manoeuvre(ticks, every, bool(rules), hold, system.tick, *limits, self.pedal.ctypes.data)
        self._recording = np.empty((25, ticks + 1))
        self._work = np.empty(ticks + 19)
        self._figures = np.empty(len(FIGURES))

    def launch(self, figures: bool = True) -> int:
        """Run the first lane in this thread, with or without its figures; return the number of rows recorded."""
        library, manoeuvre = self.library, ctypes.byref(self.manoeuvre)
        recording = _pointer(self._recording)
        outcome = library.run_launch(_pointer(self.vehicles), _pointer(self.calibration), manoeuvre, recording)
        if figures:
            rows = ctypes.c_int64(outcome.rows)
            library.launch_figures(manoeuvre, recording, rows, _pointer(self._work), _pointer(self._figures))
        return int(outcome.rows)

    def batch(self, threads: int, figures: bool = True) -> Launches:
        """Run all lanes over `threads` threads."""
        lanes = len(self.vehicles)
        outcomes, table = np.zeros(lanes, _OUTCOME), np.empty((lanes, len(FIGURES)))
        failed = self.library.run_launches(
            _pointer(self.vehicles), ctypes.c_int64(lanes), _pointer(self.calibration), ctypes.byref(self.manoeuvre),
            ctypes.c_int64(threads), _pointer(outcomes), _pointer(table) if figures else None,
        )  # fmt: skip
        if failed:
            raise MemoryError("the yardstick got no memory for its recordings")
        return Launches(outcomes, table if figures else None)

    def figures_and_recording(self) -> tuple[Floats, Floats]:
        """Return figures and recording (channels, rows) of the first lane."""
        rows = self.launch()
        return self._figures.copy(), self._recording[:, :rows].copy()


def build(folder: Path, options: tuple[str, ...] = FAST) -> ctypes.CDLL:
    """Compile the C sources into `folder` and load them.

    Raises:
        NoCompilerError: with the reason.
    """
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        raise NoCompilerError("no gcc or cc on the path")
    target = folder / f"yardstick{''.join(options)}.so"
    sources = sorted(str(source) for source in _SOURCES.glob("*.c"))
    command = [compiler, "-std=gnu11", *options, "-shared", "-fPIC", "-o", str(target), *sources, "-lm", "-lpthread"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise NoCompilerError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "the compiler failed")
    return ctypes.CDLL(str(target))


def compiler_version() -> str:
    """Return the first line of what the compiler says of itself, or "none"."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return "none"
    return subprocess.run([compiler, "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]


def _hold_sizes(library: ctypes.CDLL, vehicles: RecordArray, calibration: RecordArray) -> None:
    """Raise where the C structs are not of the size of the records that they stand for."""
    sizes = (ctypes.c_int64 * 4).in_dll(library, "yardstick_sizes")
    records = (
        vehicles.itemsize,
        calibration.itemsize,
        LaunchPidMeasurement.dtype.itemsize,
        LaunchPidCommand.dtype.itemsize,
    )
    if tuple(sizes) != records or vehicles.dtype != DctParameters.dtype:
        raise ValueError(f"records changed: {records} bytes in bitepoint, {tuple(sizes)} in benchmarks/c/yardstick.h")


def _pointer(array: np.ndarray[Any, Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
