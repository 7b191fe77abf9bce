"""A recording survives the file to the bit, with the units and meanings of its channels; what is none is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

from bitepoint.recording import Channel, Recording
from tests.conftest import Refused, names_in

SPEED = Channel("engine_speed", "rad/s", "engine speed")
TORQUE = Channel("clutch_torque", "N*m", "torque that clutch 1 carries")


def small(**about: str) -> Recording:
    """Two channels over three samples."""
    data = np.array([[83.0, 84.5, 90.0], [0.0, -0.0, 12.5]])
    return Recording(np.array([0.0, 0.002, 0.004]), (SPEED, TORQUE), data, about)


def test_a_channel_is_found_by_its_name() -> None:
    recording = small()
    assert recording["clutch_torque"].tolist() == [0.0, 0.0, 12.5]
    assert "engine_speed" in recording
    assert "time" not in recording
    assert "pedal" not in recording


def test_a_missing_channel_raises_and_names_those_that_there_are() -> None:
    with pytest.raises(KeyError, match="no channel pedal; there are engine_speed, clutch_torque"):
        _ = small()["pedal"]


@pytest.mark.parametrize("shape", [(1, 3), (2, 4), (3, 2), (2,), (2, 3, 1)])
def test_data_of_another_shape_raises(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"expected \(2, 3\)"):
        Recording(np.arange(3.0), (SPEED, TORQUE), np.zeros(shape))


names = st.from_regex(r"[a-z][a-z0-9_.]{0,20}", fullmatch=True).filter(lambda name: name != "time")
channels = st.builds(Channel, names, st.sampled_from(["1", "rad/s", "N*m", "m/s^3", "kg*m²"]), st.text(max_size=30))


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    """Any recording: also without channels, without samples, with NaN and infinities."""
    rows = tuple(draw(st.lists(channels, max_size=4, unique_by=lambda channel: channel.name)))
    finite = st.floats(allow_nan=False, allow_infinity=False)
    time = np.array(sorted(draw(st.lists(finite, max_size=20, unique=True))), float)
    data = draw(nps.arrays(np.float64, (len(rows), len(time)), elements=st.floats(width=64)))
    return Recording(time, rows, data, draw(st.dictionaries(st.text(max_size=10), st.text(max_size=30), max_size=4)))


@given(recordings())
@example(Recording(np.zeros(0), (), np.zeros((0, 0))))
@example(Recording(np.zeros(1), (SPEED,), np.array([[-0.0]]), {"": "ä\n\"'\x00"}))
def test_the_file_gives_back_every_bit(tmp_path_factory: pytest.TempPathFactory, recording: Recording) -> None:
    path = tmp_path_factory.getbasetemp() / "any.parquet"
    recording.to_parquet(path)
    back = Recording.from_parquet(path)
    assert back.channels == recording.channels
    assert back.about == recording.about
    assert back.time.tobytes() == recording.time.tobytes()
    assert back.data.tobytes() == recording.data.tobytes()
    assert back.data.shape == recording.data.shape


def test_any_reader_of_parquet_finds_time_units_and_meanings(tmp_path: Path) -> None:
    small(status="launched").to_parquet(tmp_path / "run.parquet")
    table = pq.read_table(tmp_path / "run.parquet")
    assert table.column_names == ["time", "engine_speed", "clutch_torque"]
    assert table.schema.field("time").metadata == {b"unit": b"s", b"meaning": b"time"}
    assert table.schema.field("engine_speed").metadata == {b"unit": b"rad/s", b"meaning": b"engine speed"}
    assert {str(field.type) for field in table.schema} == {"double"}


def test_columns_of_another_program_are_numbers_without_unit(tmp_path: Path) -> None:
    path = tmp_path / "other.parquet"
    pq.write_table(pa.table({"speed": [1, None], "time": pa.array([0, 1], pa.int32())}), path)
    back = Recording.from_parquet(str(path))
    assert back.channels == (Channel("speed", "1", ""),)
    assert back.time.tolist() == [0.0, 1.0]
    assert np.array_equal(back["speed"], [1.0, np.nan], equal_nan=True)
    assert back.about == {}


@pytest.mark.parametrize("content", [b"", b"time\n0\n1\n", b"PAR1", b"PAR1" + bytes(100) + b"PAR1", b"\xff" * 2000])
def test_what_is_no_parquet_is_refused(tmp_path: Path, content: bytes, refused: Refused) -> None:
    path = tmp_path / "run.parquet"
    path.write_bytes(content)
    refused(lambda: Recording.from_parquet(path), str(path), "no Parquet file")


def test_a_recording_cut_short_is_refused(tmp_path: Path, refused: Refused) -> None:
    path = tmp_path / "run.parquet"
    small().to_parquet(path)
    path.write_bytes(path.read_bytes()[:-20])
    refused(lambda: Recording.from_parquet(path), str(path), "no Parquet file")


def test_a_missing_file_is_refused(tmp_path: Path, refused: Refused) -> None:
    refused(lambda: Recording.from_parquet(tmp_path / "none.parquet"), "none.parquet", "no such file")


def test_a_missing_time_is_refused(tmp_path: Path, refused: Refused) -> None:
    path = tmp_path / "run.parquet"
    pq.write_table(pa.table({"Time": [0.0], "speed": [1.0]}), path)
    refused(lambda: Recording.from_parquet(path), str(path), "no column time")


@pytest.mark.parametrize(
    "table",
    [
        pa.table({"time": [0.0, 1.0], "speed": ["fast", "slow"]}),
        pa.table({"time": ["now", "later"], "speed": [1.0, 2.0]}),
        pa.table({"time": [0.0, 1.0], "speed": [[1.0], [2.0, 3.0]]}),
        pa.table({"time": [0.0, 1.0]}).replace_schema_metadata({"bitepoint": "{not JSON"}),
        pa.table({"time": [0.0, 1.0]}).replace_schema_metadata({"bitepoint": "[1]"}),
    ],
    ids=["text channel", "text time", "list channel", "about no JSON", "about a list"],
)
def test_columns_and_notes_that_cannot_be_a_recording_are_refused(
    tmp_path: Path, table: pa.Table, refused: Refused
) -> None:
    path = tmp_path / "run.parquet"
    pq.write_table(table, path)
    refused(lambda: Recording.from_parquet(path), str(path))


def failing(*arguments: Any, **options: Any) -> None:
    """Stand for a disk that is full."""
    raise OSError("no space left")


@pytest.mark.parametrize(("owner", "name"), [(Path, "replace"), (Path, "chmod"), (pq, "write_table")])
def test_an_interrupted_write_leaves_the_old_recording_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str
) -> None:
    path = tmp_path / "run.parquet"
    small(status="old").to_parquet(path)
    with monkeypatch.context() as patch:
        patch.setattr(owner, name, failing)
        with pytest.raises(OSError, match="no space left"):
            small(status="new").to_parquet(path)
        with pytest.raises(OSError, match="no space left"):
            small().to_parquet(tmp_path / "other.parquet")
    assert names_in(tmp_path) == ["run.parquet"]
    assert Recording.from_parquet(path).about == {"status": "old"}


def test_folders_on_the_way_are_made(tmp_path: Path) -> None:
    write: Callable[[Path], None] = small().to_parquet
    write(tmp_path / "a" / "b" / "run.parquet")
    assert names_in(tmp_path / "a" / "b") == ["run.parquet"]
