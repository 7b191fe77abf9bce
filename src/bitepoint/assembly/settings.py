"""What a user changes, sorted by whom it concerns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

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
