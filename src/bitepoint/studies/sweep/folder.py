"""The folder of a sweep: its plan, the parts that are done, and in the end the whole table. Files appear whole."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast

from bitepoint.cache import write_atomically
from bitepoint.errors import InputError

PLAN, PARTS, TABLE, PAGE = "plan.json", "parts", "sweep.parquet", "sweep.html"


class SweepFolder:
    """The folder that a sweep is kept in, so that it can be killed at any time and go on."""

    def __init__(self, folder: Path, identity: Mapping[str, Any]) -> None:
        self.folder = folder
        self.identity: dict[str, Any] = json.loads(json.dumps(identity, default=str))
        self.key = hashlib.sha256(json.dumps(self.identity, sort_keys=True).encode()).hexdigest()

    def _check(self) -> None:
        """Refuse a folder that another sweep is kept in."""
        where = str(self.folder)
        mend = "choose another folder, or start anew with --fresh"
        try:
            kept: Any = json.loads((self.folder / PLAN).read_text(encoding="utf-8"))
        except FileNotFoundError:
            if self._kept():
                raise InputError(where, f"holds {self._kept()[0].name} without {PLAN}", mend) from None
            return
        except OSError as error:
            raise InputError(where, f"cannot be read ({error.strerror})", "choose another folder") from None
        except ValueError:
            raise InputError(where, f"its {PLAN} cannot be read", mend) from None
        if kept != self.identity:
            known = cast("dict[str, Any]", kept) if isinstance(kept, dict) else {}
            other = [name for name in self.identity if known.get(name) != self.identity[name]]
            raise InputError(where, f"holds a sweep that differs in {', '.join(other) or 'its keys'}", mend)

    @contextmanager
    def held(self) -> Generator[None]:
        """Make the folder, and hold it against other processes until the end, where the system has locks.

        Raises:
            InputError: another process holds it.
        """
        (self.folder / PARTS).mkdir(parents=True, exist_ok=True)
        try:
            import fcntl
        except ImportError:
            yield
            return
        lock = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            mend = "wait for it, or choose another folder"
            raise InputError(str(self.folder), "another process is sweeping into it", mend) from None
        try:
            yield
        finally:
            os.close(lock)

    def begin(self, fresh: bool) -> None:
        """Write the plan; `fresh`: clear away what an earlier sweep left there."""
        if fresh:
            for path in (*self._kept(), self.folder / PAGE, self.folder / PLAN):
                path.unlink(missing_ok=True)
        for path in (self.folder / PARTS).glob(".part-*"):  # what was being written when it was killed
            path.unlink(missing_ok=True)
        write_atomically(self.folder / PLAN, (json.dumps(self.identity, indent=2) + "\n").encode())

    def tables(self) -> list[Any]:
        """Return what is done: the whole table, or the parts; no row is in two of them. A damaged file counts as none.

        Raises:
            InputError: the folder holds another plan, or parts without one, or cannot be read.
        """
        self._check()
        whole = self._whole(self.folder / TABLE)
        if whole is not None:
            return [whole]
        found: list[Any] = []
        seen: set[int] = set()
        for path in self._parts():
            table = self._whole(path)
            rows: set[int] = set() if table is None else set(table["row"].to_pylist())
            if rows and not rows & seen:
                found.append(table)
                seen |= rows
        return found

    @property
    def finished(self) -> bool:
        """Whether the whole table is there."""
        return self._whole(self.folder / TABLE) is not None

    def _whole(self, path: Path) -> Any:
        """Return the table of a file of this plan, or None where there is none."""
        table = _read(path)
        kept: dict[bytes, bytes] = {} if table is None else table.schema.metadata or {}
        return table if kept.get(b"plan", b"").decode() == self.key else None

    def add(self, table: Any) -> None:
        """Write a part."""
        rows = table["row"].to_numpy()
        name = f"part-{rows[0]:06d}-{hashlib.sha256(rows.tobytes()).hexdigest()[:8]}.parquet"
        self._write(table, self.folder / PARTS / name)

    def finish(self, table: Any) -> None:
        """Write the whole table, and clear the parts away."""
        self._write(table, self.folder / TABLE)
        self.clear()

    def clear(self) -> None:
        """Remove the parts, which the whole table holds."""
        for path in self._parts():
            path.unlink(missing_ok=True)
        with suppress(OSError):  # something else lies there
            (self.folder / PARTS).rmdir()

    def _write(self, table: Any, path: Path) -> None:
        kept: dict[bytes, bytes] = table.schema.metadata or {}
        write_atomically(path, parquet(table.replace_schema_metadata({**kept, "plan": self.key})))

    def _parts(self) -> list[Path]:
        return sorted((self.folder / PARTS).glob("part-*.parquet"))

    def _kept(self) -> list[Path]:
        return [path for path in (self.folder / TABLE, *self._parts()) if path.exists()]


def parquet(table: Any) -> bytes:
    """Return a table as the content of a Parquet file."""
    import pyarrow.parquet as pq

    stream = io.BytesIO()
    pq.write_table(table, stream)
    return stream.getvalue()


def _read(path: Path) -> Any:
    import pyarrow as pa
    import pyarrow.parquet as pq

    library: Any = pq
    try:
        return library.read_table(path)
    except (pa.ArrowException, OSError):
        return None
