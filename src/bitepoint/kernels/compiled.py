"""The compiled life: kernel source through Numba to machine code, kept in a content-keyed cache.

Numba's own disk cache watches only the file that a kernel stands in, and misses a changed callee. Here the key is a
hash of one self-contained text (the kernel, all that it calls, its constants and record layouts) with the versions of
the compilers and the processor; its value is the object code. A warm start loads that and never imports Numba.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import hashlib
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from bitepoint.cache import cache_folder, write_atomically
from bitepoint.errors import InputError
from bitepoint.kernels.interpreted import MATHS
from bitepoint.kernels.kernel import Kernel, Parameter, closure
from bitepoint.records import Field, Record

LOWERING = "4"
"""Part of every key: counts the changes of how this module turns Numba's output into object code."""

INLINED = 225
"""Instructions below which a kernel is compiled into its callers: 10 % faster, 10 % longer to compile."""

_OPTIONS = 'error_model="numpy"'  # a division by zero gives inf or NaN, as in C
_INNER = f"{_OPTIONS}, no_cpython_wrapper=True, no_cfunc_wrapper=True"  # nobody but the entry calls these


@cache
def compiled_entry(kernel: Kernel[..., Any]) -> int:
    """Return the address of the machine code that runs `kernel` over a batch of lanes, compiled if need be."""
    text = program(kernel)
    path = object_file(kernel.name, text)
    if read_object(path) is None:
        _announce()
        from bitepoint.kernels.subset import check

        check(kernel)
        write_atomically(path.with_suffix(".py"), text.encode())
        code = _compile(kernel, path.with_suffix(".py"))
        write_atomically(path, hashlib.sha256(code).digest() + code)
    return _load(path)


def is_compiled(kernel: Kernel[..., Any]) -> bool:
    """Return whether the machine code is in the cache already."""
    return read_object(object_file(kernel.name, program(kernel))) is not None


def object_file(name: str, text: str) -> Path:
    """Return where the machine code of the program `text` is kept."""
    key = hashlib.sha256("\0".join([text, *_toolchain()]).encode()).hexdigest()[:20]
    return cache_folder() / "kernels" / f"{name}-{key}.o"


def read_object(path: Path) -> bytes | None:
    """Return the object code kept at `path`, or None where there is none or it is damaged."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, code = content[:32], content[32:]
    return code if hashlib.sha256(code).digest() == digest else None


@cache
def _toolchain() -> tuple[str, ...]:
    from importlib.metadata import version

    features = llvm.get_host_cpu_features().flatten()
    versions = version("numba"), version("llvmlite"), np.__version__, sys.version
    rules = [(Path(__file__).parent / f"{name}.py").read_text() for name in ("subset", "expressions", "values")]
    return LOWERING, *rules, *versions, llvm.get_host_cpu_name(), features


@cache
def _announce() -> None:
    message = "bitepoint: compiling kernels for this machine; done once, later starts take them from the cache"
    print(message, file=sys.stderr, flush=True)


@cache
def program(kernel: Kernel[..., Any]) -> str:
    """Return all that the machine code depends on as one text: callees before callers, each with its constants.

    Kernels of different modules may share a name: each section first says what its names stand for.
    """
    members = list(dict.fromkeys(closure(kernel)))
    numbers = {member: number for number, member in enumerate(members)}
    sections: list[str] = []
    for member in members:
        constants = [f"{name} = {value!r}\n" for name, value in member.constants.items()]
        callees = [f"# {alias}: section {numbers[callee]}\n" for alias, callee in member.callees.items()]
        sections.append("".join([f"# section {numbers[member]}\n", *callees, *constants, _definition(member)]))
    return "\n".join([HEADER, *_declared_ranges(kernel), *sections, *_entry_text(kernel)])


def _declared_ranges(kernel: Kernel[..., Any]) -> Iterator[str]:
    """Yield the ranges of integers that the checker's proofs rest on, so that they are part of the key."""
    for parameter in kernel.parameters:
        if parameter.record is not None:
            integers = ((path, f) for path, f in parameter.record.table() if f.kind == "int")
            yield from (f"# {parameter.name}.{path}: {f.low}..{f.high}" for path, f in integers)


def _definition(kernel: Kernel[..., Any]) -> str:
    return f"@njit({_INNER})\n{kernel.source.text}\n"


