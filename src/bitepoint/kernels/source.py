"""What a kernel's source says: its syntax tree, and the kernels and constants that it uses by name."""

from __future__ import annotations

import ast
import hashlib
import io
import linecache
import textwrap
import tokenize
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

from bitepoint.errors import SubsetError


@dataclass(frozen=True)
class Source:
    """The definition of one function.

    Attributes:
        node: its syntax tree, with the line numbers of the file.
        text: its text, dedented, without decorators.
        namespace: the globals that its names are looked up in.
    """

    file: str
    node: ast.FunctionDef
    text: str
    namespace: dict[str, Any]

    def fail(self, node: ast.AST, problem: str, mend: str) -> SubsetError:
        """Return the error that names the file and the line of `node`."""
        return SubsetError(self.file, getattr(node, "lineno", self.node.lineno), problem, mend)

    @cached_property
    def free_names(self) -> list[str]:
        """Global names that the body reads, in order of appearance."""
        bound = {argument.arg for argument in self.node.args.args}
        bound |= {n.id for n in ast.walk(self.node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        names = [n.id for statement in self.node.body for n in ast.walk(statement) if isinstance(n, ast.Name)]
        return [name for name in dict.fromkeys(names) if name not in bound]

    @cached_property
    def comments(self) -> dict[int, str]:
        """Its comments without their signs, by line of the file."""
        tokens = tokenize.generate_tokens(io.StringIO(self.text).readline)
        first = self.node.lineno - 1
        return {t.start[0] + first: t.string.lstrip("# ") for t in tokens if t.type == tokenize.COMMENT}

    def above(self, line: int) -> list[str]:
        """Return the comments on lines of their own right above a line of the file, in order."""
        texts = self.text.splitlines()
        first = line
        while first - 1 in self.comments and texts[first - 1 - self.node.lineno].lstrip().startswith("#"):
            first -= 1
        return [self.comments[number] for number in range(first, line)]


def source_of(function: Callable[..., Any]) -> Source:
    """Return the source of `function`.

    Raises:
        SubsetError: the source is not to be had (typed at a prompt), or is no plain function.
    """
    code = function.__code__
    lines = linecache.getlines(code.co_filename, function.__globals__)
    node = _definitions(code.co_filename, "".join(lines)).get((function.__name__, code.co_firstlineno))
    if node is None:
        mend = "put it in a file as a plain function"
        raise SubsetError(code.co_filename, code.co_firstlineno, f"no source found for {function.__name__}", mend)
    text = textwrap.dedent("".join(lines[node.lineno - 1 : node.end_lineno]))
    return Source(code.co_filename, node, text, function.__globals__)


@cache
def _definitions(file: str, text: str) -> dict[tuple[str, int], ast.FunctionDef]:  # noqa: ARG001 - part of the key
    found: dict[tuple[str, int], ast.FunctionDef] = {}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            found[node.name, first] = node
    return found


def loaded(target: ast.expr) -> ast.expr:
    """Return the place that an assignment writes, as an expression that reads it."""
    parsed = ast.parse(ast.unparse(target), mode="eval").body
    for node in ast.walk(parsed):
        ast.copy_location(node, target)
    return parsed


def define(name: str, text: str, namespace: dict[str, Any]) -> Callable[..., Any]:
    """Return the function `name` that `text` defines, with its source known to debuggers and to `source_of`."""
    digest = hashlib.sha256(text.encode()).hexdigest()[:8]
    file = f"<bitepoint generated {name} {digest}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    scope = dict(namespace)
    exec(compile(text, file, "exec"), scope)
    function: Callable[..., Any] = scope[name]
    return function
