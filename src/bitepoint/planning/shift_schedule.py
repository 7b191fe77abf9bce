"""An economical shift schedule from a fuel model: the fuel of a unit of drive energy, gear against gear.

    g_e(v) = G_T / (F_t v)        fuel flow over drive power, at a share of the full load

At each throttle the gears' g_e meet at the speed of the upshift; the downshift is a little lower. A fuel model with a
transient correction takes the acceleration that this load gives the vehicle.

Source: the schedule of page 5 of the specification.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.longitudinal import driving_force, fuel_for, geared_speed
from bitepoint.models.plan import Floats, Integers
from bitepoint.models.shift_map import shift_map
from bitepoint.parts.body import Road
from bitepoint.parts.torque_engine import highest_torque
from bitepoint.planning.steady import gear_count
from bitepoint.records import CURVE_POINTS, RecordArray

HYSTERESIS = 2.0 / 3.6
"""Speed by which a downshift lies below the upshift, m/s."""

THROTTLES = np.linspace(0.05, 1.0, 20)
"""Shares of the full load at which the schedule is made."""

SPEED_STEP = 0.1 / 3.6
"""Raster on which the gears are compared, m/s; a crossing is then interpolated."""

CROSSING, EARLIEST, LATEST = range(3)
"""How a speed was found: the gears' g_e cross there; the higher gear is the better one wherever it can be driven, so it
is the lowest speed at which its engine speed allows it; it never is, so it is the highest speed of the lower gear."""


@dataclass(frozen=True)
class ShiftSchedule:
    """Lines of speed over throttle.

    Attributes:
        throttle: shares of the full load, shape (throttles,).
        up, down: vehicle speed, m/s, of the shifts between gear n + 1 and n + 2, shape (gears - 1, throttles).
        kind: CROSSING, EARLIEST or LATEST, likewise.
    """

    throttle: Floats
    up: Floats
    down: Floats
    kind: Integers

    def shift_map(self) -> RecordArray:
        """Return it as a record `ShiftMap`."""
        return shift_map(self.throttle, self.up, self.down)


def economy_schedule(
    model: RecordArray, *, throttles: Floats = THROTTLES, hysteresis: float = HYSTERESIS, grade: float = 0.0
) -> ShiftSchedule:
    """Return the economical schedule of a vehicle.

    Args:
        model: one record `LongitudinalModel`, with any fuel model.
        throttles: shares of the full load, rising, 0..1; hysteresis: m/s; grade: rise over run.

    Raises:
        InputError: a vehicle with one gear, or throttles that cannot be.
    """
    shares, gears = np.asarray(throttles, np.float64), gear_count(model)
    rising = len(shares) > 1 and bool((np.diff(shares) > 0.0).all())
    if not rising or len(shares) > CURVE_POINTS or shares[0] <= 0.0 or shares[-1] > 1.0:
        mend = f"expected up to {CURVE_POINTS} of them, rising, above 0 and up to 1"
        raise InputError("shift schedule", "throttles that cannot be", mend)
    if gears < 2:
        raise InputError("shift schedule", f"{gears} gear", "expected a gearbox with two or more")
    found = np.array(
        [[_upshift(model, gear, float(share), grade) for share in shares] for gear in range(1, gears)]
    )  # (gears - 1, throttles, 2)
    up = np.ascontiguousarray(found[:, :, 0])
    return ShiftSchedule(shares, up, np.maximum(up - hysteresis, 0.0), found[:, :, 1].astype(np.int64))


def specific_fuel(model: RecordArray, gear: int, share: float, speed: Floats, *, grade: float = 0.0) -> Floats:
    """Return g_e, kg/J: the fuel of a joule of drive energy in a gear at a share of the full load, over speed (m/s).

    The drive energy is what the engine gives to the wheels, its own inertia and the losses of the gears taken off.
    Infinite where it gives none.
    """
    engine_speed = geared_speed.run(model, gear, speed)
    torque = share * highest_torque.run(model["engine"], engine_speed)
    acceleration, force = _acceleration(model, gear, torque, speed, grade)
    flow = fuel_for.run(model, engine_speed, torque, speed, acceleration)
    return np.where(force > 0.0, flow / np.maximum(force * speed, 1e-9), np.inf)


def _acceleration(model: RecordArray, gear: int, torque: Floats, speed: Floats, grade: float) -> tuple[Floats, Floats]:
    """Return the acceleration (m/s^2) that a torque (N m) gives, and the force at the wheels (N)."""
    road = Road.parse({"grade": grade, "air_density": 1.206}, "shift schedule")
    gearbox, r = model["gearbox"], model["vehicle"]["wheel_radius"][0]
    lever = gearbox["ratios"][0, gear - 1] * gearbox["final_drive"][0] * gearbox["efficiency"][0] / r
    turning = model["engine"]["inertia"][0] * gearbox["ratios"][0, gear - 1] * gearbox["final_drive"][0] / r
    rest = driving_force.run(model, road, speed, 0.0)
    mass = driving_force.run(model, road, speed, 1.0) - rest
    acceleration = (lever * torque - rest) / (mass + lever * turning)
    return acceleration, lever * (torque - turning * acceleration)


def _upshift(model: RecordArray, gear: int, share: float, grade: float) -> tuple[float, int]:
    """Return the speed, m/s, at which the next gear becomes the better one, and how it was found."""
    per_speed = [float(geared_speed.run(model, g, 1.0)[0]) for g in (gear, gear + 1)]
    low = float(model["launch_speed"][0]) / per_speed[1]
    high = float(model["engine"]["speed_limit"][0]) / per_speed[0]
    if low >= high:
        return high, LATEST
    speed = np.linspace(low, high, max(int((high - low) / SPEED_STEP), 2))
    before, after = (specific_fuel(model, g, share, speed, grade=grade) for g in (gear, gear + 1))
    better = after <= before
    if not better[-1]:
        return high, LATEST
    worse = np.flatnonzero(~better)
    if len(worse) == 0:
        return low, EARLIEST
    k = int(worse[-1])
    gap = after[k : k + 2] - before[k : k + 2]
    part = gap[0] / (gap[0] - gap[1]) if np.isfinite(gap).all() else 1.0
    return float(speed[k] + part * (speed[k + 1] - speed[k])), CROSSING
