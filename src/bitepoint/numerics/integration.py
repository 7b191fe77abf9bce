"""Integration of records: kernels that are generated field by field for one record type.

A generated kernel is ordinary kernel source: it is checked, interpreted, compiled and exported like any other.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_type_hints

from bitepoint.kernels import Kernel
from bitepoint.records import Record


def float_fields(record: type[Record]) -> list[str]:
    """Return the names of the float scalars of `record`: what is integrated."""
    return [name for name, field in record.fields.items() if field.kind == "float" and not field.shape]


def copier(name: str, record: type[Record]) -> Kernel[..., None]:
    """Return the kernel `name(target, source)` that copies every float scalar."""

    def text() -> str:
        lines = [f"    target.{field} = source.{field}" for field in float_fields(record)]
        return "\n".join([f"def {name}(target: Record, source: Record) -> None:", *lines, ""])

    return Kernel.generate(name, text, {"Record": record})


def clearer(name: str, record: type[Record]) -> Kernel[..., None]:
    """Return the kernel `name(target)` that sets every float scalar to 0."""

    def text() -> str:
        lines = [f"    target.{field} = 0.0" for field in float_fields(record)]
        return "\n".join([f"def {name}(target: Record) -> None:", *lines, ""])

    return Kernel.generate(name, text, {"Record": record})


def runge_kutta_4(name: str, rates: Kernel[..., None], state: type[Record], work: type[Record]) -> Kernel[..., None]:
    """Return the kernel `name(p, mode, x, w, h)` that advances `x` by `h` with the classical Runge-Kutta rule.

    Args:
        name: of the kernel.
        rates: kernel `rates(p, mode, x, d)` that writes dx/dt into `d`, a record of x's own type.
        state: the type of x; all its float scalars are integrated.
        work: a type with fields `stage`, `slope` and `sum` of type `state`; their content is scratch.

    Order 4 in h for smooth rates. Whatever is discontinuous must be held constant in `mode` over the step.
    Reference: W. Kutta, Z. Math. Phys. 46 (1901) 435.
    """
    parameters, mode = list(get_type_hints(rates.function).values())[:2]  # rates.parameters would parse its source
    types = {"Parameters": parameters, "Mode": mode, "State": state, "Work": work}

    def text() -> str:
        header = f"def {name}(p: Parameters, mode: Mode, x: State, w: Work, h: float) -> None:"
        return "\n".join([header, *_runge_kutta_lines(rates.name, float_fields(state)), ""])

    return Kernel.generate(name, text, {rates.name: rates, **types})


def _runge_kutta_lines(rates: str, fields: list[str]) -> Iterator[str]:
    half = "    half = 0.5 * h"
    yield from (half, "    sixth = h / 6.0", "    third = h / 3.0")
    yield f"    {rates}(p, mode, x, w.slope)"
    for share, step in (("sixth", "half"), ("third", "half"), ("third", "h")):
        for field in fields:
            base = "x" if share == "sixth" else "w.sum"
            yield f"    w.sum.{field} = {base}.{field} + {share} * w.slope.{field}"
            yield f"    w.stage.{field} = x.{field} + {step} * w.slope.{field}"
        yield f"    {rates}(p, mode, w.stage, w.slope)"
    yield from (f"    x.{field} = w.sum.{field} + sixth * w.slope.{field}" for field in fields)
