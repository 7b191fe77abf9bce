"""What a user changes, sorted by whom it concerns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bitepoint.errors import InputError
from bitepoint.units import UnitError, parse

SET = "--set"
"""What errors name as the place of a setting."""


@dataclass(frozen=True)
class Settings:
    """What a user changes, sorted by whom it concerns."""

    choices: dict[str, Any] = field(default_factory=dict[str, Any])
    groups: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])

    def group(self, name: str) -> dict[str, Any]:
        """Return the settings `name.*`, without the prefix."""
        return self.groups.get(name, {})


def number(key: str, value: object, unit: str) -> float:
    """Return a finite number in SI; where it comes without a unit, it is in `unit`.

    Raises:
        InputError: it is none.
    """
    try:
        found = parse(value, unit)
    except UnitError as error:
        raise InputError(SET, f"{key}: {error}", f"expected a number in {unit}") from None
    if not np.isfinite(found):
        raise InputError(SET, f"{key}: got {value}", f"expected a finite number in {unit}")
    return found
