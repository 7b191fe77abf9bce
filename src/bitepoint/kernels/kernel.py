"""The `Kernel`: a function with several lives and one calling convention.

Every life of a kernel is a C function with the calling convention of a NumPy ufunc loop,

    void entry(char **arguments, intptr_t *steps, intptr_t lanes)

where argument k of lane n lies at arguments[k] + n * steps[k]: a record, a float64 or an int64; the result, if
there is one, is written to the last argument. A step of 0 shares an argument between all lanes.
"""

from __future__ import annotations

import ctypes
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any, Generic, Literal, ParamSpec, TypeVar, overload

import numpy as np

from bitepoint.kernels.source import Source, define, source_of
from bitepoint.records import FloatArray, IntArray, Record

P = ParamSpec("P")
R = TypeVar("R")
Life = Literal["interpreted", "compiled", "c"]

ENTRY = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_ssize_t)
"""The C type of every entry."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a kernel: kind is "float", "int", "record", or "floats" and "ints" (trusted kernels only)."""

    name: str
    kind: str
    record: type[Record] | None = None


class Kernel(Generic[P, R]):
    """A step function in the subset of Python that all lives share; made by `@kernel`.

    Calling it runs the interpreted life on whatever it is given: this is what other interpreted kernels do.
    `run` takes NumPy arrays, one element per lane, in any life.
    """

    def __init__(self, function: Callable[P, R], *, trusted: bool = False, name: str | None = None) -> None:
        self._define = lambda: function
        self.trusted = trusted
        self.name = name or function.__name__
        self.__doc__ = function.__doc__
        self.__name__ = self.name
        self.__module__ = function.__module__

    @staticmethod
    def generate(name: str, text: str | Callable[[], str], namespace: dict[str, Any]) -> Kernel[..., Any]:
        """Return the kernel `name` defined by `text`, whose global names are those of `namespace`.

        A function that writes the text is called when the kernel is first used: most programs use few kernels.
        """
        return _Generated(name, text, namespace)

    @property
    def function(self) -> Callable[P, R]:
        """The function that it was made of."""
        return self._define()

    def specialise(self, name: str, meanings: Mapping[str, Any]) -> Kernel[P, R]:
        """Return a kernel of the same source in which the global names in `meanings` stand for something else.

        A kernel written for records of one size becomes one for another: record types, constants and callees are
        exchanged by name, and line numbers, debugger and coverage stay with the original file.
        """
        function = self.function
        known: dict[str, Any] = {**function.__globals__, **meanings}
        copy = types.FunctionType(function.__code__, known, function.__name__)
        copy.__annotations__ = function.__annotations__
        copy.__doc__ = function.__doc__
        copy.__module__ = function.__module__
        return Kernel(copy, trusted=self.trusted, name=name)

    def __repr__(self) -> str:
        return f"<kernel {self.__module__}.{self.name}>"

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Run the interpreted life."""
        return self.interpreted(*args, **kwargs)

    @cached_property
    def source(self) -> Source:
        """Where and how it is written."""
        return source_of(self.function)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Its parameters in order."""
        hints = self._hints
        return tuple(self._parameter(a.arg, hints.get(a.arg)) for a in self.source.node.args.args)

    @cached_property
    def result(self) -> str:
        """Kind of its result: "float", "int", "bool" or "none"."""
        hint = self._hints.get("return", Any)
        kinds: dict[Any, str] = {float: "float", int: "int", bool: "bool", type(None): "none"}
        if hint not in kinds:
            mend = "annotate the result as float, int, bool or None"
            raise self.source.fail(self.source.node, f"{self.name} has no scalar result", mend)
        return kinds[hint]

    @cached_property
    def callees(self) -> dict[str, Kernel[..., Any]]:
        """Kernels that it calls, by the name it calls them by."""
        found = {name: self.source.namespace.get(name) for name in self.source.free_names}
        return {name: value for name, value in found.items() if isinstance(value, Kernel)}

    @cached_property
    def constants(self) -> dict[str, float]:
        """Numbers that it uses by a global name, by that name."""
        found = {name: self.source.namespace.get(name) for name in self.source.free_names}
        return {name: value for name, value in found.items() if isinstance(value, bool | int | float)}

    @cached_property
    def interpreted(self) -> Callable[P, R]:
        """Its interpreted life: the same source, checked, with the maths of the other lives."""
        from bitepoint.kernels.interpreted import interpret

        return interpret(self)

    def entry(self, life: Life = "compiled") -> int:
        """Return the address of the C function that runs a batch of lanes in this life."""
        if life == "compiled":
            from bitepoint.kernels.compiled import compiled_entry

            return compiled_entry(self)
        if life == "c":
            from bitepoint.kernels.c99.host import host_entry

            return host_entry(self)
        if life != "interpreted":
            raise ValueError(f"life {life!r}: expected compiled, interpreted or c")
        from bitepoint.kernels.interpreted import interpreted_entry

        return interpreted_entry(self)

    def run(self, *arguments: Any, life: Life = "compiled") -> Any:
        """Run a batch of lanes and return the results, shape (lanes,), or None.

        Args:
            arguments: for a record an array of records, for a float or int a scalar or an array, for a vector of a
                trusted kernel a 1-D array (shared) or a 2-D one (a row per lane). One element is shared by all lanes.
            life: which life runs.

        Raises:
            TypeError: a wrong number of arguments, another record type, or lanes that do not match.
        """
        from bitepoint.kernels.calling import call

        return call(self, arguments, life)

    @cached_property
    def _hints(self) -> dict[str, Any]:
        try:
            return typing.get_type_hints(self.function)
        except NameError as error:
            mend = "define records and annotations at module level"
            raise self.source.fail(self.source.node, f"{self.name}: {error}", mend) from None

    def _parameter(self, name: str, hint: Any) -> Parameter:
        scalars: dict[Any, str] = {float: "float", int: "int"}
        vectors: dict[Any, str] = {FloatArray: "floats", IntArray: "ints"} if self.trusted else {}
        if hint in scalars or hint in vectors:
            return Parameter(name, (scalars | vectors)[hint])
        if isinstance(hint, type) and issubclass(hint, Record):
            return Parameter(name, "record", hint)
        mend = "annotate every parameter as float, int or a Record; arrays live in records"
        raise self.source.fail(self.source.node, f"parameter {name} of {self.name} has no such type", mend)


