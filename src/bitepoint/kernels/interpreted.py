"""The interpreted life: the kernel's own source under Python, with the arithmetic of the compiled lives.

Python raises where compiled code gives inf or NaN (division by zero, square root of -1, overflow), so divisions,
squares and mathematical functions are exchanged for ones that do not; line numbers stay, and debuggers and coverage
see the original file. Records are views on the same bytes that the other lives read.
"""

from __future__ import annotations

import ast
import copy
import ctypes
import math
import threading
from collections.abc import Callable
from functools import cache
from typing import Any

from bitepoint.kernels.kernel import ENTRY, Kernel, Parameter
from bitepoint.kernels.source import loaded
from bitepoint.records import Field, Record

_thread = threading.local()
_POINTERS = {"floats": ctypes.POINTER(ctypes.c_double), "ints": ctypes.POINTER(ctypes.c_int64)}
_SCALARS: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_int64}


def interpret(kernel: Kernel[..., Any]) -> Callable[..., Any]:
    """Return the interpreted life of `kernel` as a Python function over views and scalars."""
    from bitepoint.kernels.subset import check

    check(kernel)
    source = kernel.source
    node = _SafeArithmetic().visit(copy.deepcopy(source.node))
    node.decorator_list = []
    node.returns = None
    for argument in node.args.args:
        argument.annotation = None
    callees = {name: callee.interpreted for name, callee in kernel.callees.items()}
    namespace = {**source.namespace, **callees, **SHIMS}
    exec(compile(ast.Module([node], []), source.file, "exec"), namespace)
    return namespace[source.node.name]


def invoke(entry: int, arguments: int, steps: int, lanes: int) -> None:
    """Run the entry at address `entry` (see `kernel`): trusted kernels drive others by it, in whichever life."""
    ENTRY(entry)(arguments, steps, lanes)


def interpreted_entry(kernel: Kernel[..., Any]) -> int:
    """Return the address of a C function that runs the interpreted life over a batch of lanes."""
    address = ctypes.cast(_callback(kernel), ctypes.c_void_p).value
    assert address is not None
    return address


def raise_pending() -> None:
    """Raise what an interpreted kernel raised while C code was calling it: C cannot carry it."""
    first: BaseException | None = getattr(_thread, "pending", None)
    if first is not None:
        _thread.pending = None
        raise first


@cache
def _callback(kernel: Kernel[..., Any]) -> Any:
    function, parameters = kernel.interpreted, kernel.parameters
    result = None if kernel.result == "none" else _SCALARS[kernel.result]
    pointer: Any = ctypes.POINTER(ctypes.c_int64)
    cast: Any = ctypes.cast

    def run(arguments: int, steps: int, lanes: int) -> None:
        bases, strides = cast(arguments, pointer), cast(steps, pointer)
        try:
            for lane in range(lanes):
                values = [_argument(p, bases[k] + lane * strides[k]) for k, p in enumerate(parameters)]
                value = function(*values)
                if result is not None:
                    last = len(parameters)
                    result.from_address(bases[last] + lane * strides[last]).value = value
        except BaseException as error:  # noqa: BLE001 - carried across C, raised by raise_pending
            _thread.pending = getattr(_thread, "pending", None) or error
            if result is ctypes.c_int64:  # a status other than 0 stops whoever drives this kernel
                result.from_address(bases[len(parameters)]).value = -1

    return ENTRY(run)


def _argument(parameter: Parameter, address: int) -> Any:
    if parameter.record is not None:
        return view_class(parameter.record)(address)
    if parameter.kind in _POINTERS:
        return ctypes.cast(address, _POINTERS[parameter.kind])
    return _SCALARS[parameter.kind].from_address(address).value


class View:
    """A record at an address, its fields as Python floats, integers, views and arrays."""

    __slots__ = ("_address",)

    def __init__(self, address: int) -> None:
        self._address = address


@cache
def view_class(record: type[Record]) -> type[View]:
    """Return the class of views on records of this type."""
    members: dict[str, Any] = {"__slots__": ()}
    offsets: Any = record.dtype.fields
    for name, field in record.fields.items():
        members[name] = _member(field, offsets[name][1])
    return type(record.__name__, (View,), members)


def _member(field: Field, offset: int) -> property:
    if field.record is not None:
        inner = view_class(field.record)
        if field.shape:
            size = field.record.dtype.itemsize
            return property(lambda self: _Records(self._address + offset, inner, size, field.shape[0]))
        return property(lambda self: inner(self._address + offset))
    ctype = _SCALARS[field.kind]
    if field.shape:
        return property(lambda self: _Elements(self._address + offset, ctype, field))

    def put(self: Any, value: float) -> None:
        ctype.from_address(self._address + offset).value = value

    return property(lambda self: ctype.from_address(self._address + offset).value, put)


