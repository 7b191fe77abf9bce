"""Parts to export: all that there are, and one made up of everything that records can hold."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from bitepoint.assembly import CONTROLLERS, SUPERVISORS
from bitepoint.export.subject import Options, find_subject
from bitepoint.fields import Field
from bitepoint.kernels import kernel
from bitepoint.kernels.c99 import PRECISIONS, Precision
from bitepoint.records import (
    Curve,
    FloatArray,
    IntArray,
    Map,
    Record,
    RecordArray,
    RecordElements,
    characteristic_map,
    count,
    curve,
    nested,
    quantity,
    tabulated,
)
from bitepoint.simulation.system import Part
from tests.contracts.harness import nominal, plants_with_vehicles

AWKWARD = 'a "quoted" C:\\path,\nΛ = 5 µm² at 20 °C – /* no comment */ // no comment, ≥ 0 …\x07'


class Slot(Record):
    """One of several."""

    weight: float = quantity("kg*m^2/rad", -1e300, 1e300, "weight \U0001f697 of the slot")
    table: Curve = curve(("pedal", "1", 0, 1), ("torque", "N*m", -5.5, 1e6), "of the slot")
    surface: Map = characteristic_map(
        ("pedal", "1", 0, 1), ("speed", "rad/s", 0, 10), ("torque", "N*m", -5.5, 1e6), "of the slot"
    )


class MadeUpParameters(Record):
    """Everything that a record can hold. Its "first" sentence is not the only one."""

    tiny: float = quantity("s", 1e-6, 0.002, AWKWARD)
    matrix: FloatArray = quantity("N*m*s/rad", -1e6, 1e6, "rows are \\ outputs", shape=(2, 3))
    cube: FloatArray = quantity("1", 0, 1, "", shape=(2, 3, 4))
    switches: IntArray = count(-2, 7, "0 off, 1 on", shape=(3,))
    mode: int = count(-1, 1, "sense", names=("back", "still", "ahead"))
    slots: RecordElements[Slot] = nested(Slot, "the slots", shape=(2,))
    grid: RecordElements[Slot] = nested(Slot, "more slots", shape=(2, 2))
    over_slip: Curve = curve(("slip", "rad/s", -10, 10), ("torque", "N*m", 0, 1), "over an input")
    over_speed: Curve = curve(("speed", "rad/s", 0, 10), ("torque", "N*m", 0, 1), "over no input")
    over_both: Map = characteristic_map(
        ("slip", "rad/s", -10, 10), ("pedal", "1", 0, 1), ("torque", "N*m", 0, 1), "over two inputs"
    )
    per_length: float = quantity("N/m", 0, 1, "unit whose name another one takes")
    times_length: float = quantity("N_per_m", 0, 1, "that unit")


class MadeUpState(Record):
    """Memory."""

    learned: Curve = curve(("speed", "rad/s", 0, 500), ("torque", "N*m", 0, 400), "what was learned")
    learned_map: Map = characteristic_map(
        ("speed", "rad/s", 0, 500), ("torque", "N*m", 0, 400), ("flow", "kg/s", 0, 1), "what was learned, too"
    )
    covariance: FloatArray = quantity("1", -10, 10, "of the estimate", shape=(2, 2))


class MadeUpInputs(Record):
    """What it sees."""

    pedal: float = quantity("1", 0, 1, "pedal")
    slip: float = quantity("rad/s", -10, 10, "slip")
    speed: float = quantity("m/s", 0, 1, "same name as an axis, but of another unit")


class MadeUpOutputs(Record):
    """What it shows."""

    torque: float = quantity("N*m", -1, 1, "torque")


@kernel
def init(p: MadeUpParameters, s: MadeUpState, u: MadeUpInputs, y: MadeUpOutputs) -> None:
    """Do nothing."""
    y.torque = 0.0


@kernel
def step(p: MadeUpParameters, s: MadeUpState, u: MadeUpInputs, y: MadeUpOutputs, dt: float) -> int:
    """Do nothing."""
    y.torque = u.pedal
    return 0


def _made_up() -> Part:
    parameters = filled(MadeUpParameters, 1)
    return Part(
        "made_up", init, step, parameters, MadeUpParameters, MadeUpState, MadeUpInputs, MadeUpOutputs, None, 0.01
    )


def filled(record: type[Record], seed: int) -> RecordArray:
    """One record with random numbers, all different, integers in their range; curves and maps have several lengths."""
    rng = np.random.default_rng([seed, 7])
    array = record.zeros()
    for _, field, view in leaves(array, record, ""):
        if field.axes:
            points = rng.integers(2, field.most_points, len(field.axes) - 1, endpoint=True)
            grid = [np.sort(rng.normal(size=size)) for size in points]
            view[...] = tabulated(field, *grid, rng.normal(size=points))
        elif field.kind == "int":
            view[...] = rng.integers(int(field.low), int(field.high), view.shape, endpoint=True)
        else:
            view[...] = rng.normal(size=view.shape)
    return array


def leaves(array: Any, record: type[Record], path: str) -> Iterator[tuple[str, Field, Any]]:
    """Yield path in C, field and view of each number, array of numbers, curve and map of records."""
    for name, field in record.fields.items():
        view = array[name]
        if field.record is None or field.axes:
            yield f"{path}.{name}", field, view
        else:
            for index in np.ndindex(field.shape):
                element = "".join(f"[{number}]" for number in index)
                yield from leaves(view[(slice(None), *index)], field.record, f"{path}.{name}{element}")


def every_part() -> dict[str, Part]:
    """All parts by name."""
    parts = [find_subject(Options(name)).part for name in (*CONTROLLERS, *SUPERVISORS)]
    return {part.name: part for part in [*_plants(), *parts, _made_up()]}


def _plants() -> Iterator[Part]:
    """Every plant with the last of its library vehicles."""
    for plant, vehicle in plants_with_vehicles():
        yield Part(
            plant.name, plant.init, plant.step, nominal(plant, vehicle), plant.parameters, plant.state, plant.inputs,
            plant.outputs, plant.work, 0.002,
        )  # fmt: skip


PARTS = every_part()
CASES: list[tuple[Part, Precision]] = [
    (part, precision) for part in PARTS.values() for precision in PRECISIONS.values()
]
"""Every part in every precision."""
