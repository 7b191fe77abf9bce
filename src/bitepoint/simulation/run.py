"""Running a closed loop: one lane or a hundred thousand, over the cores, in bounded memory."""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from bitepoint.errors import InputError
from bitepoint.kernels import Life
from bitepoint.kernels.kernel import addresses_of
from bitepoint.recording import Floats, Recording
from bitepoint.records import RecordArray
from bitepoint.simulation import loop
from bitepoint.simulation.system import Part, System, argument_types, lay_out

F = TypeVar("F")

Streams = Sequence[tuple[int, int]]
"""Of each lane the seed and the number of its noise."""

CHUNK_BYTES = 32_000_000
"""Most memory that the recordings of one chunk of lanes take, per thread."""

MOST_TICKS = 2_000_000
"""Longest run: above an hour at the default tick."""

SENTENCES = {
    loop.TIMED_OUT: ("timed out", "no stop rule held within {duration:g} s"),
    loop.NOT_FINITE: ("not finite", "an output of {part} was no finite number at {time:.3f} s"),
    loop.FAULT: ("not finite", "{part} refused its inputs at {time:.3f} s"),
}


@dataclass(frozen=True)
class LaneResult(Generic[F]):
    """How one lane went: its status with a sentence, its figures, and its recording where it was asked for."""

    status: str
    reason: str
    figures: F
    recording: Recording | None


