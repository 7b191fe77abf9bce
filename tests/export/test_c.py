"""Exported folders: what is in them, that they hold together, and that they cannot be got wrong silently."""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from bitepoint.assembly import ADVISERS, CONTROLLERS, PLANTS, SUPERVISORS
from bitepoint.controllers import damping_mpc_records, launch_mpc_records
from bitepoint.controllers.ddpc import MOVES
from bitepoint.export.c import export_c, vectors
from bitepoint.export.c.package import lay_down, record
from bitepoint.export.c.sources import Sources
from bitepoint.export.subject import Options, find_subject
from bitepoint.kernels.c99 import PRECISIONS, host
from bitepoint.kernels.c99.host import FLAGS, STRICT
from bitepoint.numerics.qp import qp_solver
from tests.conftest import Command, Refused, names_in, needs, needs_c, needs_target

pytestmark = needs_c

MOST_CODE, MOST_STACK = {"launch_mpc": 10_240}, 1024
"""Bytes that a controller may take on a Cortex-M7 in float32: code by name, the others 8192; and stack."""

MOST_INSTRUCTIONS = {"launch_mpc": 31_000, "ddpc": 15_000, "launch_intent": 6000, "damping_mpc": 20_000}
"""Instructions that one step may take there: those that optimise or hold a network by name, the others 1000."""

MOST_PLANT_DIFFERENCES = 5
"""Words of thousands in which a plant with random parameters may differ in float32 by more than the self-test allows:
last places of the target's maths library, amplified where a clutch or a wheel changes its mode."""

DISTANCES = {"N*m": 0.01, "rad/s": 1e-3, "s": 1e-4, "1": 1e-4}
"""How far an output may be in float32 from float64, by its unit. Of supervisors nothing is claimed: what they decide, a
gear or a clutch, falls a step earlier in one precision where a speed meets its threshold."""

WIDER = {
    ("launch_mpc", "throttle"): 0.01,
    ("launch_mpc", "road_torque_estimate"): 0.1,
    ("damping_mpc", "road_torque_estimate"): 0.1,
}
"""The same by output: where the throttle of a small torque is steep; at the wheels instead of the clutch."""

EXPORTED = [name for name, block in {**CONTROLLERS, **SUPERVISORS, **ADVISERS}.items() if not block.desktop]


def cases(names: Iterable[str]) -> pytest.MarkDecorator:
    """Run a test for each of these parts in each precision."""
    each = [(name, precision) for name in names for precision in ("float64", "float32")]
    return pytest.mark.parametrize(("name", "precision"), each, ids=["-".join(case) for case in each])


each_case = cases(EXPORTED)
Exported = Callable[[str, str], Path]


@pytest.fixture(scope="session")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """The folder of a part in a precision, exported once."""
    folder = tmp_path_factory.mktemp("exports")

    def export(name: str, precision: str) -> Path:
        out = folder / f"{name}-{precision}"
        if not out.exists():
            export_c(Options(name, precision=precision), out)
        return out

    return export


def report(out: Path) -> dict[str, Any]:
    return json.loads((out / "report.json").read_text())


def unexplained(found: dict[str, Any]) -> list[dict[str, Any]]:
    return [missing for missing in found["coverage"]["missing"] if not missing["reason"]]


def make(out: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["make", "-s", "-C", str(out), *arguments], capture_output=True, text=True, check=False)


def copy(exported: Exported, tmp_path: Path, name: str = "launch_pid", precision: str = "float64") -> Path:
    return shutil.copytree(exported(name, precision), tmp_path / "copy")


