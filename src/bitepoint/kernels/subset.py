"""The checker: is this kernel in the subset of Python that all of its lives share?

The subset: parameters are floats, integers and records; the result is a scalar (or nothing), returned once, at the
end; locals are scalars of one type; `if`, conditional expressions, `for ... in range(...)` with a literal step,
`break`; + - * / and **2; comparisons, `and`, `or`, `not`; two-argument `min` and `max`, `abs`; a list of functions of
`math`; other kernels; upper-case constants; fields of records and elements of their arrays.

Beyond syntax it proves what no life checks at run time: every index lies inside its array (see `expressions`), every
integer stored in a record lies in its declared range, every local has a value before it is read.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

from bitepoint.kernels.expressions import Expressions
from bitepoint.kernels.interpreted import SHIMS
from bitepoint.kernels.kernel import Kernel, closure
from bitepoint.kernels.source import Source, loaded
from bitepoint.kernels.values import Value, integer, union, widened

MOST_PASSES = 4

_WORDS = """
auto bool break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
abs math max min range main
"""
RESERVED = frozenset([*_WORDS.split(), *SHIMS, *(name.lstrip("_") for name in SHIMS)])
"""Names that a kernel, its parameters and its locals cannot have: C's, the subset's, the C library's."""


@dataclass(frozen=True)
class Checked:
    """What the checker found: the types of the locals, the result with its interval, the parameters it writes."""

    locals: Mapping[str, Value]
    result: Value
    written: frozenset[str] = frozenset()


@cache
def check(kernel: Kernel[..., Any]) -> Checked:
    """Check `kernel` and all that it calls.

    Raises:
        SubsetError: it is outside the subset; the error names file and line, and says what to write instead.
    """
    for callee in dict.fromkeys(closure(kernel)):
        if callee is not kernel:
            check(callee)
    if kernel.trusted:
        return Checked({}, Value(kernel.result))
    return _Checker(kernel).run()


