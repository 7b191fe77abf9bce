"""Random programs of the subset: what Python computes, the generated C computes, to the bit."""

from __future__ import annotations

import random
from collections.abc import Iterator

import numpy as np
import pytest

from bitepoint.errors import SubsetError
from bitepoint.kernels import Kernel, clamp, to_index
from bitepoint.kernels.subset import check
from tests.conftest import needs_c
from tests.kernels.c99.samples import Bag
from tests.kernels.test_lives import bits, same

pytestmark = needs_c
PROGRAMS = 60
LANES = 40


class Writer:
    """Writes one random kernel over a Bag, two floats and an integer."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.floats = ["a", "b"]
        self.integers = ["m"]

    def program(self) -> str:
        head = "def program(bag: Bag, a: float, b: float, n: int) -> float:\n    m = to_index(float(n), -9, 9)\n"
        body = "".join(f"    {line}\n" for _ in range(6) for line in self.statement(2))
        return f"{head}{body}    return {self.real(3)}\n"

    def statement(self, depth: int) -> Iterator[str]:
        kind = self.random.choice(["float", "integer", "field", "element", "hits", "if", "for"] if depth else ["float"])
        if kind == "float":
            name = f"x{len(self.floats)}"
            yield f"{name} = {self.real(3)}"
            self.floats.append(name)
        elif kind == "integer":
            name = f"k{len(self.integers)}"
            yield f"{name} = to_index({self.real(2)}, -9, 9)"
            self.integers.append(name)
        elif kind == "field":
            place, sign = self.random.choice(["x", "cell.weight"]), self.random.choice(["=", "+=", "-=", "*="])
            yield f"bag.{place} {sign} {self.real(2)}"
        elif kind == "element":
            yield f"bag.table[{self.random.randint(0, 3)}] = {self.real(2)}"
        elif kind == "hits":
            index = self.random.randint(0, 3)
            yield f"bag.cells[{index}].hits = min(bag.cells[{index}].hits + 1, 1000)"
        elif kind == "if":
            yield from self.branches(depth)
        else:
            yield from self.loop(depth)

    def block(self, depth: int) -> list[str]:
        floats, integers = list(self.floats), list(self.integers)
        lines = [f"    {line}" for _ in range(self.random.randint(1, 3)) for line in self.statement(depth - 1)]
        self.floats, self.integers = floats, integers  # what is first set in a block has no value after it
        return lines

    def branches(self, depth: int) -> Iterator[str]:
        yield f"if {self.condition(2)}:"
        yield from self.block(depth)
        if self.random.random() < 0.5:
            yield f"elif {self.condition(1)}:"
            yield from self.block(depth)
        if self.random.random() < 0.6:
            yield "else:"
            yield from self.block(depth)

    def loop(self, depth: int) -> Iterator[str]:
        name = f"i{self.random.randint(0, 10**6)}"
        end = self.random.choice(["bag.used", "3", "bag.cell.hits", "m"])
        ranges = [f"range({end})", f"range(1, {end})", f"range({end}, -2, -1)", "range(0, 7, 3)"]
        yield f"for {name} in {self.random.choice(ranges)}:"
        self.integers.append(name)
        lines = self.block(depth)
        self.integers.remove(name)
        yield from lines
        if self.random.random() < 0.4:
            yield f"    if {self.condition(1)}:"
            yield "        break"

    def integer(self) -> str:
        return self.random.choice([*self.integers, str(self.random.randint(-5, 5)), "bag.used"])

    def real(self, depth: int) -> str:
        if depth == 0 or self.random.random() < 0.2:
            leaves = [
                *self.floats,
                "bag.x",
                "bag.cell.weight",
                "bag.matrix[1, 2]",
                f"bag.table[{self.random.randint(0, 3)}]",
            ]
            return self.random.choice([*leaves, repr(self.random.choice([0.1, 2.0, -3.5, 1e-3, 0.0]))])
        left, right = self.real(depth - 1), self.real(depth - 1)
        forms = [f"({left} {sign} {right})" for sign in "+-*/"] + [f"{left} {sign} {right}" for sign in "+-*"]
        forms += [f"-({left})", f"({left}) ** 2", f"min({left}, {right})", f"max({left}, {right})", f"abs({left})"]
        forms += [f"({left} if {self.condition(1)} else {right})", f"clamp({left}, -1.0, {right})"]
        forms += [f"math.sqrt({left})", f"({left} * {self.integer()})", f"({self.integer()} - {left})"]
        return self.random.choice(forms)

    def condition(self, depth: int) -> str:
        if depth == 0:
            sign = self.random.choice(["<", "<=", ">", ">=", "==", "!="])
            if self.random.random() < 0.5:
                return f"{self.integer()} {sign} {self.integer()}"
            return f"{self.real(0)} {sign} {self.real(0)}"
        word = self.random.choice(["and", "or"])
        inner = f"({self.condition(depth - 1)} {word} {self.condition(depth - 1)})"
        return f"not {inner}" if self.random.random() < 0.3 else inner


def build(seed: int) -> Kernel[..., float]:
    import math

    names = {"Bag": Bag, "clamp": clamp, "to_index": to_index, "math": math}
    return Kernel.generate("program", Writer(seed).program(), names)


def bags(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    made = Bag.zeros(LANES)
    for name in ("x", "table", "matrix"):
        made[name] = rng.normal(size=made[name].shape)
    made["cell"]["weight"] = rng.choice([0.0, -0.0, 1.5, np.nan, np.inf, -2.0], LANES)
    made["used"], made["cell"]["hits"] = rng.integers(0, 5, LANES), rng.integers(0, 6, LANES)
    return made


@pytest.mark.parametrize("seed", range(PROGRAMS))
def test_random_program(seed: int) -> None:
    program = build(seed)
    try:
        check(program)
    except SubsetError as error:  # the writer knows less of intervals than the checker
        pytest.fail(f"the writer left the subset: {error}\n{program.source.text}")
    rng = np.random.default_rng(seed)
    a, b, n = rng.normal(0, 2, LANES), rng.normal(0, 2, LANES), rng.integers(-12, 12, LANES)
    a[::11], b[::13] = np.nan, np.inf
    left, right = bags(seed), bags(seed)
    assert bits(program.run(left, a, b, n, life="interpreted")) == bits(program.run(right, a, b, n, life="c"))
    assert same(left, right)
