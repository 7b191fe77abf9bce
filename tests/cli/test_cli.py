"""The commands: what they print, what they write, and how they end."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from bitepoint.recording import Recording
from bitepoint.version import __version__
from tests.conftest import Command, names_in

UNITS = {
    "launch_time": "s",
    "friction_work": "J",
    "jerk_peak": "m/s^3",
    "jerk_peak_settled": "m/s^3",
    "engine_speed_min": "rad/s",
    "end_speed": "m/s",
    "energy_residual": "1",
}
FILES = ["launch.html", "metrics.json", "recording.parquet"]


def test_run_json_is_one_object_with_every_figure_and_its_unit(bitepoint: Command) -> None:
    done = bitepoint("run", "dct-launch", "--json")
    assert (done.status, done.err, done.out.count("\n")) == (0, "", 1)
    said = json.loads(done.out)
    assert list(said) == ["scenario", "status", "reason", "metrics"]
    assert (said["scenario"], said["status"]) == ("dct-launch", "launched")
    assert said["reason"].startswith("engine and clutch turn as one, 1.")
    assert {name: figure["unit"] for name, figure in said["metrics"].items()} == UNITS
    assert all(list(figure) == ["value", "unit"] for figure in said["metrics"].values())
    assert all(math.isfinite(figure["value"]) for figure in said["metrics"].values())


def test_run_prints_the_figures_for_a_person(bitepoint: Command) -> None:
    done = bitepoint("run", "dct-launch")
    first, second, *rows = done.out.splitlines()
    assert (done.status, done.err) == (0, "")
    assert first == "dct-launch: dct-t240, controller launch_pid"
    assert second.startswith("launched: engine and clutch turn as one, ")
    assert [row.split()[0] for row in rows] == list(UNITS)
    assert rows[0].endswith(" s")
    assert rows[2].endswith(" m/s³")


def test_a_figure_that_does_not_exist_is_null_and_a_dash(bitepoint: Command) -> None:
    arguments = ("run", "dct-launch", "--set", "timing.duration=0.5 s")
    said = json.loads(bitepoint(*arguments, "--json").out)
    assert (said["status"], said["reason"]) == ("timed out", "no stop rule held within 0.5 s")
    assert said["metrics"]["launch_time"] == {"value": None, "unit": "s"}
    assert "launch_time          –" in bitepoint(*arguments).out


def test_every_run_is_the_same(bitepoint: Command) -> None:
    assert bitepoint("run", "dct-launch", "--json") == bitepoint("run", "dct-launch", "--json")


def test_out_writes_recording_figures_and_picture(bitepoint: Command, tmp_path: Path) -> None:
    folder = tmp_path / "not" / "yet"
    done = bitepoint("run", "dct-launch", "--set", "vehicle.mass=1700 kg", "--out", str(folder))
    assert (done.status, done.err) == (0, "")
    assert names_in(folder) == FILES
    assert sorted(line for line in done.out.splitlines() if "wrote" in line) == [f"wrote {folder / f}" for f in FILES]
    recording = Recording.from_parquet(folder / "recording.parquet")
    about = {"scenario": "dct-launch", "vehicle": "dct-t240", "controller": "launch_pid", "status": "launched"}
    about |= {"set.vehicle.mass": "1700 kg", "seed": "0", "version": __version__}
    assert {key: recording.about[key] for key in about} == about
    assert recording.time[1] == 0.002
    assert all(channel.unit and channel.meaning for channel in recording.channels)
    assert {"pedal", "engine_speed", "clutch_speed", "vehicle_speed"} < {channel.name for channel in recording.channels}


def test_out_and_json_say_the_same(bitepoint: Command, tmp_path: Path) -> None:
    done = bitepoint("run", "dct-launch", "--json", "--out", str(tmp_path))
    assert (done.status, done.err, done.out.count("\n")) == (0, "", 1)
    assert json.loads((tmp_path / "metrics.json").read_text()) == json.loads(done.out)


def test_out_replaces_the_files_of_the_run_before(bitepoint: Command, tmp_path: Path) -> None:
    bitepoint("run", "dct-launch", "--out", str(tmp_path))
    before = json.loads((tmp_path / "metrics.json").read_text())
    done = bitepoint("run", "dct-launch", "--json", "--set", "intent=slow", "--out", str(tmp_path))
    assert json.loads((tmp_path / "metrics.json").read_text()) == json.loads(done.out) != before
    assert names_in(tmp_path) == FILES


class Links(HTMLParser):
    """Collect whatever a page would load or show: addresses in attributes, and its visible text."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.text = ""
        self._inside: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._inside = [tag]
        self.loaded += [f"{tag} {name}={value}" for name, value in attrs if name in ("src", "href", "srcset", "data")]

    def handle_data(self, data: str) -> None:
        if self._inside != ["script"]:
            self.text += data