@each_case
def test_folder_has_what_is_promised(exported: Exported, name: str, precision: str) -> None:
    out = exported(name, precision)
    assert names_in(out) == sorted([
        "CMakeLists.txt", "Makefile", "REPORT.md", "bitepoint_types.h", f"{name}.c", f"{name}.h",
        f"{name}_parameters.c", f"{name}_parameters.h", "report.json", "target", "test",
    ])  # fmt: skip
    header = (out / f"{name}.h").read_text()
    for function in ("init", "step", "version"):
        assert f" {name}_{function}(" in header or f" *{name}_{function}(" in header
    assert f"#define {name.upper()}_PERIOD (0.01" in header
    for path in out.rglob("*"):
        if path.is_file():
            text = path.read_text()
            assert str(Path.home()) not in text
            assert "@" not in text.replace("$@", "").replace("@real", "@@") or path.name == "Makefile", path


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=needs("clang", packages="clang"))])
@each_case
def test_all_of_it_compiles_without_a_warning(
    exported: Exported, name: str, precision: str, compiler: str, tmp_path: Path
) -> None:
    out = exported(name, precision)
    sources = [str(path) for path in sorted([*out.glob("*.c"), *out.glob("test/*.c")])]
    command = [compiler, *FLAGS, *STRICT, f"-I{out}", f"-I{out / 'test'}", "-fsyntax-only", *sources]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("name", [*CONTROLLERS, *SUPERVISORS, *ADVISERS, *PLANTS])
def test_no_line_is_too_long_and_no_word_of_a_comment_alone(name: str, precision: str, tmp_path: Path) -> None:
    subject = find_subject(Options(name, precision=precision))
    sources = Sources(subject.part, PRECISIONS[precision], subject.meaning, subject.origin)
    recorded = list(record(subject, 20))
    sequences = [*recorded, *itertools.islice(vectors.random(subject.part, recorded), 4)]
    lay_down(sources, sequences, vectors.answers(sources, sequences), tmp_path / "out")
    for path in (tmp_path / "out").rglob("*"):
        lines = path.read_text().splitlines() if path.is_file() else []
        assert [line for line in lines if len(line) > 120] == [], path.name
        for before, line in pairwise(lines):
            alone = re.fullmatch(r" *\* (\S+) \*/", line)
            room = alone is not None and not before.rstrip().endswith(("*", "/*")) and len(before) > 100
            assert not room, line


@each_case
def test_self_test_passes_plain_and_sanitised(exported: Exported, name: str, precision: str, tmp_path: Path) -> None:
    out = copy(exported, tmp_path, name, precision)
    for target in ("test", "sanitize"):
        done = make(out, target)
        assert done.returncode == 0, done.stderr
        assert "0 differences" in done.stdout


def test_self_test_fails_when_the_code_is_broken(exported: Exported, tmp_path: Path) -> None:
    out = copy(exported, tmp_path)
    source = out / "launch_pid.c"
    text = source.read_text()
    assert text.count("s->integral - (c->clutch_kp * error)") == 1
    source.write_text(
        text.replace("s->integral - (c->clutch_kp * error)", "s->integral - (c->clutch_kp * error * 1.0001)")
    )
    done = make(out, "test")
    assert done.returncode != 0
    assert "the first one in step" in done.stdout


def test_self_test_fails_when_a_parameter_is_changed(exported: Exported, tmp_path: Path) -> None:
    out = copy(exported, tmp_path)
    source = out / "launch_pid_parameters.c"
    text = source.read_text()
    assert text.count(".kp = 0.02,") == 1
    source.write_text(text.replace(".kp = 0.02,", ".kp = 0.0201,"))
    assert make(out, "test").returncode != 0


@needs("cmake", packages="cmake")
def test_cmake_builds_and_tests_it(exported: Exported, tmp_path: Path) -> None:
    out = copy(exported, tmp_path, precision="float32")
    for command in (
        ["cmake", "-S", str(out), "-B", "build", "-DCMAKE_BUILD_TYPE=Release"],
        ["cmake", "--build", "build"],
        ["ctest", "--test-dir", "build", "--output-on-failure"],
    ):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


@each_case
def test_vectors_reach_every_line_and_branch(exported: Exported, name: str, precision: str) -> None:
    found = report(exported(name, precision))
    if found["coverage"] is None:
        pytest.skip("no gcov")
    assert unexplained(found) == []
    assert found["coverage"]["lines"] > 20