def _entry_text(kernel: Kernel[..., Any]) -> Iterator[str]:
    """Yield the casts of the parameters and the loop over lanes."""
    arguments: list[str] = []
    for k, parameter in enumerate(kernel.parameters):
        place = f"arguments[{k}] + lane * steps[{k}]"
        if parameter.record is not None:
            yield f"_record_{k} = record_at(np.dtype({_dtype_text(parameter.record)}, align=True))"
        arguments.append(_argument_text(parameter, k, place))
    call = f"kernel({', '.join(arguments)})"
    if kernel.result != "none":
        last = len(kernel.parameters)
        store = "store_float" if kernel.result == "float" else "store_int"
        call = f"{store}(arguments[{last}] + lane * steps[{last}], {call})"
    yield f"""
@cfunc(types.void(types.CPointer(types.intp), types.CPointer(types.intp), types.intp), {_OPTIONS})
def entry(arguments, steps, lanes):
    for lane in range(lanes):
        {call}
"""


def _argument_text(parameter: Parameter, k: int, place: str) -> str:
    casts = {"record": f"_record_{k}", "float": "load_float", "int": "load_int"}
    return f"{casts.get(parameter.kind, parameter.kind + '_at')}({place})"


def _dtype_text(record: type[Record]) -> str:
    return "[" + ", ".join(_field_text(field) for field in record.fields.values()) + "]"


def _field_text(field: Field) -> str:
    if field.record is not None:
        return f"({field.name!r}, np.dtype({_dtype_text(field.record)}, align=True), {field.shape!r})"
    kind = "f8" if field.kind == "float" else "i8"
    return f"({field.name!r}, {kind!r}, {field.shape!r})"


@cache
def _header() -> dict[str, Any]:
    namespace: dict[str, Any] = {"__name__": "bitepoint generated"}
    exec(HEADER, namespace)
    return namespace


@cache
def _dispatcher(kernel: Kernel[..., Any]) -> Any:
    """Return Numba's function for `kernel`: made once in a process, though many programs hold it."""
    callees = {name: _dispatcher(callee) for name, callee in kernel.callees.items()}
    namespace = {**_header(), **kernel.constants, **callees, "math": _header()["maths"]}
    text = f"from __future__ import annotations\n\n{_definition(kernel)}"  # annotations are not evaluated
    exec(compile(text, f"<bitepoint compiled {kernel.name}>", "exec"), namespace)
    return namespace[kernel.source.node.name]


def _compile(kernel: Kernel[..., Any], file: Path) -> bytes:
    """Return the object code of the program of `kernel`; its only outside symbols are those of the C library."""
    for name in ("NUMBA_DISABLE_JIT", "NUMBA_BOUNDSCHECK"):
        if os.environ.get(name, "0") != "0":
            raise InputError(name, "is set", "unset it; to look into kernels, run with life='interpreted'")
    _name_power()
    namespace = {**_header(), "kernel": _dispatcher(kernel)}
    exec(compile("\n".join(_entry_text(kernel)), str(file), "exec"), namespace)
    entry: Any = namespace["entry"]
    intermediate = entry.inspect_llvm().replace(entry.native_name, ENTRY_NAME)
    module = llvm.parse_assembly(_DECLARATION.sub(_without_python, intermediate))
    for function in module.functions:
        if not function.is_declaration and function.name != ENTRY_NAME:
            function.linkage = "internal"
            if sum(1 for block in function.blocks for _ in block.instructions) < INLINED:
                function.add_function_attribute("alwaysinline")
    builder = llvm.create_pass_builder(_machine(), llvm.create_pipeline_tuning_options(speed_level=3))
    builder.getModulePassManager().run(module, builder)
    return _machine().emit_object(module)


ENTRY_NAME = "bitepoint_entry"
_DECLARATION = re.compile(
    r"^declare (?P<type>.+?) @(?P<name>[\w.]+)\((?P<parameters>.*?)\)[^()\n]*(?:#\d+)?$", re.MULTILINE
)
POWER = "bitepoint_pow"
"""What compiled code calls the C library's pow: under its own name LLVM would put exp2 or a root in its place."""

_OUTSIDE = frozenset({"memset", "memcpy", "memmove", "fabs", "floor", "ceil", POWER, *MATHS})


