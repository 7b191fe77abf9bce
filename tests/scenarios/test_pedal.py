"""A pedal cut from a measured log: the right rows, from 0 to 1, or a sentence that says what is wrong with the log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from bitepoint.scenarios import PedalLog, read_pedal_log
from tests.conftest import Refused

LOG = "time_s,speed,pedal_pct\n10,0,14\n11,0,14\n12,0,34\n13.5,2,64\n15,4,100\n"


def written(folder: Path, text: str) -> Path:
    """A CSV file of that text."""
    path = folder / "log.csv"
    path.write_text(text)
    return path


def read(folder: Path, text: str = LOG, column: str = "pedal_pct", **options: float) -> tuple[list[float], list[float]]:
    """Time and pedal of a CSV file of that text."""
    time, pedal = read_pedal_log(PedalLog(written(folder, text), column, **options))
    return time.tolist(), pedal.tolist()


def test_time_starts_at_zero_and_percent_become_a_ratio(tmp_path: Path) -> None:
    assert read(tmp_path) == ([0.0, 1.0, 2.0, 3.5, 5.0], [0.14, 0.14, 0.34, 0.64, 1.0])


def test_the_rest_position_is_subtracted(tmp_path: Path) -> None:
    assert read(tmp_path, rest=14)[1] == [0.0, 0.0, 0.2, 0.5, 0.86]
    assert read(tmp_path, rest=34)[1] == pytest.approx([0.0, 0.0, 0.0, 0.3, 0.66])


def test_the_full_position_is_one_and_what_is_beyond_it_too(tmp_path: Path) -> None:
    assert read(tmp_path, rest=14, full=64)[1] == [0.0, 0.0, 0.4, 1.0, 1.0]


@pytest.mark.parametrize(
    ("options", "times"),
    [
        ({"start": 11}, [11, 12, 13.5, 15]),
        ({"start": 10.5}, [11, 12, 13.5, 15]),
        ({"end": 13.5}, [10, 11, 12, 13.5]),
        ({"end": 13.4}, [10, 11, 12]),
        ({"start": 11.9, "end": 14}, [12, 13.5]),
        ({"start": -5, "end": 1e9}, [10, 11, 12, 13.5, 15]),
    ],
)
def test_start_and_end_are_times_of_the_log(tmp_path: Path, options: dict[str, float], times: list[float]) -> None:
    time, pedal = read(tmp_path, **options)
    assert time == [t - times[0] for t in times]
    whole = dict(zip([10, 11, 12, 13.5, 15], read(tmp_path)[1], strict=True))
    assert pedal == [whole[t] for t in times]


@pytest.mark.parametrize("name", ["time", "time_s", "t", "timestamp", "Time [s]", "cycSecs"])
def test_the_time_column_may_have_several_names(tmp_path: Path, name: str) -> None:
    assert read(tmp_path, f"{name},p\n0,1\n2,3\n", "p") == ([0.0, 2.0], [0.01, 0.03])


@pytest.mark.parametrize("text", ["time_ms,p\n0,1\n2000,3\n", "t;p\n0,0;1\n2,0;3\n", "\ufefft\tp\n0\t1\n2\t3\n"])
def test_units_of_time_and_separators_are_those_of_the_file(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text, "p") == ([0.0, 2.0], [0.01, 0.03])


def test_a_small_overshoot_of_a_sensor_is_limited(tmp_path: Path) -> None:
    assert read(tmp_path, "t,p\n0,-1\n1,50\n2,101\n", "p")[1] == [0.0, 0.5, 1.0]


def test_gaps_outside_the_window_do_no_harm(tmp_path: Path) -> None:
    text = "t,p\n0,\n1,20\n2,30\n3,nan\n"
    assert read(tmp_path, text, "p", start=1, end=2) == ([0.0, 1.0], [0.2, 0.3])


def test_a_parquet_log_reads_as_its_csv(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    time, pedal = [10.0, 11.0, 12.0, 13.5, 15.0], [14, 14, 34, 64, 100]
    pq.write_table(pa.table({"pedal_pct": pa.array(pedal, pa.int16()), "time_s": time}), path)
    log = PedalLog(path, "pedal_pct", rest=14, start=11)
    found = read_pedal_log(log)
    assert [values.tolist() for values in found] == list(read(tmp_path, rest=14, start=11))
    assert all(values.dtype == np.float64 for values in found)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ["cannot be read", "expected CSV with a header, or Parquet"]),
        ("t,p\n", ["no rows", "expected a header and rows of numbers"]),
        ("t,p\n0,1\n", ["fewer than two rows from 0 s to 0 s", "expected part of 0..0 s"]),
        ("zeit,p\n0,1\n1,2\n", ["no time column", "expected a column named one of time, timestamp"]),
        ("t [kg],p\n0,1\n1,2\n", ["t [kg]: ", "expected a unit of time"]),
        ("t,q,r\n0,1,2\n1,2,2\n", ["no column p", "expected one of q, r"]),
        ("t,p\n0,1\n2,2\n1,3\n", ["time does not increase in row 3", "sort the rows and remove repeated ones"]),
        ("t,p\n0,1\n1,2\n1,3\n", ["time does not increase in row 3", "remove repeated ones"]),
        ("t,p\n0,1\n,2\n1,3\n", ["time does not increase in row 2"]),
        ("t,p\n,1\n1,2\n2,3\n", ["time does not increase in row 1"]),
        ("t,p\nnan,1\n1,2\n2,3\n", ["time does not increase in row 1"]),
        ("t,p\n0,1\n1,2\ninf,3\n", ["row 3"]),
        ("t,p\n-inf,1\n1,2\n2,3\n", ["row 1"]),
        ("t,p\n0,1\n1,\n2,3\n", ["p has no value at 1 s", "choose pedal.start and pedal.end where it has values"]),
        ("t,p\n0,1\n1.5,nan\n2,3\n", ["p has no value at 1.5 s"]),
        ("t,p\n0,1\n1,inf\n2,3\n", ["p has no value at 1 s"]),
        ("t,p\n0,1\n1,half\n2,3\n", ["p: not numbers only", "expected numbers or empty cells"]),
        ('t,p\n0,"1,5"\n1,2\n', ["p: not numbers only"]),
        ("t,p\nnow,1\nthen,2\n", ["t: not numbers only"]),
        ("t,p\n2024-01-01 10:00:00,1\n2024-01-01 10:00:01,2\n", ["t: not numbers only"]),
        ("t,p\n0,1\n1,101.1\n", ["p: values from 1 to 101.1", "expected percent, 0 to 100"]),
        ("t,p\n0,-1.1\n1,50\n", ["p: values from -1.1 to 50", "expected percent, 0 to 100"]),
        ("t,p\n0,1\n1,2,3\n", ["cannot be read", "Expected 2 columns, got 3"]),
        ("t,p,p\n0,1,1\n1,2,2\n", ["p"]),
        ("t,p,t\n0,1,1\n1,2,2\n", ["t"]),
    ],
)
def test_what_is_wrong_with_a_log_is_said(tmp_path: Path, text: str, said: list[str], refused: Refused) -> None:
    path = written(tmp_path, text)
    refused(lambda: read_pedal_log(PedalLog(path, "p")), str(path), *said)


@pytest.mark.parametrize(("start", "end"), [(16, None), (None, 9), (14, 11), (11, 11.5), (11, 11), (13.6, 14.9)])
def test_a_window_without_two_rows_is_refused(
    tmp_path: Path, start: float | None, end: float | None, refused: Refused
) -> None:
    log = PedalLog(written(tmp_path, LOG), "pedal_pct", start=start, end=end)
    refused(lambda: read_pedal_log(log), "fewer than two rows from", "expected part of 10..15 s")


@pytest.mark.parametrize("full", [14, 13.9, -100])
def test_a_full_position_that_is_not_above_rest_is_refused(tmp_path: Path, full: float, refused: Refused) -> None:
    log = PedalLog(written(tmp_path, LOG), "pedal_pct", rest=14, full=full)
    refused(lambda: read_pedal_log(log), "pedal.full", f"got {full:g} %", "expected more than pedal.rest, 14 %")


@pytest.mark.parametrize("rest", [101.5, 300, -2])
def test_a_rest_position_that_no_pedal_has_is_refused(tmp_path: Path, rest: float, refused: Refused) -> None:
    refused(lambda: read(tmp_path, rest=rest), "pedal.rest", f"got {rest:g} %")


@pytest.mark.parametrize("name", ["log.csv", "log.parquet"])
def test_a_missing_or_broken_file_is_refused(tmp_path: Path, name: str, refused: Refused) -> None:
    path = tmp_path / name
    refused(lambda: read_pedal_log(PedalLog(path, "p")), str(path), "no such file", "check the path")
    path.write_bytes(bytes(range(256)) * 20)
    refused(lambda: read_pedal_log(PedalLog(path, "p")), str(path), "cannot be read")
    path.unlink()
    path.mkdir()
    refused(lambda: read_pedal_log(PedalLog(path, "p")), str(path))


def test_a_ratio_has_to_be_said(tmp_path: Path, refused: Refused) -> None:
    path = written(tmp_path, "t,p\n0,0\n1,0.4\n2,0.8\n")
    refused(lambda: read_pedal_log(PedalLog(path, "p")), "values up to 0.8", "pedal.unit=ratio")
    assert read_pedal_log(PedalLog(path, "p", ratio=True))[1].tolist() == [0.0, 0.4, 0.8]
