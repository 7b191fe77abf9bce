"""A part that looks up a map: the same bits in every life and on the target, and in the description of its memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bitepoint.export.a2l import a2l_text, symbol_sizes
from bitepoint.export.c import toolchain, vectors
from bitepoint.export.c.driving import Sequence, drive
from bitepoint.export.c.package import lay_down, same
from bitepoint.export.c.sources import Sources
from bitepoint.kernels import kernel
from bitepoint.kernels.c99 import FLOAT32, PRECISIONS, Precision
from bitepoint.numerics.tables import lookup_map
from bitepoint.records import Map, Record, characteristic_map, quantity
from bitepoint.simulation.system import Part
from tests.conftest import needs_c, needs_target
from tests.export import mcd

each_precision = pytest.mark.parametrize("precision", PRECISIONS.values(), ids=PRECISIONS.keys())


class FuelParameters(Record):
    """A fuel map."""

    fuel: Map = characteristic_map(
        ("engine_speed", "rad/s", 0, 800), ("engine_torque", "N*m", -100, 400), ("flow", "kg/s", 0, 0.05), "fuel flow"
    )


class FuelState(Record):
    """What was burnt."""

    mass: float = quantity("kg", 0, 1e6, "fuel burnt")


class FuelInputs(Record):
    """Where the engine works."""

    engine_speed: float = quantity("rad/s", 0, 800, "engine speed")
    engine_torque: float = quantity("N*m", -100, 400, "engine torque")


class FuelOutputs(Record):
    """What it burns."""

    flow: float = quantity("kg/s", 0, 0.05, "fuel flow")


@kernel
def init(p: FuelParameters, s: FuelState, u: FuelInputs, y: FuelOutputs) -> None:
    """Begin with nothing burnt."""
    s.mass = 0.0
    y.flow = 0.0


@kernel
def step(p: FuelParameters, s: FuelState, u: FuelInputs, y: FuelOutputs, dt: float) -> int:
    """Look the flow up and count it."""
    y.flow = lookup_map(p.fuel, u.engine_speed, u.engine_torque)
    s.mass = s.mass + y.flow * dt
    return 0


def part(rows: int = 16, columns: int = 9) -> Part:
    """The part, with a map of so many points."""
    speed, torque = np.linspace(80.0, 650.0, rows) ** 1.01, np.linspace(-30.0, 240.0, columns)
    flow = np.maximum(1e-4 + 7e-8 * np.outer(speed, torque + 25.0), 0.0)
    columns_in_si = {"engine_speed": speed, "engine_torque": torque, "flow": flow}
    parameters = FuelParameters.parse({"fuel": columns_in_si}, "fuel map")
    return Part("fuel", init, step, parameters, FuelParameters, FuelState, FuelInputs, FuelOutputs, None, 0.01)


@pytest.fixture(scope="module")
def sequences() -> list[Sequence]:
    """Random working points, on the grid, between its points and beyond them, and broken sensors."""
    rng = np.random.default_rng(5)
    found: list[Sequence] = []
    for rows, columns in ((2, 2), (3, 16), (16, 9)):
        parameters = part(rows, columns).parameters
        fuel = parameters["fuel"][0]
        at = rng.uniform([0.0, -100.0], [800.0, 400.0], (60, 2))
        at[:20] = np.column_stack([rng.choice(fuel["x"], 20), rng.choice(fuel["y"], 20)])
        at[20:30] = rng.choice(vectors.BAD, (10, 2))
        found.append(Sequence(f"{rows} x {columns} points", parameters, at))
    return found


@needs_c
def test_every_life_gives_the_same_bits(sequences: list[Sequence]) -> None:
    for sequence in sequences:
        wanted = drive(part(), sequence)
        assert np.ptp(wanted.outputs) > 1e-4
        assert np.isfinite(wanted.outputs).all()
        for life in ("interpreted", "c"):
            assert same(part(), drive(part(), sequence, life), wanted)  # pyright: ignore


@needs_c
def test_single_precision_stays_close(sequences: list[Sequence]) -> None:
    for sequence in sequences:
        wide, small = drive(part(), sequence), drive(part(), sequence, "c", FLOAT32)
        assert small.outputs == pytest.approx(wide.outputs, rel=1e-5, abs=1e-8)


@needs_target
@each_precision
def test_the_target_gives_the_same_bits(sequences: list[Sequence], precision: Precision, tmp_path: Path) -> None:
    sources = Sources(part(), precision, "fuel flow over speed and torque", "a made-up map")
    folder, work = tmp_path / "fuel", tmp_path / "work"
    work.mkdir()
    lay_down(sources, sequences, vectors.answers(sources, sequences), folder)
    toolchain.run_host(folder, work)
    run = toolchain.run_target(sources, folder, work, "cortex-m7")
    assert run is not None
    assert (run.differences, run.steps) == (0, sum(len(s.inputs) - 1 for s in sequences))
    if precision is FLOAT32:
        assert run.instructions_worst <= 200


@each_precision
def test_a_tool_reads_the_map_in_memory(precision: Precision, tmp_path: Path) -> None:
    fuel = part(5, 3)
    start = 0x2000_0000
    addresses = {name: start + 0x1_0000 * place for place, name in enumerate(symbol_sizes(fuel, precision))}
    module = mcd.parsed(a2l_text(fuel, precision, addresses), tmp_path)
    item = mcd.objects(module)["fuel_parameters.fuel"]
    assert item["characteristic_type"] == "Map"
    assert [axis["input_quantity"] for axis in item["axis_descr"]] == [
        "fuel_inputs.engine_speed",
        "fuel_inputs.engine_torque",
    ]
    image = precision.convert(fuel.parameters, FuelParameters)
    x, y, z = mcd.Memory(module, start, image.tobytes()).calibrated(item)
    told = FuelParameters.to_mapping(fuel.parameters[0])["fuel"]
    assert (len(x), len(y)) == (5, 3)
    for got, name in ((x, "engine_speed"), (y, "engine_torque"), (z, "flow")):
        assert np.array(got) == pytest.approx(np.array(told[name]), rel=1e-6)
