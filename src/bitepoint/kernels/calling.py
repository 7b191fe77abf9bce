"""Calling a kernel from Python: NumPy arrays to the addresses and steps of its entry."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from bitepoint.kernels.interpreted import raise_pending
from bitepoint.kernels.kernel import ENTRY, Kernel, Life, Parameter, addresses_of
from bitepoint.records import RecordArray

_SCALARS: dict[str, Any] = {"float": np.float64, "int": np.int64, "bool": np.int64}
_VECTORS: dict[str, Any] = {"floats": np.float64, "ints": np.int64}


def call(kernel: Kernel[..., Any], arguments: tuple[Any, ...], life: Life) -> Any:
    """See `Kernel.run`."""
    if len(arguments) != len(kernel.parameters):
        names = ", ".join(parameter.name for parameter in kernel.parameters)
        raise TypeError(f"{kernel.name} takes {len(kernel.parameters)} arguments ({names}), got {len(arguments)}")
    arrays = [_array(kernel, p, argument) for p, argument in zip(kernel.parameters, arguments, strict=True)]
    lengths = {_lanes(p, array) for p, array in zip(kernel.parameters, arrays, strict=True)} - {1}
    if len(lengths) > 1:
        raise TypeError(f"{kernel.name}: lanes do not match: {sorted(lengths)}")
    lanes = lengths.pop() if lengths else 1
    steps = [_step(p, array) for p, array in zip(kernel.parameters, arrays, strict=True)]
    result = None
    if kernel.result != "none":
        result = np.zeros(lanes, _SCALARS[kernel.result])
        arrays.append(result)
        steps.append(8)
    addresses, strides = addresses_of(arrays), np.array(steps, np.int64)
    ENTRY(kernel.entry(life))(addresses.ctypes.data, strides.ctypes.data, lanes)
    raise_pending()
    return result.astype(bool) if kernel.result == "bool" and result is not None else result


def _array(kernel: Kernel[..., Any], parameter: Parameter, argument: Any) -> RecordArray:
    array: RecordArray
    if parameter.record is not None:
        if not isinstance(argument, np.ndarray) or argument.dtype != parameter.record.dtype or argument.ndim != 1:
            wanted = parameter.record.__name__
            raise TypeError(f"{kernel.name}: {parameter.name} must be a 1-D array of {wanted} records")
        array = cast("RecordArray", argument)
    else:
        kind = (_SCALARS | _VECTORS)[parameter.kind]
        array = np.atleast_1d(np.asarray(argument, kind))
    if not array.flags.c_contiguous:
        raise TypeError(f"{kernel.name}: {parameter.name} must be contiguous")
    return array


def _lanes(parameter: Parameter, array: np.ndarray[Any, Any]) -> int:
    if parameter.kind in _VECTORS:
        return 1 if array.ndim == 1 else array.shape[0]
    return array.shape[0]


def _step(parameter: Parameter, array: np.ndarray[Any, Any]) -> int:
    return array.strides[0] if _lanes(parameter, array) > 1 else 0