def test_the_picture_is_one_page_that_loads_nothing(bitepoint: Command, tmp_path: Path) -> None:
    bitepoint("run", "dct-launch", "--set", "vehicle.mass=1700 kg", "--out", str(tmp_path))
    page = (tmp_path / "launch.html").read_text(encoding="utf-8")
    links = Links()
    links.feed(page)
    assert links.loaded == []
    assert "@import" not in links.text
    assert "url(" not in links.text
    for words in ("dct-launch", "dct-t240", "launch_pid", "launched", "friction work", "vehicle.mass = 1700 kg"):
        assert words in links.text
    assert f"bitepoint {__version__}" in links.text
    assert "Plotly.newPlot(" in page
    assert '"clutch plate"' in page


def test_a_setting_cannot_put_markup_into_the_page(bitepoint: Command, tmp_path: Path) -> None:
    copy = tmp_path / "<script src='x'>.yaml"
    copy.write_text(library_vehicle().read_text())
    done = bitepoint("run", "dct-launch", "--set", f"vehicle={copy}", "--out", str(tmp_path / "out"))
    links = Links()
    links.feed((tmp_path / "out" / "launch.html").read_text(encoding="utf-8"))
    assert (done.status, links.loaded) == (0, [])


def test_a_file_name_that_is_no_text_does_no_harm(bitepoint: Command, tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"car-\xff.yaml")
    try:
        odd.write_text(library_vehicle().read_text())
    except OSError:
        pytest.skip("this file system has only names that are text")
    done = bitepoint("run", "dct-launch", "--json", "--set", f"vehicle={odd}", "--out", str(tmp_path / "out"))
    assert (done.status, done.err) == (0, "")
    assert names_in(tmp_path / "out") == FILES
    assert Recording.from_parquet(tmp_path / "out" / "recording.parquet").about["set.vehicle"] == str(odd)


def library_vehicle() -> Path:
    """The file of the library's default vehicle."""
    from bitepoint.files import library_folder

    return library_folder("vehicles") / "dct-t240.yaml"


