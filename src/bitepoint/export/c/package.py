"""Putting an export together: translate, record vectors, hold the lives to each other, measure, and write it whole."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bitepoint.assembly import PLANTS
from bitepoint.errors import InputError
from bitepoint.export.c import coverage, toolchain, vectors
from bitepoint.export.c.driving import Answers, Floats, drive, iteration_counts
from bitepoint.export.c.driving import Sequence as Inputs
from bitepoint.export.c.longest import drawn, longest
from bitepoint.export.c.report import Difference, Findings
from bitepoint.export.c.sources import Sources
from bitepoint.export.c.templates import filled
from bitepoint.export.subject import Options, Subject, chosen_precision, find_subject
from bitepoint.kernels.c99 import FLOAT32
from bitepoint.kernels.c99.host import compiler
from bitepoint.kernels.c99.precision import whole_words
from bitepoint.simulation.run import Simulation
from bitepoint.simulation.system import Imperfections, Part, argument_types

MOST_BYTES = 1_000_000
"""Most bytes that the records of one part may take on an ECU."""

RECORDED_ROWS = 300
"""Most rows that are taken from one recorded run."""

Step = Callable[[str], None]
"""Told what is being done."""


def export_c(options: Options, out: Path, step: Step = lambda _: None) -> Findings:
    """Write a controller or a plant as C99 into the folder `out`, made whole or not at all.

    Raises:
        InputError: an unknown name, vehicle, setting or precision, a folder that is not empty, no C compiler, a part
            too large for an ECU.
        SubsetError: a kernel that cannot be translated.
    """
    try:
        out = out.resolve()
        refuse_folder(out)
    except OSError as error:  # a name that no folder can have
        raise InputError(str(out)[:60], f"cannot be written ({error.strerror})", "choose another folder") from None
    compiler()
    found = find_subject(options)
    _refuse_large(found.part)
    sources = Sources(found.part, chosen_precision(options), found.meaning, found.origin)
    _ = sources.translation
    with tempfile.TemporaryDirectory(prefix="bitepoint-export-") as work:
        folder = Path(work) / "export"
        findings = _write(sources, list(record(found)), folder, Path(work), step)
        _keep(folder, out)
    return findings


def refuse_folder(out: Path) -> None:
    """Raise InputError where `out` is there and is no empty folder."""
    ancestor = next(folder for folder in (out, *out.absolute().parents) if folder.exists())
    if (not ancestor.is_dir() and ancestor != out) or not os.access(ancestor, os.W_OK):
        raise InputError(str(out), f"cannot be written: {ancestor} is no folder for that", "choose another folder")
    if not out.exists() or (out.is_dir() and not any(out.iterdir())):
        return
    what = "a folder that is not empty" if out.is_dir() else "a file"
    raise InputError(str(out), f"is {what}", "name a folder that is new or empty")


def record(found: Subject, rows: int = RECORDED_ROWS) -> Iterator[Inputs]:
    """Yield what the part met in each of its loops, run without lag, delay and noise: at most `rows` of each."""
    for name, assembly in found.loops:
        long_enough = min(assembly.system.duration, (rows + 1) * found.part.period)
        ideal = replace(assembly.system, imperfections=Imperfections(), duration=long_enough)
        recording = Simulation(ideal).run(lambda _: None)[0].recording
        assert recording is not None
        yield vectors.recorded(found.part, recording, name, rows)


def _refuse_large(part: Part) -> None:
    size = sum(record.dtype.itemsize for record in argument_types(part))
    if size > MOST_BYTES:
        raise InputError(part.name, f"its records take {size} bytes", f"expected at most {MOST_BYTES} on an ECU")


def _write(sources: Sources, recorded: Sequence[Inputs], folder: Path, work: Path, step: Step) -> Findings:
    """Write all files into `folder`, use `work` for what is built on the way, and return what was found."""
    step("recording vectors")
    small = replace(sources, precision=FLOAT32)
    step("looking for the longest step")
    fixed = [*recorded, *_longest((small, sources), recorded, work)]
    sequences = coverage.choose(sources, fixed, vectors.random(sources.part, recorded), _folder(work, "probe"))
    expected = vectors.answers(sources, sequences)
    _hold(sources, sequences, expected)
    lay_down(sources, sequences, expected, folder)
    step("running the self-test")
    toolchain.run_host(folder, _folder(work, "host"))
    variants = [(sources, folder)]
    if sources.precision is not FLOAT32:
        variants.insert(0, (small, work / "small"))
        lay_down(small, sequences, vectors.answers(small, sequences), work / "small")
    step("measuring on the target")
    tried = [(v, path, cpu) for v, path in variants for cpu in toolchain.PROCESSORS[v.precision.name]]
    runs = [toolchain.run_target(v, path, _folder(work, f"{cpu}-{v.precision.name}"), cpu) for v, path, cpu in tried]
    builds = [toolchain.build(v, path, _folder(work, f"build-{v.precision.name}")) for v, path in variants]
    step("checking rules and coverage")
    findings = Findings(
        sources=sources,
        steps=sum(len(sequence.inputs) - 1 for sequence in sequences),
        sequences=len(sequences),
        data_bytes=small.data_bytes,
        builds=[built for built in builds if built is not None],
        runs=[run for run in runs if run is not None],
        misra=toolchain.misra(sources, folder),
        coverage=toolchain.measure_coverage(sources, folder, _folder(work, "coverage")),
        differences=_differences(sources, recorded),
        solver=_solver(sources, [answer for s, answer in zip(sequences, expected, strict=True) if s.designed]),
    )
    (folder / "report.json").write_text(json.dumps(findings.to_json(), indent=2, allow_nan=False) + "\n", "utf-8")
    (folder / "REPORT.md").write_text(findings.to_markdown(), "utf-8")
    return findings


def _longest(variants: Sequence[Sources], recorded: Sequence[Inputs], work: Path) -> Iterator[Inputs]:
    """Yield the longest step that a search finds in each precision; of a plant a run with the longest searches."""
    part = variants[0].part
    if part.name in PLANTS or not coverage.available():
        yield vectors.longest_searches(recorded[0], part)
        return
    tables = drawn(part, recorded)
    for name, variant in {variant.precision.name: variant for variant in variants}.items():
        yield longest(variant, tables, _folder(work, f"longest-{name}"))


def _folder(work: Path, name: str) -> Path:
    path = work / name
    path.mkdir()
    return path


def lay_down(sources: Sources, sequences: Sequence[Inputs], expected: Sequence[Answers], folder: Path) -> None:
    """Write sources, templates and vectors, whose sequences and answers belong to each other, into a folder."""
    files = {**sources.files(), **filled(sources), **vectors.files(sources, sequences, expected)}
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _hold(sources: Sources, sequences: Sequence[Inputs], expected: Sequence[Answers]) -> None:
    """Raise unless the C on this machine answers exactly as the compiled life."""
    if sources.precision is FLOAT32:
        return  # the C itself is what was recorded
    for sequence, answer in zip(sequences, expected, strict=True):
        again = drive(sources.part, sequence, "c")
        if not same(sources.part, answer, again):
            raise RuntimeError(f"{sources.part.name}: C and the compiled life differ in sequence {sequence.name}")


def same(part: Part, a: Answers, b: Answers) -> bool:
    """Return whether two lives of a part gave the same answers, to the bit; every NaN of a float is the same one."""
    whole = np.zeros(a.outputs.shape[1], bool)
    state = whole_words(part.state)
    return (
        np.array_equal(a.statuses, b.statuses)
        and _same_words(a.outputs, b.outputs, whole)
        and _same_words(a.state.view(a.outputs.dtype), b.state.view(b.outputs.dtype), state)
    )


def _same_words(a: Floats, b: Floats, whole: np.ndarray[Any, np.dtype[np.bool_]]) -> bool:
    bits = np.int64 if a.itemsize == 8 else np.int32
    neither = np.isnan(a) & np.isnan(b) & ~whole
    return bool(((a.view(bits) == b.view(bits)) | neither).all())


def _differences(sources: Sources, recorded: Sequence[Inputs]) -> list[Difference]:
    fields = sources.part.outputs.fields
    largest = np.zeros(len(fields))
    for sequence in recorded:
        wide = drive(sources.part, sequence, "compiled").outputs
        small = drive(sources.part, sequence, "c", FLOAT32).outputs.astype(np.float64)
        largest = np.fmax(largest, np.abs(wide - small).max(axis=0))
    return [Difference(name, f.unit, float(value)) for (name, f), value in zip(fields.items(), largest, strict=True)]


def _solver(sources: Sources, expected: Sequence[Answers]) -> tuple[int, int] | None:
    seen = [answer.iterations for answer in expected if answer.iterations is not None]
    caps = [cap for _, _, cap in iteration_counts(sources.part)]
    return (max(seen), max(caps)) if seen and caps else None


def _keep(folder: Path, out: Path) -> None:
    """Move the finished folder to where it was asked for."""
    refuse_folder(out)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as near:
            beside = Path(near) / "export"
            shutil.copytree(folder, beside)
            if out.exists():
                out.rmdir()
            beside.rename(out)
    except OSError as error:
        raise InputError(str(out), f"cannot be written ({error.strerror})", "choose another folder") from None