class _Generated(Kernel[..., Any]):
    """A kernel whose text is written, and whose function is defined, at first use."""

    def __init__(self, name: str, text: str | Callable[[], str], namespace: dict[str, Any]) -> None:
        self._define = cache(lambda: define(name, text if isinstance(text, str) else text(), namespace))
        self.trusted = False
        self.name = self.__name__ = name
        self.__module__ = namespace.get("__name__", "")


@overload
def kernel(function: Callable[P, R], /) -> Kernel[P, R]: ...
@overload
def kernel(*, trusted: bool = ...) -> Callable[[Callable[P, R]], Kernel[P, R]]: ...
def kernel(function: Any = None, /, *, trusted: bool = False) -> Any:
    """Make a kernel of a function. The subset is checked when it is first used, in whichever life.

    A trusted kernel is not checked: it is part of the machinery (it drives others, or makes a check itself).
    """
    if function is None:
        return partial(Kernel[Any, Any], trusted=trusted)
    return Kernel(function, trusted=trusted)


def closure(kernel: Kernel[..., Any], callers: tuple[Kernel[..., Any], ...] = ()) -> Iterator[Kernel[..., Any]]:
    """Yield all that `kernel` calls, callees before callers, and last the kernel itself; some more than once.

    Raises:
        SubsetError: a kernel calls itself, directly or through others.
    """
    if kernel in callers:
        raise kernel.source.fail(kernel.source.node, f"{kernel.name} calls itself", "write a loop: there is no stack")
    for callee in kernel.callees.values():
        yield from closure(callee, (*callers, kernel))
    yield kernel


def addresses_of(arrays: list[np.ndarray[Any, Any]]) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return the address of the first byte of each array."""
    return np.array([array.ctypes.data for array in arrays], np.int64)
