"""The physical optimum of a launch: against published figures, a certificate, another method, and the plant."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint import metrics
from bitepoint.assembly import assemble
from bitepoint.models.launch_vehicle import LaunchVehicle
from bitepoint.planning.bounds import ENGINE_TORQUE_RATE, Bound, least_friction_work, least_time
from bitepoint.planning.bounds_program import load_casadi, program
from tests.conftest import Command, Refused
from tests.planning.reduced import clutch_profiles, least_work
from tests.planning.replay import replay
from tests.tolerances import (
    BOUND_MESH,
    BOUND_ON_PLANT,
    BOUND_PUBLISHED_TIME,
    BOUND_PUBLISHED_WORK,
    BOUND_RASTER,
    BOUND_WITH_SHAFTS,
    CERTIFICATE,
)

TASKS = {"slow": (1.52, 1.77, 3.3), "normal": (1.29, 2.72, 7.3), "urgent": (1.23, 3.47, 10.0)}
"""Launch time, end speed and jerk of the predictive controller of Yang et al. 2020, table 3."""

PUBLISHED = {"slow": (2747.0, 1.10), "normal": (2644.0, 0.95), "urgent": (2759.0, 0.95)}
"""Least friction work, J, at these; and least time, s, at the end speed and the jerk: computed elsewhere."""

INTENTS = tuple(TASKS)


@cache
def vehicle(*settings: tuple[str, str]) -> LaunchVehicle:
    return LaunchVehicle.of(assemble("dct-launch", dict(settings)).system.plant.parameters)


STEEP = (("road.grade", "10 %"), ("vehicle.mass", "1900 kg"))


@cache
def least(intent: str) -> Bound:
    return least_friction_work(vehicle(), *TASKS[intent])


@cache
def fastest(intent: str) -> Bound:
    return least_time(vehicle(), TASKS[intent][2], TASKS[intent][1])


def integral(bound: Bound, values: Any) -> float:
    return float(np.trapezoid(values, bound.time))


@pytest.mark.parametrize("intent", INTENTS)
def test_reproduces_the_published_bounds(intent: str) -> None:
    work, time = PUBLISHED[intent]
    assert least(intent).friction_work == pytest.approx(work, rel=BOUND_PUBLISHED_WORK)
    assert fastest(intent).launch_time == pytest.approx(time, rel=BOUND_PUBLISHED_TIME)


@pytest.mark.parametrize("bound", [least, fastest])
@pytest.mark.parametrize("intent", INTENTS)
def test_keeps_every_limit(intent: str, bound: Any) -> None:
    found, car, (_, end_speed, jerk) = bound(intent), vehicle(), TASKS[intent]
    step = np.diff(found.time)
    assert step.min() > 0.0
    assert np.abs(np.diff(found.clutch_torque) / step).max() <= 750.0 * (1 + 1e-6)
    assert np.abs(np.diff(found.engine_torque) / step).max() <= ENGINE_TORQUE_RATE * (1 + 1e-6)
    assert np.abs(np.diff(found.acceleration) / step).max() <= jerk * (1 + 1e-6)
    assert found.clutch_torque.min() >= -1e-9
    assert found.clutch_torque.max() <= 280.0
    assert found.engine_speed.min() >= car.idle_speed - 1e-6
    assert (found.engine_speed - found.clutch_speed).min() >= -1e-6
    for sign, limits in ((1.0, car.highest_torque), (-1.0, car.lowest_torque)):
        allowed = np.interp(found.engine_speed, car.engine_speeds, limits)
        assert (sign * (found.engine_torque - allowed)).max() < 0.15  # N m: corners are rounded
    assert found.end_speed == pytest.approx(end_speed)
    assert found.engine_speed[-1] == pytest.approx(found.clutch_speed[-1])
    engine = (found.engine_torque - found.clutch_torque - 0.02 * found.engine_speed)[-1] / car.model.engine_inertia
    assert engine * car.model.metres_per_radian == pytest.approx(found.acceleration[-1], abs=1e-5)


@pytest.mark.parametrize("intent", INTENTS)
def test_fulfils_the_conditions_of_optimality(intent: str) -> None:
    """Karush, Kuhn and Tucker: computed from the programme's derivatives, not taken from the solver's word."""
    casadi, search = load_casadi(), program(vehicle(), ENGINE_TORQUE_RATE, 60)
    time, end_speed, jerk = TASKS[intent]
    lower, upper = search.lower.copy(), search.upper.copy()
    upper[-2], lower[-1], upper[-1] = time, end_speed, end_speed
    weights = [jerk, 1e-3, 0.0, 1e-3]
    start, (low, high) = search.guess(0.9 * time, 0.01, end_speed), search.variables
    found = search.solver(x0=start, p=weights, lbx=low, ubx=high, lbg=lower, ubg=upper)
    x, p = casadi.MX.sym("x", low.size), casadi.MX.sym("p", 4)
    objective, constraints = search.solver.oracle()(x, p)
    slopes = casadi.Function("slopes", [x, p], [casadi.gradient(objective, x), casadi.jacobian(constraints, x)])
    gradient, jacobian = slopes(found["x"], weights)
    assert np.abs(np.array(gradient + jacobian.T @ found["lam_g"] + found["lam_x"])).max() < 1e-6
    for value, force, least_value, most in (("x", "lam_x", low, high), ("g", "lam_g", lower, upper)):
        at, push = np.array(found[value]).ravel(), np.array(found[force]).ravel()
        assert max((least_value - at).max(), (at - most).max()) < 1e-7
        room = np.where(push > 0.0, most - at, at - least_value)
        assert np.abs(np.where(push == 0.0, 0.0, push * np.where(np.isfinite(room), room, 1.0))).max() < 1e-6


@pytest.mark.parametrize("settings", [(), STEEP])
def test_friction_work_is_what_the_energy_balance_leaves(settings: tuple[tuple[str, str], ...]) -> None:
    """Engine work is heat, gear loss, engine friction, resistance and kinetic energy; and so is the impulse shared."""
    car = vehicle(*settings)
    found, model = least_friction_work(car, 1.5, 2.4, 6.0), car.model
    load = car.grade_torque + car.rolling_torque + car.air_coefficient * (found.clutch_speed / model.ratio) ** 2
    engine, clutch = found.engine_speed, found.clutch_speed
    drive = integral(found, (found.engine_torque - model.engine_friction * engine) * engine)
    spun_up = 0.5 * model.engine_inertia * (engine[-1] ** 2 - engine[0] ** 2)
    driven = (0.5 * model.inertia * clutch[-1] ** 2 + integral(found, load / model.ratio * clutch)) / model.efficiency
    assert drive - spun_up - driven == pytest.approx(found.friction_work, rel=BOUND_RASTER)
    moving = found.clutch_speed > 1e-6
    resisting = integral(found, np.where(moving, load / model.ratio, model.efficiency * found.clutch_torque))
    impulse = (model.inertia * clutch[-1] + resisting) / model.efficiency
    assert integral(found, found.clutch_torque) == pytest.approx(impulse, rel=BOUND_RASTER)


def certificate(car: LaunchVehicle, jerk: float) -> float:
    """Return a friction work, J, that no launch on a road with a load can undercut, whatever its time and end speed.

    The engine is never below idle, w0, nor below the clutch, so W >= integral of Tc max(w0 - wc, 0) dt; with
    eta Tc = J dwc/dt + load, the first part is J w0^2 / (2 eta), and the second is least for the fastest run-up to w0
    that the jerk allows. Before that, the torque rises to the load at the clutch's rate.
    """
    model, idle, release = car.model, car.idle_speed, car.release_torque
    run_up = np.sqrt(2.0 * idle * model.metres_per_radian / jerk)
    held = 0.5 * release**2 / model.torque_rate_limit * idle
    return 0.5 * model.inertia / model.efficiency * idle**2 + release * 2.0 / 3.0 * idle * run_up + held


@pytest.mark.parametrize("intent", INTENTS)
def test_nothing_is_below_the_certificate_and_a_late_launch_comes_close(intent: str) -> None:
    _, end_speed, jerk = TASKS[intent]
    floor = certificate(vehicle(), jerk)
    late = least_friction_work(vehicle(), 2.0, end_speed, jerk).friction_work
    assert floor < late < floor * (1.0 + CERTIFICATE)
    assert floor < least(intent).friction_work < 1.06 * floor
    assert fastest(intent).friction_work > floor


@pytest.mark.parametrize("intent", INTENTS)
def test_twice_the_intervals_change_next_to_nothing(intent: str) -> None:
    fine = least_friction_work(vehicle(), *TASKS[intent], intervals=120)
    assert fine.friction_work == pytest.approx(least(intent).friction_work, rel=BOUND_MESH)
    time = least_time(vehicle(), TASKS[intent][2], TASKS[intent][1], intervals=120).launch_time
    assert time == pytest.approx(fastest(intent).launch_time, rel=BOUND_MESH)


@pytest.mark.parametrize(
    ("intent", "time", "worst"), [("slow", 1.13, 1.002), ("normal", 1.29, 1.002), ("urgent", 1.23, 1.3)]
)
def test_a_linear_programme_for_each_of_many_clutch_torques_is_never_better(
    intent: str, time: float, worst: float
) -> None:
    _, end_speed, jerk = TASKS[intent]
    bound = least_friction_work(vehicle(), time, end_speed, jerk).friction_work
    works = [
        least_work(vehicle(), c, time, ENGINE_TORQUE_RATE) for c in clutch_profiles(vehicle(), time, end_speed, jerk)
    ]
    found = [work for work in works if work is not None]
    assert len(found) > 20
    assert bound * (1.0 - BOUND_RASTER) < min(found) < bound * worst


@pytest.mark.parametrize("intent", ["slow", "normal"])
def test_the_engine_of_the_optimum_is_that_of_a_linear_programme(intent: str) -> None:
    bound = least(intent)
    first = int(np.flatnonzero(bound.clutch_torque >= vehicle().release_torque - 1e-6)[0])
    start, end = bound.time[first], bound.time[-1]
    raster = np.linspace(start, end, round((end - start) / 0.005) + 1)
    clutch = np.interp(raster, bound.time, bound.clutch_torque)
    held = vehicle().release_torque / 750.0
    work = least_work(vehicle(), clutch, end - start + held, ENGINE_TORQUE_RATE)
    assert work == pytest.approx(bound.friction_work, rel=BOUND_RASTER)


def test_more_time_or_less_smoothness_never_cost_work() -> None:
    works = [least_friction_work(vehicle(), time, 2.72, 7.3).friction_work for time in (0.95, 1.1, 3.0)]
    assert all(after < before * (1 + BOUND_MESH) for before, after in pairwise(works))
    assert works[0] > 1.7 * works[-1]
    smooth, rough = (least_friction_work(vehicle(), 1.2, 2.72, jerk).friction_work for jerk in (6.0, 9.0))
    assert rough < smooth
    slow, quick = (least_time(vehicle(), 10.0, 3.47, engine_torque_rate=rate).launch_time for rate in (400.0, 800.0))
    assert quick < 0.95 * slow


def test_a_free_end_speed_is_that_of_an_engine_at_idle() -> None:
    free = least_time(vehicle(), 7.3)
    assert free.launch_time < fastest("normal").launch_time
    assert free.end_speed >= 83.0 * vehicle().model.metres_per_radian - 1e-6
    assert free.end_speed < 1.75


@pytest.mark.parametrize(
    ("settings", "task"),
    [((), TASKS["slow"]), ((), (0.95, 2.72, 7.3)), ((), (0.95, 3.47, 10.0)), (STEEP, (1.45, 2.5, 6.0))],
)
def test_the_plant_does_what_the_optimum_says(
    settings: tuple[tuple[str, str], ...], task: tuple[float, float, float]
) -> None:
    """Open loop. The rigid model does not know the work that winds up the shafts; with it, the books agree."""
    bound = least_friction_work(vehicle(*settings), *task)
    played = replay(bound, dict(settings))
    figures = metrics.launch(played)
    work, sync = figures["friction_work"].value, metrics.sync_time(played, 0.0)
    assert work is not None
    assert work == pytest.approx(bound.friction_work, rel=BOUND_ON_PLANT)
    ahead = played["clutch_speed"] - vehicle().model.ratio * played["wheel_speed"]
    slipping = played.time <= sync
    winding = np.trapezoid((played["clutch_torque"] * ahead)[slipping], played.time[slipping])
    assert work + winding == pytest.approx(bound.friction_work, rel=BOUND_WITH_SHAFTS)
    at_end = {name: float(np.interp(task[0], played.time, played[name])) for name in ("vehicle_speed", "slip_speed")}
    assert at_end["vehicle_speed"] == pytest.approx(task[1], rel=BOUND_ON_PLANT)
    assert abs(at_end["slip_speed"]) < 5.0


class TestStatuses:
    def test_too_little_time(self) -> None:
        bound = least_friction_work(vehicle(), 0.85, 2.72, 7.3)
        assert (bound.status, bound.optimal, bound.time.size) == ("infeasible", False, 0)
        assert np.isnan(bound.friction_work)
        assert "0.92" in bound.reason

    def test_an_end_speed_below_idle(self) -> None:
        bound = least_friction_work(vehicle(), 1.5, 1.5, 7.3)
        assert (bound.status, "1.65 m/s" in bound.reason) == ("infeasible", True)

    def test_waiting_is_shown(self) -> None:
        bound = least("slow")
        assert 0.3 < bound.waiting < 0.45
        assert bound.time[0] == 0.0
        assert bound.clutch_torque[bound.time <= bound.waiting].max() < 1e-6

    def test_downhill_nobody_waits(self) -> None:
        down = vehicle(("road.grade", "-10 %"))
        assert down.rolls_off
        assert down.release_torque == 0.0
        bound = least_friction_work(down, 1.8, 2.0, 5.0)
        assert bound.waiting == pytest.approx(0.0, abs=1e-6)
        assert bound.friction_work < 0.1 * least("normal").friction_work
        assert least_friction_work(down, 4.0, 2.0, 5.0).status == "infeasible"  # too fast by then

    @pytest.mark.parametrize("figures", [(0.0, 2.0, 5.0), (1.5, -2.0, 5.0), (1.5, 2.0, float("nan"))])
    def test_figures_that_are_none_are_refused(self, refused: Refused, figures: tuple[float, float, float]) -> None:
        refused(lambda: least_friction_work(vehicle(), *figures), "bounds", "above 0")


class TestBoundRatio:
    def test_is_work_over_least_work_of_the_run_s_own_vehicle(self) -> None:
        result = bitepoint.run("dct-launch", {"report.bound": "true", **dict(STEEP)})
        time, work, speed, jerk = (
            result.metrics[name].value or 0.0 for name in ("launch_time", "friction_work", "end_speed", "jerk_peak")
        )
        least_here = least_friction_work(vehicle(*STEEP), time, speed, jerk).friction_work
        assert result.metrics["bound_ratio"] == metrics.Metric(work / least_here, "1")
        assert 1.0 < work / least_here < 5.0

    def test_is_not_there_unless_asked_for(self) -> None:
        assert "bound_ratio" not in bitepoint.run("dct-launch").metrics
        assert "bound_ratio" not in bitepoint.run("dct-launch", report__bound=False).metrics

    def test_a_launch_that_was_none_says_why(self, bitepoint: Command) -> None:
        arguments = ("run", "dct-launch", "--set", "timing.duration=1 s", "--set", "report.bound=true")
        assert "bound_ratio          – (not launched)" in bitepoint(*arguments).out
        assert (
            '"bound_ratio": {"value": null, "unit": "1", "reason": "not launched"}'
            in bitepoint(*arguments, "--json").out
        )

    def test_without_casadi_nothing_is_run(self, bitepoint: Command, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setitem(sys.modules, "casadi", None)
        bitepoint("run", "dct-launch", "--set", "report.bound=true").refusal("CasADi", "bitepoint[bounds]")
        assert bitepoint("run", "dct-launch").status == 0

    @pytest.mark.parametrize("setting", ["report.bound=perhaps", "report.bond=true"])
    def test_odd_settings_are_refused(self, bitepoint: Command, setting: str) -> None:
        bitepoint("run", "dct-launch", "--set", setting).refusal("report.")

    def test_not_for_a_batch(self, refused: Refused) -> None:
        over = {"vehicle.mass": [1500, 1600]}
        refused(lambda: bitepoint.run_batch("dct-launch", over, report__bound=True), "report.bound", "batch")


class TestVehicle:
    def test_torque_range_is_that_of_the_engine(self) -> None:
        from bitepoint.parts.engine import engine_torque, throttle_effect

        engine = assemble("dct-launch", {}).system.plant.parameters["engine"].copy()
        speeds = np.random.default_rng(1).uniform(83.0, 620.0, 200)
        for throttle, known in ((0.0, vehicle().lowest_torque), (1.0, vehicle().highest_torque)):
            effect = throttle_effect.run(engine, throttle)
            torque = engine_torque.run(engine, effect, speeds)
            assert np.abs(np.interp(speeds, vehicle().engine_speeds, known) - torque).max() < 0.5

    def test_vehicle_is_released_where_the_plant_releases_it(self) -> None:
        recording = bitepoint.run("dct-launch", dict(STEEP), controller="none").recording
        released = recording["clutch_torque"][int(np.flatnonzero(recording["vehicle_held"] < 0.5)[0])]
        assert released == pytest.approx(vehicle(*STEEP).release_torque, rel=0.06)  # the shafts wind up first

    def test_a_worn_clutch_is_what_the_bound_knows(self) -> None:
        worn = vehicle(("clutch.friction_gain", "0.5"))
        assert (worn.model.torque_limit, worn.model.torque_rate_limit) == (140.0, 375.0)
        assert replace(worn, model=vehicle().model) == vehicle()


def test_casadi_is_imported_by_no_run_without_bounds() -> None:
    import subprocess

    code = "import sys, bitepoint; bitepoint.run('dct-launch'); sys.exit('casadi' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    assert load_casadi().__name__ == "casadi"
