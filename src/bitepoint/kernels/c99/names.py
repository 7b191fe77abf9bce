"""Identifiers: what things of Python are called in C."""

from __future__ import annotations

import re
from collections.abc import Hashable
from typing import Any

from bitepoint.kernels.kernel import Kernel
from bitepoint.records import Record

_KEYWORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false
asm typeof NAN INFINITY HUGE_VAL NULL EOF I
"""
_LIBRARY = """
abs acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim floor fma fmax
fmin fmod frexp gamma hypot ilogb index j0 j1 jn ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf
nan nearbyint nextafter pow remainder remquo rint round scalbn signbit sin sinh sqrt tan tanh tgamma trunc y0 y1 yn main
div exit free malloc time clock signal raise rand float32_t float64_t int8_t int16_t int32_t int64_t uint8_t uint16_t
uint32_t uint64_t intptr_t uintptr_t intmax_t uintmax_t size_t ptrdiff_t wchar_t
"""

KEYWORDS = frozenset(_KEYWORDS.split())
"""Words that nothing can be called: keywords and macros."""

TAKEN = KEYWORDS | frozenset(_LIBRARY.split())
"""Identifiers that no function or variable can have."""


_MACROS = re.compile(r"U?INT\w*_(MAX|MIN|C)|(PTRDIFF|SIZE|SIG_ATOMIC|WCHAR|WINT)_\w+|(FLT|DBL|LDBL|M|FP|HUGE|MATH)_\w+")
"""Macros of <float.h>, <math.h> and <stdint.h>."""


def snake(name: str) -> str:
    """Return `LaunchPidState` as `launch_pid_state`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


class Names:
    """Gives every thing at file scope an identifier of its own: its plain name, or one with its module before it."""

    def __init__(self, prefix: str) -> None:
        self.prefix = prefix
        self._given: dict[Hashable, str] = {}
        self.taken: set[str] = set(TAKEN)
        self.fields: set[str] = set()

    def give(self, thing: Hashable, *candidates: str) -> str:
        """Return the name of `thing`: the one that it has, or the first candidate that is free."""
        if thing not in self._given:
            numbered = (f"{candidates[-1]}_{number}" for number in range(2, 1000))
            name = next(c for c in (*candidates, *numbered) if c not in self.taken)
            self._given[thing] = name
            self.taken.add(name)
        return self._given[thing]

    def function(self, kernel: Kernel[..., Any]) -> str:
        """Return the name of a kernel."""
        return self.give(kernel, kernel.name, f"{_module(kernel)}_{kernel.name}")

    def type(self, record: type[Record]) -> str:
        """Return the name of the struct of a record; all carry the prefix, since headers meet in one program."""
        name = snake(record.__name__)
        prefixed = name if name.startswith(f"{self.prefix}_") else f"{self.prefix}_{name}"
        return self.give(record, f"{prefixed}_t", f"{prefixed}_{record.__module__.rpartition('.')[2]}_t")

    def constant(self, kernel: Kernel[..., Any], name: str, value: float) -> str:
        """Return what the constant `name` of a kernel is called: it is a macro, so nothing else can be called that."""
        module = _module(kernel).upper()
        candidates = [name, f"{module}_{name}", f"{self.prefix.upper()}_{module}_{name}"]
        free = [c for c in candidates if c not in self.fields and not _MACROS.fullmatch(c)]
        return self.give((name, repr(value)), *(free or [f"{name}_OF_{module}"]))


def _module(kernel: Kernel[..., Any]) -> str:
    return (kernel.__module__ or "generated").rpartition(".")[2]
