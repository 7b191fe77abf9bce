"""Kernels whose innermost loops are written out."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator, Mapping
from typing import Any

from bitepoint.kernels import Kernel
from bitepoint.kernels.source import Source


def unrolled(
    kernel: Kernel[..., Any], name: str, meanings: Mapping[str, Any], lengths: Mapping[str, int]
) -> Kernel[..., Any]:
    """Return `kernel` with other meanings, its innermost loops over some bounds written out to a fixed length.

    A short loop costs a small processor three times what it does inside, and compilers for these write it out only at
    settings that nobody uses. Loops in whose body there is a loop, or a break, stay.

    Args:
        kernel: the kernel, with loops `for j in range(BOUND)` or `range(1, BOUND)`.
        name: of the new one. Its text is generated: `Kernel.specialise` keeps the lines of the file.
        meanings: what global names stand for, as in `Kernel.specialise`.
        lengths: by the bound, a constant, or a number that says how much of an array is in use (what lies behind must
            not count): the constant, or the most that the number can be.
    """

    def written_out() -> str:
        node = copy.deepcopy(kernel.source.node)
        node.name = name
        node.decorator_list = []
        for bound, length in lengths.items():
            node = ast.fix_missing_locations(_Unroller(bound, length).visit(node))
        return _commented(ast.unparse(node), node, kernel.source) + "\n"

    return Kernel.generate(name, written_out, {**kernel.function.__globals__, **meanings})


def _commented(text: str, node: ast.FunctionDef, source: Source) -> str:
    """Return the text of `node` with the comments that stand above its statements in the source."""
    lines = text.splitlines()
    written = _statements(ast.parse(text).body[0])
    for old, new in reversed(list(zip(_statements(node), written, strict=True))):
        line = lines[new.lineno - 1]
        indent = line[: len(line) - len(line.lstrip())]
        lines[new.lineno - 1 : new.lineno - 1] = [f"{indent}# {remark}" for remark in source.above(old.lineno)]
    return "\n".join(lines)


def _statements(node: ast.stmt) -> Iterator[ast.stmt]:
    """Yield all statements inside one, in the order in which they are written."""
    for part in ast.iter_child_nodes(node):
        if isinstance(part, ast.stmt):
            yield part
            yield from _statements(part)


class _Unroller(ast.NodeTransformer):
    """Exchanges loops over one bound for copies of their body."""

    def __init__(self, bound: str, length: int) -> None:
        self.starts = {f"range({bound})": 0, f"range(1, {bound})": 1}
        self.length = length

    def visit_For(self, node: ast.For) -> Any:
        """Return the copies of the body, or the loop as it is."""
        inner = any(isinstance(part, ast.For | ast.Break) for line in node.body for part in ast.walk(line))
        start = self.starts.get(ast.unparse(node.iter))
        if inner or start is None or not isinstance(node.target, ast.Name):
            return self.generic_visit(node)
        turns = [_Exchange(node.target.id, turn) for turn in range(start, self.length)]
        return [turn.visit(copy.deepcopy(line)) for turn in turns for line in node.body]


class _Exchange(ast.NodeTransformer):
    """Exchanges a name for a number, and a sum of two numbers, as in a place of an array, for theirs."""

    def __init__(self, name: str, number: int) -> None:
        self.name = name
        self.number = number

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """Return the number in place of the name."""
        return ast.Constant(self.number) if node.id == self.name else node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Return the sum in place of two numbers."""
        self.generic_visit(node)
        match node:
            case ast.BinOp(ast.Constant(int(left)), ast.Add(), ast.Constant(int(right))):
                return ast.Constant(left + right)
            case _:
                return node