class Simulation:
    """A closed loop, ready to run: wired, with its entries looked up (and compiled where they have to be)."""

    def __init__(self, system: System, *, life: Life = "compiled") -> None:
        self.system = system
        self.life: Life = life
        self.layout = lay_out(system)
        self.ticks = max(round(system.duration / system.tick), 1)
        if self.ticks > MOST_TICKS:
            mend = f"expected at most {MOST_TICKS} ticks of {system.tick:g} s"
            raise InputError("timing.duration", f"got {system.duration:g} s", mend)
        self.noisy = [c for c in self.layout.connections if c.noise > 0.0]
        self.delay_places = 0
        self.plan = self._plan()
        self.profiles = self._profiles()
        loop.run_lane.entry("compiled")

    def run(
        self,
        figures: Callable[[Recording], F],
        *,
        lanes: int = 1,
        record: Collection[int] = (0,),
        seed: int | Sequence[int] = 0,
        threads: int | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> list[LaneResult[F]]:
        """Run the lanes and return their results in order.

        Args:
            figures: makes the figures of a lane from its recording; the recording is not to be kept.
            record: lanes whose recordings are kept.
            seed: of the noise; lane n has its own stream, whatever else runs. One seed per lane gives each lane the
                noise of a single run with its seed.
            threads: how many run at once; by default as many as there are processors.
            progress: called with the number of lanes that a finished chunk had.
        """
        for part in self.system.parts:
            if len(part.parameters) not in (1, lanes):
                raise ValueError(f"{part.name} has parameters for {len(part.parameters)} lanes, asked to run {lanes}")
        chunk = max(1, min(CHUNK_BYTES // self._recording_bytes(), 256, lanes))
        spans = [range(first, min(first + chunk, lanes)) for first in range(0, lanes, chunk)]
        kept = frozenset(record)
        streams = [(seed, lane) for lane in range(lanes)] if isinstance(seed, int) else [(each, 0) for each in seed]
        results: list[list[LaneResult[F]]] = []
        workers = threads or os.cpu_count() or 1
        if len(spans) == 1 or self.life == "interpreted" or workers == 1:
            workspace = _Workspace(self, chunk)
            for span in spans:
                results.append(workspace.run(span, figures, kept, streams))
                if progress is not None:
                    progress(len(span))
            return [result for part in results for result in part]
        return _in_threads(
            self, spans, workers, lambda workspace, span: workspace.run(span, figures, kept, streams), progress
        )

    def _recording_bytes(self) -> int:
        return 8 * (self.ticks + 1) * len(self.layout.channels)

    def _profiles(self) -> Floats:
        raster = np.arange(self.ticks + 1) * self.system.tick
        columns = [np.interp(raster, profile.time, profile.values) for profile in self.system.profiles]
        return np.ascontiguousarray(np.array(columns).T).ravel()

    def _plan(self) -> RecordArray:
        system, layout = self.system, self.layout
        plan = loop.LoopPlan.zeros()
        row = plan[0]
        row["ticks"], row["rows"] = self.ticks, self.ticks + 1
        row["blocks"], row["wires"] = len(system.parts), len(layout.connections)
        row["rules"], row["profiles"] = len(system.rules), len(system.profiles)
        row["channels"], row["noisy"] = len(layout.channels), len(self.noisy)
        first = 0
        for index, part in enumerate(system.parts):
            block = row["block"][index]
            block["init"], block["step"] = part.init.entry(self.life), part.step.entry(self.life)
            block["every"] = _multiple(
                part.period, system.tick, f"timing.tick, with {part.name} stepping every {part.period:g} s"
            )
            block["init_arguments"], block["step_arguments"] = first, first + len(part.init.parameters)
            first += len(part.init.parameters) + len(part.step.parameters) + 1
            block["first_output"], block["outputs"] = layout.outputs[index], len(part.outputs.fields)
        self._plan_wires(row)
        for index, rule in enumerate(system.rules):
            if rule.signal not in layout.shown:
                raise InputError(f"stop rule {rule.status}", f"no signal {rule.signal}", "see bitepoint list signals")
            direction = 1.0 if rule.above else -1.0
            hold = round(rule.hold / system.tick)
            row["rule"][index] = (layout.shown[rule.signal], hold, direction, rule.limit)
        return plan

    def _plan_wires(self, row: Any) -> None:
        for index, connection in enumerate(self.layout.connections):
            period = self.system.parts[connection.part].period
            delay = 0
            if connection.delay > self.system.duration:
                mend = f"expected at most the duration, {self.system.duration:g} s"
                raise InputError(f"delay.{connection.signal}", f"got {connection.delay:g} s", mend)
            if connection.delay > 0.0:
                delay = _multiple(connection.delay, self.system.tick, f"delay.{connection.signal}")
            noise = self.noisy.index(connection) if connection.noise > 0.0 else -1
            memory = np.exp(-period / connection.lag) if connection.lag > 0.0 else 0.0
            row["wire"][index] = (
                connection.source, connection.target, connection.part, delay, self.delay_places, noise,
                connection.noise, memory,
            )  # fmt: skip
            self.delay_places += delay


def _multiple(time: float, tick: float, what: str) -> int:
    ticks = round(time / tick)
    if ticks < 1 or abs(ticks * tick - time) > 1e-6 * tick:
        raise InputError(what, f"{time:g} s over a tick of {tick:g} s", "expected a multiple of the tick")
    return ticks


def _in_threads(
    simulation: Simulation,
    spans: Sequence[range],
    workers: int,
    work: Callable[[_Workspace, range], list[LaneResult[F]]],
    progress: Callable[[int], None] | None,
) -> list[LaneResult[F]]:
    """Run the spans over threads, each with a workspace of its own; compiled lanes do not hold Python's lock."""
    free = [_Workspace(simulation, len(spans[0])) for _ in range(min(workers, len(spans)))]

    def one(span: range) -> list[LaneResult[F]]:
        workspace = free.pop()
        try:
            return work(workspace, span)
        finally:
            free.append(workspace)
            if progress is not None:
                progress(len(span))

    with ThreadPoolExecutor(len(free)) as pool:
        return [result for part in pool.map(one, spans) for result in part]


class _Workspace:
    """The memory of one thread: signals, states and scratch, and the recordings of one chunk of lanes."""

    def __init__(self, simulation: Simulation, chunk: int) -> None:
        self.simulation = simulation
        layout, parts = simulation.layout, simulation.system.parts
        self.signals = np.zeros(max(layout.size, 1))
        self.buffers = np.zeros(max(simulation.delay_places, 1))
        self.statuses = np.zeros(loop.MOST_BLOCKS, np.int64)
        self.held = np.zeros(loop.MOST_RULES, np.int64)
        self.channels = np.array([place for _, place in layout.channels], np.int64)
        self.periods = np.array([part.period for part in parts])
        self.memory = [_memory(part) for part in parts]
        self.time: Floats = np.arange(simulation.ticks + 1, dtype=np.float64) * simulation.system.tick
        self.recording = np.empty((chunk, len(layout.channels), simulation.ticks + 1))
        self.outcome = loop.Outcome.zeros(chunk)
        slots = sum(len(part.init.parameters) + len(part.step.parameters) + 1 for part in parts)
        self.addresses = np.zeros((chunk, slots), np.int64)
        self.steps = np.zeros(slots + 1, np.int64)

    def run(
        self, span: range, figures: Callable[[Recording], F], kept: Collection[int], streams: Streams
    ) -> list[LaneResult[F]]:
        """Run the lanes of `span`, at most as many as the workspace was made for."""
        lanes = len(span)
        self._address(span)
        rows = addresses_of([self.addresses])[0] + np.arange(lanes) * self.addresses.strides[0]
        loop.run_lane.run(
            self.simulation.plan, rows, addresses_of([self.steps])[0], self.simulation.profiles,
            self._noise(span, streams), self.signals, self.buffers, self.statuses, self.held, self.channels,
            self.recording[:lanes].reshape(lanes, -1), self.outcome[:lanes],
        )  # fmt: skip
        return [self._result(n, figures, lane in kept) for n, lane in enumerate(span)]

    def _address(self, span: range) -> None:
        """Write the argument addresses of every lane: parameters differ from lane to lane, the rest is shared."""
        slot = 0
        for index, part in enumerate(self.simulation.system.parts):
            base = self._bases(index, part)
            roles = argument_types(part)
            for kernel in (part.init, part.step):
                for parameter in kernel.parameters:
                    role = "period" if parameter.record is None else roles[parameter.record]
                    self.addresses[:, slot] = base[role]
                    if role == "parameters" and len(part.parameters) > 1:
                        lanes = np.arange(span.start, span.stop)
                        self.addresses[: len(span), slot] += lanes * part.parameters.itemsize
                    slot += 1
            self.addresses[:, slot] = base["status"]
            slot += 1

    def _bases(self, index: int, part: Part) -> dict[str, int]:
        layout, memory = self.simulation.layout, self.memory[index]
        arrays = {"parameters": part.parameters, **memory}
        base = {role: int(addresses_of([array])[0]) for role, array in arrays.items()}
        signals, statuses, periods = (int(a) for a in addresses_of([self.signals, self.statuses, self.periods]))
        places = {"inputs": signals + 8 * layout.inputs[index], "outputs": signals + 8 * layout.outputs[index]}
        return base | places | {"period": periods + 8 * index, "status": statuses + 8 * index}

    def _noise(self, span: range, streams: Streams) -> Floats:
        """Return standard normal numbers, one row per lane: the steps of its readers times its noisy wires."""
        simulation = self.simulation
        if not simulation.noisy:
            return np.zeros(1)
        shortest = min(simulation.system.parts[c.part].period for c in simulation.noisy)
        steps = int(simulation.ticks * simulation.system.tick / shortest) + 2
        names = [zlib.crc32(c.signal.encode()) for c in simulation.noisy]
        lanes = [[np.random.default_rng([*streams[lane], n]).standard_normal(steps) for n in names] for lane in span]
        return np.ascontiguousarray(np.array(lanes).transpose(0, 2, 1)).reshape(len(span), -1)

    def _result(self, n: int, figures: Callable[[Recording], F], keep: bool) -> LaneResult[F]:
        system, layout, outcome = self.simulation.system, self.simulation.layout, self.outcome[n]
        rows = int(outcome["rows"])
        data = self.recording[n, :, :rows]
        channels = tuple(channel for channel, _ in layout.channels)
        status, reason = _sentence(system, outcome)
        recording = Recording(self.time[:rows], channels, data.copy() if keep else data)
        return LaneResult(status, reason, figures(recording), recording if keep else None)


def _memory(part: Part) -> dict[str, RecordArray]:
    memory = {"state": part.state.zeros()}
    return memory if part.work is None else memory | {"work": part.work.zeros()}


def _sentence(system: System, outcome: Any) -> tuple[str, str]:
    number, time = int(outcome["status"]), float(outcome["ticks"]) * system.tick
    if number >= 0:
        rule = system.rules[number]
        return rule.status, f"{rule.reason}, {time - rule.hold:.3f} s into the run"
    status, text = SENTENCES[number]
    if number == loop.TIMED_OUT and system.at_end != status:
        return system.at_end, f"{system.duration:g} s were run"
    part = system.parts[int(outcome["block"])].name
    return status, text.format(duration=system.duration, part=part, time=time)
