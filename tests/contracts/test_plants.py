"""What every plant must do, with every library vehicle. A new plant is in by existing."""

from __future__ import annotations

import numpy as np
import pytest

from bitepoint.kernels import Life
from bitepoint.plants.plant import Plant
from tests.conftest import OTHER_LIVES, needs_c
from tests.contracts.driving import DRIVING
from tests.contracts.harness import PlantBench, nominal, plants_with_vehicles, random_signals, same_bits
from tests.tolerances import ENERGY, ENERGY_STIFF

CASES = list(plants_with_vehicles())
each_vehicle = pytest.mark.parametrize(("plant", "vehicle"), CASES, ids=[vehicle for _, vehicle in CASES])
HELD = [(plant, vehicle) for plant, vehicle in CASES if "vehicle_held" in plant.outputs.fields]
each_held = pytest.mark.parametrize(("plant", "vehicle"), HELD, ids=[vehicle for _, vehicle in HELD])
"""Those that stand still by themselves, and whose clutch locks."""


def losses(plant: Plant) -> list[str]:
    """What only grows among the quantities that are integrated."""
    motion = plant.state.fields["motion"].record
    assert motion is not None
    return [name for name in motion.fields if name.endswith(("_loss", "_heat", "friction_work", "fuel_used"))]


def work(bench: PlantBench, before: np.ndarray) -> np.ndarray:
    """What engine and motor have done since, J, per lane."""
    done = [name for name in ("engine_work", "motor_work") if name in bench.plant.outputs.fields]
    return np.sum([bench.y[name] - before[name] for name in done], axis=0)


def balance(bench: PlantBench, before: np.ndarray) -> np.ndarray:
    """What the energy balance misses since, J, per lane."""
    gone = [bench.y[name] - before[name] for name in ("friction_heat", "losses", "stored_energy")]
    return work(bench, before) - np.sum(gone, axis=0)


@each_vehicle
@pytest.mark.parametrize("grade", [-0.1, 0.0, 0.2])
def test_energy_balance_of_a_launch(plant: Plant, vehicle: str, grade: float) -> None:
    p = nominal(plant, vehicle)
    p["road"]["grade"] = grade
    bench = PlantBench(plant, p)
    before = bench.y.copy()
    for k in range(2000):
        bench.step(**DRIVING[plant.name].move_off(k))
    assert bench.y["vehicle_speed"][0] > 1.0
    assert bench.y["friction_heat"][0] > 100.0
    assert abs(balance(bench, before)[0]) < ENERGY * work(bench, before)[0]


@each_vehicle
def test_energy_balance_in_overrun(plant: Plant, vehicle: str) -> None:
    bench = PlantBench(plant, nominal(plant, vehicle))
    for k in range(2500):
        bench.step(**DRIVING[plant.name].move_off(k))
    start = bench.y.copy()
    lost = bench.x["motion"].copy()
    for _ in range(1000):
        bench.step(**DRIVING[plant.name].overrun)
    assert bench.y["clutch_torque"][0] < 0.0  # the vehicle drives the engine
    assert bench.y["engine_work"][0] < start["engine_work"][0]
    assert abs(balance(bench, start)[0]) < ENERGY * abs(work(bench, start)[0])
    for name in losses(plant):
        assert bench.x["motion"][name][0] >= lost[name][0], name


@each_vehicle
def test_every_loss_only_grows_whatever_the_inputs(plant: Plant, vehicle: str) -> None:
    rng = np.random.default_rng(7)
    p = np.repeat(nominal(plant, vehicle), 32)
    p["road"]["grade"] = rng.uniform(-0.3, 0.3, 32)
    p["solver"]["substep"] = 1e-4
    bench = PlantBench(plant, p)
    before, turnover = bench.y.copy(), np.zeros(32)
    for _ in range(400):
        last = bench.x["motion"].copy()
        assert not bench.step(0.005, **DRIVING[plant.name].plausible(rng, 32)).any()
        for name in losses(plant):
            change = bench.x["motion"][name] - last[name]
            assert (change >= -1e-9 * (1.0 + last[name])).all(), (name, change.min())
        turnover += np.abs(bench.x["motion"]["engine_work"] - last["engine_work"])
    assert (np.abs(balance(bench, before)) < ENERGY_STIFF * (turnover + 1000.0)).all()


