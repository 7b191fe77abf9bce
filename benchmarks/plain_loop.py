"""The launch in plain Python: controller and closed loop around `plain_plant`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from benchmarks.plain_plant import PlainPlant, clamp, interpolate
from bitepoint.assembly import Assembly
from bitepoint.recording import Floats

WAITING, SLIPPING, CLOSING, DRIVING = range(4)


class PlainController:
    """Launch at constant engine speed, as `bitepoint.controllers.launch_pid`."""

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self.p, self.c = parameters, parameters["calibration"]
        self.phase, self.time = WAITING, 0.0
        self.feed_forward = self.integral = self.clutch_torque = 0.0
        self.throttle, self.error, self.error_before = clamp(parameters["idle_throttle"], 0.0, 1.0), 0.0, 0.0

    def curve(self, name: str, ordinate: str, pedal: float) -> float:
        return interpolate(pedal, self.c[name]["pedal"], self.c[name][ordinate])

    def next_phase(self, pedal: float, slip: float) -> int:
        c = self.c
        if pedal <= c["pedal_threshold"] and self.phase < CLOSING:
            return WAITING
        if self.phase == WAITING:
            return SLIPPING
        if self.phase == SLIPPING and self.time > c["touch_delay"] and slip < c["closing_slip"]:
            return CLOSING
        return DRIVING if self.phase == CLOSING and slip <= 0.0 else self.phase

    def slipping_torque(self, pedal: float, speed_error: float, dt: float) -> float:
        c = self.c
        if self.time < c["touch_delay"]:
            return 0.0
        error = speed_error - clamp(speed_error, -c["clutch_deadband"], c["clutch_deadband"])
        goal, rise = self.curve("clutch_torque", "torque", pedal), self.curve("clutch_rate", "rate", pedal) * dt
        self.feed_forward = clamp(goal, self.feed_forward - rise, self.feed_forward + rise)
        self.integral = clamp(self.integral - c["clutch_ki"] * dt * error, -self.feed_forward, 10_000.0)
        return self.feed_forward + self.integral - c["clutch_kp"] * error

    def engine_speed_control(self, target: float, speed: float, dt: float) -> float:
        c, error = self.c["engine_speed"], clamp(target - speed, -2000.0, 2000.0)
        change = c["kp"] * (error - self.error) + c["ki"] * dt * error
        change += c["kd"] * (error - 2.0 * self.error + self.error_before) / dt
        change = clamp(change, -c["rate_limit"] * dt, c["rate_limit"] * dt)
        self.error_before, self.error = self.error, error
        return clamp(self.throttle + change, 0.0, 1.0)

    def step(self, measured_pedal: float, engine_speed: float, clutch_speed: float, dt: float) -> list[float]:
        """Return throttle, clutch torque, engine-speed target and phase."""
        p, c = self.p, self.c
        if not (math.isfinite(measured_pedal) and math.isfinite(engine_speed) and math.isfinite(clutch_speed)):
            raise ValueError("a measurement is no number")
        pedal = clamp(measured_pedal, 0.0, 1.0)
        self.phase = self.next_phase(pedal, engine_speed - clutch_speed)
        risen = clamp(self.time / c["target_rise_time"], 0.0, 1.0)
        target = p["idle_speed"] + risen * (self.curve("engine_target", "speed", pedal) - p["idle_speed"])
        torque = 0.0
        if self.phase == WAITING:
            self.time = self.feed_forward = self.integral = 0.0
            target = p["idle_speed"]
        elif self.phase == SLIPPING:
            torque = self.slipping_torque(pedal, target - engine_speed, dt)
            self.time += dt
        else:
            torque = self.clutch_torque + c["closing_rate"] * dt
        change = p["rate_limit"] * dt
        torque = clamp(torque, self.clutch_torque - change, self.clutch_torque + change)
        self.clutch_torque = clamp(torque, 0.0, p["torque_limit"])
        if self.phase == DRIVING:
            change = c["handover_rate"] * dt
            self.throttle = clamp(pedal, self.throttle - change, self.throttle + change)
        else:
            self.throttle = self.engine_speed_control(target, engine_speed, dt)
        return [self.throttle, self.clutch_torque, target, float(self.phase)]


def parameters_of(assembly: Assembly) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """Return the parameters of plant and controller as mappings in SI, curves under the names of their axes."""
    plant, controller = assembly.plant.parameters, assembly.controller.parameters
    system = assembly.system
    given = plant.to_mapping(system.plant.parameters[0]), controller.to_mapping(system.controllers[0].parameters[0])
    return _with_arrays(given[0]), _with_arrays(given[1])


def _with_arrays(value: Any) -> Any:
    if isinstance(value, Mapping):
        block = cast("Mapping[str, Any]", value)
        return {key: _with_arrays(item) for key, item in block.items()}
    return np.array(cast("list[float]", value)) if isinstance(value, list) else value


def run_plain(assembly: Assembly) -> Floats:
    """Run the first lane without stop rules for the whole duration; return the recording, shape (channels, rows)."""
    system = assembly.system
    plant_parameters, controller_parameters = parameters_of(assembly)
    plant, controller = PlainPlant(plant_parameters), PlainController(controller_parameters)
    ticks, every = round(system.duration / system.tick), round(system.controllers[0].period / system.tick)
    time = np.arange(ticks + 1) * system.tick
    pedal = np.interp(time, system.profiles[0].time, system.profiles[0].values)
    recording = np.empty((25, ticks + 1))
    seen, commands = plant.outputs(), [0.0] * 4
    for tick in range(ticks + 1):
        if tick % every == 0:
            commands = controller.step(pedal[tick], seen[0], seen[1], system.controllers[0].period)
            plant.command(commands[0], commands[1])
        recording[:, tick] = [pedal[tick], *seen, *commands]
        if tick < ticks:
            plant.step(system.tick)
            seen = plant.outputs()
    return recording
