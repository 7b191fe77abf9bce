"""Roads from files and made ones: the same road however it is written, and one sentence for each that is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from bitepoint.scenarios.routes import load_route, route_names, terrain
from bitepoint.scenarios.routes.terrain import Points, road, smoothed, track_distance
from tests.conftest import Refused

GPX = '<?xml version="1.0"?><gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1">{}</gpx>'
METRE = 180.0 / np.pi / 6_378_137.0
"""Longitude of a metre on the equator, degrees."""


def written(folder: Path, text: str, name: str = "road.csv") -> str:
    """A file of that text."""
    path = folder / name
    path.write_text(text)
    return str(path)


def rows(header: str, *columns: object) -> str:
    """CSV of some columns, numbers to the last digit."""
    lines = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
    return "\n".join([header, *(",".join(map(str, line)) for line in lines)]) + "\n"


def track_file(folder: Path, points: str, kind: str = "trk", name: str = "road.gpx") -> str:
    """A GPX file with one track, or one route, of points."""
    inner = f"<trk><trkseg>{points}</trkseg></trk>" if kind == "trk" else f"<rte>{points}</rte>"
    return written(folder, GPX.format(inner), name)


def trackpoint(east: float, elevation: float | None, tag: str = "trkpt") -> str:
    """A point on the equator, `east` metres east of Greenwich."""
    height = "" if elevation is None else f"<ele>{elevation!r}</ele>"
    return f'<{tag} lat="0" lon="{east * METRE!r}">{height}</{tag}>'


# ---- the same road, however it is written


X = np.arange(0.0, 2001.0, 25.0)
HEIGHT = 100.0 + 15.0 * np.sin(2.0 * np.pi * X / 1000.0)


def test_units_separators_and_kinds_of_file_do_not_matter(tmp_path: Path) -> None:
    expected = load_route(written(tmp_path, rows("distance,elevation", X, HEIGHT)))
    longitude = X * METRE
    texts = {
        "km.csv": rows("distance_km,elevation_ft", X / 1000.0, HEIGHT / 0.3048),
        "brackets.csv": rows("Distance [km],Elevation (m),name", X / 1000.0, HEIGHT, X),
        "semicolons.csv": rows("distance,elevation", X, HEIGHT).replace(",", ";").replace(".", ","),
        "mark.csv": "\ufeff" + rows("distance,elevation", X, HEIGHT),
        "later.csv": rows("distance,elevation", X + 500.0, HEIGHT),
        "position.csv": rows("latitude,longitude_deg,elevation", 0.0 * X, longitude, HEIGHT),
    }
    files = [written(tmp_path, text, name) for name, text in texts.items()]
    points = list(zip(X.tolist(), HEIGHT.tolist(), strict=True))
    half = "".join(trackpoint(x, z) for x, z in points[:40])
    rest = "".join(trackpoint(x, z) for x, z in points[40:])
    files.append(track_file(tmp_path, f"{half}</trkseg><trkseg>{rest}"))
    files.append(track_file(tmp_path, "".join(trackpoint(x, z, "rtept") for x, z in points), "rte", "plan.gpx"))
    table = pa.table({"distance": X / 1000.0, "elevation": HEIGHT})
    fields = [
        pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in (("distance", "km"), ("elevation", "m"))
    ]
    parquet.write_table(table.cast(pa.schema(fields)), tmp_path / "road.parquet")
    files.append(str(tmp_path / "road.parquet"))
    for file in files:
        route = load_route(file)
        assert route.distance == pytest.approx(expected.distance, abs=1e-6), file
        assert route.elevation == pytest.approx(expected.elevation, abs=1e-6), file
        assert route.grade == pytest.approx(expected.grade, abs=1e-9), file


def test_grade_limits_and_stops_are_taken_as_they_are(tmp_path: Path) -> None:
    text = "distance_km,grade_percent,speed_limit_km_per_h,stop\n0,0,72,\n0.1,4,,1\n0.3,-2,36,0\n0.4,0,36,1\n"
    route = load_route(written(tmp_path, text))
    assert route.distance == pytest.approx([0.0, 100.0, 300.0, 400.0])
    assert route.grade == pytest.approx([0.0, 0.04, -0.02, 0.0])
    assert route.elevation == pytest.approx([0.0, 2.0, 4.0, 3.0])
    assert route.speed_limit.tolist() == pytest.approx([20.0, np.inf, 10.0, 10.0])
    assert route.stops == pytest.approx([100.0, 400.0])
    assert route.about == "road.csv"


def test_where_both_stand_the_grade_counts(tmp_path: Path) -> None:
    route = load_route(written(tmp_path, "distance,elevation,grade\n0,50,0.02\n100,99,0.02\n"))
    assert route.elevation == pytest.approx([50.0, 52.0])


def test_a_limit_is_never_raised_by_the_raster(tmp_path: Path) -> None:
    limit = np.where((X >= 475.0) & (X < 525.0), 10.0, 30.0)
    route = load_route(written(tmp_path, rows("distance,elevation,speed_limit", X, HEIGHT, limit)))
    slow = route.distance[route.speed_limit == 10.0]
    assert slow[0] <= 475.0
    assert slow[-1] + route.distance[1] >= 525.0
    assert slow.size <= 7


def test_stop_lines_of_a_file_that_are_too_near_are_told_with_its_name(tmp_path: Path, refused: Refused) -> None:
    path = tmp_path / "lines.csv"
    path.write_text("distance_m,grade,stop\n0,0,0\n100,0,1\n100.5,0,1\n300,0,0\n")
    refused(lambda: load_route(str(path)), "lines.csv: stop lines at 100 and 100.5 m", "1 m between two")


def test_a_stop_may_stand_at_the_very_end(tmp_path: Path) -> None:
    x, stop = X * 1.1237, np.where(X[-1] == X, 1, 0)
    route = load_route(written(tmp_path, rows("distance,elevation,stop", x, HEIGHT, stop)))
    assert route.stops.tolist() == [route.length]


def test_a_receiver_that_stands_does_not_make_a_road(tmp_path: Path) -> None:
    places = [0.0, 100.0, 100.0, 100.2, 100.0, 200.0, 300.0]
    route = load_route(track_file(tmp_path, "".join(trackpoint(x, 10.0 + 0.05 * x) for x in places)))
    assert route.length == pytest.approx(300.0)
    assert route.grade == pytest.approx(0.05, abs=1e-6)
    assert "3 points left out" in route.about


# ---- smoothing


@pytest.mark.parametrize(("wavelength", "kept"), [(1000.0, 0.967), (500.0, 0.875), (200.0, 0.405), (100.0, 0.0)])
def test_hills_keep_what_is_stated(wavelength: float, kept: float) -> None:
    x = np.arange(0.0, 4001.0, 5.0)
    wave = 0.01 * wavelength * np.sin(2.0 * np.pi * x / wavelength)
    route = road(Points("", x, wave), 200.0)
    middle = slice(50, -50)  # the reflection at the ends is another road
    expected = kept * np.interp(route.distance, x, wave)
    assert route.elevation[middle] == pytest.approx(expected[middle], abs=0.011 * 0.01 * wavelength)


def test_a_constant_grade_stays_up_to_the_ends() -> None:
    route = road(Points("", X, 3.0 + 0.07 * X))
    assert route.grade == pytest.approx(0.07, abs=1e-12)
    assert route.elevation == pytest.approx(3.0 + 0.07 * route.distance)


def test_errors_of_points_leave_the_stated_error_of_the_grade() -> None:
    x = np.arange(0.0, 200_001.0, 20.0)
    route = road(Points("", x, np.random.default_rng(7).normal(0.0, 1.0, x.size)))
    assert route.grade.std() == pytest.approx(4.0 * np.sqrt(20.0 / 200.0**3), rel=0.12)
    assert "smoothed over 200 m, climb" in route.about


def test_what_smoothing_keeps_of_the_climb_is_told() -> None:
    hills = load_route("hills")
    x, error = hills.distance[::2], np.random.default_rng(1).normal(0.0, 1.0, 1001)
    route = road(Points("", x, hills.elevation[::2] + error))
    assert route.about == "elevation smoothed over 200 m, climb 170 of 579 m"
    assert route.climb == pytest.approx(hills.climb, rel=0.05)


def test_smoothing_is_a_weighted_mean() -> None:
    impulse = np.zeros(9)
    impulse[4] = 9.0
    assert smoothed(impulse, 3).tolist() == pytest.approx([0, 0, 1, 2, 3, 2, 1, 0, 0])
    assert smoothed(impulse, 1).tolist() == impulse.tolist()


def test_no_smoothing_where_none_is_wanted() -> None:
    route = road(Points("", X, HEIGHT), 0.0)
    assert route.elevation.tolist() == HEIGHT.tolist()
    assert route.grade == pytest.approx(np.gradient(HEIGHT, X))


# ---- distance on the ellipsoid


@pytest.mark.parametrize(
    ("latitude", "north", "length"),
    [(0.5, True, 110_574.3), (45.0, True, 111_131.8), (0.0, False, 111_319.5), (60.0, False, 55_800.0)],
)
def test_degrees_have_their_published_length(latitude: float, north: bool, length: float) -> None:
    """A degree of latitude around it, or of longitude at it: the tables of the ellipsoid WGS 84."""
    along = np.linspace(-0.5, 0.5, 101)
    still = np.full(101, latitude)
    distance = track_distance(latitude + along, 0.0 * along) if north else track_distance(still, 180.0 + along)
    assert distance[-1] == pytest.approx(length, rel=2e-6)


def test_the_date_line_is_no_gap() -> None:
    assert track_distance(np.zeros(2), np.array([179.999, -179.999]))[-1] == pytest.approx(222.64, abs=0.01)


# ---- made roads


def test_the_hills_of_the_library_are_as_stated() -> None:
    assert route_names() == ["hills"]
    route = load_route("hills")
    assert route.length == 20_000.0
    assert route.grade[:-1].std() == pytest.approx(np.sqrt(0.5 * (0.8**2 + 1 + 1.2**2 + 1.5**2 + 1.6**2)) / 100.0)
    assert (np.abs(route.grade) < 0.04).mean() > 0.95
    assert np.abs(route.grade).max() < 0.055
    assert route.elevation[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.gradient(route.elevation, route.distance)[1:-1] == pytest.approx(route.grade[1:-1], abs=1e-4)


def test_made_roads_of_a_file(tmp_path: Path, refused: Refused) -> None:
    text = (
        "length: 1 km\nwaves:\n  wavelength: {{unit: m, values: [500, 1000]}}\n  grade: {{unit: '%', values: [{}]}}\n"
    )
    route = load_route(written(tmp_path, text.format("0, 2"), "road.yaml"))
    assert np.abs(route.grade).max() == pytest.approx(0.02, rel=1e-2)
    path = written(tmp_path, text.format("20, 20"), "steep.yaml")
    refused(lambda: load_route(path), path, "waves: grades up to 0.4")
    path = written(tmp_path, "length: 1 km\nhills: 3\n", "odd.yaml")
    refused(lambda: load_route(path), path, "hills")


# ---- what is no road


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("distance,speed\n0,1\n100,1\n", ["no column elevation or grade"]),
        ("grade\n0\n0\n", ["no column distance", "latitude and longitude also do"]),
        ("latitude,elevation\n0,1\n1,1\n", ["no column distance"]),
        ("distance,grade\n0,0\n100,0\n100,0\n", ["distance does not rise in row 3"]),
        ("distance,grade\n0,0\n100,0\n90,0\n", ["distance does not rise in row 3"]),
        ("distance,grade\n0,0\n,0\n90,0\n", ["no distance in row 2"]),
        ("distance,grade\n0,0\n100,\n", ["no grade in row 2"]),
        ("distance,elevation\n0,0\n100,nan\n200,0\n", ["no elevation in row 2"]),
        ("distance,elevation\n0,0\n100,0\n1200,0\n", ["a gap of 1100 m after row 2"]),
        ("distance,elevation\n0,0\n300,150\n600,300\n", ["grade of 0.5 at ", "smooth over more"]),
        ("distance,grade\n0,0\n100,4\n", ["grade of 4 at 100 m", "check units"]),
        ("distance,grade_deg\n0,0\n100,4\n", ["grade_deg: ", "angle"]),
        ("distance,grade\n0,0\n20,0\n", ["a road of 20 m", "check the unit of distance"]),
        ("distance,elevation\n0,0\n90,0\n", ["smoothing over 200 m", "the length of the road, 90 m"]),
        ("distance,grade\n0,0\n", ["1 points"]),
        ("distance,grade\n", ["no rows"]),
        ("distance_yd,grade\n0,0\n100,0\n", ["distance_yd: unit unknown", "distance [m]"]),
        ("distance [kg],grade\n0,0\n100,0\n", ["distance [kg]: ", "another dimension"]),
        ("distance,distance_km,grade\n0,0,0\n100,0.1,0\n", ["two columns are distance, one of them distance_km"]),
        ("distance,grade,grade\n0,0,0\n100,0.1,0\n", ["two columns are named grade"]),
        ("distance,grade\n0,0\n100,steep\n", ["grade: not numbers only"]),
        ("distance,grade,speed_limit\n0,0,50\n100,0,\n", ["speed_limit: 50 m/s", "speed_limit_kmh"]),
        ("distance,grade,speed_limit\n0,0,0\n100,0,\n", ["speed_limit: 0 m/s"]),
        ("distance,grade,stop\n0,0,0\n100,0,2\n", ["stop: got 2"]),
        ("latitude,longitude,grade\n0,0,0\n91,0,0\n", ["no position on Earth in row 2"]),
        ("latitude,longitude,grade\n5,5,0\n5,5,0\n", ["1 points", "at different places"]),
        ("distance,grade\n0,0\n1,2,3\n", ["cannot be read"]),
    ],
)
def test_what_is_wrong_with_a_table_is_said(tmp_path: Path, text: str, said: list[str], refused: Refused) -> None:
    path = written(tmp_path, text)
    refused(lambda: load_route(path), path, *said)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<gpx><trk>", ["cannot be read", "expected a GPX file"]),
        ("no xml at all", ["cannot be read"]),
        ("", ["cannot be read"]),
        (GPX.format(""), ["no track and no route"]),
        (GPX.format("<trk/><trk/>"), ["2 tracks"]),
        (GPX.format("<trk><trkseg/></trk>"), ["0 points"]),
        (
            GPX.format(f"<rte>{trackpoint(0, 1, 'rtept')}{trackpoint(300, None, 'rtept')}</rte>"),
            ["no elevation in point 2"],
        ),
        (GPX.format('<rte><rtept lat="x" lon="0"/></rte>'), ["cannot be read"]),
        (GPX.format(f"<rte>{trackpoint(0, 1, 'rtept')}{trackpoint(3000, 1, 'rtept')}</rte>"), ["a gap of 3000 m"]),
    ],
)
def test_what_is_wrong_with_gpx_is_said(tmp_path: Path, text: str, said: list[str], refused: Refused) -> None:
    path = written(tmp_path, text, "road.gpx")
    refused(lambda: load_route(path), path, *said)


def test_bytes_that_are_no_text_are_refused(tmp_path: Path, refused: Refused) -> None:
    for name in ("road.gpx", "road.csv", "road.parquet", "road.yaml"):
        (tmp_path / name).write_bytes(b"\xff\xfe\x00\x81" * 40)
        refused(lambda name=name: load_route(str(tmp_path / name)), name)


def test_roads_that_are_not_there(tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(lambda: load_route("mountains"), "mountains: no such road", "one of hills")
    for kind in ("csv", "gpx", "parquet", "yaml"):
        path = str(tmp_path / f"none.{kind}")
        refused(lambda path=path: load_route(path), path)
    monkeypatch.setitem(__import__("sys").modules, "gpxpy", None)
    refused(lambda: load_route("road.gpx"), "needs gpxpy", "pip install 'bitepoint[route]'")


@pytest.mark.parametrize("smoothing", [-1.0, 5.0, 2001.0, float("nan")])
def test_smoothing_has_its_range(smoothing: float, refused: Refused) -> None:
    refused(lambda: road(Points("file", X, HEIGHT), smoothing), "file: smoothing over", "expected 0, or 10 m")


def test_a_road_may_be_as_long_as_a_journey() -> None:
    x = np.arange(0.0, 1_000_001.0, 50.0)
    assert road(Points("", x, np.zeros(x.size))).length == terrain.LONGEST / 2.0