class _Checker:
    """Walks the statements of one kernel, again until the intervals of its integers no longer change."""

    def __init__(self, kernel: Kernel[..., Any]) -> None:
        self.kernel = kernel
        self.source: Source = kernel.source
        self.locals: dict[str, Value] = {}
        self.known: dict[str, Value] | None = None
        self.assigned: set[str] = set()
        self.loop_variables: set[str] = set()
        self.loop_names: set[str] = set()
        self.final = False
        self.parameters = {p.name: Value(p.kind, record=p.record) for p in kernel.parameters}
        self.result = Value(kernel.result)
        found = {name: check(callee) for name, callee in kernel.callees.items()}
        results = {name: checked.result for name, checked in found.items()}
        written = {name: checked.written for name, checked in found.items()}
        self.expressions = Expressions(kernel, self._look_up, results, written)

    def run(self) -> Checked:
        """Check, and return what was found."""
        self._check_signature()
        for turn in itertools.count():
            before = dict(self.locals)
            self._pass()
            if self.locals == before:
                break
            if turn >= MOST_PASSES:  # a bound that keeps moving may be anywhere: each one moves once more, for good
                self.locals = {name: widened(before.get(name, value), value) for name, value in self.locals.items()}
        self._narrow()
        self.final = self.expressions.final = True
        self._pass()
        return Checked(self.locals, self.result, frozenset(self.expressions.written))

    def _pass(self) -> None:
        """Walk all statements; intervals of locals only grow."""
        self.assigned = set()
        self._body(self.source.node.body[self._docstring() :], top=True)

    def _narrow(self) -> None:
        """Take what the assignments say of widened intervals: min and max inside them bound a counter again."""
        self.known = self.locals
        self.locals = {}
        self._pass()
        self.known = None

    def _docstring(self) -> int:
        first = self.source.node.body[0]
        is_text = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
        return 1 if is_text and isinstance(first.value.value, str) else 0  # pyright: ignore[reportAttributeAccessIssue]

    def _check_signature(self) -> None:
        arguments = self.source.node.args
        extra = [arguments.vararg, arguments.kwarg, *arguments.kwonlyargs, *arguments.posonlyargs, *arguments.defaults]
        if any(extra):
            raise self.source.fail(self.source.node, "defaults, * or ** in a kernel", "use plain parameters")
        if self.source.node.col_offset or self.kernel.function.__code__.co_freevars:
            raise self.source.fail(self.source.node, "a kernel inside a function", "define it at module level")
        for name in {self.kernel.name, *self.parameters, *self._all_locals} & RESERVED:
            raise self.source.fail(self.source.node, f"the name {name} in a kernel", "it means something in C or here")

    def _look_up(self, node: ast.Name) -> Value | None:
        """Return the value of a parameter or a local, or None for a global name."""
        if node.id in self.parameters:
            return self.parameters[node.id]
        if node.id not in self._all_locals:
            return None
        if node.id not in self.assigned:
            problem = f"{node.id} may have no value here"
            raise self.source.fail(node, problem, "give it one before the branch or the loop")
        return (self.known or self.locals)[node.id]

    @cached_property
    def _all_locals(self) -> set[str]:
        walk = ast.walk(self.source.node)
        return {n.id for n in walk if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}

    def _body(self, statements: list[ast.stmt], *, top: bool = False) -> None:
        for number, statement in enumerate(statements):
            last = top and number == len(statements) - 1
            self._statement(statement, last)
        if top and self.kernel.result != "none" and not (statements and isinstance(statements[-1], ast.Return)):
            where = statements[-1] if statements else self.source.node
            raise self.source.fail(where, "no return at the end", "return the result in the last line")

    def _statement(self, node: ast.stmt, last: bool) -> None:
        self.expressions.whole = getattr(node, "value", None)
        if isinstance(node, ast.Assign):
            if len(node.targets) != 1:
                raise self.source.fail(node, "two assignments in one", "write one per line")
            self._store(node.targets[0], self.expressions.value(node.value))
        elif isinstance(node, ast.AugAssign):
            left = self.expressions.value(loaded(node.target))
            self._store(node.target, self.expressions.binary(node, node.op, left, self.expressions.value(node.value)))
        elif isinstance(node, ast.If):
            self._if(node)
        elif isinstance(node, ast.For):
            self._for(node)
        elif isinstance(node, ast.Return):
            self._return(node, last)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            self.expressions.value(node.value)
        elif not isinstance(node, ast.Break | ast.Pass):
            what = type(node).__name__.lower()
            mend = {"while": "use for ... in range(...) with a cap", "try": "kernels cannot raise: return a status"}
            raise self.source.fail(node, f"{what} in a kernel", mend.get(what, "see the subset in kernels/subset.py"))

    def _store(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self._store_local(target, value)
        elif isinstance(target, ast.Attribute | ast.Subscript):
            if any(isinstance(part, ast.Call) for part in ast.walk(target)):
                raise self.source.fail(target, "a call in the place of an assignment", "give the index a name first")
            place = self.expressions.value(loaded(target))
            self.expressions.written.add(self.expressions.root(target))
            self._store_field(target, place, value)
        else:
            raise self.source.fail(target, "assignment to several names", "write one assignment per line")

    def _store_local(self, target: ast.Name, value: Value) -> None:
        name = target.id
        if name in self.parameters or name in self.loop_names:
            raise self.source.fail(target, f"assignment to {name}, a parameter or loop variable", "use another name")
        if value.kind not in ("float", "int", "bool"):
            problem = f"{name} would be another name for a {value.describe()}"
            raise self.source.fail(target, problem, "use the record's own name; locals are scalars")
        known = self.locals.get(name)
        if known is not None and known.kind != value.kind:
            problem = f"{name} is {known.kind} and {value.kind}"
            raise self.source.fail(target, problem, "give each type a name of its own (1.0 is a float, 1 an integer)")
        plain = integer(value.low, value.high) if value.kind == "int" else Value(value.kind)
        self.locals[name] = plain if known is None else union(known, plain)
        self.assigned.add(name)

    def _store_field(self, target: ast.expr, place: Value, value: Value) -> None:
        text = ast.unparse(target)
        if place.kind not in ("float", "int"):
            raise self.source.fail(target, f"assignment to {text}, a {place.describe()}", "assign its numbers")
        if place.kind == "float" and value.kind == "float":
            return
        if place.kind != value.kind:
            mend = "write 1.0 for a float" if place.kind == "float" else "go through to_index(x, low, high)"
            raise self.source.fail(target, f"{text} is {place.kind}, got {value.kind}", mend)
        if self.final and not (place.low <= value.low and value.high <= place.high):
            problem = f"{text} is declared {place.low}..{place.high}, got {_span(value)}"
            raise self.source.fail(target, problem, "limit it by to_index(float(x), low, high), min or max")

    def _if(self, node: ast.If) -> None:
        self.expressions.condition(node.test)
        before = set(self.assigned)
        self._body(node.body)
        after_body, self.assigned = self.assigned, set(before)
        self._body(node.orelse)
        self.assigned &= after_body

    def _for(self, node: ast.For) -> None:
        if not isinstance(node.target, ast.Name) or node.orelse:
            raise self.source.fail(node, "a loop over several names, or with else", "use for i in range(...)")
        name = node.target.id
        taken = name in self.locals and name not in self.loop_names
        if name in self.parameters or name in self.loop_variables or taken:
            raise self.source.fail(node, f"loop variable {name} is in use", "use another name")
        value = self.expressions.range_of(node.iter)
        self.loop_names.add(name)
        self.locals[name] = value
        before = set(self.assigned)
        self.assigned.add(name)
        self.loop_variables.add(name)
        self._body(node.body)
        self.loop_variables.remove(name)
        self.assigned = before - {name}

    def _return(self, node: ast.Return, last: bool) -> None:
        if not last:
            raise self.source.fail(node, "a return before the end", "set a local and return it in the last line")
        value = Value("none") if node.value is None else self.expressions.value(node.value)
        if value.kind != self.kernel.result:
            problem = f"returns {value.describe()}, annotated {self.kernel.result}"
            raise self.source.fail(node, problem, "make them agree (1.0 is a float, 1 an integer)")
        self.result = value


def _span(value: Value) -> str:
    return f"{value.low}..{value.high}" if value.known else "any integer"
