"""Putting a vehicle, a controller and a manoeuvre together by name: the one room that knows the concrete ones."""

from bitepoint.assembly.bound import bound_ratio
from bitepoint.assembly.catalogue import (
    ADVISERS,
    CONTROLLERS,
    PLANTS,
    SUPERVISORS,
    all_kernels,
    controllers_for,
    keys,
    signals,
)
from bitepoint.assembly.comparison import Comparer, at_the_end
from bitepoint.assembly.composition import Assembly, Lanes, assemble
from bitepoint.assembly.report_wishes import solve_times

__all__ = [
    "ADVISERS", "CONTROLLERS", "PLANTS", "SUPERVISORS", "Assembly", "Comparer", "Lanes", "all_kernels", "assemble",
    "at_the_end", "bound_ratio", "controllers_for", "keys", "signals", "solve_times",
]  # fmt: skip
