"""Kernels in C: the same bits, readable, without warnings, and refused with file and line where that cannot be."""

from __future__ import annotations

import inspect
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bitepoint.assembly import CONTROLLERS, PLANTS
from bitepoint.errors import InputError, SubsetError
from bitepoint.kernels import Kernel, kernel
from bitepoint.kernels.c99 import FLOAT32, FLOAT64, PRECISIONS, Precision, translate
from bitepoint.kernels.c99.host import FLAGS, STRICT, host_entry, program
from bitepoint.kernels.kernel import closure
from bitepoint.numerics.filters import biquad
from bitepoint.records import Record, count, quantity
from tests.conftest import Refused, needs, needs_c
from tests.kernels.c99 import samples
from tests.kernels.test_lives import bits, same

each_precision = pytest.mark.parametrize("precision", PRECISIONS.values(), ids=PRECISIONS.keys())
PARTS = [*CONTROLLERS.values(), *PLANTS.values()]
KERNELS = [*samples.ALL, *samples.OTHERS, *(k for part in PARTS for k in (part.init, part.step))]


def in_c(kernel: Kernel[..., Any], precision: Precision = FLOAT64) -> str:
    return program(kernel, translate("sample", {f"public_{kernel.name}": kernel}, precision))


def compile_strictly(text: str, folder: Path, compiler: str) -> Path:
    source, built = folder / "source.c", folder / "source.o"
    source.write_text(text)
    command = [compiler, *FLAGS, *STRICT, "-c", "-o", str(built), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return built


@pytest.mark.parametrize(
    "compiler",
    [pytest.param("gcc", marks=needs_c), pytest.param("clang", marks=needs("clang", packages="clang"))],
)
@each_precision
@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: f"{k.__module__.rpartition('.')[2]}-{k.name}")
def test_compiles_without_a_warning(
    kernel: Kernel[..., Any], precision: Precision, compiler: str, tmp_path: Path
) -> None:
    compile_strictly(in_c(kernel, precision), tmp_path, compiler)


@needs_c
@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_has_no_variables_of_its_own_and_needs_only_the_maths_library(part: Any, tmp_path: Path) -> None:
    built = compile_strictly(in_c(part.step), tmp_path, "gcc")
    table = subprocess.run(["nm", str(built)], capture_output=True, text=True, check=True).stdout
    symbols = [line.split()[-2:] for line in table.splitlines()]
    assert not [name for kind, name in symbols if kind in "bBdDC"]
    made_by_gcc = {"_GLOBAL_OFFSET_TABLE_", "memset", "memcpy", "memmove"}  # of loops; freestanding C has these too
    assert {name for kind, name in symbols if kind == "U"} <= {"exp", "pow", "log", "sqrt", "sin", "atan", *made_by_gcc}
    assert "malloc" not in table


numbers = st.floats(-1e3, 1e3) | st.sampled_from([0.0, -0.0, np.inf, -np.inf, np.nan, 1.0])


@needs_c
@given(a=numbers, b=numbers, c=numbers, n=st.integers(-5, 5))
def test_samples_agree_with_the_other_lives(a: float, b: float, c: float, n: int) -> None:
    for name, arguments in (("grouping", (a, b, c)), ("logic", (a, b, n)), ("blocks", (a, n))):
        function = getattr(samples, name)
        compiled = bits(function.run(*arguments))
        assert (
            compiled == bits(function.run(*arguments, life="c")) == bits(function.run(*arguments, life="interpreted"))
        )


@needs_c
def test_records_agree_with_the_other_lives() -> None:
    rng = np.random.default_rng(3)
    bags = samples.Bag.zeros(300)
    for name in ("table", "matrix"):
        bags[name] = rng.uniform(-1, 1, bags[name].shape)
    bags["cells"]["weight"] = rng.uniform(-10, 10, bags["cells"]["weight"].shape)
    bags["x"], bags["used"] = rng.normal(1, 2, 300), rng.integers(0, 5, 300)
    bags["x"][::9] = np.nan
    again = bags.copy()
    x = rng.normal(size=300)
    assert bits(samples.step.run(bags, x)) == bits(samples.step.run(again, x, life="c"))
    assert same(bags, again)
    assert samples.moving_end.run(bags).tolist() == samples.moving_end.run(again, life="c").tolist()
    assert bags["used"].tolist() == again["used"].tolist()


@needs_c
def test_float32_computes_in_float32() -> None:
    x = np.array([0.1, 1 / 3, 2.5], np.float32)
    result = np.zeros(3, np.float32)
    arguments = np.array([a.ctypes.data for a in (x, x, x, result)], np.int64)
    from bitepoint.kernels.kernel import ENTRY

    ENTRY(host_entry(samples.grouping, FLOAT32))(arguments.ctypes.data, np.full(4, 4).ctypes.data, 3)
    exact = samples.grouping.run(*[x.astype(float)] * 3)
    assert result == pytest.approx(exact, rel=1e-5)
    assert (result.astype(float) != exact).any()


@needs_c
def test_names_and_aliases_mean_the_same_in_every_life() -> None:
    for name, arguments in (("upper_names", (2.0, 5.0)), ("whole_squares", (4,))):
        function = getattr(samples, name)
        assert len({float(function.run(*arguments, life=life)[0]) for life in ("compiled", "interpreted", "c")}) == 1
    for life in ("compiled", "interpreted", "c"):
        bag = samples.Bag.zeros()
        bag["used"] = 3
        assert samples.two_names.run(bag, bag, life=life)[0] == 3.0


