"""The third life: kernels and records as readable C99, in double or single precision.

`translate` turns kernels and their records into a header and a source that need nothing but the C library's maths;
`host` compiles that on this machine and runs it in the place of the other lives.
"""

from bitepoint.kernels.c99.precision import FLOAT32, FLOAT64, PRECISIONS, Precision
from bitepoint.kernels.c99.translate import Translation, translate

__all__ = ["FLOAT32", "FLOAT64", "PRECISIONS", "Precision", "Translation", "translate"]
