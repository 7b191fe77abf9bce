"""Measurements of an exported folder by tools that may be there or not: sizes, stack, instructions, MISRA, coverage."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from bitepoint.export.c import coverage
from bitepoint.export.c.coverage import Coverage
from bitepoint.export.c.sources import Sources
from bitepoint.kernels.c99.host import FLAGS, compiler

CROSS = "arm-none-eabi-gcc"
SIZE = "arm-none-eabi-size"
EMULATOR = "qemu-system-arm"
CPUS = {"cortex-m7": "fpv5-d16", "cortex-m4": "fpv4-sp-d16"}
"""Processors that the exported Makefile knows, with their floating-point units."""

PROCESSORS = {"float64": ("cortex-m7",), "float32": ("cortex-m7", "cortex-m4")}
"""Where the self-test of each precision is run: a Cortex-M4 has no unit for double precision."""

PACKAGES = "gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm cppcheck"
"""What Debian calls the packages that these measurements need."""

LONGEST = 300
"""Most seconds that one tool may take."""


@dataclass(frozen=True)
class Build:
    """Bytes of code and constants of the generated source, of its records, and of the deepest stack, at -O2."""

    cpu: str
    precision: str
    code_bytes: int
    data_bytes: int
    stack_bytes: int


@dataclass(frozen=True)
class TargetRun:
    """The self-test on an emulated processor.

    Attributes:
        instructions_worst: of a step with the parameters that were designed; None where a step was too long to count.
        instructions_worst_of_random: with random parameters, which need not make sense together.
        instructions_mean: over all steps.
        stack_measured: deepest stack below the caller of a step, bytes, of which less than the floor cannot be seen.
    """

    cpu: str
    precision: str
    steps: int
    differences: int
    steps_too_long: int
    instructions_worst: int | None
    instructions_worst_of_random: int | None
    instructions_mean: int | None
    stack_measured: int
    stack_floor: int


def missing() -> list[str]:
    """Return which programs of the target's tool chain are not on the path."""
    return [program for program in ("make", CROSS, SIZE, EMULATOR) if shutil.which(program) is None]


def build(sources: Sources, folder: Path, work: Path, cpu: str = "cortex-m7") -> Build | None:
    """Compile the generated source for a processor at -O2; None where there is no cross compiler.

    The stack is the sum of the frames along the deepest path of calls, as the compiler counts them; what the maths
    library takes is not in it.
    """
    if shutil.which(CROSS) is None or shutil.which(SIZE) is None:
        return None
    target = [f"-mcpu={cpu}", "-mthumb", "-mfloat-abi=hard", f"-mfpu={CPUS[cpu]}"]
    file = work / f"{sources.prefix}.o"
    _run([CROSS, *target, *FLAGS, "-fstack-usage", "-c", "-o", str(file), f"{sources.prefix}.c"], folder)
    table = _run([SIZE, str(file)], folder).splitlines()
    deepest = _deepest(sources, _frames(file.with_suffix(".su")))
    return Build(cpu, sources.precision.name, int(table[1].split()[0]), sources.data_bytes, deepest)


def _frames(file: Path) -> dict[str, int]:
    """Return the bytes of stack of each function; clones that the compiler made count for their original."""
    frames: dict[str, int] = {}
    for line in file.read_text().splitlines():
        place, size, _ = line.split("\t")
        name = place.rpartition(":")[2].partition(".")[0]
        frames[name] = max(int(size), frames.get(name, 0))
    return frames


def _deepest(sources: Sources, frames: Mapping[str, int]) -> int:
    calls = sources.translation.calls

    def below(name: str) -> int:
        return frames.get(name, 0) + max((below(callee) for callee in calls.get(name, ())), default=0)

    return max(below(f"{sources.prefix}_{role}") for role in ("init", "step"))


def run_target(sources: Sources, folder: Path, work: Path, cpu: str) -> TargetRun | None:
    """Run the self-test on an emulated processor; None where the tool chain is missing."""
    if missing():
        return None
    done = _finish(_make("target", work, f"CPU={cpu}"), folder)
    pairs = re.findall(r"^(\w+)=(\d+)$", done.stdout + done.stderr, re.MULTILINE)
    found: dict[str, Any] = {name: int(number) for name, number in pairs}
    if "stack_floor" not in found:
        raise RuntimeError(f"the image for {cpu} did not run:\n{done.stdout}{done.stderr}")
    if found["steps_too_long"] > 0:
        found |= dict.fromkeys(("instructions_worst", "instructions_worst_of_random", "instructions_mean"))
    told = {field.name: found[field.name] for field in fields(TargetRun) if field.name in found}
    return TargetRun(cpu, sources.precision.name, **told)


def run_host(folder: Path, work: Path) -> None:
    """Run the exported self-test on this machine.

    Raises:
        RuntimeError: it does not compile, or does not answer as recorded.
    """
    if shutil.which("make") is not None:
        _run(_make("test", work), folder)


def measure_coverage(sources: Sources, folder: Path, work: Path) -> Coverage | None:
    """Return what the vectors reach of the generated source; None where gcc's gcov or make is missing."""
    if not coverage.available() or shutil.which("make") is None:
        return None
    _run(_make("coverage", work), folder)
    file = work / f"selftest-coverage-{sources.prefix}.gcov.json.gz"
    return coverage.read(file, folder / f"{sources.prefix}.c")


def misra(sources: Sources, folder: Path) -> dict[str, int] | None:
    """Return the findings of cppcheck's MISRA C:2012 checks by rule; None where cppcheck is missing."""
    if shutil.which("cppcheck") is None:
        return None
    files = [f"{sources.prefix}.c", f"{sources.prefix}_parameters.c"]
    command = ["cppcheck", "--addon=misra", "--std=c99", "--quiet", "--template={id}", "-I.", *files]
    done = _finish(command, folder)
    lines = [*done.stdout.splitlines(), *done.stderr.splitlines()]
    if done.returncode != 0 or any(" " in line for line in lines):  # findings are single words: it says what it lacks
        return None
    counts = Counter(line.removeprefix("misra-c2012-") for line in lines if line.startswith("misra-c2012-"))
    return dict(sorted(counts.items(), key=lambda item: [int(part) for part in item[0].split(".")]))


def _make(target: str, work: Path, *settings: str) -> list[str]:
    """Return the command that makes a target of the exported folder; `work` lies beside the folder."""
    return ["make", "-s", target, f"CC={compiler()}", f"BUILD=../{work.name}", *settings]


def _finish(command: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command without what the user's environment says to make and compilers."""
    environment = {name: value for name, value in os.environ.items() if name not in _IGNORED}
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=LONGEST, check=False, env=environment
    )


_IGNORED = frozenset({
    "CC", "CFLAGS", "CPPFLAGS", "LDFLAGS", "MAKEFLAGS", "MFLAGS", "MAKELEVEL", "CPU", "CROSS", "QEMU", "BUILD", "AR",
})  # fmt: skip


def _run(command: Sequence[str], folder: Path) -> str:
    done = _finish(command, folder)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")
    return done.stdout