def capacity_at_pressure(bench: PlantBench) -> np.ndarray:
    """What the clutch can carry, N m, at the pressure, temperature and slip that the plant shows."""
    a, y = bench.p["actuator"], bench.y
    force = np.maximum(y["clutch_pressure"] * a["piston_area"] - a["spring_force"], 0.0)
    rise = (a["static_friction"] - a["sliding_friction"]) * np.exp(-np.abs(y["slip_speed"]) / a["slip_scale"])
    fade = 1.0 + a["temperature_slope"] * (y["clutch_temperature"] - a["reference_temperature"])
    return a["faces"] * (a["sliding_friction"] + rise) * fade * a["mean_radius"] * force


@each_held
def test_clutch_never_carries_more_than_its_capacity(plant: Plant, vehicle: str) -> None:
    rng = np.random.default_rng(3)
    bench = PlantBench(plant, np.repeat(nominal(plant, vehicle), 64))
    seen = np.zeros(2, bool)
    for k in range(600):
        capacity = np.clip(60.0 + 0.5 * k + 80.0 * rng.standard_normal(64), 0.0, 280.0)
        bench.step(throttle=rng.uniform(0.1, 0.6, 64), clutch_torque_command=capacity)
        if bench.p["actuator"]["active"].all():
            capacity = capacity_at_pressure(bench)
        assert (np.abs(bench.y["clutch_torque"]) <= capacity * (1 + 1e-9) + 1e-9).all()
        locked = bench.y["clutch_locked"] == 1.0
        assert (bench.y["slip_speed"][locked] == 0.0).all()
        seen |= [locked.any(), not locked.all()]
    assert seen.all()


@each_held
@pytest.mark.parametrize("grade", [0.0, 0.05, 0.3])
def test_stands_still_on_a_grade(plant: Plant, vehicle: str, grade: float) -> None:
    p = nominal(plant, vehicle)
    p["road"]["grade"] = grade
    bench = PlantBench(plant, p)
    for _ in range(200):
        bench.step(clutch_torque_command=2.0)
        assert bench.y["vehicle_speed"][0] == 0.0
    assert bench.y["vehicle_held"][0] == 1.0


@each_held
def test_comes_to_rest_by_rolling_resistance_and_stays(plant: Plant, vehicle: str) -> None:
    bench = PlantBench(plant, nominal(plant, vehicle))
    for k in range(500):
        bench.step(throttle=0.4, clutch_torque_command=min(0.2 * k, 90.0))
    assert bench.y["vehicle_speed"][0] > 0.3
    for _ in range(6000):
        bench.step(clutch_torque_command=0.0)
    assert bench.y["vehicle_held"][0] == 1.0
    assert bench.y["vehicle_speed"][0] == 0.0


@each_held
def test_rolls_back_when_it_has_moved_and_is_let_go_uphill(plant: Plant, vehicle: str) -> None:
    p = nominal(plant, vehicle)
    p["road"]["grade"] = 0.1
    bench = PlantBench(plant, p)
    for k in range(500):
        bench.step(throttle=0.5, clutch_torque_command=min(0.3 * k, 110.0))
    assert bench.y["vehicle_speed"][0] > 0.1
    for _ in range(2000):
        bench.step(clutch_torque_command=0.0)
    assert bench.y["vehicle_speed"][0] < -0.1


