"""Kernels: one Python function, interpreted, compiled and in batches; translated to C later.

`@kernel` marks a step function over records. The same source is run by Python (`life="interpreted"`) and by
Numba (`life="compiled"`); in both lives it is a C function that runs a batch of lanes, so whatever drives
kernels (the closed loop, a test, a real-time node) need not know which life it drives.
"""

from bitepoint.kernels.interpreted import invoke
from bitepoint.kernels.kernel import Kernel, Life, kernel
from bitepoint.kernels.maths import EPSILON, clamp, is_finite, sign, to_index

__all__ = ["EPSILON", "Kernel", "Life", "clamp", "invoke", "is_finite", "kernel", "sign", "to_index"]
