"""Identification on signals that a production car has: torques from models instead of torque sensors."""

import bitepoint
from bitepoint.assembly import assemble
from bitepoint.identification.derived import map_torque, observed_load, with_channel
from bitepoint.identification.identify import Options, identify_runs
from bitepoint.models.launch import LaunchModel
from bitepoint.recording import Recording

VEHICLE = assemble("dct-excitation", {}).system.plant.parameters
MODEL = LaunchModel.of(VEHICLE)
SETTLED = 30  # rows that the observer needs


def sensors(log: Recording) -> Recording:
    """As a test car has it."""
    return log


def engine_map(log: Recording) -> Recording:
    """Steady torque at the logged speed and throttle."""
    throttle = float(log.about["run.controller.throttle"].removesuffix(" %")) / 100.0
    return with_channel(log, "engine_torque", map_torque(log, VEHICLE["engine"], throttle))


def pressure(log: Recording) -> Recording:
    """The clutch grips 5 % harder than believed, and 2 N m earlier."""
    return with_channel(log, "clutch_torque", log["clutch_torque"] / 1.05 - 2.0)


def observer(log: Recording) -> Recording:
    """From the wheels, for a vehicle of the library's mass."""
    return with_channel(log, "load_torque", observed_load(log, MODEL, 0.01))


def derived(log: Recording) -> Recording:
    """All three."""
    return observer(pressure(engine_map(log)))


CASES = {
    "torque sensors": (sensors, sensors),
    "engine torque from the engine map": (engine_map, engine_map),
    "clutch torque from pressure": (pressure, pressure),
    "the same, in validation only": (sensors, pressure),
    "load torque from an observer": (observer, observer),
    "all three": (derived, derived),
}

logs = bitepoint.run("dct-excitation").logs.values()
checks = bitepoint.run("dct-excitation", seed=5, road__grade="15 %", vehicle__mass="1700 kg").logs.values()
print(f"{'largest free-run errors':<34} engine speed         slip")
for name, (train, check) in CASES.items():
    runs = [[step(log).rows(SETTLED) for log in group] for group, step in ((logs, train), (checks, check))]
    errors = identify_runs(runs[0], runs[1], Options(), 0.01).errors["validation"]
    worst = [errors[output].free_run_max for output in ("engine_speed", "slip")]
    print(f"{name:<34} {worst[0]:6.2f} rad/s {worst[1]:6.2f} rad/s")
