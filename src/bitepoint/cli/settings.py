"""`--set key=value`, read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bitepoint.errors import InputError
from bitepoint.files import parse_yaml_value


def read_settings(texts: Sequence[str]) -> dict[str, Any]:
    """Return the settings by key; a value in brackets is a list or a block in YAML's flow style.

    Raises:
        InputError: no equals sign, no key, or a key given twice.
    """
    settings: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        key, value = key.strip(), value.strip()
        if not equals or not key or not value:
            raise InputError("--set", f"got {text!r}", "expected key=value, such as vehicle.mass='1900 kg'")
        if key in settings:
            raise InputError("--set", f"{key}: given twice", "leave one of them out")
        settings[key] = parse_yaml_value(value, f"--set {key}") if value[0] in "[{" else value
    return settings
