"""Constant expressions that mean something in float64 and lose it in float32, such as 1.0 - 1e-12."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bitepoint.kernels.maths import EPSILON

_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_TYPES = (np.float64, np.float32)


@dataclass(frozen=True)
class Absorbed:
    """A constant expression of a kernel that in float32 is one of its own operands.

    Attributes:
        file: of the kernel, from the package on; line: in it.
        expression: as it is written.
    """

    file: str
    line: int
    expression: str


def is_absorbed(node: ast.BinOp, constant: Callable[[str], float | None]) -> bool:
    """Return whether a constant expression is one of its own operands in float32, and is none in float64.

    Args:
        constant: the number that a name stands for, or None where it is none.
    """
    verdicts = [_keeps(node, constant, real) for real in _TYPES]
    return verdicts == [False, True]


def _keeps(node: ast.BinOp, constant: Callable[[str], float | None], real: type[Any]) -> bool | None:
    """Whether the value is one of the operands; None where it is no constant."""
    operands = [_value(part, constant, real) for part in (node.left, node.right)]
    value = _value(node, constant, real)
    return None if value is None else any(value == operand for operand in operands)


def _value(node: ast.expr, constant: Callable[[str], float | None], real: type[Any]) -> Any:
    """Return a constant expression in a type of numbers, or None where it is no constant."""
    with np.errstate(all="ignore"):
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return real(node.value)
        if isinstance(node, ast.Name):
            number = constant(node.id)
            precise = node.id == "EPSILON" and number == EPSILON
            return np.finfo(real).eps if precise else None if number is None else real(number)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            inside = _value(node.operand, constant, real)
            return None if inside is None else -inside
        apply = _OPERATORS.get(type(node.op)) if isinstance(node, ast.BinOp) else None
        if apply is None or not isinstance(node, ast.BinOp):
            return None
        left, right = _value(node.left, constant, real), _value(node.right, constant, real)
        return None if left is None or right is None else apply(left, right)
