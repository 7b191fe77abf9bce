"""The loop is a kernel too: both of its lives run the same launch, and its wires do what they say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import bitepoint
from bitepoint.errors import WiringError
from bitepoint.recording import Channel
from bitepoint.records import Record, quantity
from bitepoint.simulation import loop, run
from bitepoint.simulation.system import Imperfections, Part, Profile, System, lay_out


class Interpreted:
    """The loop, in its interpreted life."""

    def run(self, *arguments: Any, life: str = "interpreted") -> Any:
        return loop.run_lane.run(*arguments, life="interpreted")

    def entry(self, _life: str) -> int:
        return 0


def test_lives_of_the_loop_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = {
        "timing.duration": "0.25 s", "delay.engine_speed": "20 ms", "noise.clutch_speed": 0.2, "lag.throttle": "50 ms",
    }  # fmt: skip
    compiled = bitepoint.run("dct-launch", seed=3, **settings)
    real = loop.run_lane

    class Patched:
        run_lane = Interpreted()

        def __getattr__(self, name: str) -> Any:
            return getattr(loop, name)

    monkeypatch.setattr(run, "loop", Patched())
    interpreted = bitepoint.run("dct-launch", seed=3, **settings)
    assert loop.run_lane is real
    assert np.array_equal(compiled.recording.data, interpreted.recording.data)
    assert (compiled.status, compiled.reason) == (interpreted.status, interpreted.reason)


def test_stop_rules_agree_in_both_lives(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = {"controller": "none", "controller.clutch_torque": 280, "controller.clutch_rate": 20_000}
    compiled = bitepoint.run("dct-launch", **settings)
    assert compiled.status == "stalled"

    class Patched:
        run_lane = Interpreted()

        def __getattr__(self, name: str) -> Any:
            return getattr(loop, name)

    monkeypatch.setattr(run, "loop", Patched())
    assert bitepoint.run("dct-launch", **settings).reason == compiled.reason


class Seen(Record):
    """Inputs of a part."""

    speed: float = quantity("m/s", -1, 1, "a speed")


class SeenInOtherUnits(Record):
    """Inputs of a part that thinks in kilometres per hour."""

    speed: float = quantity("km/h", -1, 1, "a speed")


class Shown(Record):
    """Outputs of a part."""

    force: float = quantity("N", -1, 1, "a force")


def part(inputs: type[Record], outputs: type[Record]) -> Part:
    from bitepoint.controllers import none as any_controller

    control = any_controller.CONTROLLER
    parameters = control.parameters.zeros()
    return Part(
        "part", control.init, control.step, parameters, control.parameters, control.state, inputs, outputs, None, 0.01
    )


def system(plant: Part, controllers: list[Part], profiles: list[Profile]) -> System:
    return System(plant, controllers, profiles, [], Imperfections(), 1.0, 0.01)


PROFILE = Profile(Channel("speed", "m/s"), np.array([0.0]), np.array([1.0]))


def test_a_missing_signal_is_an_error() -> None:
    with pytest.raises(WiringError, match="speed: part reads it, but no part"):
        lay_out(system(part(Seen, Shown), [], []))


def test_units_that_differ_are_an_error() -> None:
    with pytest.raises(WiringError, match="km/h, but it is shown in m/s"):
        lay_out(system(part(SeenInOtherUnits, Shown), [], [PROFILE]))


def test_two_sources_of_one_signal_are_an_error() -> None:
    with pytest.raises(WiringError, match="force: two parts show it"):
        lay_out(system(part(Seen, Shown), [part(Seen, Shown)], [PROFILE]))


def test_every_signal_has_its_own_place() -> None:
    layout = lay_out(system(part(Seen, Shown), [], [PROFILE]))
    assert layout.size == 3
    assert [(c.source, c.target) for c in layout.connections] == [(0, 1)]
    assert [channel.name for channel, _ in layout.channels] == ["speed", "force"]
