"""The launch as users run it: published figures, statuses, imperfections, batches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

import bitepoint
from bitepoint import InputError, Recording, Result, metrics
from tests.tolerances import ENERGY, PUBLISHED_JERK, PUBLISHED_TIME, PUBLISHED_WORK

PUBLISHED = yaml.safe_load((Path(__file__).parent / "published.yaml").read_text())
TOLERANCE = {"launch_time": PUBLISHED_TIME, "friction_work": PUBLISHED_WORK, "jerk_peak": PUBLISHED_JERK}
INTENTS = ("slow", "normal", "urgent")


def value(result: Result, name: str) -> float:
    found = result.metrics[name].value
    assert found is not None, name
    return found


@pytest.mark.parametrize("intent", INTENTS)
def test_paper_calibration_reproduces_the_published_row(intent: str) -> None:
    result = bitepoint.run("dct-launch", intent=intent, **{"controller.calibration": "paper"})
    assert result.status == "launched"
    for name, published in PUBLISHED[intent].items():
        assert value(result, name) == pytest.approx(published, rel=TOLERANCE[name]), name


@pytest.mark.parametrize("intent", INTENTS)
def test_tuned_is_better_than_paper_in_every_figure(intent: str) -> None:
    tuned = bitepoint.run("dct-launch", intent=intent)
    paper = bitepoint.run("dct-launch", intent=intent, controller__calibration="paper")
    for name in ("launch_time", "friction_work", "jerk_peak", "jerk_peak_settled"):
        assert value(tuned, name) < value(paper, name), name


@pytest.mark.parametrize("vehicle", ["dct-t240", "dct-na190"])
@pytest.mark.parametrize("intent", INTENTS)
def test_tuned_launches_a_heavy_car_on_a_steep_hill(vehicle: str, intent: str) -> None:
    settings = {"vehicle": vehicle, "vehicle.mass": "1900 kg", "road.grade": "20 %"}
    result = bitepoint.run("dct-launch", intent=intent, **settings)
    assert result.status == "launched"
    assert value(result, "engine_speed_min") > 75.0
    assert value(result, "energy_residual") < ENERGY


def test_friction_work_is_the_same_from_torque_and_slip_alone() -> None:
    recording = bitepoint.run("dct-launch").recording
    kept = [k for k, channel in enumerate(recording.channels) if channel.name != "friction_heat"]
    measured = Recording(recording.time, tuple(recording.channels[k] for k in kept), recording.data[kept])
    assert metrics.friction_work(measured, 0.0, 1.2) == pytest.approx(
        metrics.friction_work(recording, 0.0, 1.2), rel=5e-3
    )


def test_figures_do_not_depend_on_the_raster() -> None:
    coarse, fine = bitepoint.run("dct-launch"), bitepoint.run("dct-launch", timing__tick="0.5 ms")
    for name in ("launch_time", "friction_work", "jerk_peak", "end_speed"):
        assert value(coarse, name) == pytest.approx(value(fine, name), rel=2e-3), name


STATUSES = {
    "launched": {},
    "stalled": {"controller": "none", "controller.clutch_torque": "250 N*m", "controller.clutch_rate": "700 N*m/s"},
    "timed out": {"controller": "none", "controller.clutch_torque": "0 N*m", "timing.duration": "2 s"},
    "rolled back": {"controller": "none", "controller.clutch_torque": "0 N*m", "road.grade": "-10 %"},
}


@pytest.mark.parametrize("status", ["launched", "stalled", "timed out"])
def test_status_with_a_sentence(status: str) -> None:
    result = bitepoint.run("dct-launch", **STATUSES[status])
    assert result.status == status
    assert len(result.reason.split()) > 3
    if status != "launched":
        assert result.metrics["launch_time"].value is None
        assert result.metrics["jerk_peak_settled"].value is None
        assert result.metrics["engine_speed_min"].value is not None


def test_rolls_back_when_the_pedal_is_let_go_on_a_hill(tmp_path: Path) -> None:
    log = tmp_path / "pedal.csv"
    rows = ["time,pedal", *(f"{0.1 * k:.1f},{25 if k < 12 else 0}" for k in range(60))]
    log.write_text("\n".join(rows) + "\n")
    settings = {"pedal": str(log), "pedal.column": "pedal", "road.grade": "15 %"}
    result = bitepoint.run("dct-launch", **settings)
    assert result.status == "rolled back"


def test_not_finite_is_a_status() -> None:
    from bitepoint.assembly import assemble
    from bitepoint.metrics import launch
    from bitepoint.simulation.run import Simulation

    assembly = assemble("dct-launch", {})
    assembly.system.plant.parameters["engine"]["inertia"] = np.nan  # what no validated file can hold
    lane = Simulation(assembly.system).run(launch)[0]
    assert lane.status == "not finite"
    assert "dct" in lane.reason


def test_none_is_open_loop() -> None:
    result = bitepoint.run("dct-launch", controller="none")
    pedal, throttle = result.recording["pedal"], result.recording["throttle"]
    assert np.abs(throttle - pedal).max() < 0.2 * 0.01 / 0.2 * 0.235 + 0.02  # one control period late at most


class TestImperfections:
    def test_default_is_perfect(self) -> None:
        names = [channel.name for channel in bitepoint.run("dct-launch").recording.channels]
        assert not [name for name in names if name.endswith(("_measured", "_actual"))]

    def test_delay_shifts_what_the_controller_sees(self) -> None:
        recording = bitepoint.run("dct-launch", delay__engine_speed="40 ms").recording
        sent, seen = recording["engine_speed"], recording["engine_speed_measured"]
        controls = np.arange(20, len(sent), 5)  # the controller reads every fifth tick
        assert seen[controls + 4 - 4] == pytest.approx(sent[controls - 20], abs=1e-12)

    def test_noise_has_its_strength_and_its_seed(self) -> None:
        runs = [bitepoint.run("dct-launch", seed=seed, noise__engine_speed=0.5).recording for seed in (1, 1, 2)]
        error = (runs[0]["engine_speed_measured"] - runs[0]["engine_speed"])[::5]
        assert 0.35 < error.std() < 0.65
        assert np.array_equal(runs[0]["engine_speed_measured"], runs[1]["engine_speed_measured"])
        assert not np.array_equal(runs[0]["engine_speed_measured"][:50], runs[2]["engine_speed_measured"][:50])

    def test_lag_is_first_order(self) -> None:
        settings = {"controller": "none", "lag.throttle": "100 ms", "timing.duration": "1 s"}
        recording = bitepoint.run("dct-launch", **settings).recording
        command, actual = recording["throttle"], recording["throttle_actual"]
        expected, state, keep = [], actual[0], np.exp(-0.002 / 0.1)
        for k in range(len(command)):
            expected.append(state)
            state = command[k] + keep * (state - command[k])
        assert actual == pytest.approx(np.array(expected), abs=1e-12)

    def test_lag_makes_the_launch_worse(self) -> None:
        lagged = bitepoint.run("dct-launch", intent="urgent", lag__throttle="0.1 s")
        assert value(lagged, "jerk_peak") > value(bitepoint.run("dct-launch", intent="urgent"), "jerk_peak")

    @pytest.mark.parametrize("key", ["lag.engine_speed", "delay.throttle", "noise.nothing"])
    def test_unknown_signals_are_refused(self, key: str) -> None:
        with pytest.raises(InputError, match="unknown signal"):
            bitepoint.run("dct-launch", **{key: 0.1})

    def test_a_delay_between_ticks_is_refused(self) -> None:
        with pytest.raises(InputError, match="multiple of the tick"):
            bitepoint.run("dct-launch", delay__engine_speed="3 ms")


class TestBatch:
    MASSES = tuple(range(1200, 2000, 40))

    def test_each_lane_is_the_run_of_its_own(self) -> None:
        batch = bitepoint.run_batch("dct-launch", {"vehicle.mass": self.MASSES}, record=[3, 17])
        assert sorted(batch.recordings) == [3, 17]
        for lane in (3, 17):
            single = bitepoint.run("dct-launch", vehicle__mass=self.MASSES[lane])
            assert np.array_equal(batch.recordings[lane].data, single.recording.data)
            for name, metric in single.metrics.items():
                assert batch.metrics[name][lane] == metric.value, name

    def test_threads_and_chunks_change_nothing(self, monkeypatch: pytest.MonkeyPatch) -> None:
        over = {"vehicle.mass": self.MASSES, "road.grade": np.linspace(0.0, 0.2, 20)}
        settings = {"noise.engine_speed": 0.3}
        whole = bitepoint.run_batch("dct-launch", over, seed=4, threads=1, **settings)
        monkeypatch.setattr("bitepoint.simulation.run.CHUNK_BYTES", 3_000_000)
        counted: list[int] = []
        pieces = bitepoint.run_batch("dct-launch", over, seed=4, threads=3, progress=counted.append, **settings)
        assert sum(counted) == 20
        assert len(counted) > 3
        assert whole.status == pieces.status
        for name in whole.metrics:
            assert np.array_equal(whole.metrics[name], pieces.metrics[name], equal_nan=True), name

    def test_calibrations_can_differ_too(self) -> None:
        batch = bitepoint.run_batch("dct-launch", {"controller.touch_delay": [0.2, 0.28, 0.4]})
        assert np.all(np.diff(batch.metrics["launch_time"]) > 0.0)

    def test_a_failing_lane_has_a_status_and_no_figures(self) -> None:
        over = {"clutch.friction_gain": [1.0, 0.1]}
        batch = bitepoint.run_batch("dct-launch", over, road__grade="30 %", timing__duration="3 s")
        assert batch.status[1] == "timed out"
        assert np.isnan(batch.metrics["launch_time"][1])

    def test_memory_does_not_grow_with_the_lanes(self) -> None:
        from bitepoint.assembly import assemble
        from bitepoint.simulation.run import CHUNK_BYTES, Simulation, _Workspace  # pyright: ignore

        simulation = Simulation(assemble("dct-launch", {}).system)
        chunk = max(1, CHUNK_BYTES // simulation._recording_bytes())  # pyright: ignore
        assert _Workspace(simulation, chunk).recording.nbytes <= CHUNK_BYTES

    @pytest.mark.parametrize(
        ("over", "message"),
        [
            ({"vehicle.mass": [1500, 1600], "road.grade": [0.0]}, "as many values"),
            ({"vehicle.mass": []}, "as many values"),
            ({"intent": ["slow"]}, "cannot differ"),
            ({"vehicle.mass": [1500, "-3 kg"]}, "vehicle.mass"),
            ({"nothing.mass": [1500]}, "unknown group"),
        ],
    )
    def test_bad_lanes_are_refused(self, over: dict[str, list[object]], message: str) -> None:
        with pytest.raises(InputError, match=message):
            bitepoint.run_batch("dct-launch", over)


def test_interpreted_life_gives_the_same_launch() -> None:
    settings = {"timing.duration": "0.3 s"}
    compiled = bitepoint.run("dct-launch", **settings)
    interpreted = bitepoint.run("dct-launch", life="interpreted", **settings)
    assert np.array_equal(compiled.recording.data, interpreted.recording.data)


def test_controller_stays_designed_on_the_library_vehicle() -> None:
    from bitepoint.assembly import assemble

    changed = assemble("dct-launch", {"engine.idle_speed": "90 rad/s", "clutch.torque_limit": "100 N*m"})
    library = assemble("dct-launch", {})
    assert changed.system.controllers[0].parameters == library.system.controllers[0].parameters
    assert changed.system.plant.parameters["clutch"]["torque_limit"][0] == 100.0


def test_figure_has_axes_with_units() -> None:
    figure = bitepoint.run("dct-launch").figure()
    titles = [axis.title.text for axis in figure.select_yaxes()]
    assert titles == ["speed, rpm", "torque, N m", "opening, %", "speed, km/h", "jerk, m/s³; acceleration, m/s²"]
    assert [axis.title.text for axis in figure.select_xaxes()][-1] == "time, s"
    assert len(figure.data) >= 9


def lifted(tmp_path: Path, *settings: tuple[str, str]) -> Result:
    """The driver lifts the pedal from 31 to 10 % while the clutch slips."""
    log = tmp_path / "lift.csv"
    log.write_text("time,p\n0,0\n0.2,31\n0.9,31\n1.0,10\n6,10\n")
    return bitepoint.run("dct-launch", {"pedal": str(log), "pedal.column": "p", **dict(settings)})


def test_lifting_the_pedal_never_makes_the_clutch_grip_harder(tmp_path: Path) -> None:
    recording = lifted(tmp_path).recording
    command, phase = recording["clutch_torque_command"], recording["launch_phase"]
    at_lift = command[np.searchsorted(recording.time, 0.9)]
    slipping = (recording.time > 0.9) & (phase == 1.0)
    assert command[slipping].max() < at_lift + 40.0  # what the pedal still asks for until it is down


def test_figures_do_not_depend_on_the_tick_at_all() -> None:
    times = [value(bitepoint.run("dct-launch", timing__tick=tick), "launch_time") for tick in ("10 ms", "2 ms", "1 ms")]
    assert times == pytest.approx([times[0]] * 3, abs=2e-4)


def test_more_lanes_than_parameters_are_refused() -> None:
    from bitepoint.assembly import assemble
    from bitepoint.metrics import launch
    from bitepoint.simulation.run import Simulation

    simulation = Simulation(assemble("dct-launch", {}, {"vehicle.mass": [1500, 1600]}).system)
    with pytest.raises(ValueError, match="parameters for 2 lanes"):
        simulation.run(launch, lanes=8)


@pytest.mark.parametrize("option", [{"seed": -1}, {"seed": 1.5}, {"life": "Compiled"}])
def test_odd_options_are_refused(option: dict[str, object]) -> None:
    with pytest.raises(InputError):
        bitepoint.run("dct-launch", **option)  # pyright: ignore


def test_launched_marks_the_lanes_that_count() -> None:
    over = {"clutch.friction_gain": [1.0, 0.1]}
    batch = bitepoint.run_batch("dct-launch", over, {"road.grade": "30 %", "timing.duration": "3 s"})
    assert batch.launched.tolist() == [batch.status[0] == "launched", False]
    assert "lanes" not in repr(batch)
    assert len(repr(batch)) < 200
