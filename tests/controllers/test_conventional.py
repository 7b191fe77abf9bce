"""Driver and transmission control of a conventional vehicle: launches, shifts, no stall, frozen drivers, plans."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.controllers import pedal_driver
from bitepoint.controllers.amt_control import CLOSING, DRIVING, LAUNCHING, RELEASING, SHIFTING
from bitepoint.controllers.plan_table import plan_parameters, planned_gear, planned_speed, planned_torque
from bitepoint.recording import Floats, Recording
from bitepoint.records import RecordArray
from bitepoint.simulation.run import Simulation
from tests.conftest import Refused
from tests.tolerances import ENERGY_TIGHT

FROZEN = ("eco", "mid", "typical", "late")


@cache
def launched(driver: str) -> Any:
    """The launch of a frozen driver, the baseline of a planned one; it and its figures are not changed."""
    assembly = assemble("eco-launch", {"baseline": driver})
    return Simulation(replace(assembly.system, controllers=assembly.baseline)).run(assembly.figures)[0]


@pytest.mark.parametrize("driver", FROZEN)
def test_frozen_drivers_arrive_as_page_5_has_it(driver: str) -> None:
    """13.5 to 15.3 g and 12.5 to 15 s there, without shifts that take time; late is chosen here."""
    figures = {name: metric.value for name, metric in launched(driver).figures.items()}
    assert launched(driver).status == "arrived"
    assert 0.0135 < figures["fuel_used"] < 0.0165
    assert 12.5 < figures["drive_time"] < 15.0
    assert abs(figures["end_speed_error"]) < 0.2
    assert figures["energy_residual"] < ENERGY_TIGHT


def test_the_later_the_shift_the_more_fuel() -> None:
    fuel = [launched(driver).figures["fuel_used"].value for driver in FROZEN]
    assert fuel == sorted(fuel)
    assert fuel[2] > 1.1 * fuel[0]


def phases(recording: Recording, phase: int) -> list[slice]:
    """The rows of each stretch of a phase."""
    inside = np.concatenate([[False], recording["shift_phase"] == phase, [False]])
    edges = np.flatnonzero(np.diff(inside.astype(int)))
    return [slice(a, b) for a, b in edges.reshape(-1, 2)]


@pytest.mark.parametrize("driver", FROZEN)
def test_shifts(driver: str) -> None:
    """From the cut of the torque until 40 % of it are back at the wheels: 0.3 to 0.5 s, without a blow."""
    recording: Recording = launched(driver).recording
    shaft, engine = recording["halfshaft_torque"], recording["engine_speed"]
    shifts = phases(recording, RELEASING)
    assert len(shifts) == launched(driver).figures["gear_changes"].value
    for shift, neutral, closing in zip(shifts, phases(recording, SHIFTING), phases(recording, CLOSING), strict=True):
        before = shaft[shift.start]
        back = neutral.stop + int(np.argmax(shaft[neutral.stop :] > 0.4 * before))
        assert 0.3 < (back - shift.start) * 0.01 < 0.5
        assert 0.1 <= (closing.stop - closing.start) * 0.01 < 0.5
        assert recording["clutch_torque_command"][neutral].max() == 0.0
        assert engine[shift.start : closing.stop].max() < engine[shift.start] + 15.0  # hardly a flare
        assert shaft[closing].max() < 1.4 * before + 100.0


def test_the_clutch_launches_at_the_launch_speed_and_locks() -> None:
    recording: Recording = launched("eco").recording
    launch = phases(recording, LAUNCHING)[0]
    assert launch.start == 0
    assert recording["engine_speed"][launch] == pytest.approx(125.7, abs=6.0)
    locked = recording["shift_phase"] == DRIVING
    assert np.abs(recording["slip_speed"][locked][20:]).max() < 10.0


@pytest.mark.parametrize("vehicle", ["hatchback-2l", "light-truck"])
@pytest.mark.parametrize("grade", ["0 %", "12 %"])
def test_moves_off_from_standstill_and_never_stalls(vehicle: str, grade: str) -> None:
    settings = {"vehicle": vehicle, "road.grade": grade, "timing.duration": "12 s", "pedal_driver.calibration": "mid"}
    recording = bitepoint.run("conventional-nedc", settings).recording
    assert bitepoint.run("conventional-nedc", {**settings, "timing.duration": "40 s"}).status == "completed"
    assert recording["engine_speed"].min() > 50.0


def test_stops_and_holds_and_goes_again() -> None:
    run = bitepoint.run("conventional-nedc", {"timing.duration": "130 s"})
    recording = run.recording
    standing = recording["speed_target"] < 0.01
    settled = standing & (recording["vehicle_speed"] < 0.05)
    assert settled.sum() > 0.8 * standing.sum()
    assert recording["clutch_torque_command"][settled][50:].max() < 30.0
    assert run.metrics["within_tolerance"].value == 1.0


def test_the_driver_does_not_wind_up() -> None:
    """A target that cannot be reached for long, then one below the speed: the throttle goes at once."""
    controller = pedal_driver.CONTROLLER
    assembly = assemble("eco-launch", {"pedal_driver.calibration": "eco"})
    part = next(part for part in assembly.baseline if part.name == "pedal_driver")
    s, m, c = (record.zeros() for record in (controller.state, controller.measurement, controller.command))
    m["gear"], m["engine_speed"], m["vehicle_speed"], m["speed_target"] = 3.0, 200.0, 10.0, 40.0
    controller.init.run(part.parameters, s, m, c)
    for _ in range(3000):
        controller.step.run(part.parameters, s, m, c, 0.01)
    assert c["throttle"][0] == pytest.approx(0.7)
    m["speed_target"] = 9.0
    controller.step.run(part.parameters, s, m, c, 0.01)
    assert c["throttle"][0] == 0.0


def simple_plan(points: int = 151) -> tuple[Floats, Floats, Floats, Floats]:
    """A launch with constant acceleration in second gear, then third, with the torque that it takes."""
    s = np.linspace(0.0, 150.0, points)
    v = np.sqrt((5.0 / 3.6) ** 2 + 2.0 * 0.6 * s)
    gear = np.where(v < 6.0, 1.0, np.where(v < 10.0, 2.0, 3.0))
    ratio = np.array([3.917, 2.429, 1.436])[gear.astype(int) - 1] * 4.06
    force = (1474.0 + 3.6 / 0.317**2) * 0.6 + 1474.0 * 9.80665 * 0.0095 + 0.5 * 1.206 * 0.6667 * v**2
    torque = force * 0.317 / (ratio * 0.92) + 0.195 * 0.6 * ratio / 0.317
    return s, v, gear, torque


def driven(plan: RecordArray, **settings: Any) -> Any:
    """The run of a plan."""
    assembly = assemble("eco-launch", settings)
    change: Callable[[Any], Any] = lambda part: (  # noqa: E731
        replace(part, parameters=pedal_driver.with_plan(part.parameters, plan)) if part.name == "pedal_driver" else part
    )
    system = replace(assembly.system, controllers=[change(part) for part in assembly.system.controllers])
    return Simulation(system).run(assembly.figures)[0]


def test_a_plan_is_driven_with_its_gears_at_its_speed() -> None:
    s, v, gear, torque = simple_plan()
    lane = driven(plan_parameters(s, v, gear, torque))
    recording = lane.recording
    wanted = np.interp(recording["distance"], s, v)
    assert lane.status == "arrived"
    assert recording["speed_wanted"] == pytest.approx(wanted, abs=0.05)
    assert np.abs(recording["vehicle_speed"] - wanted).max() < 0.7
    assert lane.figures["gear_changes"].value == 2.0
    planned = float(np.sum(2.0 * np.diff(s) / (v[1:] + v[:-1])))
    assert lane.figures["drive_time"].value == pytest.approx(planned, rel=0.03)
    for number in (2, 3):
        planned_at = s[np.flatnonzero(gear == number)[0]]
        shifted = recording["distance"][np.flatnonzero(recording["gear"] == number)[0]]
        assert abs(shifted - planned_at) < 3.0


def test_table_of_a_plan() -> None:
    table = plan_parameters([0.0, 10.0, 20.0], [1.0, 3.0, 3.0], [1.0, 2.0], [50.0, 60.0])
    assert (table["points"][0], table["spacing"][0]) == (3, 10.0)
    places = np.array([-5.0, 0.0, 5.0, 9.99, 10.0, 15.0, 25.0])
    tables = np.repeat(table, len(places))
    assert planned_speed.run(tables, places) == pytest.approx([1, 1, np.sqrt(5.0), 2.9987, 3, 3, 3], abs=1e-3)
    assert planned_gear.run(tables, places).tolist() == [1, 1, 1, 1, 2, 2, 2]
    assert planned_torque.run(tables, places).tolist() == [50, 50, 50, 50, 60, 60, 60]


def test_a_plan_of_many_points_is_told_by_as_many_as_fit() -> None:
    way = np.linspace(0.0, 20_000.0, 5001)
    speed = 20.0 + np.sin(way / 500.0)
    table = plan_parameters(way, speed, np.full(5001, 6.0), np.full(5001, 100.0))
    assert table["points"][0] == 1024
    at = np.arange(1024) * table["spacing"][0]
    assert table["speed"][0] == pytest.approx(20.0 + np.sin(at / 500.0), abs=1e-3)


@pytest.mark.parametrize(
    "columns",
    [
        ([0.0], [1.0], [1.0], [1.0]),
        ([0.0, 1.0], [1.0], [1.0, 1.0], [1.0, 1.0]),
        ([0.0, 0.0], [1.0, 1.0], [1.0, 1.0], [1.0, 1.0]),
        ([0.0, 1.0], [1.0, 1.0], [1.0, 9.0], [1.0, 1.0]),
        ([0.0, 1.0], [1.0, np.nan], [1.0, 1.0], [1.0, 1.0]),
    ],
)
def test_a_plan_that_is_none_is_refused(columns: tuple[list[float], ...], refused: Refused) -> None:
    refused(lambda: plan_parameters(*columns), "plan", "expected")
