"""Logs of every kind: what is read, in which unit; and what is broken is named, left out, or refused."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from bitepoint.errors import InputError
from bitepoint.identification.datasets import Request, read_dataset
from bitepoint.identification.readers import log as readers_log
from bitepoint.recording import Channel
from tests.conftest import Refused

SPEED, TORQUE = Channel("engine_speed", "rad/s"), Channel("clutch_torque", "N*m")
BOTH = (SPEED, TORQUE)
TIME = np.arange(200) * 0.01
TRUE = {"engine_speed": 100.0 + 20.0 * np.sin(TIME), "clutch_torque": 50.0 + 10.0 * TIME}
RPM = 30.0 / np.pi


def write_csv(path: Path, columns: dict[str, np.ndarray], separator: str = ",", decimal: str = ".") -> Path:
    rows = [separator.join(columns)]
    for row in zip(*columns.values(), strict=True):
        rows.append(separator.join("" if np.isnan(v) else repr(float(v)).replace(".", decimal) for v in row))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def good(path: Path, **columns: np.ndarray) -> Path:
    return write_csv(path, {"time": TIME, **TRUE, **columns})


def check(path: Path, **options: Any) -> None:
    """The file says what is true."""
    data = read_dataset([path], Request(BOTH, **options))
    (run,) = data.runs
    assert data.period == pytest.approx(0.01)
    assert not data.warnings
    for name, truth in TRUE.items():
        assert run[name] == pytest.approx(np.interp(run.time - run.time[0], TIME, truth), rel=1e-6)


@pytest.mark.parametrize(
    ("header", "factor", "columns"),
    [
        ("engine_speed", 1.0, {}),
        ("engine_speed_rpm", RPM, {}),
        ("engine_speed [rpm]", RPM, {}),
        ("Engine_Speed (rpm)", RPM, {}),
        ("engine_speed_rad_s", 1.0, {}),
        ("EngSpd", RPM, {"engine_speed": "EngSpd rpm"}),
        ("Eng Spd", RPM, {"engine_speed": "Eng Spd rpm"}),
        ("Eng Spd [rpm]", RPM, {"engine_speed": "Eng Spd [rpm]"}),
        ("n", 1.0, {"engine_speed": "n"}),
    ],
)
def test_units_by_header_or_by_request(tmp_path: Path, header: str, factor: float, columns: dict[str, str]) -> None:
    table = {"time": TIME, header: factor * TRUE["engine_speed"], "clutch_torque": TRUE["clutch_torque"]}
    check(write_csv(tmp_path / "log.csv", table), columns=columns)


@pytest.mark.parametrize(("separator", "decimal"), [(";", ","), (";", "."), ("\t", ","), (",", ".")])
def test_dialects_of_csv(tmp_path: Path, separator: str, decimal: str) -> None:
    check(write_csv(tmp_path / "log.csv", {"time": TIME, **TRUE}, separator, decimal))


@pytest.mark.parametrize(("header", "factor"), [("time_ms", 1e3), ("t [ms]", 1e3), ("Timestamp", 1.0), ("time_s", 1.0)])
def test_time_has_a_unit_too(tmp_path: Path, header: str, factor: float) -> None:
    check(write_csv(tmp_path / "log.csv", {header: factor * TIME, **TRUE}))


def test_time_by_request(tmp_path: Path) -> None:
    check(write_csv(tmp_path / "log.csv", {"clock": 1e3 * TIME, **TRUE}), columns={"time": "clock ms"})


def test_units_by_metadata_of_a_parquet_file(tmp_path: Path) -> None:
    fields = [
        pa.field("time", pa.float64()),
        pa.field("engine_speed", pa.float64(), metadata={"unit": "rpm"}),
        pa.field("clutch_torque", pa.float32(), metadata={"unit": "kN*m"}),
    ]
    columns = [TIME, RPM * TRUE["engine_speed"], np.float32(1e-3 * TRUE["clutch_torque"])]
    pq.write_table(
        pa.Table.from_arrays([pa.array(c) for c in columns], schema=pa.schema(fields)), tmp_path / "a.parquet"
    )
    check(tmp_path / "a.parquet")


@pytest.mark.parametrize(("start", "kind"), [(1.7e18, pa.timestamp("ns")), (0.0, pa.duration("ns"))])
def test_a_parquet_file_with_dates_or_durations(tmp_path: Path, start: float, kind: Any) -> None:
    stamps = pa.array((start + TIME * 1e9).astype(np.int64), kind)
    pq.write_table(pa.table({"time": stamps, **TRUE}), tmp_path / "a.parquet")
    check(tmp_path / "a.parquet")


def test_mf4_with_channels_on_rasters_of_their_own(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    file, slow = asammdf.MDF(), np.arange(0.0, 2.0, 0.005)
    file.append(asammdf.Signal(RPM * TRUE["engine_speed"], TIME, name="nEng", unit="rpm"))
    file.append(asammdf.Signal(50.0 + 10.0 * slow, slow, name="clutch_torque", unit="Nm"))
    path = tmp_path / "log.mf4"
    file.save(path)
    file.close()
    check(path, columns={"engine_speed": "nEng"})


DBC = """VERSION ""
NS_ :
BS_:
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ nEng : 0|16@1+ (0.01,0) [0|600] "rad/s" ECU
BO_ 257 Clutch: 8 ECU
 SG_ tqCl : 0|16@1+ (0.01,0) [0|600] "Nm" ECU