@each_vehicle
def test_stays_finite_at_the_corners_of_its_inputs(plant: Plant, vehicle: str) -> None:
    rng = np.random.default_rng(11)
    lanes = 64
    p = np.repeat(nominal(plant, vehicle), lanes)
    p["vehicle"]["mass"] = rng.choice([500.0, 1600.0, 4000.0], lanes)
    p["road"]["grade"] = rng.choice([-0.5, 0.0, 0.5], lanes)
    if plant.name == "dct":
        p["clutch"]["friction_gain"] = rng.choice([0.1, 1.0, 3.0], lanes)
    bench = PlantBench(plant, p)
    for _ in range(300):
        status = bench.step(0.01, **random_signals(plant.inputs, rng, (lanes,)))
        assert not status.any()
        assert np.isfinite(bench.y.view(np.float64)).all()


@each_vehicle
def test_says_so_when_a_number_is_not_finite(plant: Plant, vehicle: str) -> None:
    bench = PlantBench(plant, nominal(plant, vehicle))
    bench.x["motion"]["engine_speed"] = np.nan
    assert bench.step()[0] != 0


@each_vehicle
def test_init_forgets_the_past(plant: Plant, vehicle: str) -> None:
    fresh = PlantBench(plant, nominal(plant, vehicle))
    used = PlantBench(plant, nominal(plant, vehicle))
    for _ in range(300):
        used.step(**DRIVING[plant.name].steady)
    plant.init.run(used.p, used.x, used.u, used.y, used.w)
    for _ in range(50):
        fresh.step(**DRIVING[plant.name].gentle)
        used.step(**DRIVING[plant.name].gentle)
    assert same_bits(fresh.y, used.y)


@pytest.mark.parametrize("life", OTHER_LIVES)
@each_vehicle
def test_lives_agree_to_the_bit(plant: Plant, vehicle: str, life: Life) -> None:
    rng = np.random.default_rng(5)
    benches = [PlantBench(plant, nominal(plant, vehicle), other) for other in ("compiled", life)]
    for k in range(40):
        inputs = DRIVING[plant.name].plausible(rng, 1) if k > 5 else DRIVING[plant.name].gentle
        statuses = [bench.step(0.001, **inputs)[0] for bench in benches]
        assert statuses == [0, 0]
        assert same_bits(benches[0].y, benches[1].y)
    assert same_bits(benches[0].x, benches[1].x)


@needs_c
@each_vehicle
def test_c_agrees_to_the_bit_over_a_hundred_thousand_steps(plant: Plant, vehicle: str) -> None:
    rng = np.random.default_rng(6)
    lanes, steps = 200, 500
    p = np.repeat(nominal(plant, vehicle), lanes)
    p["road"]["grade"] = rng.uniform(-0.3, 0.3, lanes)
    p["vehicle"]["mass"] = rng.uniform(900, 2500, lanes)
    benches = [PlantBench(plant, p, "compiled"), PlantBench(plant, p, "c")]
    for k in range(steps):
        if k % 20 == 0:
            inputs = DRIVING[plant.name].plausible(rng, lanes)
        if k % 97 == 0:
            inputs[next(iter(inputs))][rng.integers(0, lanes, 3)] = [np.nan, np.inf, -1e300]
        statuses = [bench.step(0.001, **inputs) for bench in benches]
        assert np.array_equal(*statuses)
        assert same_bits(benches[0].y, benches[1].y)
        assert same_bits(benches[0].x, benches[1].x)


@each_vehicle
def test_a_lane_does_not_depend_on_its_batch(plant: Plant, vehicle: str) -> None:
    p = np.repeat(nominal(plant, vehicle), 5)
    p["vehicle"]["mass"] = [1200, 1400, 1600, 1800, 2000]
    batch, single = PlantBench(plant, p), PlantBench(plant, p[3:4].copy())
    for _ in range(200):
        batch.step(**DRIVING[plant.name].steady)
        single.step(**DRIVING[plant.name].steady)
    assert same_bits(batch.y[3:4].copy(), single.y)
