"""A set of kernels with their records as one C99 header and one source.

The source needs <float.h>, <math.h>, <stdbool.h> and <stdint.h>: no heap, no recursion, no variable of its own. It is
to be compiled without fused multiply-add (-ffp-contract=off); then it computes what the other lives do, bit by bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bitepoint.errors import InputError
from bitepoint.kernels.c99.absorbed import Absorbed
from bitepoint.kernels.c99.expressions import HELPERS, Uses
from bitepoint.kernels.c99.functions import Function
from bitepoint.kernels.c99.names import Names
from bitepoint.kernels.c99.precision import Precision
from bitepoint.kernels.c99.structs import struct, with_nested
from bitepoint.kernels.c99.text import indented
from bitepoint.kernels.kernel import Kernel, closure
from bitepoint.records import Record

EXACT = frozenset({"sqrt", "fabs", "copysign"})
"""Functions of the maths library whose result every library rounds alike."""

TYPES = """\
/* Types of numbers in exported code. */
#ifndef BITEPOINT_TYPES_H
#define BITEPOINT_TYPES_H

#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it takes NaN and infinity for impossible, and exported code guards against them"
#endif

#ifndef BITEPOINT_FLOATS_ARE_DEFINED /* define this where another header, such as CMSIS-DSP's, has these two types */
typedef float float32_t;
typedef double float64_t;
#endif

#endif
"""
"""Content of bitepoint_types.h, the one header that all exports share."""


@dataclass(frozen=True)
class Translation:
    """Kernels in C.

    Attributes:
        types: the structs; prototypes: the public functions with their comments; source: all functions.
        type_names: what the struct of each record is called.
        functions: what each kernel is called; public ones by the name they were asked for.
        calls: which functions each function calls, by name.
        maths: functions of the maths library in use, as `math` names them.
        absorbed: constant expressions that are one of their own operands in float32, in either precision.
    """

    prefix: str
    precision: Precision
    types: str
    prototypes: str
    source: str
    type_names: Mapping[type[Record], str]
    functions: Mapping[Kernel[..., Any], str]
    calls: Mapping[str, Sequence[str]]
    maths: frozenset[str]
    absorbed: Sequence[Absorbed]

    @property
    def exact(self) -> bool:
        """Whether its results do not depend on whose maths library it meets."""
        return self.maths <= EXACT


def translate(
    prefix: str,
    public: Mapping[str, Kernel[..., Any]],
    precision: Precision,
    records: Iterable[type[Record]] = (),
) -> Translation:
    """Return `public` kernels, under the names given, with all that they call, in C.

    Args:
        prefix: what the names of types begin with.
        records: more records that are to have a struct.

    Raises:
        SubsetError: a kernel that cannot be translated, with file, line and the mend.
        InputError: a record that has no place in C.
    """
    if not prefix.isidentifier() or not prefix.isascii():
        raise InputError("prefix", f"got {prefix!r}", "expected letters, digits and underscores")
    names = Names(prefix)
    members = list(dict.fromkeys(member for kernel in public.values() for member in closure(kernel)))
    used = [p.record for kernel in members for p in kernel.parameters if p.record is not None]
    structs = with_nested([*records, *used])
    names.fields = {name for record in structs for name in record.fields}
    for member in members:  # before any local gets a name
        for name, value in member.constants.items():
            names.constant(member, name, value)
    type_names = {record: names.type(record) for record in structs}
    functions = {kernel: names.give(kernel, name) for name, kernel in public.items()}
    functions |= {kernel: names.function(kernel) for kernel in members}
    for helper in HELPERS:
        names.give(("helper", helper), helper, f"{helper}_of_two")
    uses = Uses(set(), set(), {}, {})
    outside = {kernel: name for name, kernel in public.items()}
    texts = [Function(kernel, names, precision, uses, outside.get(kernel)) for kernel in members]
    bodies = ["\n".join(text.text()) for text in texts]
    return Translation(
        prefix,
        precision,
        "\n\n".join("\n".join(struct(record, names, precision)) for record in structs) + "\n",
        "\n\n".join("\n".join([*text.about(), f"{text.signature()};"]) for text in texts if text.public) + "\n",
        "\n".join([*_constants(uses), *_helpers(uses, names, precision), *_separated(bodies)]),
        type_names,
        functions,
        {functions[k]: [functions[callee] for callee in k.callees.values()] for k in members},
        frozenset(uses.maths),
        list(uses.absorbed),
    )


def _constants(uses: Uses) -> Iterator[str]:
    yield from (f"#define {name} {text}" for name, text in uses.constants.items())
    if uses.constants:
        yield ""


def _helpers(uses: Uses, names: Names, precision: Precision) -> Iterator[str]:
    for helper in sorted(uses.helpers):
        signature, result, meaning = HELPERS[helper].split("|")
        name = names.give(("helper", helper), helper)
        yield f"/* {meaning} */"
        yield "static " + signature.format(name=name, real=precision.real, integer=precision.integer)
        yield "{"
        yield from indented([f"return {result};"])
        yield from ("}", "")


def _separated(bodies: Sequence[str]) -> Iterator[str]:
    for number, body in enumerate(bodies):
        if number:
            yield ""
        yield body
    yield ""
