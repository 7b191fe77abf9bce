"""Puts the parts of the reproduction together: rows, notes and pictures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bitepoint.api import FuelIdentification
from bitepoint.assembly import PLANTS
from bitepoint.models.longitudinal import LongitudinalModel
from bitepoint.planning.shift_schedule import ShiftSchedule, economy_schedule
from bitepoint.records import RecordArray
from bitepoint.report.eco_launch import (
    cruise_figure,
    euler_figure,
    front_figure,
    hills_figure,
    launch_figure,
    savings_figure,
)
from bitepoint.report.fuel import fit_figure
from bitepoint.report.shift_schedule import shift_schedule_figure
from bitepoint.scenarios import load_scenario
from bitepoint.studies.eco_launch.cruise import Cruises, cruise_rows, cruises
from bitepoint.studies.eco_launch.fuel import filter_rows, fitted, fuel_rows
from bitepoint.studies.eco_launch.launches import (
    BASELINES,
    PUBLISHED_SAVING,
    SCENARIO,
    Launches,
    launches,
    saving_rows,
    sensitivity_rows,
)
from bitepoint.studies.eco_launch.notes import NOTES
from bitepoint.studies.eco_launch.plans import (
    FRONT,
    Discretised,
    Plans,
    discretised,
    euler_rows,
    plan_rows,
    plans,
    schedule_rows,
)
from bitepoint.studies.reproduction import Reproduction
from bitepoint.vehicles import load_vehicle

NAME = "eco-launch"
SOURCE = (
    "the paper on the cheapest launch of an intelligent car by dynamic programming (004 of the sources; its equations "
    "and most of its parameters are lost pictures)"
)

DRAWN = "typical"
"""Driver beside whom plans are drawn."""


def reproduce(progress: Callable[[str], object]) -> Reproduction:
    """Return the paper's figures beside ours: the saving as it reckons and as is fair; what it cannot have right."""
    progress("fuel model")
    model = vehicle_model()
    fit = fitted()
    rows = [*fuel_rows(fit), *filter_rows()]
    progress("schedule and plans")
    schedule = economy_schedule(model)
    rows += schedule_rows(model, schedule)
    found = plans(model)
    rows += plan_rows(found)
    progress("launches")
    driven = {name: launches(name) for name in BASELINES}
    rows += saving_rows(driven)
    progress("cost of shifts, late drivers")
    rows += sensitivity_rows()
    progress("the paper's programme")
    steps = discretised(model)
    rows += euler_rows(steps, found.bound)
    progress("hills")
    hills = cruises()
    rows += cruise_rows(hills)
    return Reproduction(NAME, SOURCE, rows, NOTES, _figures(fit, schedule, found, driven, steps, hills))


def vehicle_model() -> RecordArray:
    """Return the vehicle of the scenario in balance."""
    scenario = load_scenario(SCENARIO)
    vehicle = load_vehicle(scenario.vehicle)
    blocks = {**vehicle.blocks, "road": scenario.road, "start": scenario.start}
    return LongitudinalModel.of(PLANTS[vehicle.plant].parameters.parse(blocks, vehicle.where))


def _figures(
    fit: FuelIdentification | None, schedule: ShiftSchedule, found: Plans, driven: dict[str, Launches],
    steps: Discretised, hills: Cruises,
) -> dict[str, Any]:  # fmt: skip
    each = driven[DRAWN]
    drawn = {f"{DRAWN} driver": each.driver, "plan of equal time": each.equal, "cheapest plan": each.cheapest}
    pictures: dict[str, Any] = {}
    if fit is not None:
        pictures["Fuel model: US06, which it never saw"] = fit_figure(fit)
    pictures["Economical shift schedule"] = shift_schedule_figure(schedule, "")
    pictures["Launches, as driven on the plant"] = launch_figure({k: v.recording for k, v in drawn.items()})
    free = {time: timed.fuel for time, timed in found.free.items()}
    pairs = {name: (one.driver, one.equal) for name, one in driven.items()}
    points = {name: ((one.time, one.fuel), (two.time, two.fuel)) for name, (one, two) in pairs.items()}
    pictures["Fuel against time"] = front_figure(found.front, FRONT, free, points, found.bound)
    savings = {
        name: (one.value("fuel_saving_raw"), one.raw_saving, one.value("fuel_saving_equal_time"))
        for name, one in driven.items()
    }
    pictures["Saving against four drivers"] = savings_figure(savings, PUBLISHED_SAVING)
    fuels = {"the paper's programme": steps.euler, "exact steps on the same speeds": steps.exact}
    promised = {name: {step: plan.fuel for step, plan in made.items()} for name, made in fuels.items()}
    pictures["What the paper's steps do"] = euler_figure(steps.errors, promised, found.bound)
    runs = {"driver who holds the set speed": hills.driver.recording, "plan": hills.planned.recording}
    pictures["Beyond: a light truck on hills"] = hills_figure(runs)
    saved = {grade: (one.saving, hills.spared(grade)) for grade, one in hills.roads.items()}
    pictures["Beyond: saving over how steep the road is"] = cruise_figure(saved)
    return pictures
