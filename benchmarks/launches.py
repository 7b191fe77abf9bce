"""One launch and a thousand, against the hand-written C and against plain Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import bitepoint
from benchmarks.plain_loop import run_plain
from benchmarks.results import Figure, cores
from benchmarks.timing import Samples, side_by_side
from benchmarks.yardstick import FAST, FIGURES, PORTABLE, STATUSES, Yardstick, build
from bitepoint.assembly import Assembly, assemble
from bitepoint.metrics import FAMILIES
from bitepoint.recording import Floats, Recording
from bitepoint.simulation.run import Simulation

SCENARIO = "dct-launch"
LANES = 1000
TOLERANCE = 1e-6
"""Largest relative difference between bitepoint and what it is measured against."""


class DisagreementError(Exception):
    """What is measured against does not compute the same launch."""


@dataclass(frozen=True)
class Libraries:
    """The yardstick, compiled twice."""

    fast: Callable[[Assembly], Yardstick]
    portable: Callable[[Assembly], Yardstick]


def libraries(folder: Path) -> Libraries:
    """Compile the yardstick into `folder`; raises NoCompilerError."""
    fast, portable = build(folder, FAST), build(folder, PORTABLE)
    return Libraries(lambda assembly: Yardstick(fast, assembly), lambda assembly: Yardstick(portable, assembly))


def two_seconds() -> Assembly:
    """Return the scenario without stop rules, 2 s long: 1000 ticks, 1001 rows of 25 channels."""
    assembly = assemble(SCENARIO, {})
    return replace(assembly, system=replace(assembly.system, duration=2.0, rules=[]))


def varied() -> dict[str, list[float]]:
    """Return what differs between the lanes of the batch."""
    generator = np.random.default_rng(0)
    mass, grade = generator.uniform(1200.0, 2000.0, LANES), generator.uniform(-0.02, 0.12, LANES)
    return {"vehicle.mass": mass.tolist(), "road.grade": grade.tolist()}


NOT_IN_YARDSTICK = ("longitudinal_acceleration", "clutch_pressure", "clutch_temperature")
"""Channels that the yardsticks do not record: less work for them."""


def nothing(recording: Recording) -> None:
    """Make no figures."""


def measure_one_run(compiled: Libraries | None) -> list[Figure]:
    """Return the figures of one launch of 2 s in a warm process."""
    assembly = two_seconds()
    simulation = Simulation(assembly.system)
    family = FAMILIES[assembly.scenario.metrics]
    _hold(simulation.run(nothing)[0].recording, run_plain(assembly), "the plain Python loop")
    ours = {"metrics": lambda: simulation.run(family), "bare": lambda: simulation.run(nothing)}
    slow = side_by_side({"bare": ours["bare"], "plain": lambda: run_plain(assembly)}, 11, {"bare": 100, "plain": 1})
    plain = Figure(
        "one_run_vs_plain_python", 1e3 * slow.median("bare"), "ms", slow.ratio("bare", "plain"),
        f"plain NumPy loop, no figures: {1e3 * slow.median('plain'):.0f} ms",
    )  # fmt: skip
    if compiled is None:
        samples = side_by_side(ours, rounds=80, calls=10)
        names = {"metrics": "one_run", "bare": "one_run_without_figures"}
        return [*(Figure(names[k], 1e3 * samples.median(k), "ms", None, None) for k in names), plain]
    fast, portable = compiled.fast(assembly), compiled.portable(assembly)
    for yardstick in (fast, portable):
        _hold_nominal(simulation, yardstick)
    beside = {"c": fast.launch, "c bare": lambda: fast.launch(False), "portable": lambda: portable.launch(False)}
    samples = side_by_side(ours | beside, rounds=80, calls=10)
    return [
        _against_c("one_run", samples, "metrics", "c", "the same in C"),
        _against_c("one_run_without_figures", samples, "bare", "c bare", "the same in C"),
        _against_c("one_run_vs_portable_c", samples, "bare", "portable", f"C with {' '.join(PORTABLE)}, no figures"),
        plain,
    ]


def _against_c(name: str, samples: Samples, ours: str, theirs: str, what: str) -> Figure:
    against = f"{what}: {1e3 * samples.median(theirs):.3f} ms"
    return Figure(name, 1e3 * samples.median(ours), "ms", samples.ratio(ours, theirs), against)


def measure_batch(compiled: Libraries | None) -> list[Figure]:
    """Return the figures of 1000 launches, over all cores and over one."""
    over = varied()
    assembly = assemble(SCENARIO, {}, over)
    yardstick = None if compiled is None else compiled.fast(assembly)
    if yardstick is not None:
        _hold_batch(over, yardstick)
    found: list[Figure] = []
    for suffix, threads in (("", cores()), ("_one_thread", 1)):
        for tail, figures in (("", True), ("_without_figures", False)):
            found.append(_batch(f"batch_1000{suffix}{tail}", over, threads, figures, yardstick))
    return found


def _batch(name: str, over: dict[str, list[float]], threads: int, figures: bool, yardstick: Yardstick | None) -> Figure:
    def ours() -> None:
        if figures:
            bitepoint.run_batch(SCENARIO, over, threads=threads)
        else:
            assembly = assemble(SCENARIO, {}, over)
            Simulation(assembly.system).run(nothing, lanes=assembly.lanes, record=(), threads=threads)

    if yardstick is None:
        samples = side_by_side({"ours": ours}, rounds=9)
        return Figure(name, LANES / samples.median("ours"), "launches/s", None, None)
    samples = side_by_side({"ours": ours, "c": lambda: yardstick.batch(threads, figures)}, rounds=9)
    against = f"the same in C, {threads} thread{'s' * (threads > 1)}: {LANES / samples.median('c'):.0f} launches/s"
    return Figure(name, LANES / samples.median("ours"), "launches/s", 1.0 / samples.ratio("ours", "c"), against)


def _hold_nominal(simulation: Simulation, yardstick: Yardstick) -> None:
    lane = simulation.run(FAMILIES["launch"])[0]
    figures, recording = yardstick.figures_and_recording()
    _hold(lane.recording, recording, "the yardstick")
    expected = np.array([np.nan if lane.figures[name].value is None else lane.figures[name].value for name in FIGURES])
    _hold_figures(expected[None], figures[None])


def _hold_batch(over: dict[str, list[float]], yardstick: Yardstick) -> None:
    """Raise unless statuses and figures of all lanes agree."""
    ours, theirs = bitepoint.run_batch(SCENARIO, over), yardstick.batch(1)
    statuses = [STATUSES[int(number)] for number in theirs.outcomes["status"]]
    if list(ours.status) != statuses:
        raise DisagreementError("the yardstick ends a lane with another status")
    assert theirs.figures is not None
    _hold_figures(np.array([ours.metrics[name] for name in FIGURES]).T, theirs.figures)


def _hold_figures(expected: Floats, got: Floats) -> None:
    """Raise unless all figures, shape (lanes, figures), agree; the energy residual, a small difference, absolutely."""
    scale = np.where([name == "energy_residual" for name in FIGURES], 1.0, np.abs(expected))
    good = (np.abs(got - expected) <= TOLERANCE * scale) | (np.isnan(got) & np.isnan(expected))
    if not good.all():
        lane, figure = (int(place[0]) for place in np.nonzero(~good))
        values = f"{got[lane, figure]:.9g}, bitepoint {expected[lane, figure]:.9g}"
        raise DisagreementError(f"lane {lane}: {FIGURES[figure]} of the yardstick is {values}")


def _hold(recording: Recording | None, got: Floats, what: str) -> None:
    """Raise unless every channel agrees at every time, to the channel's largest magnitude."""
    assert recording is not None
    both = [n for n, channel in enumerate(recording.channels) if channel.name not in NOT_IN_YARDSTICK]
    if (len(both), recording.data.shape[1]) != got.shape:
        raise DisagreementError(f"{what} recorded {got.shape}, bitepoint {len(both), recording.data.shape[1]}")
    for n, row in zip(both, got, strict=True):
        channel, expected = recording.channels[n], recording.data[n]
        difference, scale = float(np.abs(row - expected).max()), float(np.abs(expected).max())
        if not difference <= TOLERANCE * max(scale, 1e-9):
            raise DisagreementError(
                f"{what}: {channel.name} differs by {difference:.3g}, its largest value is {scale:.3g}"
            )
