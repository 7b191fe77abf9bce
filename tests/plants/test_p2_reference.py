"""The P2 hybrid against an independent integrator, and its modes by linearisation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bitepoint.assembly import PLANTS
from bitepoint.plants.p2_hybrid import rates
from bitepoint.plants.p2_hybrid_records import P2Mode, P2Motion
from tests.contracts.harness import PlantBench, nominal
from tests.plants import reference_p2 as reference
from tests.tolerances import REFERENCE_SPEED

P2 = PLANTS["p2_hybrid"]
TICK = 0.002
SPEEDS = ("engine_speed", "motor_speed", "wheel_speed", "speed")
TWISTS = ("clutch_twist", "halfshaft_twist")


def bench(**changes: Any) -> PlantBench:
    """The library vehicle at 5 m/s in second gear, wound up by 15 N m; `block__key` changes a parameter."""
    p = nominal(P2, "p2-suv")
    p["start"]["speed"], p["start"]["engine_torque"] = 5.0, 15.0
    for name, value in changes.items():
        block, _, key = name.partition("__")
        p[block][key] = value
    return PlantBench(P2, p)


def tip_in(plant: PlantBench, end: float) -> np.ndarray:
    """The outputs at each tick of the manoeuvre."""
    rows = [plant.y.copy()]
    for k in range(round(end / TICK)):
        assert plant.step(TICK, engine_torque_request=reference.request(k * TICK))[0] == 0
        rows.append(plant.y.copy())
    return np.concatenate(rows)


def jerk(acceleration: np.ndarray) -> float:
    """Largest change of the acceleration within 10 ms, m/s^3."""
    return float(np.abs(np.diff(acceleration[::5])).max() / 0.01)


@pytest.mark.parametrize("mu", [1.05, 0.45], ids=["dry", "snow"])
def test_tip_in_agrees_with_an_independent_integration(mu: float) -> None:
    _, states = reference.integrate(12.0, mu)
    plant = bench(road__friction=mu)
    seen = tip_in(plant, 12.0)
    for row, name in enumerate(("engine_speed", "motor_speed", "wheel_speed", "vehicle_speed")):
        assert seen[name] == pytest.approx(states[row], abs=2.0 * REFERENCE_SPEED), name
    for row, name in enumerate(TWISTS):
        assert seen[name] == pytest.approx(states[4 + row], abs=1e-5), name
    expected = reference.acceleration(states, mu)
    assert seen["vehicle_acceleration"] == pytest.approx(expected, abs=0.01)
    assert seen["torsional_speed"] == pytest.approx(reference.torsional_speed(states), abs=0.01)
    assert jerk(seen["vehicle_acceleration"]) == pytest.approx(jerk(expected), rel=0.01)


def test_figures_of_the_tip_in() -> None:
    """The figures that a damper of the driveline has to improve, over the first 43 s of the manoeuvre."""
    seen = tip_in(bench(), 43.0)
    assert np.abs(seen["torsional_speed"]).max() == pytest.approx(5.37, rel=0.01)
    assert seen["vehicle_acceleration"].max() == pytest.approx(8.84, rel=0.01)
    assert jerk(seen["vehicle_acceleration"]) == pytest.approx(62.7, rel=0.01)


def test_slip_on_snow() -> None:
    assert tip_in(bench(road__friction=0.45), 4.0)["tyre_slip"].max() == pytest.approx(1.77, rel=0.01)


def linearised(plant: PlantBench, names: tuple[str, ...]) -> np.ndarray:
    """Derivatives of the rates of these quantities by themselves, by central differences."""
    columns = []
    for name in names:
        ends = []
        for change in (1e-6, -1e-6):
            motion, slope = plant.x["motion"].copy(), P2Motion.zeros()
            motion[name] += change
            mode = plant.x["mode"].copy().view(P2Mode.dtype)
            rates.run(plant.p, mode, motion, slope)
            ends.append(np.array([slope[other][0] for other in names]))
        columns.append((ends[0] - ends[1]) / 2e-6)
    return np.array(columns).T


def test_modes() -> None:
    """Tyres that hardly slip are no tyres; library tyres damp the slow mode, the more the faster they roll."""
    assert reference.modes() == pytest.approx(np.array([(2.2, 0.09), (19.7, 0.28)]), rel=0.03)
    stiff = bench(road__friction=2.0, tyre__stiffness_factor=100.0)
    stiff_modes = reference.oscillations(linearised(stiff, (*SPEEDS, *TWISTS)))
    assert stiff_modes == pytest.approx(np.array(reference.modes()), rel=0.03)
    slow, fast = reference.oscillations(linearised(bench(), (*SPEEDS, *TWISTS)))
    assert fast == pytest.approx((19.7, 0.28), rel=0.02)
    assert slow == pytest.approx((2.20, 0.118), rel=0.02)
    assert reference.oscillations(linearised(bench(start__speed=20.0), (*SPEEDS, *TWISTS)))[0][1] > 0.15


def test_error_falls_with_the_fourth_power_of_the_substep() -> None:
    """Between the steps of the request all is smooth."""
    finals = []
    for h in (1e-3, 5e-4, 2.5e-4, 2e-5):
        plant = bench(solver__substep=h, start__speed=15.0)
        for k in range(25):
            plant.step(0.02, engine_torque_request=200.0 if k < 10 else 50.0)
        finals.append(plant.x["motion"]["wheel_speed"][0])
    errors = np.abs(np.array(finals[:-1]) - finals[-1])
    orders = np.log2(errors[:-1] / errors[1:])
    assert (orders > 3.5).all()
    assert (orders < 4.7).all()