def _without_python(declaration: re.Match[str]) -> str:
    """Return the declaration of a libm function as it is; what only Numba's error path calls is never reached.

    Kernels cannot raise: the checker sees to it. So the path can go, and with it the need for Numba at run time.
    """
    if declaration["name"].startswith("llvm.") or declaration["name"] in _OUTSIDE:
        return declaration[0]
    if not declaration["name"].startswith(("Py", "_Py", "NRT_", "numba_")):
        raise RuntimeError(f"compiled code asks for {declaration['name']}, which nobody has looked at")
    return (
        f"define internal {declaration['type']} @{declaration['name']}({declaration['parameters']}) {{ unreachable }}"
    )


@cache
def _machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_default_triple()
    features = llvm.get_host_cpu_features().flatten()
    options: dict[str, Any] = {"cpu": llvm.get_host_cpu_name(), "features": features, "opt": 3, "jit": True}
    return target.create_target_machine(**options, reloc="default", codemodel="jitdefault")


@cache
def _name_power() -> None:
    """Make POWER known to all that links in this process, Numba included."""
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else ctypes.util.find_library("m"))
    llvm.add_symbol(POWER, ctypes.cast(library.pow, ctypes.c_void_p).value)


_engines: list[Any] = []


def _load(path: Path) -> int:
    """Link the object code into this process and return the address of its entry."""
    code = read_object(path)
    if code is None:
        raise OSError(f"{path} vanished while it was being used; run again")
    _name_power()
    engine: Any = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _engines.append(engine)  # the code lives as long as its engine
    return engine.get_function_address(ENTRY_NAME)


HEADER = '''\
"""Generated by bitepoint from kernel sources; the object file of the same name is what it compiles to."""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np
from llvmlite import ir
from numba import carray, cfunc, from_dtype, njit, types
from numba.core import cgutils
from numba.extending import intrinsic


def pointer_to(builder, address, kind):
    return builder.inttoptr(address, kind.as_pointer())


def record_at(dtype):
    @intrinsic
    def cast(typing_context, address):
        record = from_dtype(dtype)

        def codegen(context, builder, signature, args):
            return builder.inttoptr(args[0], context.get_value_type(record))

        return record(types.intp), codegen

    return cast


def loader(kind, llvm_kind):
    @intrinsic
    def load(typing_context, address):
        def codegen(context, builder, signature, args):
            return builder.load(pointer_to(builder, args[0], llvm_kind))

        return kind(types.intp), codegen

    return load


def storer(kind, llvm_kind):
    @intrinsic
    def store(typing_context, address, value):
        def codegen(context, builder, signature, args):
            value = context.cast(builder, args[1], signature.args[1], kind)
            builder.store(value, pointer_to(builder, args[0], llvm_kind))
            return context.get_dummy_value()

        return types.void(types.intp, value), codegen

    return store


def vector_at(kind):
    @intrinsic
    def cast(typing_context, address):
        def codegen(context, builder, signature, args):
            return builder.inttoptr(args[0], context.get_value_type(types.CPointer(kind)))

        return types.CPointer(kind)(types.intp), codegen

    return cast


load_float, store_float = loader(types.float64, ir.DoubleType()), storer(types.float64, ir.DoubleType())
load_int, store_int = loader(types.int64, ir.IntType(64)), storer(types.int64, ir.IntType(64))
float_pointer, int_pointer = vector_at(types.float64), vector_at(types.int64)
UNBOUNDED = 1 << 40


@njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
def floats_at(address):
    return carray(float_pointer(address), (UNBOUNDED,))


@njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
def ints_at(address):
    return carray(int_pointer(address), (UNBOUNDED,))


@intrinsic
def invoke(typing_context, entry, arguments, steps, lanes):
    def codegen(context, builder, signature, args):
        word = ir.IntType(64)
        function = ir.FunctionType(ir.VoidType(), [word, word, word])
        builder.call(pointer_to(builder, args[0], function), args[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp, types.intp), codegen


@intrinsic
def power(typing_context, x, y):
    def codegen(context, builder, signature, args):
        double = ir.DoubleType()
        kind = ir.FunctionType(double, [double, double])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "bitepoint_pow"), args)

    return types.float64(types.float64, types.float64), codegen


maths = ModuleType("maths")
maths.__dict__.update(vars(math), pow=power)


@njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
def min(a, b):
    return b if b < a else a


@njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
def max(a, b):
    return b if b > a else a

'''
"""What every generated module begins with."""
