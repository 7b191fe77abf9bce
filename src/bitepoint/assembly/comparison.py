"""What a planned drive saves: beside the baseline on the same plant, in the same time, with the same energy at the end.

Fuel is compared where the way ends, between two rows of a recording, and corrected for what is not equal there:

    corrected = fuel - worth * (E - E_target) + price * (T - T_baseline)

E is the kinetic energy, worth the fuel that a joule of it takes at the end speed, price that of time of the plan of
equal time. The plan is made for the time in which the plant, which is a little slower than a plan, meets the baseline;
where the cheapest plan of all is faster than the baseline, it stands for those of equal time, none of which is cheaper.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bitepoint.assembly.planned import PlannedDrive
from bitepoint.kernels import Life
from bitepoint.metrics import Metric, Metrics
from bitepoint.models.longitudinal import driving_force
from bitepoint.models.plan import SpeedPlan
from bitepoint.parts.body import Road
from bitepoint.planning.steady import energy_value, fuel_by_gear
from bitepoint.recording import Floats, Recording
from bitepoint.simulation.run import Simulation
from bitepoint.simulation.system import Part, System

TURNS = 4
"""Most plans that are driven to meet the time of the baseline."""

TIME_MISSED = 2e-3
"""Share of that time that may be missed; the rest is valued at the price of time."""

MOST_TIME_MISSED = 5e-3
"""The same, beyond which no drive is said to take that time."""

LONGEST_STAGE = 10.0
"""Way, m, over which a drive is averaged to see what its gears cost; a short one has 150 stages."""

NOT_ARRIVED = "the planned drive, or the baseline, does not arrive"
NOT_FAST = "no plan is as fast as the baseline"
NOT_MET = "no planned drive takes the time of the baseline"
"""Why there is no comparison."""

UNITS: Mapping[str, str] = {
    "fuel_saving_equal_time": "1",
    "fuel_saving_raw": "1",
    "fuel_saving_planned": "1",
    "saving_realised": "1",
    "gear_only_share": "1",
    "mean_speed_loss": "m/s",
    "baseline_fuel": "kg",
    "baseline_time": "s",
    "plan_time": "s",
    "grid_gap": "1",
}
"""The figures of a comparison, and their units."""


@dataclass(frozen=True)
class Drive:
    """A drive over the whole way.

    Attributes:
        fuel: kg; time: s; end_speed: m/s; all where the way ends.
    """

    recording: Recording
    fuel: float
    time: float
    end_speed: float

    @staticmethod
    def of(recording: Recording, length: float) -> Drive | None:
        """Return that of a recording; None where it did not arrive."""
        if recording["distance"][-1] < length:
            return None
        fuel, time, speed = (
            float(np.interp(length, recording["distance"], each))
            for each in (recording["fuel_used"], recording.time, recording["vehicle_speed"])
        )
        return Drive(recording, fuel, time, speed)


@dataclass(frozen=True)
class Comparison:
    """A planned drive beside its baseline: figures, and the recordings by name."""

    metrics: Metrics
    recordings: Mapping[str, Recording]


class Comparer:
    """Compares drives of one scenario.

    Args:
        system: with the driver who follows the plan; parts: the same controllers, the driver with the baseline.
    """

    def __init__(self, planned: PlannedDrive, system: System, parts: Sequence[Part], seed: int, life: Life) -> None:
        self.planned, self.system, self.parts, self.seed = planned, system, parts, seed
        self.life: Life = life
        model = planned.model
        radius = float(model["vehicle"]["wheel_radius"][0])
        self.mass = float(model["vehicle"]["mass"][0]) + float(model["wheel_inertia"][0]) / radius**2
        self.worth = energy_value(model, planned.target)

    def drive(self, parts: Sequence[Part]) -> Drive | None:
        """Return the drive of these controllers; None where it does not arrive."""
        system = replace(self.system, controllers=parts)
        lane = Simulation(system, life=self.life).run(lambda recording: recording, seed=self.seed)[0]
        assert lane.recording is not None
        return Drive.of(lane.recording, self.planned.length)

    def corrected(self, drive: Drive, price: float = 0.0, time: float = 0.0) -> float:
        """Return the fuel, kg, had the drive ended at the target speed and taken `time` (s) at `price` (kg/s)."""
        energy = 0.5 * self.mass * (drive.end_speed**2 - self.planned.target**2)
        return drive.fuel - self.worth * energy + price * (drive.time - time)

    def compare(self, main: Recording) -> Comparison:
        """Return the figures of a planned drive that was recorded; None for those that do not exist."""
        driven, baseline = Drive.of(main, self.planned.length), self.drive(self.parts)
        values: dict[str, float | None] = dict.fromkeys(UNITS)
        values["plan_time"], values["grid_gap"] = self._planned_again()
        recordings: dict[str, Recording] = {}
        reason = "" if driven is not None and baseline is not None else NOT_ARRIVED
        if baseline is not None:
            recordings["baseline"] = baseline.recording
            values["baseline_fuel"], values["baseline_time"] = baseline.fuel, baseline.time
        if baseline is not None and driven is not None:
            values["fuel_saving_raw"] = 1.0 - driven.fuel / baseline.fuel
            values["mean_speed_loss"] = self.planned.length * (1.0 / baseline.time - 1.0 / driven.time)
            plan, price, equal, reason = self._equal_time(driven, baseline.time)
            if equal is not None:
                recordings |= {} if equal is driven else {"equal-time": equal.recording}
                values |= self._savings(plan, price, equal, baseline)
        finite = {name: None if value is None or not np.isfinite(value) else value for name, value in values.items()}
        whys = {name: reason if value is None else "" for name, value in finite.items()}
        return Comparison({name: Metric(finite[name], unit, whys[name]) for name, unit in UNITS.items()}, recordings)

    def _planned_again(self) -> tuple[float, float]:
        """Return what a plan takes, s, once its kernels are loaded, and by how much the halved grid lowers its cost."""
        plan, known = self.planned.plan, bool(np.isfinite(self.planned.plan.grid_gap))
        again = self.planned.planner.plan(self.planned.price, gap=not known)
        return again.plan_time, plan.grid_gap if known else again.grid_gap

    def _equal_time(self, driven: Drive, time: float) -> tuple[SpeedPlan, float, Drive | None, str]:
        """Return the plan whose drive takes `time` (s), its price of time, and the drive: this one, if it does.

        Where there is none, the last that was tried, and why not.
        """
        plan, price = self.planned.plan, self.planned.price
        if abs(driven.time - time) <= TIME_MISSED * time:
            return plan, price, driven, ""
        late, best, reason = driven.time - plan.total_time, driven, NOT_MET
        for _ in range(TURNS):
            timed = self.planned.planner.plan_at_time(time - late)
            if timed.late(time - late):
                reason = NOT_FAST
                break
            drive = self.drive(self.planned.followed(self.parts, timed.plan)) if timed.plan.optimal else None
            if drive is None:
                break
            if best is driven or abs(drive.time - time) < abs(best.time - time):
                plan, price, best = timed.plan, timed.price, drive
            if abs(best.time - time) <= TIME_MISSED * time:
                break
            late += drive.time - time
        met = best is not driven and abs(best.time - time) <= MOST_TIME_MISSED * time
        faster = best is not driven and price == 0.0 and best.time < time  # the cheapest plan of all, and yet faster
        return (plan, price, best, "") if met or faster else (plan, price, None, reason)

    def _savings(self, plan: SpeedPlan, price: float, equal: Drive, baseline: Drive) -> dict[str, float | None]:
        reference = self.corrected(baseline)
        saving = 1.0 - self.corrected(equal, price, baseline.time) / reference
        promised = plan.total_fuel + price * (plan.total_time - baseline.time)
        planned = 1.0 - promised / reference
        gears = self.gear_only_saving(baseline.recording)
        return {
            "fuel_saving_equal_time": saving,
            "fuel_saving_planned": planned,
            "saving_realised": saving / planned if planned > 0.0 else None,
            "gear_only_share": gears / saving if saving > 0.0 else None,
        }

    def gear_only_saving(self, recording: Recording) -> float:
        """Return the share of the fuel that the best gear at each place would save, at the speeds that were driven.

        Both are reckoned in balance (`models.longitudinal`), shifts left out.
        """
        length = self.planned.length
        edges = np.linspace(0.0, length, int(max(np.ceil(length / LONGEST_STAGE), 150)) + 1)
        way = recording["distance"]
        squared = np.interp(edges, way, recording["vehicle_speed"] ** 2)
        acceleration = np.diff(squared) / (2.0 * np.diff(edges))
        speed = np.sqrt(np.maximum(0.5 * (squared[1:] + squared[:-1]), 1e-3))
        flow = self._flows(edges, speed, acceleration)
        engaged = recording["gear"] > 0.0
        middle = 0.5 * (edges[1:] + edges[:-1])
        place = np.clip(np.searchsorted(way[engaged], middle), 0, np.count_nonzero(engaged) - 1)
        gear = recording["gear"][engaged][place].astype(int)
        used = flow[gear - 1, np.arange(len(middle))]
        best = np.minimum(flow.min(axis=0), used)
        seconds = np.diff(edges) / speed
        known = np.isfinite(used)
        return float(1.0 - np.sum((best * seconds)[known]) / np.sum((used * seconds)[known]))

    def _flows(self, edges: Floats, speed: Floats, acceleration: Floats) -> Floats:
        """Return the fuel flow in each gear, kg/s, shape (gears, stages); infinite where the gear cannot do it."""
        model, route = self.planned.model, self.planned.route
        grade = np.zeros(len(speed)) if route is None else route.cells(edges)[0]
        road = Road.zeros(len(speed))
        road["grade"], road["air_density"] = grade, self.system.plant.parameters["road"]["air_density"][0]
        force = driving_force.run(model, road, speed, acceleration)
        found = fuel_by_gear(model, force, speed, acceleration)
        slow = found.turning < 0.95 * model["launch_speed"][0]
        slow[0] = False
        weak = found.torque > 1.02 * found.full_load
        return np.where(slow | weak | (found.turning > model["engine"]["speed_limit"][0]), np.inf, found.flow)


def at_the_end(metrics: Metrics, recording: Recording, length: float, target: float) -> Metrics:
    """Return the figures of a drive as they are where the way ends, between two rows; those of one that arrived."""
    drive = Drive.of(recording, length)
    if drive is None:
        return metrics
    values = {
        "fuel_used": drive.fuel,
        "drive_time": drive.time,
        "distance": length,
        "mean_speed": length / drive.time,
        "end_speed": drive.end_speed,
        "end_speed_error": drive.end_speed - target,
    }
    return {**metrics, **{name: Metric(value, metrics[name].unit) for name, value in values.items()}}