@pytest.mark.parametrize("name", ["ddpc", "launch_mpc", "damping_mpc"])
def test_report_tells_the_cap_of_the_solver(exported: Exported, name: str) -> None:
    solver = report(exported(name, "float32"))["solver"]
    variables, rows = {
        "ddpc": (MOVES, 3 * MOVES),
        "launch_mpc": (launch_mpc_records.MOVES, launch_mpc_records.ROWS),
        "damping_mpc": (damping_mpc_records.MOVES, damping_mpc_records.ROWS),
    }[name]
    assert solver["cap"] == qp_solver(variables, rows).iterations == 10 * variables + rows
    assert 0 < solver["iterations_worst"] <= solver["cap"]


@cases(name for name in EXPORTED if name not in SUPERVISORS)
def test_float32_stays_close_to_float64(exported: Exported, name: str, precision: str) -> None:
    differences = report(exported(name, precision))["float32_against_float64"]
    assert {d["unit"] for d in differences.values()} & {"N*m", "1"}
    for output, difference in differences.items():
        assert difference["largest"] <= WIDER.get((name, output), DISTANCES[difference["unit"]]), output


@needs("cppcheck", packages="cppcheck")
@each_case
def test_misra_findings_are_explained(exported: Exported, name: str, precision: str) -> None:
    out = exported(name, precision)
    found = report(out)["misra"]
    assert found is not None
    text = (out / "REPORT.md").read_text()
    assert "compliant" not in text
    assert "not explained" not in text.partition("MISRA")[2]
    for rule, count in found.items():
        assert f"| {rule} | {count} |" in text


@needs_target
@each_case
def test_processor_in_the_loop_answers_to_the_bit_within_its_budget(
    exported: Exported, name: str, precision: str
) -> None:
    found = report(exported(name, precision))
    assert [run["differences"] for run in found["targets"]] == [0] * len(found["targets"])
    kinds = {(run["cpu"], run["precision"]) for run in found["targets"]}
    assert kinds >= {("cortex-m7", "float32"), ("cortex-m4", "float32"), ("cortex-m7", precision)}
    assert 0 < found["instructions_worst"] <= MOST_INSTRUCTIONS.get(name, 1000)
    assert 0 < found["code_bytes"] <= MOST_CODE.get(name, 8192)
    assert found["stack_bytes"] <= MOST_STACK
    for run in found["targets"]:
        if (run["cpu"], run["precision"]) == ("cortex-m7", "float32"):
            assert run["stack_measured"] <= max(found["stack_bytes"], run["stack_floor"])
            assert run["stack_floor"] <= 16
            assert run["steps_too_long"] == 0


@needs_target
def test_double_precision_in_software_gives_the_same_bits(exported: Exported, tmp_path: Path) -> None:
    done = make(copy(exported, tmp_path), "target", "CPU=cortex-m4")
    assert done.returncode == 0, done.stderr
    assert "\ndifferences=0\n" in done.stderr


@needs_target
def test_instructions_are_the_same_in_every_run(exported: Exported, tmp_path: Path) -> None:
    out = copy(exported, tmp_path, precision="float32")
    runs = [make(out, "target").stderr for _ in range(2)]
    assert runs[0] == runs[1]
    assert f"instructions_worst={report(out)['instructions_worst']}\n" in runs[0]


@needs_target
def test_processor_in_the_loop_sees_a_difference(exported: Exported, tmp_path: Path) -> None:
    out = copy(exported, tmp_path, precision="float32")
    source = out / "launch_pid.c"
    source.write_text(source.read_text().replace("s->time + dt", "s->time + (dt * 1.001F)"))
    done = make(out, "target")
    assert done.returncode != 0
    assert "differences=" in done.stderr
    assert "\ndifferences=0\n" not in done.stderr


@pytest.mark.parametrize("name", PLANTS)
def test_plants_export_too(exported: Exported, name: str, tmp_path: Path) -> None:
    found = report(exported(name, "float32"))
    assert make(copy(exported, tmp_path, name, "float32"), "test").returncode == 0
    assert max((run["differences"] for run in found["targets"]), default=0) <= MOST_PLANT_DIFFERENCES
    assert found["coverage"] is None or unexplained(found) == []


