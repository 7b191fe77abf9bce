"""Every library scenario, with every controller and intent that fits it, is the same run in every life."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from bitepoint.assembly import CONTROLLERS, PLANTS, assemble
from bitepoint.export.c.driving import drive
from bitepoint.export.c.package import RECORDED_ROWS, record, same
from bitepoint.export.subject import Options, find_subject
from bitepoint.kernels import Life
from bitepoint.scenarios import load_scenario, scenario_names
from bitepoint.simulation.run import Simulation
from tests.conftest import OTHER_LIVES, needs_c

LONGEST = 150.0
"""What of a scenario is run, s: of a driving cycle, its first standing starts, gears and stops."""


def cases() -> Iterator[tuple[str, str, str]]:
    """Scenario, controller, intent."""
    for name in scenario_names():
        scenario = load_scenario(name)
        for controller in CONTROLLERS.values():
            if scenario.plant in controller.plants:
                yield from ((name, controller.name, intent) for intent in scenario.intents)


@needs_c
@pytest.mark.parametrize(("scenario", "controller", "intent"), list(cases()))
def test_a_closed_loop_in_c_is_the_simulated_one_to_the_bit(scenario: str, controller: str, intent: str) -> None:
    settings = {"controller": controller, "intent": intent, "noise.engine_speed": 0.3, "delay.engine_speed": "10 ms"}
    if "engine_speed" not in CONTROLLERS[controller].measurement.fields:
        settings = {"controller": controller, "intent": intent}
    settings |= {"timing.duration": min(LONGEST, float(load_scenario(scenario).timing["duration"][0]))}
    assembly = assemble(scenario, settings)
    lives: tuple[Life, Life] = ("compiled", "c")
    compiled, in_c = (Simulation(assembly.system, life=life).run(assembly.figures, seed=4)[0] for life in lives)
    assert compiled.recording is not None
    assert in_c.recording is not None
    assert in_c.status == compiled.status
    assert np.array_equal(in_c.recording.data, compiled.recording.data)
    assert in_c.figures == compiled.figures


@pytest.mark.parametrize("life", OTHER_LIVES)
@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_controller_answers_a_recorded_scenario_alike_in_every_life(name: str, life: Life) -> None:
    found = find_subject(Options(name))
    slow = life == "interpreted" and CONTROLLERS[name].desktop
    for sequence in record(
        found, rows=31 if slow else RECORDED_ROWS
    ):  # a swarm takes seconds for a step from 0.28 s on
        assert same(found.part, drive(found.part, sequence), drive(found.part, sequence, life)), sequence.name


@pytest.mark.parametrize("life", OTHER_LIVES)
@pytest.mark.parametrize("name", PLANTS)
def test_a_plant_answers_a_recorded_scenario_alike_in_every_life(name: str, life: Life) -> None:
    found = find_subject(Options(name))
    sequence = next(record(found, rows=100 if life == "interpreted" else 2000))
    assert same(found.part, drive(found.part, sequence), drive(found.part, sequence, life))
