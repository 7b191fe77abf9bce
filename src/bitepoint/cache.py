"""The folder of things that can be made again: compiled kernels, remembered unit conversions.

It is the user's cache folder, or $BITEPOINT_CACHE. Deleting it is always safe.
"""

from __future__ import annotations

import os
import tempfile
from functools import cache
from pathlib import Path


@cache
def cache_folder() -> Path:
    """Return the cache folder, made if needed; a temporary one where the user's is not writable."""
    for candidate in _candidates():
        try:
            candidate.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(candidate, os.W_OK):
            return candidate
    return Path(tempfile.mkdtemp(prefix="bitepoint-"))


def _candidates() -> list[Path]:
    named = os.environ.get("BITEPOINT_CACHE")
    if named:
        return [Path(named).expanduser().absolute()]
    from platformdirs import user_cache_path

    return [user_cache_path("bitepoint")]


def write_atomically(path: Path, content: bytes) -> None:
    """Write `content` to `path` so that a reader sees either the old file or the whole new one.

    Raises:
        OSError: the folder cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
