"""Types and intervals of the expressions in a kernel, and what is refused in them."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any

from bitepoint.kernels.interpreted import MATHS
from bitepoint.kernels.kernel import Kernel
from bitepoint.kernels.values import BOOL, FLOAT, Value, arithmetic, element_of, integer, limited, of_field, union

NUMBERS = ("float", "int")

LARGEST = 2**31 - 1
"""Largest magnitude of an integer that kernels compute: the int of C."""


class Expressions:
    """Finds the value of every expression of one kernel."""

    def __init__(
        self,
        kernel: Kernel[..., Any],
        look_up: Callable[[ast.Name], Value | None],
        results: Mapping[str, Value],
        written_by: Mapping[str, frozenset[str]],
    ) -> None:
        self.kernel = kernel
        self.results = results
        self.written_by = written_by
        self.written: set[str] = set()
        self.whole: ast.expr | None = None
        self.source = kernel.source
        self.look_up = look_up
        self.final = False

    def value(self, node: ast.expr) -> Value:
        """Return what `node` is.

        Raises:
            SubsetError: it is outside the subset.
        """
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            what = type(node).__name__
            mend = {"ListComp": "write a loop", "Tuple": "write one value per line", "JoinedStr": "return a status"}
            raise self.source.fail(node, f"{what} in a kernel", mend.get(what, "see the subset in kernels/subset.py"))
        return method(node)

    def condition(self, node: ast.expr) -> None:
        """Check that `node` is a bool: other types are true for different reasons in different lives."""
        value = self.value(node)
        if value.kind != "bool":
            raise self.source.fail(node, f"a {value.describe()} as a condition", "compare it: x != 0")

    def binary(self, node: ast.AST, operator: ast.operator, left: Value, right: Value) -> Value:
        """Return left operator right."""
        name = type(operator).__name__
        if name not in ("Add", "Sub", "Mult", "Div", "Pow"):
            mends = {"Mod": "use to_index or a counter", "FloorDiv": "use to_index(a / b, low, high)"}
            raise self.source.fail(node, f"operator {name} in a kernel", mends.get(name, "write it with + - * /"))
        if left.kind not in NUMBERS or right.kind not in NUMBERS:
            problem = f"{name} of {left.describe()} and {right.describe()}"
            raise self.source.fail(node, problem, "use numbers; 1.0 if c else 0.0 makes one of a bool")
        if name == "Pow" and right != integer(2, 2):
            raise self.source.fail(node, "a power other than **2", "use math.pow(x, y)")
        if name == "Div" or "float" in (left.kind, right.kind):
            return FLOAT
        result = arithmetic("Mult" if name == "Pow" else name, left, left if name == "Pow" else right)
        return self._bounded(node, result)

    def _bounded(self, node: ast.AST, result: Value) -> Value:
        """Refuse integer arithmetic that could leave 32 bits: lives would wrap at different places, or not at all."""
        if self.final and not (result.low >= -LARGEST and result.high <= LARGEST):
            raise self.source.fail(node, "an integer that may overflow", "limit what it is made of by min and max")
        return result

    def range_of(self, node: ast.expr) -> Value:
        """Return the integers that a loop over `node` runs through."""
        if not isinstance(node, ast.Call) or ast.unparse(node.func) != "range" or node.keywords:
            raise self.source.fail(node, "a loop over something else than range", "use for i in range(...)")
        bounds = [self.value(argument) for argument in node.args]
        if not 1 <= len(bounds) <= 3:
            raise self.source.fail(node, f"range with {len(bounds)} arguments", "it takes 1 to 3")
        if any(bound.kind != "int" for bound in bounds):
            raise self.source.fail(node, "range of something else than integers", "use to_index(x, low, high)")
        step = bounds[2] if len(bounds) == 3 else integer(1, 1)
        if step.low != step.high or step.low == 0:
            raise self.source.fail(node, "a step that is no literal", "write the step as a number")
        start, stop = (integer(0, 0), bounds[0]) if len(bounds) == 1 else (bounds[0], bounds[1])
        if step.low > 0:
            return integer(start.low, max(stop.high - 1, start.low))
        return integer(min(stop.low + 1, start.high), start.high)

    def _constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, bool):
            return BOOL
        if isinstance(node.value, int):
            if abs(node.value) > LARGEST:
                raise self.source.fail(node, f"the constant {node.value}", "use a float, or a smaller integer")
            return integer(node.value, node.value)
        if isinstance(node.value, float):
            return FLOAT
        raise self.source.fail(node, f"the constant {node.value!r} in a kernel", "use numbers")

    def _name(self, node: ast.Name) -> Value:
        value = self.look_up(node)
        if value is not None:
            return value
        constant = self.source.namespace.get(node.id)
        if isinstance(constant, bool) or not isinstance(constant, int | float):
            raise self.source.fail(node, f"the name {node.id} in a kernel", "use parameters, locals and constants")
        if not node.id.isupper():
            raise self.source.fail(node, f"the global {node.id} in a kernel", "write constants in upper case")
        return integer(constant, constant) if isinstance(constant, int) else FLOAT

    def _attribute(self, node: ast.Attribute) -> Value:
        base = self.value(node.value)
        if base.kind != "record" or base.record is None:
            raise self.source.fail(node, f"attribute {node.attr} of a {base.describe()}", "only records have fields")
        field = base.record.fields.get(node.attr)
        if field is None:
            mend = f"expected one of {', '.join(base.record.fields)}"
            raise self.source.fail(node, f"{base.record.__name__} has no field {node.attr}", mend)
        return of_field(field)

    def _subscript(self, node: ast.Subscript) -> Value:
        array = self.value(node.value)
        if array.kind not in ("array", "records") or array.field is None:
            raise self.source.fail(node, f"an index into a {array.describe()}", "only arrays have elements")
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(indices) != len(array.field.shape):
            problem = f"{len(indices)} indices into {len(array.field.shape)} dimensions"
            raise self.source.fail(node, problem, "give one index per dimension")
        for index, size in zip(indices, array.field.shape, strict=True):
            self._check_index(index, size, ast.unparse(node.value))
        return element_of(array)

    def _check_index(self, node: ast.expr, size: int, array: str) -> None:
        if isinstance(node, ast.Slice):
            raise self.source.fail(node, "a slice in a kernel", "write a loop over indices")
        value = self.value(node)
        if value.kind != "int":
            raise self.source.fail(node, f"a {value.describe()} as an index", "use to_index(x, low, high)")
        if self.final and not (value.low >= 0 and value.high < size):
            span = f"{value.low}..{value.high}" if value.known else "any integer"
            problem = f"index {ast.unparse(node)} into {array} is {span}, its size is {size}"
            raise self.source.fail(node, problem, f"limit it by to_index(x, 0, {size - 1})")

    def _binop(self, node: ast.BinOp) -> Value:
        return self.binary(node, node.op, self.value(node.left), self.value(node.right))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            self.condition(node.operand)
            return BOOL
        if value.kind not in NUMBERS or isinstance(node.op, ast.Invert):
            raise self.source.fail(node, f"{type(node.op).__name__} of a {value.describe()}", "use numbers")
        if value.kind == "float" or isinstance(node.op, ast.UAdd):
            return FLOAT if value.kind == "float" else value
        return self._bounded(node, arithmetic("Sub", integer(0, 0), value))

    def _boolop(self, node: ast.BoolOp) -> Value:
        for part in node.values:
            self.condition(part)
        return BOOL

    def _compare(self, node: ast.Compare) -> Value:
        if len(node.ops) != 1:
            raise self.source.fail(node, "a chain of comparisons", "write a < b and b < c")
        if isinstance(node.ops[0], ast.Is | ast.IsNot | ast.In | ast.NotIn):
            raise self.source.fail(node, f"{type(node.ops[0]).__name__} in a kernel", "compare numbers")
        for side in (node.left, node.comparators[0]):
            value = self.value(side)
            if value.kind not in NUMBERS:
                raise self.source.fail(node, f"a comparison of a {value.describe()}", "compare numbers")
        return BOOL

    def _ifexp(self, node: ast.IfExp) -> Value:
        self.condition(node.test)
        yes, no = self.value(node.body), self.value(node.orelse)
        if yes.kind != no.kind:
            problem = f"a value that is {yes.describe()} or {no.describe()}"
            raise self.source.fail(node, problem, "make both the same type (1.0 is a float, 1 an integer)")
        return union(yes, no)

    def _call(self, node: ast.Call) -> Value:
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            raise self.source.fail(node, "keyword or starred arguments", "pass arguments by position")
        function = node.func
        if isinstance(function, ast.Attribute):
            return self._call_math(node, function)
        if not isinstance(function, ast.Name):
            raise self.source.fail(node, "a call of an expression", "call kernels by name")
        callee = self.kernel.callees.get(function.id)
        if callee is not None:
            return self._call_kernel(node, callee)
        return self._call_builtin(node, function.id)

    def _call_math(self, node: ast.Call, function: ast.Attribute) -> Value:
        name = ast.unparse(function)
        if not (isinstance(function.value, ast.Name) and function.value.id == "math" and function.attr in MATHS):
            mend = f"call kernels by name, or one of math.{', math.'.join(sorted(MATHS))}"
            raise self.source.fail(node, f"a call of {name}", mend)
        for argument in node.args:
            if self.value(argument).kind != "float":
                raise self.source.fail(node, f"{name} of something else than floats", "write 1.0 for a float")
        wanted = 2 if function.attr in ("pow", "atan2", "copysign") else 1
        if len(node.args) != wanted:
            raise self.source.fail(node, f"{name} with {len(node.args)} arguments", f"it takes {wanted}")
        return FLOAT

    def _call_builtin(self, node: ast.Call, name: str) -> Value:
        if name in self.source.namespace:
            raise self.source.fail(node, f"a call of {name}", "make it a kernel with @kernel, under a name of its own")
        values = [self.value(argument) for argument in node.args]
        kinds = {value.kind for value in values}
        if name in ("min", "max") and len(values) == 2 and kinds in ({"float"}, {"int"}):
            return FLOAT if kinds == {"float"} else limited(name, *values)
        if name == "abs" and len(values) == 1 and kinds <= set(NUMBERS):
            value = values[0]
            if value.kind == "float":
                return FLOAT
            if not value.known:
                return integer()
            low = 0 if value.low <= 0 <= value.high else min(abs(value.low), abs(value.high))
            return integer(low, max(abs(value.low), abs(value.high)))
        if name == "float" and len(values) == 1 and kinds <= set(NUMBERS):
            return FLOAT
        mends = {
            "int": "use to_index(x, low, high)",
            "min": "use two arguments of one type",
            "max": "use two arguments of one type",
            "range": "only a for loop takes a range",
        }
        raise self.source.fail(node, f"a call of {name}", mends.get(name, "make it a kernel with @kernel"))

    def root(self, node: ast.expr) -> str:
        """Return the name that a place, such as p.sub.table[3], begins with."""
        while isinstance(node, ast.Attribute | ast.Subscript):
            node = node.value
        return node.id if isinstance(node, ast.Name) else ""

    def _note_writes(self, node: ast.Call, callee: Kernel[..., Any]) -> None:
        """Note which records a call writes, and refuse it inside a larger expression: C leaves its order open."""
        written = self.written_by[ast.unparse(node.func)]
        self.written |= {
            self.root(argument)
            for parameter, argument in zip(callee.parameters, node.args, strict=True)
            if parameter.name in written
        }
        if written and node is not self.whole:
            problem = f"a call of {callee.name}, which writes {', '.join(sorted(written))}, inside an expression"
            raise self.source.fail(node, problem, "give its result a name of its own first")

    def _call_kernel(self, node: ast.Call, callee: Kernel[..., Any]) -> Value:
        if len(node.args) != len(callee.parameters):
            problem = f"{callee.name} with {len(node.args)} arguments"
            raise self.source.fail(node, problem, f"it takes {len(callee.parameters)}")
        values = [self.value(argument) for argument in node.args]
        for parameter, value in zip(callee.parameters, values, strict=True):
            wanted = Value(parameter.kind, record=parameter.record)
            if (value.kind, value.record) != (wanted.kind, wanted.record):
                problem = f"{parameter.name} of {callee.name} is {wanted.describe()}, got {value.describe()}"
                raise self.source.fail(node, problem, "make them agree (1.0 is a float, 1 an integer)")
        self._note_writes(node, callee)
        if callee.name == "to_index" and callee.trusted:
            return union(values[1], values[2])  # whichever of low and high is the larger
        return self.results[ast.unparse(node.func)]
