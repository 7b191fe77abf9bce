"""Vectors of the self-test: recorded launches, and random inputs and parameters that reach every branch."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from bitepoint.export.c.driving import Answers, Floats, drive
from bitepoint.export.c.driving import Sequence as Inputs
from bitepoint.export.c.sources import Sources, ended, initialiser, number
from bitepoint.fields import Field
from bitepoint.kernels.c99.precision import whole_words
from bitepoint.kernels.c99.text import c_file, comment, indented
from bitepoint.recording import Recording
from bitepoint.records import Record, RecordArray, tabulated
from bitepoint.simulation.system import Part

BAD = (np.nan, np.inf, -np.inf, 1e30, -1e30)
"""What a broken sensor may show."""

ROWS = 120
"""Rows of a random sequence."""

SWITCHED = 0.3
"""Share of the random sequences in which a switch of the parameters is thrown."""

AS_DESIGNED = 0.2
"""Share of the random sequences whose parameters are those that were designed, as far as they do not overflow."""

OVERFLOWING = 0.3
"""Share of the random sequences in which parameters that may have any size have one that overflows."""

HUGE = (0.0, 1e37, 1e307, np.inf)
"""Sizes that overflow in what is made of them: about the largest in either precision; 0 for what it divides."""

RECORDED = 200
"""Most rows of a disturbed recording."""


def recorded(part: Part, recording: Recording, name: str, rows: int = 10_000) -> Inputs:
    """Return the inputs that a part had in a recording of its closed loop, at its own steps."""
    every = max(round(part.period / float(recording.time[1] - recording.time[0])), 1)
    table = np.array([recording[signal][::every][:rows] for signal in part.inputs.fields]).T
    return Inputs(name, part.parameters[:1], np.ascontiguousarray(np.vstack([table[:1], table])))


def random(part: Part, runs: Sequence[Inputs]) -> Iterator[Inputs]:
    """Yield random sequences without end, as `random_inputs` does, with random parameters; the same ones every time."""
    for seed, (rng, table) in enumerate(_drawn(part, runs)):
        parameters = part.parameters[:1].copy()
        if rng.random() >= AS_DESIGNED:
            _vary(parameters[0], part.parameters_type, rng, revive=rng.random() < 0.3)
        if rng.random() < OVERFLOWING:
            _overflow(parameters, part, rng)
        designed = parameters.tobytes() == part.parameters[:1].tobytes()
        yield Inputs(f"random {seed}", parameters, table, designed)


def random_inputs(part: Part, runs: Sequence[Inputs]) -> Iterator[Floats]:
    """Yield random inputs without end, in turn wild ones and disturbed recordings; the same ones every time."""
    return (table for _, table in _drawn(part, runs))


def _drawn(part: Part, runs: Sequence[Inputs]) -> Iterator[tuple[np.random.Generator, Floats]]:
    """Yield inputs, each with what drew them."""
    for seed in itertools.count():
        rng = np.random.default_rng([seed, 2026])
        run = runs[seed // 2 % len(runs)]
        table = _wild(part, rng) if seed % 2 == 0 else _disturbed(part, run, rng)
        _break(table, float(rng.choice([0.0, 0.02])), rng)
        yield rng, np.ascontiguousarray(table)


def longest_searches(run: Inputs, part: Part) -> Inputs:
    """Return a recorded run in which every search in a curve or a map goes through all the points that it can have."""
    parameters = run.parameters.copy()
    for path, field in part.parameters_type.table():
        if field.axes:
            *over, last = field.axes
            grid = [axis.low + (axis.high - axis.low) * np.linspace(0.0, 1e-3, field.most_points) for axis in over]
            values = np.full([field.most_points] * len(over), np.clip(0.3 * last.high, last.low, 1e4))
            part.parameters_type.locate(parameters, path, part.name)[1][...] = tabulated(field, *grid, values)[0]
    return Inputs(f"{run.name}, longest searches", parameters, run.inputs, designed=False)


def _break(table: Floats, share: float, rng: np.random.Generator) -> None:
    """Replace a share of the inputs by what a broken sensor may show."""
    if share == 0.0:
        rng.random(table.size)  # as many as below, so that what is drawn next does not depend on it
        return
    for row in table:
        for column in range(len(row)):
            if rng.random() < share:
                row[column] = rng.choice(BAD)


def _wild(part: Part, rng: np.random.Generator) -> Floats:
    """Return inputs over their declared ranges: they hold for a while, drift, or jump."""
    fields = list(part.inputs.fields.values())
    table = np.array([_signal(field, ROWS, rng) for field in fields]).T
    _approach(table, fields, rng)
    return table


def _disturbed(part: Part, run: Inputs, rng: np.random.Generator) -> Floats:
    """Return recorded inputs, each of them for some time replaced by others, scaled or shifted."""
    table = run.inputs[:RECORDED].copy()
    for column, field in enumerate(part.inputs.fields.values()):
        first, length = rng.integers(0, len(table)), rng.integers(1, len(table))
        some = slice(first, first + length)
        other = _signal(field, len(table), rng)[some]
        near = table[some, column] * rng.uniform(0.3, 1.7)
        table[some, column] = np.clip(near if rng.random() < 0.7 else other, field.low, field.high)
    return table


def _signal(field: Field, rows: int, rng: np.random.Generator) -> Floats:
    low, high = max(field.low, -1e6), min(field.high, 1e6)
    span = (high - low) * rng.choice([1.0, 0.3, 0.05])
    start = np.clip(0.0, low, high) + rng.uniform(-0.5, 0.5) * span
    jumps = np.cumsum(rng.random(rows) < rng.choice([0.02, 0.1, 0.5]))
    levels = start + rng.uniform(-0.5, 0.5, rows + 1)[jumps] * span
    drift = np.cumsum(rng.normal(0.0, 0.01, rows)) * span
    zero = rng.random(rows + 1)[jumps] < 0.2
    return np.clip(np.where(zero, 0.0, levels + drift), low, high)


def _approach(table: Floats, fields: Sequence[Field], rng: np.random.Generator) -> None:
    """Bring signals of one unit close to each other for a while: control happens where speeds nearly meet."""
    rows = len(table)
    for column, field in enumerate(fields):
        first = next(n for n, other in enumerate(fields) if other.unit == field.unit)
        first_row, length = rng.integers(0, rows), rng.integers(rows // 4, rows)
        if first < column:
            some = slice(first_row, first_row + length)
            gap = (field.high - field.low) * 10.0 ** rng.uniform(-6, -1) * rng.choice([-1.0, 1.0])
            near = table[some, first] + gap * np.linspace(1.0, rng.uniform(-0.2, 1.0), len(table[some]))
            table[some, column] = np.clip(near, field.low, field.high)


def _vary(record: Any, kind: type[Record], rng: np.random.Generator, *, revive: bool) -> None:
    """Change numbers of one record at random, within their ranges; `revive` some of those that are 0."""
    for name, field in kind.fields.items():
        if field.axes:
            record[name] = _table(field, rng)[0]
        elif field.record is not None:
            for item in np.atleast_1d(record[name]):
                _vary(item, field.record, rng, revive=revive)
        elif field.kind == "int":
            if (field.low, field.high) == (0.0, 1.0) and rng.random() < SWITCHED:
                record[name] = 1 - record[name]
            elif field.names:
                record[name] = rng.integers(int(field.low), int(field.high), endpoint=True)
            continue  # else a number of things, whose other values need more than a number
        else:
            shape = field.shape or None
            span = min(field.high - field.low, 1e6) * 10.0 ** rng.uniform(-4, 0)
            value = np.where(rng.random(shape) < 0.1, 0.0, record[name] * np.exp(rng.uniform(-1.0, 1.0, shape)))
            if revive:
                value = np.where((value == 0.0) & (rng.random(shape) < 0.7), rng.uniform(-span, span, shape), value)
            record[name] = np.clip(value, field.low, field.high)


def _overflow(parameters: RecordArray, part: Part, rng: np.random.Generator) -> None:
    """Give numbers of an unlimited field, or all of them, a size that overflows in what is made of them."""
    unlimited = [path for path, field in part.parameters_type.table() if field.kind == "float" and field.high == np.inf]
    if unlimited:
        field, view = part.parameters_type.locate(parameters, str(rng.choice(unlimited)), part.name)
        numbers: Floats = np.asarray(view, np.float64)
        shape: tuple[int, ...] = numbers.shape
        some = rng.random(shape) < float(rng.choice([0.1, 0.5, 1.0]))
        size = float(rng.choice(HUGE)) * rng.choice([-1.0, 1.0], shape)
        view[...] = np.clip(np.where(some, size, numbers), field.low, field.high)


def _table(field: Field, rng: np.random.Generator) -> RecordArray:
    """Return a random curve or map, which may have few points or all that there can be."""
    *over, last = field.axes
    grid: list[Floats] = []
    for axis in over:
        points = int(rng.choice([2, 3, 6, field.most_points]))
        reach = axis.low + (min(axis.high, 1e4) - axis.low) * rng.uniform(0.2, 1.0)
        grid.append(np.sort(rng.uniform(axis.low, reach, points)))
    return tabulated(field, *grid, rng.uniform(last.low, min(last.high, 1e4), [len(points) for points in grid]))


def answers(sources: Sources, sequences: Sequence[Inputs]) -> list[Answers]:
    """Return what the part answers to each sequence: in float64 by the compiled life, in float32 by the C itself."""
    life = "compiled" if sources.precision.size == 8 else "c"
    return [drive(sources.part, sequence, life, sources.precision) for sequence in sequences]


def files(sources: Sources, sequences: Sequence[Inputs], expected: Sequence[Answers]) -> dict[str, str]:
    """Return vectors.h and vectors.c."""
    return {
        "test/vectors.h": c_file(_header(sources, sequences)),
        "test/vectors.c": c_file(_source(sources, sequences, expected)),
    }


def _header(sources: Sources, sequences: Sequence[Inputs]) -> Iterator[str]:
    real, integer = sources.precision.real, sources.precision.integer
    rows = sum(len(sequence.inputs) for sequence in sequences)
    inputs, outputs = len(sources.part.inputs.fields), len(sources.part.outputs.fields)
    whole = whole_words(sources.records["state"])
    yield from comment("Recorded vectors; row by row, the first row of each sequence is what init sees and shows.")
    yield from ("#ifndef VECTORS_H", "#define VECTORS_H", "", f'#include "{sources.prefix}.h"', "")
    yield f"#define VECTORS_SEQUENCES ({len(sequences)}U)"
    yield f"#define VECTORS_PERIOD ({sources.prefix.upper()}_PERIOD)"
    yield from ("", "typedef struct", "{", f"    const {sources.type('parameters')} *parameters;")
    yield from ("    bool designed; /* or else with random parameters */", "    uint32_t rows;")
    yield f"    {sources.type('state')} state; /* after the last row */"
    yield from ("} vectors_sequence_t;", "")
    yield "extern const vectors_sequence_t vectors_sequences[VECTORS_SEQUENCES];"
    yield f"extern const {real} vectors_inputs[{rows}][{inputs}];"
    yield f"extern const {real} vectors_outputs[{rows}][{outputs}];"
    yield f"extern const {integer} vectors_status[{rows}];"
    yield f"extern const bool vectors_whole[{whole.size}]; /* which words of the state are integers */"
    yield from ("", "#endif")


def _source(sources: Sources, sequences: Sequence[Inputs], expected: Sequence[Answers]) -> Iterator[str]:
    precision, record = sources.precision, sources.records
    nominal = sources.part.parameters[:1].tobytes()
    designed = [sequence.parameters.tobytes() == nominal for sequence in sequences]
    names = [sources.instance("parameters") if same else f"parameters_{n}" for n, same in enumerate(designed)]
    yield f'#include "{sources.prefix}_parameters.h"'
    yield from ('#include "vectors.h"', "", "#include <math.h>", "")
    for name, same, sequence in zip(names, designed, sequences, strict=True):
        if same:
            continue
        yield f"static const {sources.type('parameters')} {name} ="
        yield from ended(initialiser(sequence.parameters[0], record["parameters"], precision))
        yield ""
    yield "const vectors_sequence_t vectors_sequences[VECTORS_SEQUENCES] ="
    yield "{"
    for name, sequence, answer in zip(names, sequences, expected, strict=True):
        yield from indented(comment(sequence.name))
        known = "true" if sequence.designed else "false"
        yield f"    {{ .parameters = &{name}, .designed = {known}, .rows = {len(sequence.inputs)}U, .state ="
        yield from indented(initialiser(answer.state[0], record["state"], precision), 2)
        yield "    },"
    yield from ("};", "")
    tables = (("inputs", [s.inputs for s in sequences]), ("outputs", [a.outputs for a in expected]))
    for name, parts in tables:
        table = np.vstack(parts)
        yield f"const {precision.real} vectors_{name}[{len(table)}][{table.shape[1]}] ="
        yield "{"
        yield from (f"    {{{', '.join(number(value, 'float', precision) for value in row)}}}," for row in table)
        yield from ("};", "")
    statuses = np.concatenate([answer.statuses for answer in expected])
    flags = ["true" if flag else "false" for flag in whole_words(record["state"])]
    yield f"const bool vectors_whole[{len(flags)}] ="
    yield "{"
    yield from (f"    {', '.join(flags[n : n + 16])}," for n in range(0, len(flags), 16))
    yield from ("};", "")
    yield f"const {precision.integer} vectors_status[{len(statuses)}] ="
    yield "{"
    for first in range(0, len(statuses), 32):
        yield "    " + " ".join(f"{status}," for status in statuses[first : first + 32])
    yield "};"
