"""The plant in plain Python, as an engineer would write it: a NumPy state vector, `np.interp`, no compiler.

The equations are those of `bitepoint.plants.dct`; see there for their sources.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bitepoint.recording import Floats
from bitepoint.units import STANDARD_GRAVITY

ENGINE, PLATE, AXLE, WHEEL, DAMPER_TWIST, HALFSHAFT_TWIST, DISTANCE, ENGINE_WORK, FRICTION_WORK = range(9)
LOSSES = slice(9, 14)


def clamp(x: float, low: float, high: float) -> float:
    return min(max(x, low), high)


def interpolate(x: float, points: Floats, values: Floats) -> float:
    return float(np.interp(x, points, values))


class PlainPlant:
    """One vehicle: constants, modes, and 14 states (6 of motion, distance, engine work, friction work, 5 losses)."""

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        body, road, gearbox = parameters["vehicle"], parameters["road"], parameters["gearbox"]
        self.engine, self.clutch = parameters["engine"], parameters["clutch"]
        self.damper, self.halfshaft = parameters["damper"], parameters["halfshaft"]
        self.efficiency, self.radius = gearbox["efficiency"], body["wheel_radius"]
        first, second = gearbox["ratios"][:2]
        self.ratio = gearbox["ratios"][int(gearbox["gear"]) - 1] * gearbox["final_drive"]
        shafts = gearbox["odd_shaft_inertia"] + gearbox["layshaft_inertia"] / first**2
        shafts += gearbox["even_shaft_inertia"] * (second / first) ** 2
        self.engine_inertia = self.engine["inertia"] + self.engine["transient_loss"]
        self.plate_inertia = self.clutch["plate_inertia"]
        self.axle_inertia = gearbox["axle_inertia"] + self.ratio**2 * shafts
        self.vehicle_inertia = body["mass"] * self.radius**2
        fade = (1.0 / self.efficiency - 1.0) * self.ratio * self.clutch["torque_limit"] / (0.05 * self.axle_inertia)
        self.substep = min(parameters["solver"]["substep"], 2.7 / (self.damper_rate() + fade + self.halfshaft_rate()))
        weight = body["mass"] * STANDARD_GRAVITY * self.radius / math.sqrt(1.0 + road["grade"] ** 2)
        self.grade_torque = weight * road["grade"]
        self.rolling_torque = weight * body["rolling_resistance"]
        self.air = 0.5 * road["air_density"] * body["drag_coefficient"] * body["frontal_area"] * self.radius**3
        self.x = np.zeros(14)
        self.x[ENGINE] = self.engine["idle_speed"]
        self.locked, self.hill_hold = False, True
        self.locked_time = 0.0
        self.slip_direction, self.rolling_direction = 1.0, 0.0
        self.effect, self.capacity = 0.0, 0.0
        idle = self.engine["idle_speed"]
        self.command(self.throttle_for(self.engine["friction"] * idle, idle), 0.0)

    def damper_rate(self) -> float:
        """Return a bound of the fastest rate of the torsional damper, 1/s."""
        mobility = 1.0 / self.plate_inertia + self.ratio**2 / self.axle_inertia
        decay = 0.5 * self.damper["damping"] * mobility
        return decay + math.sqrt(abs(decay**2 - self.damper["stiffness"] * mobility))

    def halfshaft_rate(self) -> float:
        return self.halfshaft["damping"] / self.axle_inertia

    def command(self, throttle: float, clutch_torque: float) -> None:
        """Take throttle (0..1) and commanded clutch torque (N m)."""
        e = self.engine
        self.effect = e["filling_gain"] * clamp(throttle, 0.0, 1.0) ** e["filling_throttle_exponent"]
        self.capacity = self.clutch["friction_gain"] * clamp(clutch_torque, 0.0, self.clutch["torque_limit"])

    def drag(self, speed: float) -> float:
        return (self.engine["drag_constant"] + self.engine["drag_slope"] * abs(speed)) * clamp(speed / 5.0, -1.0, 1.0)

    def full_load(self, speed: float) -> float:
        return interpolate(speed, self.engine["full_load"]["speed"], self.engine["full_load"]["torque"])

    def throttle_for(self, torque: float, speed: float) -> float:
        e, drag = self.engine, self.drag(speed)
        filling = clamp((torque + drag) / max(self.full_load(speed) + drag, 1e-9), 0.0, 1.0 - 1e-12)
        ratio = e["filling_speed"] / max(speed, e["filling_speed_floor"])
        effect = -math.log(1.0 - filling) / (e["filling_gain"] * ratio ** e["filling_speed_exponent"])
        return clamp(effect ** (1.0 / e["filling_throttle_exponent"]), 0.0, 1.0)

    def engine_torque(self, speed: float) -> float:
        e, drag = self.engine, self.drag(speed)
        ratio = e["filling_speed"] / max(speed, e["filling_speed_floor"])
        filling = 1.0 - math.exp(-self.effect * ratio ** e["filling_speed_exponent"])
        return (self.full_load(speed) + drag) * filling - drag

    def damper_torque(self, x: Floats) -> float:
        slip = x[PLATE] - self.ratio * x[AXLE]
        return self.damper["stiffness"] * x[DAMPER_TWIST] + self.damper["damping"] * slip

    def halfshaft_torque(self, x: Floats) -> float:
        return self.halfshaft["stiffness"] * x[HALFSHAFT_TWIST] + self.halfshaft["damping"] * (x[AXLE] - x[WHEEL])

    def rates(self, x: Floats) -> Floats:
        """Return dx/dt."""
        engine, damper, halfshaft = self.engine_torque(x[ENGINE]), self.damper_torque(x), self.halfshaft_torque(x)
        friction, clutch = self.engine["friction"] * x[ENGINE], self.slip_direction * self.capacity
        share = 1.0 - self.efficiency if damper * x[AXLE] > 0.0 else 1.0 / self.efficiency - 1.0
        gear_loss = share * abs(self.ratio * damper) * clamp(x[AXLE] / 0.05, -1.0, 1.0)
        drag = self.air * x[WHEEL] * abs(x[WHEEL]) + self.rolling_direction * self.rolling_torque
        d = np.zeros(14)
        if self.locked:
            d[ENGINE] = d[PLATE] = (engine - friction - damper) / (self.engine_inertia + self.plate_inertia)
        else:
            d[ENGINE] = (engine - friction - clutch) / self.engine_inertia
            d[PLATE] = (clutch - damper) / self.plate_inertia
            d[FRICTION_WORK] = clutch * (x[ENGINE] - x[PLATE])
        d[AXLE] = (self.ratio * damper - gear_loss - halfshaft) / self.axle_inertia
        if self.rolling_direction != 0.0:
            d[WHEEL] = (halfshaft - self.grade_torque - drag) / self.vehicle_inertia
        d[DAMPER_TWIST] = x[PLATE] - self.ratio * x[AXLE]
        d[HALFSHAFT_TWIST] = x[AXLE] - x[WHEEL]
        d[DISTANCE] = self.radius * x[WHEEL]
        d[ENGINE_WORK] = engine * x[ENGINE]
        d[LOSSES] = (
            friction * x[ENGINE], self.damper["damping"] * d[DAMPER_TWIST] ** 2, gear_loss * x[AXLE],
            self.halfshaft["damping"] * d[HALFSHAFT_TWIST] ** 2, drag * x[WHEEL],
        )  # fmt: skip
        return d

    def integrated(self, x: Floats, h: float) -> Floats:
        """Return the state after h by the classical Runge-Kutta rule."""
        k1 = self.rates(x)
        k2 = self.rates(x + 0.5 * h * k1)
        k3 = self.rates(x + 0.5 * h * k2)
        k4 = self.rates(x + h * k3)
        return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def locked_torque(self, x: Floats) -> float:
        engine, damper = self.engine_torque(x[ENGINE]) - self.engine["friction"] * x[ENGINE], self.damper_torque(x)
        return damper + self.plate_inertia / (self.engine_inertia + self.plate_inertia) * (engine - damper)

    def crossed(self, x: Floats) -> bool:
        """Return whether the modes no longer fit the state."""
        if self.locked:
            clutch = abs(self.locked_torque(x)) > self.capacity
        else:
            clutch = (x[ENGINE] - x[PLATE]) * self.slip_direction < 0.0
        if self.rolling_direction == 0.0:
            pull = self.halfshaft_torque(x) - self.grade_torque
            wheel = pull > self.rolling_torque or (not self.hill_hold and pull < -self.rolling_torque)
        else:
            wheel = x[WHEEL] * self.rolling_direction < 0.0
        return bool(clutch or wheel)

    def switch_modes(self) -> None:
        """Lock, unlock, stop or release where a mode no longer fits."""
        x = self.x
        if self.locked:
            torque = self.locked_torque(x)
            if abs(torque) > self.capacity:
                self.locked, self.slip_direction = False, math.copysign(1.0, torque)
        elif (x[ENGINE] - x[PLATE]) * self.slip_direction <= 0.0:
            momentum = self.engine_inertia * x[ENGINE] + self.plate_inertia * x[PLATE]
            x[ENGINE] = x[PLATE] = momentum / (self.engine_inertia + self.plate_inertia)
            torque = self.locked_torque(x)
            self.locked = abs(torque) <= self.capacity
            if not self.locked:
                self.slip_direction = float(np.sign(torque))
        if x[WHEEL] * self.rolling_direction < 0.0:
            x[WHEEL] = self.rolling_direction = 0.0
        if self.rolling_direction == 0.0:
            pull = self.halfshaft_torque(x) - self.grade_torque
            if pull > self.rolling_torque:
                self.rolling_direction, self.hill_hold = 1.0, False
            elif not self.hill_hold and pull < -self.rolling_torque:
                self.rolling_direction = -1.0

    def advance(self, h: float) -> float:
        """Integrate over h, or to the first event before it; return the time that went by."""
        end = self.integrated(self.x, h)
        before, passed = 0.0, h
        if self.crossed(end):
            for _ in range(40):
                middle = 0.5 * (before + passed)
                if self.crossed(self.integrated(self.x, middle)):
                    passed = middle
                else:
                    before = middle
            end = self.integrated(self.x, passed)
        self.x = end
        return passed

    def step(self, dt: float) -> None:
        """Advance by dt."""
        substeps = max(int(dt / self.substep + 0.999), 1)
        for _ in range(substeps):
            left = dt / substeps
            for _ in range(8):
                if left > 0.0:
                    self.follow_modes()
                    passed = self.advance(left)
                    self.locked_time += passed if self.locked else 0.0
                    left -= passed
            if left > 0.0:
                self.x = self.integrated(self.x, left)
        self.follow_modes()

    def follow_modes(self) -> None:
        """Switch the modes; the time since the lock starts again with each lock and unlock."""
        locked = self.locked
        self.switch_modes()
        if self.locked != locked:
            self.locked_time = 0.0

    def outputs(self) -> list[float]:
        """Return the outputs, in the order of bitepoint's plant."""
        x, d = self.x, self.rates(self.x)
        engine = self.engine_torque(x[ENGINE])
        clutch = self.locked_torque(x) if self.locked else self.slip_direction * self.capacity
        halfshaft = self.halfshaft_torque(x)
        inertias = np.array([self.engine_inertia, self.plate_inertia, self.axle_inertia, self.vehicle_inertia])
        stored = 0.5 * float(inertias @ x[:4] ** 2) + self.grade_torque * x[DISTANCE] / self.radius
        stored += 0.5 * self.damper["stiffness"] * x[DAMPER_TWIST] ** 2
        stored += 0.5 * self.halfshaft["stiffness"] * x[HALFSHAFT_TWIST] ** 2
        return [
            x[ENGINE], x[PLATE], x[ENGINE] - x[PLATE], self.ratio * x[AXLE], x[WHEEL], self.radius * x[WHEEL],
            self.radius * d[WHEEL], x[DISTANCE], engine - self.engine["transient_loss"] * d[ENGINE], clutch,
            self.damper_torque(x), halfshaft, halfshaft - self.vehicle_inertia * d[WHEEL], float(self.locked),
            self.locked_time, float(self.rolling_direction == 0.0), x[ENGINE_WORK], x[FRICTION_WORK],
            float(x[LOSSES].sum()), stored,
        ]  # fmt: skip