def test_command_line(bitepoint: Command, tmp_path: Path) -> None:
    out = tmp_path / "new" / "none"
    done = bitepoint("export", "c", "none", "--out", str(out), "--precision", "float32", "--json")
    assert done.status == 0
    assert json.loads(done.out) == report(out)
    assert json.loads(done.out)["precision"] == "float32"


def test_the_vehicle_tells_which_controller_of_a_name_is_meant() -> None:
    assert find_subject(Options("none")).part.name == "none"
    assert find_subject(Options("none", vehicle="p2-suv")).part.name == "undamped"


def test_a_process_leaves_nothing_but_the_folder(tmp_path: Path) -> None:
    (tmp_path / "scratch").mkdir()
    command = [sys.executable, "-m", "bitepoint", "export", "c", "none", "--out", str(tmp_path / "out" / "none")]
    environment = {**os.environ, "TMPDIR": str(tmp_path / "scratch")}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert names_in(tmp_path / "scratch") == []
    assert names_in(tmp_path / "out") == ["none"]


def test_settings_and_vehicle_change_the_parameters(bitepoint: Command, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = bitepoint(
        "export", "c", "none", "--vehicle", "dct-na190", "--set", "controller.clutch_torque=60 N*m", "--out", str(out)
    )
    assert done.status == 0
    text = (out / "none_parameters.c").read_text()
    assert ".clutch_torque = 60.0, /* N*m */" in text
    assert "vehicle dct-na190, controller.clutch_torque=60 N*m" in text


def test_bad_input_is_one_line_and_leaves_nothing(bitepoint: Command, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for arguments, parts in (
        (["nothing"], ["got nothing", "launch_pid"]),
        (["launch_pid", "--precision", "float16"], ["--precision", "float16", "float32"]),
        (["launch_pid", "--vehicle", "bus"], ["bus", "no such vehicle"]),
        (["launch_pid", "--set", "controller.gain=3"], ["controller.gain", "unknown key"]),
        (["launch_intent", "--set", "controller.clutch_kp=3"], ["controller.clutch_kp", "is none of launch_intent"]),
        (["launch_pid", "--set", "controller.clutch_kp=3 m"], ["controller.clutch_kp", "N m s/rad"]),
    ):
        bitepoint("export", "c", *arguments, "--out", str(out)).refusal(*parts)
        assert names_in(tmp_path) == []


def test_a_folder_that_is_not_empty_is_left_alone(bitepoint: Command, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("kept")
    bitepoint("export", "c", "none", "--out", str(tmp_path / "out")).refusal("not empty", "new or empty")
    assert (tmp_path / "out" / "mine").read_text() == "kept"
    (tmp_path / "file").write_text("kept")
    bitepoint("export", "c", "none", "--out", str(tmp_path / "file")).refusal("is a file")
    bitepoint("export", "c", "none", "--out", str(tmp_path / "file" / "under")).refusal("cannot be written")
    assert names_in(tmp_path) == ["file", "out"]


def test_a_missing_compiler_is_one_line(bitepoint: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    host.compiler.cache_clear()
    try:
        bitepoint("export", "c", "none", "--out", str(tmp_path / "out")).refusal("C compiler", "install one")
    finally:
        host.compiler.cache_clear()
    assert names_in(tmp_path) == []


def test_what_is_not_measured_is_null(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bare = tmp_path / "bin"
    bare.mkdir()
    for program in ("gcc", "as", "ld", "cc1"):
        path = shutil.which(program)
        if path is not None:
            (bare / program).symlink_to(path)
    monkeypatch.setenv("PATH", str(bare))
    host.compiler.cache_clear()
    try:
        export_c(Options("none"), tmp_path / "out")
    finally:
        host.compiler.cache_clear()
    found = report(tmp_path / "out")
    assert [found[key] for key in ("code_bytes", "stack_bytes", "instructions_worst", "misra", "coverage")] == [
        None
    ] * 5
    assert found["targets"] == []
    assert found["data_bytes"] > 0
    text = (tmp_path / "out" / "REPORT.md").read_text()
    assert "gcc-arm-none-eabi" in text


def test_too_large_for_an_ecu_is_refused(refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bitepoint.export.c.package.MOST_BYTES", 500)
    refused(lambda: export_c(Options("launch_pid"), tmp_path / "out"), "launch_pid", "bytes", "at most 500")
    assert not (tmp_path / "out").exists()


def test_the_environment_of_the_user_does_not_leak_in(
    bitepoint: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a blank").mkdir()
    for name, value in (("CC", "arm-none-eabi-gcc"), ("CFLAGS", "-O3 -ffast-math"), ("MAKEFLAGS", "-n")):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "a blank"))
    host.compiler.cache_clear()
    try:
        done = bitepoint("export", "c", "none", "--out", str(tmp_path / "my export"))
    finally:
        host.compiler.cache_clear()
    assert done.status == 0
    assert report(tmp_path / "my export")["coverage"]["lines"] > 20
    assert names_in(tmp_path) == ["a blank", "my export"]


def test_fast_math_is_refused_by_the_header(exported: Exported, tmp_path: Path) -> None:
    source = str(exported("none", "float32") / "none.c")
    done = subprocess.run(
        ["gcc", "-ffast-math", "-c", source], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode != 0
    assert "without -ffast-math" in done.stderr


@needs("g++", packages="g++")
def test_a_caller_in_cpp_links_two_exports(exported: Exported, tmp_path: Path) -> None:
    folders = [exported("launch_pid", "float32"), exported("none", "float32")]
    caller = tmp_path / "caller.cpp"
    caller.write_text(
        '#include "launch_pid_parameters.h"\n#include "none_parameters.h"\n#include <cstdio>\n'
        "launch_pid_state_t state; launch_pid_measurement_t seen; launch_pid_command_t shown;\n"
        "none_open_loop_state_t state_2; none_open_loop_measurement_t seen_2; none_open_loop_command_t shown_2;\n"
        "int main() { launch_pid_init(&launch_pid_parameters, &state, &seen, &shown);\n"
        "none_init(&none_open_loop_parameters, &state_2, &seen_2, &shown_2);\n"
        "std::puts(launch_pid_version()); std::puts(none_version());\n"
        "return launch_pid_step(&launch_pid_parameters, &state, &seen, &shown, LAUNCH_PID_PERIOD)\n"
        " + none_step(&none_open_loop_parameters, &state_2, &seen_2, &shown_2, NONE_PERIOD); }\n"
    )
    sources = [str(path) for folder in folders for path in folder.glob("*.c")]
    includes = [f"-I{folder}" for folder in folders]
    subprocess.run(["gcc", "-std=c99", "-O2", "-c", *sources], cwd=tmp_path, check=True)
    objects = [str(path) for path in tmp_path.glob("*.o")]
    subprocess.run(
        ["g++", "-Wall", "-Wextra", *includes, str(caller), *objects, "-o", "caller"], cwd=tmp_path, check=True
    )
    done = subprocess.run([str(tmp_path / "caller")], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert len(done.stdout.split()) == 2


@pytest.mark.parametrize(
    ("key", "part"), [("controller=none", "it is the part"), ("vehicle=dct-na190", "use --vehicle")]
)
def test_what_the_part_is_cannot_be_set(bitepoint: Command, tmp_path: Path, key: str, part: str) -> None:
    bitepoint("export", "c", "launch_pid", "--set", key, "--out", str(tmp_path / "out")).refusal(part)


def test_a_name_that_no_folder_can_have(bitepoint: Command, tmp_path: Path) -> None:
    bitepoint("export", "c", "none", "--out", str(tmp_path / ("a" * 300))).refusal("cannot be written")
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    assert bitepoint("export", "c", "none", "--out", str(tmp_path / "link")).status == 0
    assert "Makefile" in names_in(tmp_path / "real")
