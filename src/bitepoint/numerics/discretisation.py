"""From differential to difference equations."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from bitepoint.recording import Floats


def zero_order_hold(a: Floats, b: Floats, period: float) -> tuple[Floats, Floats]:
    """Return the transition and the input matrix of dx/dt = a x + b u for u held over `period` (s).

    Args:
        a: shape (n, n); b: (n, m).

    Returns:
        The blocks of exp([[a, b], [0, 0]] period), shapes (n, n) and (n, m).
    """
    from scipy.linalg import expm  # pyright: ignore[reportUnknownVariableType]

    n, m = b.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = a, b
    exponential: Floats = cast("Any", expm)(block * period)
    return exponential[:n, :n], exponential[:n, n:]
