"""A closed loop, described: parts, the wires between them, profiles and stop rules."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bitepoint.errors import InputError, WiringError
from bitepoint.kernels import Kernel
from bitepoint.kernels.compiled import is_compiled
from bitepoint.kernels.kernel import addresses_of
from bitepoint.kernels.subset import check
from bitepoint.recording import Channel, Floats
from bitepoint.records import Field, Record, RecordArray


@dataclass(frozen=True)
class Part:
    """A plant or a controller in the loop.

    Attributes:
        parameters: one record shared by all lanes, or one per lane.
        inputs, outputs: record types whose fields are all floats: signals.
        work: type of the scratch of the kernels, or None.
        period: time between two steps, s.
    """

    name: str
    init: Kernel[..., None]
    step: Kernel[..., int]
    parameters: RecordArray
    parameters_type: type[Record]
    state: type[Record]
    inputs: type[Record]
    outputs: type[Record]
    work: type[Record] | None
    period: float

    def __post_init__(self) -> None:
        """Hold what compiled code relies on: it reads memory by address, and checks nothing.

        Raises:
            WiringError: parameters of another type, an integer out of its range, or a kernel that writes parameters.
        """
        if self.parameters.dtype != self.parameters_type.dtype or not self.parameters.flags.c_contiguous:
            raise WiringError(f"{self.name}: parameters are no contiguous array of {self.parameters_type.__name__}")
        for path, declared in self.parameters_type.table():
            if declared.kind == "int":
                view = self.parameters_type.locate(self.parameters, path, self.name)[1]
                if not ((view >= declared.low) & (view <= declared.high)).all():
                    raise WiringError(f"{self.name}: {path} is outside {declared.low:g}..{declared.high:g}")
        for kernel in (self.init, self.step):
            written = frozenset[str]() if is_compiled(kernel) else check(kernel).written  # what is compiled was checked
            for parameter in kernel.parameters:
                if parameter.record is self.parameters_type and parameter.name in written:
                    raise WiringError(f"{self.name}: {kernel.name} writes its parameters, which lanes share")


@dataclass(frozen=True)
class Profile:
    """A signal that the scenario gives: linear between its points, constant beyond them."""

    channel: Channel
    time: Floats
    values: Floats


@dataclass(frozen=True)
class StopRule:
    """End the run with `status` when `signal` has been above or below `limit` for `hold` seconds."""

    status: str
    reason: str
    signal: str
    above: bool
    limit: float
    hold: float


@dataclass(frozen=True)
class Imperfections:
    """What the wires add, by the name of the signal; nothing by default.

    Attributes:
        lag: time constant of a first-order lag, s, for inputs of the plant.
        delay: dead time, s; noise: standard deviation in SI, for measurements of the controllers.
    """

    lag: Mapping[str, float] = field(default_factory=dict[str, float])
    delay: Mapping[str, float] = field(default_factory=dict[str, float])
    noise: Mapping[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True)
class System:
    """A closed loop.

    Attributes:
        plant: steps every tick; controllers: step at their own periods, multiples of the tick, before the plant.
        duration: time after which a run ends, s.
        tick: step of the plant and raster of the recording, s.
        at_end: status of a run that no rule ended.
    """

    plant: Part
    controllers: Sequence[Part]
    profiles: Sequence[Profile]
    rules: Sequence[StopRule]
    imperfections: Imperfections
    duration: float
    tick: float
    at_end: str = "timed out"

    @property
    def parts(self) -> list[Part]:
        """All parts in the order of a tick."""
        return [*self.controllers, self.plant]


@dataclass(frozen=True)
class Connection:
    """A wire between named signals; `part` is the index of the reader."""

    signal: str
    source: int
    target: int
    part: int
    lag: float
    delay: float
    noise: float

    @property
    def ideal(self) -> bool:
        """Whether the reader sees exactly what the source shows."""
        return self.lag == 0.0 and self.delay == 0.0 and self.noise == 0.0


@dataclass(frozen=True)
class Layout:
    """Where each signal lies in the one vector: profiles first, then inputs and outputs of each part."""

    size: int
    inputs: Sequence[int]
    outputs: Sequence[int]
    connections: Sequence[Connection]
    shown: Mapping[str, int]
    channels: Sequence[tuple[Channel, int]]


def lay_out(system: System) -> Layout:
    """Give every signal its place and connect the parts by name.

    Raises:
        WiringError: an input that no part or profile shows, two sources of one signal, or units that differ.
        InputError: a lag, delay or noise on a signal that has none.
    """
    shown: dict[str, tuple[int, str]] = {}
    for place, profile in enumerate(system.profiles):
        shown[profile.channel.name] = place, profile.channel.unit
    inputs, outputs = [0] * len(system.parts), [0] * len(system.parts)
    end = len(system.profiles)
    for index, part in enumerate(system.parts):
        inputs[index], outputs[index] = end, end + len(part.inputs.fields)
        end = outputs[index] + len(part.outputs.fields)
        for place, (name, signal) in enumerate(part.outputs.fields.items(), outputs[index]):
            if name in shown:
                raise WiringError(f"{name}: two parts show it; rename the one of {part.name}")
            shown[name] = place, signal.unit
    connections = list(_connect(system, shown, inputs))
    _refuse_unknown(system, connections)
    places = {name: place for name, (place, _) in shown.items()}
    channels = list(_channels(system, places, connections))
    return Layout(end, inputs, outputs, connections, places, channels)


def _connect(system: System, shown: Mapping[str, tuple[int, str]], inputs: Sequence[int]) -> Iterator[Connection]:
    wrong = system.imperfections
    for index, part in enumerate(system.parts):
        for target, (name, signal) in enumerate(part.inputs.fields.items(), inputs[index]):
            if name not in shown:
                raise WiringError(f"{name}: {part.name} reads it, but no part and no profile shows it")
            source, unit = shown[name]
            if unit != signal.unit:
                raise WiringError(f"{name}: {part.name} reads it in {signal.unit}, but it is shown in {unit}")
            if part is system.plant:
                yield Connection(name, source, target, index, wrong.lag.get(name, 0.0), 0.0, 0.0)
            else:
                delay, noise = wrong.delay.get(name, 0.0), wrong.noise.get(name, 0.0)
                yield Connection(name, source, target, index, 0.0, delay, noise)


def _refuse_unknown(system: System, connections: Sequence[Connection]) -> None:
    plant = len(system.parts) - 1
    commanded = {c.signal for c in connections if c.part == plant}
    measured = {c.signal for c in connections if c.part != plant}
    wrong = system.imperfections
    for kind, given, known in (
        ("lag", wrong.lag, commanded), ("delay", wrong.delay, measured), ("noise", wrong.noise, measured)
    ):  # fmt: skip
        for name in given:
            if name not in known:
                raise InputError(f"{kind}.{name}", "no such signal here", f"expected one of {', '.join(sorted(known))}")


def _channels(
    system: System, places: Mapping[str, int], connections: Sequence[Connection]
) -> Iterator[tuple[Channel, int]]:
    """Yield what is recorded: every shown signal once, and what a reader got where a wire altered it.

    Where several controllers read a signal, NAME_measured is that of the last one; the others have their name behind.
    """
    readers = {c.signal: c.part for c in connections if system.parts[c.part] is not system.plant}
    for profile in system.profiles:
        yield profile.channel, places[profile.channel.name]
    for part in (system.plant, *system.controllers):
        for name, signal in part.outputs.fields.items():
            yield _channel(name, signal), places[name]
    for connection in connections:
        if not connection.ideal:
            part = system.parts[connection.part]
            suffix = "actual" if part is system.plant else "measured"
            if suffix == "measured" and readers[connection.signal] != connection.part:
                suffix += f"_{part.name}"
            signal = part.inputs.fields[connection.signal]
            channel = Channel(f"{connection.signal}_{suffix}", signal.unit, f"{signal.meaning}, as {part.name} gets it")
            yield channel, connection.target


def _channel(name: str, signal: Field) -> Channel:
    return Channel(name, signal.unit, signal.meaning)


def argument_types(part: Part) -> dict[type[Record], str]:
    """Return what each record type is to the kernels of a part."""
    roles: dict[type[Record], Any] = {part.parameters_type: "parameters", part.state: "state"}
    roles |= {part.inputs: "inputs", part.outputs: "outputs"}
    if part.work is not None:
        roles[part.work] = "work"
    return roles


def argument_addresses(
    kernel: Kernel[..., Any], part: Part, arrays: Mapping[str, RecordArray]
) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return the addresses of what init or step of a part takes, and of its status, as an entry wants them.

    Args:
        arrays: one record for each role of `argument_types`, and one number each for "period" and "status".
    """
    roles = argument_types(part)
    found = [arrays["period" if each.record is None else roles[each.record]] for each in kernel.parameters]
    return addresses_of([*found, arrays["status"]] if kernel.result != "none" else found)
