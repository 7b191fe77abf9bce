"""The cache of compiled kernels: keyed by content, so that nothing stale is ever run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bitepoint.kernels import Kernel, kernel
from bitepoint.kernels.compiled import is_compiled, object_file, program, read_object
from bitepoint.records import Record, quantity

MODULE = """
from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Record, quantity

GAIN = {gain}

class Data(Record):
    x: float = quantity("1", 0, 1, "x"){extra}

@kernel
def callee(x: float) -> float:
    return {body}

@kernel
def caller(d: Data) -> float:
    return callee(d.x) * GAIN
"""


def build(tmp_path: Path, gain: float = 2.0, body: str = "x + 1.0", extra: str = "") -> Kernel[..., float]:
    path = tmp_path / "module.py"
    text = MODULE.format(gain=gain, body=body, extra=extra)
    path.write_text(text)
    namespace = {"__name__": "module"}
    import linecache

    linecache.checkcache(str(path))
    exec(compile(text, str(path), "exec"), namespace)
    return namespace["caller"]  # pyright: ignore


def key(built: Kernel[..., float]) -> Path:
    return object_file(built.name, program(built))


@pytest.mark.parametrize(
    "change",
    [{"gain": 3.0}, {"body": "x + 2.0"}, {"extra": '\n    y: float = quantity("1", 0, 1, "y")'}],
    ids=["constant", "callee", "layout"],
)
def test_key_follows_what_the_kernel_depends_on(tmp_path: Path, change: dict[str, object]) -> None:
    first = key(build(tmp_path))
    (tmp_path / "module.py").unlink()
    assert key(build(tmp_path, **change)) != first  # pyright: ignore
    (tmp_path / "module.py").unlink()
    assert key(build(tmp_path)) == first


def test_program_holds_callees_before_callers(tmp_path: Path) -> None:
    text = program(build(tmp_path))
    assert text.index("def callee") < text.index("def caller") < text.index("def entry")


def test_two_kernels_of_one_name_are_kept_apart() -> None:
    first = Kernel.generate("helper", "def helper(x: float) -> float:\n    return x\n", {})
    second = Kernel.generate("helper", "def helper(x: float) -> float:\n    return 2.0 * x\n", {})
    middle = Kernel.generate("middle", "def middle(x: float) -> float:\n    return helper(x)\n", {"helper": second})
    text = "def top(x: float) -> float:\n    return helper(x) + middle(x)\n"
    top = Kernel.generate("top", text, {"helper": first, "middle": middle})
    other = Kernel.generate("top", text, {"helper": second, "middle": middle})
    assert program(top) != program(other)
    for life in ("compiled", "interpreted"):
        assert top.run(1.0, life=life)[0] == 3.0
        assert other.run(1.0, life=life)[0] == 4.0


def test_a_specialised_kernel_is_the_same_source_with_other_meanings(tmp_path: Path) -> None:
    caller = build(tmp_path)
    other = caller.specialise("caller_5", {"GAIN": 5.0})
    data = caller.parameters[0].record
    assert data is not None
    for life in ("compiled", "interpreted"):
        assert caller.run(data.zeros(), life=life)[0] == 2.0
        assert other.run(data.zeros(), life=life)[0] == 5.0
    assert other.name == "caller_5"
    assert other.source.file == caller.source.file
    assert other.source.node.lineno == caller.source.node.lineno


SCRIPT = """
import sys, json
from bitepoint.assembly import all_kernels
from bitepoint.numerics.filters import butterworth_forward_backward as k
k.entry()
print(json.dumps("numba" in sys.modules))
"""


def test_cold_start_says_so_once_and_warm_start_needs_no_numba(tmp_path: Path) -> None:
    environment = {"BITEPOINT_CACHE": str(tmp_path), "PATH": "/usr/bin:/bin"}
    cold = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=environment, check=True)
    assert cold.stderr.count("compiling") == 1
    assert cold.stdout.strip() == "true"
    warm = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=environment, check=True)
    assert warm.stderr == ""
    assert warm.stdout.strip() == "false"
    assert len(list((tmp_path / "kernels").glob("*.o"))) == 1


def test_object_code_needs_only_the_maths_library() -> None:
    import llvmlite.binding as llvm

    from bitepoint.assembly import all_kernels
    from bitepoint.kernels.compiled import ENTRY_NAME

    allowed = {"exp", "log", "pow", "tan", "sqrt", "memset", "memcpy", "memmove", ENTRY_NAME}
    for compiled in all_kernels():
        compiled.entry("compiled")
        assert is_compiled(compiled)
        data = read_object(object_file(compiled.name, program(compiled)))
        assert data is not None
        assert llvm.ObjectFileRef.from_data(data) is not None
        for foreign in (b"PyErr", b"NRT_", b"numba_"):
            assert foreign not in data, f"{compiled.name} refers to {foreign!r}, none of {allowed}"


def test_a_damaged_object_is_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bitepoint.kernels.compiled.cache_folder", lambda: tmp_path)
    fresh = Kernel.generate("fresh", "def fresh(x: float) -> float:\n    return x + 1.0\n", {})
    assert fresh.run(1.0)[0] == 2.0
    path = object_file(fresh.name, program(fresh))
    path.write_bytes(path.read_bytes()[:-7])
    assert not is_compiled(fresh)
    again = Kernel.generate("fresh", "def fresh(x: float) -> float:\n    return x + 1.0\n", {})
    assert again.run(1.0)[0] == 2.0
    assert is_compiled(again)


class Empty(Record):
    """Something to read."""

    x: float = quantity("1", 0, 1, "x")


@kernel
def reads(e: Empty) -> float:
    """Read."""
    return e.x


def test_repr_names_module_and_kernel() -> None:
    assert repr(reads) == "<kernel tests.kernels.test_cache.reads>"


def test_a_generated_text_is_written_at_first_use_and_once() -> None:
    written: list[str] = []

    def text() -> str:
        written.append("now")
        return "def twice(x: float) -> float:\n    return 2.0 * x\n"

    twice = Kernel.generate("twice", text, {})
    assert written == []
    assert [twice.run(np.array([3.0, 4.0]), life="interpreted").tolist(), twice(1.0)] == [[6.0, 8.0], 2.0]
    assert twice.function is twice.function
    assert written == ["now"]


def test_importing_the_package_writes_no_kernel() -> None:
    asked = "import bitepoint, linecache; print([name for name in linecache.cache if 'generated' in name])"
    done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