@needs_c
def test_only_the_epsilon_of_the_kernels_follows_the_precision() -> None:
    text = "def own(x: float) -> float:\n    return 1.0 if x < EPSILON else 0.0\n"
    own = Kernel.generate("own", text, {"EPSILON": 1e-3})
    assert [own.run(1e-5, life=life)[0] for life in ("compiled", "interpreted", "c")] == [1.0] * 3


def test_carries_names_units_docstrings_and_comments() -> None:
    translation = translate("sample", {"public_step": samples.step}, FLOAT64)
    text = translation.types + translation.source
    assert "/* A local called like a function of its own, and like one of the library. */" in text
    assert "float64_t x; /* m/s^2, -1e+09 .. 1e+09: a number */" in text
    assert "int64_t used; /* 0 .. 4: cells in use */" in text
    assert "/* why: a comment beside a line */" in text
    assert "/* why: a comment of its own */" in text
    assert "a weight / * of a kind * /" in text
    assert text.isascii()
    assert "sample_cell_t cells[4];" in text
    assert "float64_t matrix[2][3];" in text


def test_epsilon_and_literals_follow_the_precision() -> None:
    double, single = in_c(samples.step, FLOAT64), in_c(samples.step, FLOAT32)
    assert "> DBL_EPSILON" in double
    assert "> FLT_EPSILON" in single
    assert "0.25F" in single
    assert "fabsf(" in single


def test_parameters_that_are_only_read_are_constant() -> None:
    prototypes = translate("sample", {"first": samples.step, "second": samples.add}, FLOAT64).prototypes
    assert "float64_t first(sample_bag_t *b, float64_t clamp_);" in prototypes
    assert "float64_t second(const sample_cell_t *c, float64_t real_min_);" in prototypes


@needs_c
def test_two_kernels_of_one_name_are_kept_apart() -> None:
    first = Kernel.generate("helper", "def helper(x: float) -> float:\n    return x * BY\n", {"BY": 3.0})
    second = Kernel.generate("helper", "def helper(x: float) -> float:\n    return x * BY\n", {"BY": 5.0})
    middle = Kernel.generate("middle", "def middle(x: float) -> float:\n    return helper(x)\n", {"helper": second})
    text = "def top(x: float) -> float:\n    return helper(x) + middle(x)\n"
    top = Kernel.generate("top", text, {"helper": first, "middle": middle})
    assert top.run(1.0, life="c")[0] == 8.0


@pytest.mark.parametrize("refused", [samples.large_constant, samples.small_constant], ids=lambda k: k.name)
def test_a_number_that_float32_has_not_is_refused_with_file_and_line(refused: Kernel[..., Any]) -> None:
    lines, first = inspect.getsourcelines(refused.function)
    marked = first + next(number for number, line in enumerate(lines) if "# here" in line)
    translate("sample", {"public": refused}, FLOAT64)
    with pytest.raises(SubsetError, match="out of range in float32") as caught:
        translate("sample", {"public": refused}, FLOAT32)
    assert str(caught.value).startswith(f"{samples.__file__}:{marked}: ")
    assert "; " in str(caught.value)


def test_bare_arrays_are_refused_with_file_and_line() -> None:
    with pytest.raises(SubsetError, match=r"filters\.py:\d+: biquad takes a bare array.*; put the array into a record"):
        translate("sample", {"public": biquad}, FLOAT64)


class Keyword(Record):
    """A field that C keeps for itself."""

    volatile: float = quantity("1", 0, 1, "a number")


class Wide(Record):
    """An integer that C's 32 bits cannot hold."""

    address: int = count(0, 1 << 40, "an address")


@kernel
def reads_keyword(k: Keyword) -> float:
    """Read."""
    return k.volatile


@kernel
def reads_wide(w: Wide) -> float:
    """Read."""
    return 1.0 if w.address > 0 else 0.0


def test_records_that_have_no_place_in_c_are_refused(refused: Refused) -> None:
    refused(lambda: translate("a", {"f": reads_keyword}, FLOAT64), "Keyword.volatile", "another name")
    refused(lambda: translate("a", {"f": reads_wide}, FLOAT64), "Wide.address", "32 bits")
    with pytest.raises(InputError, match="prefix"):
        translate("a b", {"f": samples.grouping}, FLOAT64)


@each_precision
def test_layout_has_no_padding_and_converts_every_number(precision: Precision) -> None:
    bags = samples.Bag.zeros(3)
    bags["x"], bags["used"] = [1.5, -2.5, 1e300], [0, 3, 4]
    bags["cells"]["hits"], bags["cell"]["weight"] = 7, 0.25
    assert precision.layout(samples.Bag).itemsize == samples.Bag.dtype.itemsize // 8 * precision.size
    converted = precision.convert(bags, samples.Bag)
    assert converted["used"].tolist() == [0, 3, 4]
    assert converted["cells"]["hits"].tolist() == [[7] * 4] * 3
    assert converted["x"].tolist() == [1.5, -2.5, 1e300 if precision is FLOAT64 else np.inf]
    assert converted["cell"]["weight"].tolist() == [0.25] * 3


def test_every_function_of_a_call_tree_is_there_once() -> None:
    step = PLANTS["dct"].step
    translation = translate("dct", {"dct_step": step}, FLOAT64)
    names = [translation.functions[member] for member in dict.fromkeys(closure(step))]
    assert len(names) == len(set(names))
    definitions = re.findall(r"^(?:static )?\w+ (\w+)\([^;]*?\)\n\{", translation.source, re.MULTILINE)
    assert sorted(set(definitions) - {"real_min", "real_max", "int_min", "int_max"}) == sorted(names)
    assert set(translation.calls) == set(names)
    assert translation.maths == {"exp", "fabs", "log", "pow"}
    assert not translation.exact
    assert translate("pid", {"pid_step": CONTROLLERS["launch_pid"].step}, FLOAT64).exact