class _Records:
    """A fixed-size array of records at an address."""

    __slots__ = ("_address", "_length", "_size", "_view")

    def __init__(self, address: int, view: type[View], size: int, length: int) -> None:
        self._address = address
        self._view = view
        self._size = size
        self._length = length

    def __getitem__(self, index: int) -> View:
        if not 0 <= index < self._length:
            raise IndexError(f"[{index}] is outside 0..{self._length - 1}")
        return self._view(self._address + index * self._size)


class _Elements:
    """A fixed-size array at an address. An index outside it is an error, as nothing checks it in the other lives."""

    __slots__ = ("_address", "_ctype", "_field")

    def __init__(self, address: int, ctype: Any, field: Field) -> None:
        self._address = address
        self._ctype = ctype
        self._field = field

    def __getitem__(self, index: int | tuple[int, int]) -> Any:
        return self._ctype.from_address(self._locate(index)).value

    def __setitem__(self, index: int | tuple[int, int], value: float) -> None:
        self._ctype.from_address(self._locate(index)).value = value

    def _locate(self, index: int | tuple[int, int]) -> int:
        indices = index if isinstance(index, tuple) else (index,)
        flat = 0
        for i, size in zip(indices, self._field.shape, strict=True):
            if not 0 <= i < size:
                raise IndexError(f"{self._field.name}[{i}] is outside 0..{size - 1}")
            flat = flat * size + i
        return self._address + 8 * flat


class _SafeArithmetic(ast.NodeTransformer):
    """Exchange what raises in Python for the shims below."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Div):
            return _call("_divide", [node.left, node.right], node)
        if isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant) and node.right.value == 2:
            return _call("_square", [node.left], node)
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        function = node.func
        if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name) and function.value.id == "math":
            return _call(f"_{function.attr}", node.args, node)
        if isinstance(function, ast.Name) and function.id in ("min", "max"):
            return _call(f"_{function.id}", node.args, node)
        return node

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Div | ast.Pow):
            return node
        arguments = [loaded(node.target), node.value]
        value = _call("_divide", arguments, node)
        if isinstance(node.op, ast.Pow):
            value = _call("_square", arguments[:1], node)
        return ast.copy_location(ast.Assign([node.target], value), node)


def _call(name: str, arguments: list[ast.expr], at: ast.AST) -> ast.Call:
    node = ast.Call(ast.Name(name, ast.Load()), arguments, [])
    return ast.fix_missing_locations(ast.copy_location(node, at))


def _divide(a: float, b: float) -> float:
    if b != 0.0:
        return a / b
    if a == 0.0 or a != a:
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _square(a: float) -> float:
    return a * a


def _min(a: float, b: float) -> float:
    return b if b < a else a


def _max(a: float, b: float) -> float:
    return b if b > a else a


def _power(a: float, b: float) -> float:
    try:
        return math.pow(a, b)
    except OverflowError:
        return -math.inf if a < 0.0 and b % 2.0 == 1.0 else math.inf
    except ValueError:  # a negative base, or zero to a negative power
        if a != 0.0:
            return math.nan
        return math.copysign(math.inf, a) if b % 2.0 == 1.0 else math.inf


def _logarithm(function: Callable[[float], float], pole: float) -> Callable[[float], float]:
    def shim(x: float) -> float:
        if x == pole:
            return -math.inf
        return function(x) if x > pole else math.nan

    return shim


def _or_nan(function: Callable[..., float]) -> Callable[..., float]:
    def shim(*x: float) -> float:
        try:
            return function(*x)
        except ValueError:
            return math.nan

    return shim


def _or_infinite(function: Callable[[float], float], odd: bool) -> Callable[[float], float]:
    def shim(x: float) -> float:
        try:
            return function(x)
        except OverflowError:
            return -math.inf if odd and x < 0.0 else math.inf

    return shim


SHIMS: dict[str, Callable[..., Any]] = {
    "_divide": _divide,
    "_square": _square,
    "_min": _min,
    "_max": _max,
    "_pow": _power,
    "_log": _logarithm(math.log, 0.0),
    "_log1p": _logarithm(math.log1p, -1.0),
    "_exp": _or_infinite(math.exp, odd=False),
    "_expm1": _or_infinite(math.expm1, odd=False),
    "_cosh": _or_infinite(math.cosh, odd=False),
    "_sinh": _or_infinite(math.sinh, odd=True),
    **{f"_{name}": _or_nan(getattr(math, name)) for name in ("sqrt", "sin", "cos", "tan", "asin", "acos")},
    **{f"_{name}": getattr(math, name) for name in ("atan", "atan2", "tanh", "fabs", "copysign")},
}
"""What the interpreted life calls instead of operators and functions that raise."""

MATHS = frozenset(name[1:] for name in SHIMS) - {"divide", "square", "min", "max"}
"""Functions of `math` that kernels may call."""
