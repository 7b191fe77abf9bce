"""The cache folder is always one that can be written, and a write is whole or nothing."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bitepoint.cache import cache_folder, write_atomically
from tests.conftest import names_in

fresh_cache_folder: Callable[[], Path] = cache_folder.__wrapped__
"""What `cache_folder` does in a new process."""


def test_the_named_folder_is_made_and_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BITEPOINT_CACHE", str(tmp_path / "not" / "yet"))
    assert fresh_cache_folder() == tmp_path / "not" / "yet"
    assert (tmp_path / "not" / "yet").is_dir()


def test_a_relative_name_is_made_absolute(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BITEPOINT_CACHE", "here")
    assert fresh_cache_folder() == tmp_path / "here"


def test_without_a_name_it_is_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import platformdirs

    monkeypatch.delenv("BITEPOINT_CACHE", raising=False)
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / "cache" / name)
    assert fresh_cache_folder() == tmp_path / "cache" / "bitepoint"


def test_a_folder_that_cannot_be_made_is_replaced_by_a_temporary_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_text("in the way")
    monkeypatch.setenv("BITEPOINT_CACHE", str(file / "cache"))
    check_temporary(fresh_cache_folder(), file)
    assert file.read_text() == "in the way"


def test_a_folder_that_cannot_be_written_is_replaced_by_a_temporary_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BITEPOINT_CACHE", str(tmp_path))
    with monkeypatch.context() as patch:  # rights cannot be taken from root, who may run this
        patch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
        found = fresh_cache_folder()
    check_temporary(found, tmp_path)


def check_temporary(found: Path, wanted: Path) -> None:
    assert found != wanted
    write_atomically(found / "something", b"can be written")
    (found / "something").unlink()
    found.rmdir()


def test_a_file_is_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "new" / "file"
    write_atomically(path, b"one")
    write_atomically(path, b"two")
    assert path.read_bytes() == b"two"
    assert names_in(path.parent) == ["file"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o644


@pytest.mark.parametrize("step", ["chmod", "replace"])
@pytest.mark.parametrize("failure", [OSError("no space"), KeyboardInterrupt()])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, failure: BaseException
) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"old")

    def fail(*arguments: Any) -> None:
        raise failure

    with monkeypatch.context() as patch:
        patch.setattr(Path, step, fail)
        with pytest.raises(type(failure)):
            write_atomically(path, b"new")
    assert path.read_bytes() == b"old"
    assert names_in(tmp_path) == ["file"]


def test_a_write_that_fails_halfway_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"old")
    unwritable: Any = "text is no bytes"
    with pytest.raises(TypeError):
        write_atomically(path, unwritable)
    assert path.read_bytes() == b"old"
    assert names_in(tmp_path) == ["file"]


def test_a_folder_in_the_way_is_an_error_and_stays(tmp_path: Path) -> None:
    (tmp_path / "file").mkdir()
    with pytest.raises(OSError, match="directory"):
        write_atomically(tmp_path / "file", b"new")
    assert names_in(tmp_path) == ["file"]
    assert names_in(tmp_path / "file") == []


def test_a_file_where_the_folder_should_be_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"old")
    with pytest.raises(OSError, match=r"exists|directory"):
        write_atomically(tmp_path / "file" / "deeper", b"new")
    assert (tmp_path / "file").read_bytes() == b"old"
