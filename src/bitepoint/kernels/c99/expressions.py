"""Expressions of a kernel as C, with the types that C needs said aloud."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bitepoint.kernels.c99.absorbed import Absorbed, is_absorbed
from bitepoint.kernels.c99.names import Names
from bitepoint.kernels.c99.precision import Precision
from bitepoint.kernels.c99.text import real_literal
from bitepoint.kernels.interpreted import MATHS
from bitepoint.kernels.kernel import Kernel
from bitepoint.kernels.maths import EPSILON
from bitepoint.kernels.values import Value, element_of, of_field

PRIMARY, UNARY, PRODUCT, SUM, RELATION, LOGIC, CHOICE = 7, 6, 5, 4, 3, 2, 1
"""How tightly an expression binds; everything that is not plain is put into parentheses inside something else."""

_OPERATORS = {"Add": ("+", SUM), "Sub": ("-", SUM), "Mult": ("*", PRODUCT), "Div": ("/", PRODUCT)}
_COMPARISONS = {"Lt": "<", "LtE": "<=", "Gt": ">", "GtE": ">=", "Eq": "==", "NotEq": "!="}

HELPERS = {
    "real_min": "{real} {name}({real} a, {real} b)|(b < a) ? b : a|The smaller of two; a where they do not compare.",
    "real_max": "{real} {name}({real} a, {real} b)|(b > a) ? b : a|The larger of two; a where they do not compare.",
    "int_min": "{integer} {name}({integer} a, {integer} b)|(b < a) ? b : a|The smaller of two.",
    "int_max": "{integer} {name}({integer} a, {integer} b)|(b > a) ? b : a|The larger of two.",
    "int_abs": "{integer} {name}({integer} a)|(a < 0) ? -a : a|The magnitude.",
    "int_square": "{integer} {name}({integer} a)|a * a|The square.",
    "real_square": "{real} {name}({real} a)|a * a|The square.",
}
"""Small functions that a source gets where it needs them: signature, result, meaning."""


@dataclass(frozen=True)
class Term:
    """An expression in C: its text, what it is, how tightly it binds, and whether it is a pointer to a record."""

    text: str
    value: Value
    level: int = PRIMARY
    pointer: bool = False

    @property
    def kind(self) -> str:
        """Its type: "float", "int", "bool", "record", "array" or "records"."""
        return self.value.kind

    def inside(self) -> str:
        """Return the text as a part of something larger."""
        return self.text if self.level == PRIMARY else f"({self.text})"


@dataclass
class Uses:
    """What the functions of one source have asked for so far."""

    helpers: set[str]
    maths: set[str]
    constants: dict[str, str]
    absorbed: dict[Absorbed, None]


class Terms:
    """Translates the expressions of one kernel."""

    def __init__(
        self,
        kernel: Kernel[..., Any],
        names: Names,
        precision: Precision,
        uses: Uses,
        look_up: Callable[[str], Term | None],
    ) -> None:
        self.kernel = kernel
        self.source = kernel.source
        self.names = names
        self.precision = precision
        self.uses = uses
        self.look_up = look_up

    def term(self, node: ast.expr) -> Term:
        """Return `node` in C.

        Raises:
            SubsetError: it has no meaning in C.
        """
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            mend = "write it within the subset, see kernels/subset.py"
            raise self.source.fail(node, f"{type(node).__name__} cannot be translated to C", mend)
        return method(node)

    def real(self, node: ast.expr, term: Term | None = None) -> str:
        """Return `node` (and its `term`, where it is known) as a float operand, converted where it is an integer."""
        if isinstance(node, ast.Constant) and isinstance(node.value, int):
            return self._literal(node, float(node.value))
        term = term or self.term(node)
        return term.inside() if term.kind == "float" else f"({self.precision.real}){term.inside()}"

    def argument(self, node: ast.expr) -> str:
        """Return `node` as an argument: records by their address."""
        term = self.term(node)
        return f"&{term.text}" if term.kind == "record" and not term.pointer else term.text

    def _literal(self, node: ast.AST, value: float) -> str:
        try:
            return real_literal(value, self.precision)
        except OverflowError:
            mend = "use a number that it holds, or export in float64"
            raise self.source.fail(node, f"{value!r} is out of range in {self.precision.name}", mend) from None

    def _constant(self, node: ast.Constant) -> Term:
        if isinstance(node.value, bool):
            return Term("true" if node.value else "false", Value("bool"))
        if isinstance(node.value, float):
            return Term(self._literal(node, node.value), Value("float"))
        return Term(str(node.value), Value("int"))

    def _name(self, node: ast.Name) -> Term:
        local = self.look_up(node.id)
        if local is not None:
            return local
        value = self.source.namespace.get(node.id)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.source.fail(node, f"the name {node.id} means nothing in C", "use parameters, locals, constants")
        if node.id == "EPSILON" and value == EPSILON:
            return Term(self.precision.epsilon, Value("float"))
        name = self.names.constant(self.kernel, node.id, value)
        text = self._literal(node, value) if isinstance(value, float) else str(value)
        self.uses.constants[name] = f"({text})"
        return Term(name, Value("float" if isinstance(value, float) else "int"))

    def _attribute(self, node: ast.Attribute) -> Term:
        base = self.term(node.value)
        if base.value.record is None:
            raise self.source.fail(node, f"attribute {node.attr} of no record", "only records have fields")
        arrow = "->" if base.pointer else "."
        return Term(f"{base.text}{arrow}{node.attr}", of_field(base.value.record.fields[node.attr]))

    def _subscript(self, node: ast.Subscript) -> Term:
        array = self.term(node.value)
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        text = "".join(f"[{self.term(index).text}]" for index in indices)
        return Term(array.text + text, element_of(array.value))

    def _number(self, name: str) -> float | None:
        """Return the number that a global name stands for, or None."""
        value = self.source.namespace.get(name) if self.look_up(name) is None else None
        return value if isinstance(value, int | float) and not isinstance(value, bool) else None

    def _binop(self, node: ast.BinOp) -> Term:
        if is_absorbed(node, self._number):
            file = f"{self.kernel.__module__.replace('.', '/')}.py"
            self.uses.absorbed[Absorbed(file, node.lineno, ast.unparse(node))] = None
        return self.binary(node.op, node.left, node.right)

    def binary(self, operator: ast.operator, left: ast.expr, right: ast.expr) -> Term:
        """Return left operator right."""
        name = type(operator).__name__
        if name == "Pow":
            return self._square(left)
        first, second = self.term(left), self.term(right)
        whole = name != "Div" and first.kind == second.kind == "int"
        sign, level = _OPERATORS[name]
        kind = "int" if whole else "float"
        if isinstance(left, ast.BinOp) and (first.level, first.kind) == (level, kind):
            before = first.text  # a chain of one kind, from left to right as Python has it
        else:
            before = first.inside() if whole else self.real(left, first)
        after = second.inside() if whole else self.real(right, second)
        return Term(f"{before} {sign} {after}", Value(kind), level)

    def _square(self, node: ast.expr) -> Term:
        term = self.term(node)
        if isinstance(node, ast.Name) or (isinstance(node, ast.Attribute) and term.level == PRIMARY):
            return Term(f"{term.text} * {term.text}", Value(term.kind), PRODUCT)
        helper = self._helper("int_square" if term.kind == "int" else "real_square")
        return Term(f"{helper}({term.text})", Value(term.kind))

    def _unaryop(self, node: ast.UnaryOp) -> Term:
        term = self.term(node.operand)
        if isinstance(node.op, ast.Not):
            return Term(f"!{term.inside()}", Value("bool"), UNARY)
        if isinstance(node.op, ast.UAdd):
            return term
        return Term(f"-{term.inside()}", Value(term.kind), UNARY)

    def _boolop(self, node: ast.BoolOp) -> Term:
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return Term(sign.join(self.term(part).inside() for part in node.values), Value("bool"), LOGIC)

    def _compare(self, node: ast.Compare) -> Term:
        left, right = node.left, node.comparators[0]
        first, second = self.term(left), self.term(right)
        if first.kind == second.kind == "int":
            before, after = first.inside(), second.inside()
        else:
            before, after = self.real(left, first), self.real(right, second)
        return Term(f"{before} {_COMPARISONS[type(node.ops[0]).__name__]} {after}", Value("bool"), RELATION)

    def _ifexp(self, node: ast.IfExp) -> Term:
        test, yes, no = self.term(node.test), self.term(node.body), self.term(node.orelse)
        results = [yes.inside(), no.inside()]
        if yes.kind == "int" and self._fixed(node.body) and self._fixed(node.orelse):
            results = [f"({self.precision.integer}){result}" for result in results]  # not C's narrower int
        return Term(f"{test.inside()} ? {results[0]} : {results[1]}", Value(yes.kind), CHOICE)

    def _fixed(self, node: ast.expr) -> bool:
        """Whether `node` is a number, written or by its name."""
        return isinstance(node, ast.Constant) or (isinstance(node, ast.Name) and self.look_up(node.id) is None)

    def _call(self, node: ast.Call) -> Term:
        function = node.func
        if isinstance(function, ast.Attribute):
            if function.attr not in MATHS:
                raise self.source.fail(node, f"{ast.unparse(function)} has no place in C", "use a function of math")
            return self._libm(function.attr, [self.term(argument).text for argument in node.args])
        assert isinstance(function, ast.Name)
        callee = self.kernel.callees.get(function.id)
        if callee is not None:
            arguments = ", ".join(self.argument(argument) for argument in node.args)
            return Term(f"{self.names.function(callee)}({arguments})", Value(callee.result))
        return self._builtin(node, function.id)

    def _builtin(self, node: ast.Call, name: str) -> Term:
        terms = [self.term(argument) for argument in node.args]
        if name == "float":
            return Term(self.real(node.args[0]), Value("float"), PRIMARY if terms[0].kind == "float" else UNARY)
        if name == "int" and self.kernel.trusted:
            return Term(f"({self.precision.integer}){terms[0].inside()}", Value("int"), UNARY)
        if name == "abs" and terms[0].kind == "float":
            return self._libm("fabs", [terms[0].text])
        if name in ("min", "max", "abs"):
            kind = terms[0].kind
            helper = self._helper(f"{'int' if kind == 'int' else 'real'}_{name}")
            return Term(f"{helper}({', '.join(term.text for term in terms)})", Value(kind))
        mend = "trusted kernels that drive others stay on the desktop"
        raise self.source.fail(node, f"a call of {name} cannot be translated to C", mend)

    def _libm(self, name: str, arguments: list[str]) -> Term:
        self.uses.maths.add(name)
        return Term(f"{name}{self.precision.maths}({', '.join(arguments)})", Value("float"))

    def _helper(self, name: str) -> str:
        self.uses.helpers.add(name)
        return self.names.give(("helper", name), name, f"{name}_of_two")