"""


def frames_file(path: Path) -> None:
    can = pytest.importorskip("can")
    with can.Logger(str(path)) as writer:
        for time, speed, torque in zip(TIME, *TRUE.values(), strict=True):
            for number, value in ((256, speed), (257, torque)):
                data = struct.pack("<H6x", round(100 * value))
                writer.on_message_received(can.Message(1000 + time, number, is_extended_id=False, data=data))


@pytest.mark.parametrize("ending", [".log", ".blf", ".asc"])
def test_frames_with_a_database(tmp_path: Path, ending: str) -> None:
    (tmp_path / "car.dbc").write_text(DBC)
    path = tmp_path / f"drive{ending}"
    frames_file(path)
    columns = {"engine_speed": "nEng", "clutch_torque": "Clutch.tqCl"}
    data = read_dataset([path], Request(BOTH, columns, databases=(tmp_path / "car.dbc",), period=0.01))
    (run,) = data.runs
    assert run["engine_speed"] == pytest.approx(TRUE["engine_speed"][: len(run.time)], abs=0.02)
    assert run["clutch_torque"] == pytest.approx(TRUE["clutch_torque"][: len(run.time)], abs=0.02)


def test_frames_without_a_database_are_refused(tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "a.log").write_text("(0.0) can0 100#00\n")
    refused(lambda: read_dataset([tmp_path / "a.log"], Request(BOTH)), "a.log: CAN frames without a database", "--dbc")
    request = Request(BOTH, databases=(tmp_path / "none.dbc",))
    refused(lambda: read_dataset([tmp_path / "a.log"], request), "none.dbc: no such file")
    (tmp_path / "bad.dbc").write_text("what is this")
    request = Request(BOTH, databases=(tmp_path / "bad.dbc",))
    refused(lambda: read_dataset([tmp_path / "a.log"], request), "bad.dbc: cannot be read")
    (tmp_path / "car.dbc").write_text(DBC.replace("256", "512").replace("257", "513"))
    request = Request(BOTH, databases=(tmp_path / "car.dbc",))
    refused(lambda: read_dataset([tmp_path / "a.log"], request), "a.log: none of its 1 frames")


def test_a_missing_library_names_the_extra(tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(readers_log.importlib, "import_module", absent)
    (tmp_path / "a.mf4").write_bytes(b"MDF")
    refused(lambda: read_dataset([tmp_path / "a.mf4"], Request(BOTH)), "needs asammdf", "bitepoint[mf4]")
    (tmp_path / "a.log").write_text("")
    request = Request(BOTH, databases=(tmp_path / "car.dbc",))
    refused(lambda: read_dataset([tmp_path / "a.log"], request), "needs can", "bitepoint[can]")


# what is broken


def cut(path: Path) -> Path:
    good(path)
    path.write_bytes(path.read_bytes()[:-9].rsplit(b",", 1)[0])
    return path


def holed(path: Path) -> Path:
    torque = TRUE["clutch_torque"].copy()
    torque[80:120] = np.nan
    return good(path, clutch_torque=torque)


def backwards(path: Path) -> Path:
    time = TIME.copy()
    time[100:] -= 0.5
    return write_csv(path, {"time": time, **TRUE})


def parted(path: Path) -> Path:
    speed, torque = TRUE["engine_speed"].copy(), TRUE["clutch_torque"].copy()
    speed[100:], torque[:100] = np.nan, np.nan
    return write_csv(path, {"time": TIME, "engine_speed": speed, "clutch_torque": torque})


def table(**columns: np.ndarray) -> Callable[[Path], Path]:
    return lambda path: write_csv(path, columns)


def text(content: str) -> Callable[[Path], Path]:
    def make(path: Path) -> Path:
        path.write_text(content)
        return path

    return make


BROKEN: dict[str, tuple[Callable[[Path], Path], list[str]]] = {
    "truncated": (cut, ["cannot be read", "columns"]),
    "empty": (text(""), ["cannot be read"]),
    "header only": (text("time,engine_speed,clutch_torque\n"), ["no rows"]),
    "text": (text("time,engine_speed,clutch_torque\n0,1,2\n1,fast,2\n"), ["engine_speed: not numbers only"]),
    "wrong dimension": (
        table(time=TIME, engine_speed_nm=TIME, clutch_torque=TIME), ["engine_speed_nm: got unit 'N*m' of another dim"]
    ),
    "unknown unit": (
        table(**{"time": TIME, "engine_speed [pears]": TIME, "clutch_torque": TIME}), ["got unknown unit 'pears'"]
    ),
    "hertz": (table(**{"time": TIME, "engine_speed [Hz]": TIME, "clutch_torque": TIME}), ["names no angle"]),
    "time not monotone": (backwards, ["time does not increase at 0.5 s"]),
    "no values for a while": (holed, ["clutch_torque: 40 values missing, from 0.8 s"]),
    "never a value": (lambda path: good(path, clutch_torque=np.full(200, np.nan)), ["clutch_torque: no"]),
    "missing channel": (table(time=TIME, engine_speed=TIME), ["no channel clutch_torque"]),
    "no time": (table(engine_speed=TIME, clutch_torque=TIME), ["no column of time"]),
    "time in metres": (table(**{"time [m]": TIME, **TRUE}), ["time [m]: got unit 'm' of another dimension"]),
    "no overlap": (parted, ["no time in common"]),
    "two of one name": (text("time,engine_speed,engine_speed\n0,1,2\n1,2,3\n"), ["two columns are named engine_speed"]),
    "two that fit": (
        table(time=TIME, engine_speed_rpm=TIME, **{"engine_speed [rpm]": TIME}, clutch_torque=TIME),
        ["engine_speed_rpm and engine_speed [rpm] all are engine_speed"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_file_is_named_and_left_out(tmp_path: Path, kind: str) -> None:
    make, said = BROKEN[kind]
    bad = make(tmp_path / "bad.csv")
    data = read_dataset([good(tmp_path / "good.csv"), bad], Request(BOTH))
    assert len(data.runs) == 1
    assert list(data.files) == [str(tmp_path / "good.csv")]
    (warning,) = [each for each in data.warnings if "left out" in each]
    assert "bad.csv" in warning
    assert not [part for part in said if part not in warning], warning


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_file_alone_is_refused(tmp_path: Path, kind: str, refused: Refused) -> None:
    make, said = BROKEN[kind]
    bad = make(tmp_path / "bad.csv")
    refused(lambda: read_dataset([bad], Request(BOTH)), "bad.csv", *said)


def parquet_file(path: Path) -> None:
    pq.write_table(pa.table({"time": TIME, "nEng": TRUE["engine_speed"], "tqCl": TRUE["clutch_torque"]}), path)


def mf4_file(path: Path) -> None:
    file = pytest.importorskip("asammdf").MDF()
    for name, values in zip(("nEng", "tqCl"), TRUE.values(), strict=True):
        file.append(pytest.importorskip("asammdf").Signal(values, TIME, name=name))
    file.save(path, overwrite=True)
    file.close()


@pytest.mark.parametrize(("ending", "make"), [(".parquet", parquet_file), (".mf4", mf4_file), (".blf", frames_file)])
def test_random_bytes_and_truncated_files_are_faults(
    tmp_path: Path, ending: str, make: Callable[[Path], None], refused: Refused
) -> None:
    (tmp_path / "car.dbc").write_text(DBC)
    path = tmp_path / f"bad{ending}"
    path.write_bytes(np.random.default_rng(1).bytes(3000))
    columns = {"engine_speed": "nEng", "clutch_torque": "tqCl"}
    request = Request(BOTH, columns, databases=(tmp_path / "car.dbc",), period=0.01)
    refused(lambda: read_dataset([path], request), f"bad{ending}")
    make(path)
    read_dataset([path], request)
    whole = path.read_bytes()
    for length in (0, 20, len(whole) // 2, len(whole) - 20):
        path.write_bytes(whole[:length])
        refused(lambda: read_dataset([path], request), f"bad{ending}: cannot be read")


def test_a_name_twice_in_a_parquet_file_is_told_and_binary_text_is_not_printed(
    tmp_path: Path, refused: Refused
) -> None:
    columns = [pa.array(each) for each in (TIME, *TRUE.values(), TIME)]
    pq.write_table(pa.Table.from_arrays(columns, [*("time", *TRUE), "clutch_torque"]), tmp_path / "a.parquet")
    refused(lambda: read_dataset([tmp_path / "a.parquet"], Request(BOTH)), "two columns are named clutch_torque")
    (tmp_path / "a.csv").write_bytes((tmp_path / "a.parquet").read_bytes())
    with pytest.raises(InputError, match=r"a\.csv") as told:
        read_dataset([tmp_path / "a.csv"], Request(BOTH))
    assert str(told.value).isprintable()


def test_a_value_that_no_car_reaches_is_of_another_unit(tmp_path: Path, refused: Refused) -> None:
    path = good(tmp_path / "a.csv", engine_speed=RPM * TRUE["engine_speed"])
    request = Request(BOTH, limits={"engine_speed": 1e3})
    refused(lambda: read_dataset([path], request), "a.csv: engine_speed: reaches 11", "rad/s", "--column engine_speed=")
    check(path, columns={"engine_speed": "engine_speed rpm"}, limits={"engine_speed": 1e3})


def test_folders_stand_for_their_logs(tmp_path: Path, refused: Refused) -> None:
    good(tmp_path / "b.csv")
    good(tmp_path / "a.csv")
    (tmp_path / "notes.md").write_text("no log")
    data = read_dataset([tmp_path], Request(BOTH))
    assert [Path(run.about["file"]).name for run in data.runs] == ["a.csv", "b.csv"]
    (tmp_path / "empty").mkdir()
    refused(lambda: read_dataset([tmp_path / "empty"], Request(BOTH)), "empty: no logs in it")
    refused(lambda: read_dataset([tmp_path / "none.csv"], Request(BOTH)), "none.csv: no such file")
    refused(lambda: read_dataset([tmp_path / "notes.md"], Request(BOTH)), "notes.md: a .md file")
    refused(lambda: read_dataset([], Request(BOTH)), "no files")


def test_a_wrong_request_is_refused() -> None:
    for options, said in (
        ({"columns": {"speed": "n"}}, "speed: unknown channel"),
        ({"delays": {"time": 0.1}}, "time: unknown channel"),
        ({"delays": {"engine_speed": 20.0}}, "at most 10 s"),
        ({"delays": {"engine_speed": float("nan")}}, "at most 10 s"),
        ({"period": 0.0}, "got 0 s"),
    ):
        with pytest.raises(InputError, match=said):
            Request(BOTH, **options)


@pytest.mark.real_data
class TestMeasured:
    """Logs of real cars."""

    def test_frames_of_a_moving_car(self, data_folder: Path) -> None:
        pytest.importorskip("can")
        folder = data_folder / "can_rav4"
        channels = (SPEED, Channel("vehicle_speed", "m/s"))
        request = Request(
            channels, {"engine_speed": "RPM", "vehicle_speed": "SPEED.SPEED"},
            databases=(folder / "toyota_rav4_2017.dbc",), period=0.02,
        )  # fmt: skip
        data = read_dataset([folder / "rav4_60s_bus0.log"], request)
        (run,) = data.runs
        assert run.time[-1] - run.time[0] == pytest.approx(60.0, abs=0.1)
        assert 900 < RPM * run["engine_speed"].min() < RPM * run["engine_speed"].max() < 2600
        assert 29 / 3.6 - 1 < run["vehicle_speed"].min() < run["vehicle_speed"].max() < 73 / 3.6 + 1

    def test_j1939_frames_are_known_by_their_group(self, data_folder: Path) -> None:
        pytest.importorskip("can")
        request = Request(
            (SPEED,), {"engine_speed": "EngineSpeed"}, databases=(data_folder / "dbc" / "j1939_demo.dbc",)
        )
        data = read_dataset([data_folder / "can_j1939" / "idle_20s.log"], request)
        speed = RPM * np.concatenate([run["engine_speed"] for run in data.runs])
        assert data.period == pytest.approx(0.01, abs=0.001)
        assert 646 <= speed.min() < speed.max() <= 654

    @pytest.mark.parametrize("name", ["udds", "wltc_3b", "hwfet"])
    def test_drive_cycles_are_tables(self, data_folder: Path, name: str) -> None:
        columns = {"time": "cycSecs", "vehicle_speed": "cycMps"}
        path = data_folder / "drive_cycles" / f"{name}.csv"
        data = read_dataset([path], Request((Channel("vehicle_speed", "m/s"),), columns))
        assert data.period == 1.0
        assert 20.0 < data.runs[0]["vehicle_speed"].max() < 40.0

    def test_a_drive_with_stops_between_trips_is_several_runs(self, data_folder: Path) -> None:
        path = data_folder / "drive_cycles" / "gps_1hz_trip_4116728_1.csv"
        speed = Channel("vehicle_speed", "m/s")
        data = read_dataset([path], Request((speed,), {"vehicle_speed": "speed_mph mph"}))
        assert len(data.runs) > 1
        assert all(np.diff(run.time) == pytest.approx(1.0) for run in data.runs)