def test_a_run_that_is_not_finite_is_told_like_any_other(bitepoint: Command, tmp_path: Path) -> None:
    overflow = ("--set", "noise.engine_speed=1e308 rad/s")
    done = bitepoint("run", "dct-launch", "--json", "--out", str(tmp_path), *overflow)
    assert (done.status, done.err) == (0, "")
    said = json.loads(done.out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert said["status"] == "not finite"
    assert names_in(tmp_path) == FILES


def test_an_out_folder_that_cannot_be_made_is_refused(bitepoint: Command, tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("in the way")
    bitepoint("run", "dct-launch", "--out", str(file)).refusal(str(file), "cannot be written", "choose another folder")
    bitepoint("run", "dct-launch", "--out", str(file / "deeper")).refusal(str(file / "deeper"), "cannot be written")
    assert names_in(tmp_path) == ["file"]
    assert file.read_text() == "in the way"


def listed(bitepoint: Command, *arguments: str) -> dict[str, Any]:
    """What `bitepoint list --json` says."""
    done = bitepoint("list", *arguments, "--json")
    assert (done.status, done.err, done.out.count("\n")) == (0, "", 1)
    return json.loads(done.out)


def test_list_json_has_names_by_kind(bitepoint: Command) -> None:
    assert listed(bitepoint) == {
        "vehicles": ["dct-na190", "dct-t240", "hatchback-2l", "light-truck", "p2-suv"],
        "scenarios": [
            "conventional-nedc", "dct-excitation", "dct-launch", "eco-launch", "p2-nedc", "p2-tip-in", "p2-tip-step",
            "predictive-cruise",
        ],
        "controllers": [
            "none", "launch_pid", "ddpc", "ddpc_pso", "launch_mpc", "excitation", "damping_mpc", "damping_shaping",
            "amt_control",
        ],
    }  # fmt: skip
    vehicles = ["dct-na190", "dct-t240", "hatchback-2l", "light-truck", "p2-suv"]
    assert listed(bitepoint, "vehicles") == {"vehicles": vehicles}


def test_list_signals_has_what_is_recorded(bitepoint: Command, tmp_path: Path) -> None:
    recorded: set[str] = set()
    launches = [[f"controller={name}"] for name in ("none", "launch_pid", "ddpc", "launch_mpc", "excitation")]
    launches.append(["controller=ddpc", "controller.intention=network"])
    steps = [[f"controller={name}"] for name in ("none", "damping_mpc", "damping_shaping")]
    every = [("dct-launch", settings) for settings in launches] + [("p2-tip-step", settings) for settings in steps]
    every.append(("eco-launch", []))
    for scenario, settings in every:
        words = [word for setting in settings for word in ("--set", setting)]
        bitepoint("run", scenario, *words, "--out", str(tmp_path))
        recorded |= {channel.name for channel in Recording.from_parquet(tmp_path / "recording.parquet").channels}
    assert set(listed(bitepoint, "signals")["signals"]) == recorded - {"speed_target"}  # which the scenario gives


def test_list_for_a_person_has_a_meaning_for_every_name(bitepoint: Command) -> None:
    for kind in ("vehicles", "scenarios", "controllers", "signals"):
        heading, *rows = bitepoint("list", kind).out.splitlines()
        assert heading == kind
        assert [row.split()[0] for row in rows] == listed(bitepoint, kind)[kind]
        assert all(len(row.split()) > 2 for row in rows)
    assert "calibrations: paper, tuned" in bitepoint("list").out
    assert "rad/s    engine speed" in bitepoint("list", "signals").out


def test_list_of_an_unknown_kind_is_refused(bitepoint: Command) -> None:
    bitepoint("list", "boats").refusal("list: got boats", "expected one of vehicles, scenarios, controllers, signals")


def test_an_unknown_scenario_is_refused(bitepoint: Command, tmp_path: Path) -> None:
    bitepoint("run", "dct-lunch").refusal("dct-lunch: no such scenario", "dct-launch")
    bitepoint("run", str(tmp_path / "none.yaml")).refusal("none.yaml: no such file")
    bitepoint("run", "").refusal()


@pytest.mark.parametrize(
    "arguments",
    [
        ["run"],
        ["run", "dct-launch", "again"],
        ["run", "dct-launch", "--seed", "-1"],
        ["run", "dct-launch", "--seed", "many"],
        ["run", "dct-launch", "--set"],
        ["run", "dct-launch", "--fast"],
        ["sail"],
        ["--fast"],
    ],
    ids=" ".join,
)
def test_a_command_line_that_is_no_command_is_refused_in_one_line(bitepoint: Command, arguments: list[str]) -> None:
    bitepoint(*arguments).refusal()


def test_a_bare_command_shows_the_help_and_no_error(bitepoint: Command) -> None:
    done = bitepoint()
    assert "Usage: " in done.out
    assert done.err == ""


def test_version_and_help(bitepoint: Command) -> None:
    assert bitepoint("--version").out == f"bitepoint {__version__}\n"
    for arguments in (["--help"], ["run", "--help"], ["list", "--help"], ["warmup", "--help"]):
        done = bitepoint(*arguments)
        assert (done.status, done.err) == (0, "")
        assert "Usage: " in done.out


def test_warmup_compiles_what_is_missing_and_then_nothing(bitepoint: Command) -> None:
    assert bitepoint("warmup").status == 0
    done = bitepoint("warmup")
    assert done.status == 0
    assert done.out.splitlines()[-1].startswith("0 kernels compiled, ")


def test_the_module_is_the_command(tmp_path: Path, ready_kernels: None) -> None:
    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "bitepoint", *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)

    good = call("run", "dct-launch", "--json")
    assert (good.returncode, good.stderr, json.loads(good.stdout)["status"]) == (0, "", "launched")
    bad = call("run", "dct-launch", "--set", "vehicle.mass=5 s", "--out", "out")
    assert (bad.returncode, bad.stdout, bad.stderr.count("\n")) == (2, "", 1)
    assert bad.stderr.startswith("error: --set: vehicle.mass: got unit 's' of another dimension")
    assert names_in(tmp_path) == []


def test_show_prints_a_library_file_that_runs(bitepoint: Command, tmp_path: Path) -> None:
    shown = bitepoint("show", "dct-na190")
    assert (shown.status, shown.err) == (0, "")
    path = tmp_path / "mine.yaml"
    path.write_text(shown.out)
    assert bitepoint("run", "dct-launch", "--set", f"vehicle={path}").status == 0
    assert "stop:" in bitepoint("show", "dct-launch").out
    bitepoint("show", "boat").refusal("got boat", "dct-na190, dct-t240, hatchback-2l, light-truck, p2-suv, conven")


def test_list_keys_names_what_set_takes(bitepoint: Command) -> None:
    said = json.loads(bitepoint("list", "keys", "--json").out)["keys"]
    assert {"vehicle.mass", "road.grade", "controller.touch_delay", "timing.tick", "engine.full_load"} <= set(said)
    for key in ("vehicle.mass", "damper.stiffness", "controller.clutch_kp", "timing.duration"):
        assert key in said
        bitepoint("run", "dct-launch", "--set", f"{key}=soon").refusal(f"{key}: got 'soon'")
