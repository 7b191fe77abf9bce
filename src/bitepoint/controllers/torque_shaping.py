"""Shaping of a driver's torque by two filters in series, each of first order: a request whose rate does not jump.

    first += share (request - first)        second += share (first - second)

The rate of the second is (first - second) / time constant.
"""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.records import Record, quantity


class ShapedTorque(Record):
    """Memory of both filters."""

    first: float = quantity("N*m", -1e5, 1e5, "after the first filter")
    second: float = quantity("N*m", -1e5, 1e5, "after both: the shaped torque")


@kernel
def shaping_reset(s: ShapedTorque, torque: float) -> None:
    """Begin at a torque that has long been asked for, N m."""
    s.first = torque
    s.second = torque


@kernel
def shaping_step(s: ShapedTorque, request: float, share: float) -> None:
    """Follow a request, N m; `share` of a step is answered per step, 1 for no filter."""
    s.first += share * (request - s.first)
    s.second += share * (s.first - s.second)
