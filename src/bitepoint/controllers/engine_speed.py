"""Engine-speed control: a PID on the rate of the throttle.

Velocity form, so that limits and hand-overs leave no wound-up integral:

    throttle(k) = throttle(k-1) + kp (e(k) - e(k-1)) + ki Ts e(k) + kd (e(k) - 2 e(k-1) + e(k-2)) / Ts

with the change limited to +- rate_limit Ts, e = target - engine speed.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.parts.engine import throttle_for
from bitepoint.recording import Floats
from bitepoint.records import Record, RecordArray, quantity


class EngineSpeedCalibration(Record):
    """Gains of the engine-speed control."""

    kp: float = quantity("s/rad", 0, 10, "throttle per speed error")
    ki: float = quantity("1/rad", 0, 100, "throttle rate per speed error")
    kd: float = quantity("s^2/rad", 0, 1, "throttle per change rate of the speed error", default=0.0)
    rate_limit: float = quantity("1/s", 0.1, 100, "fastest change of the throttle")


class EngineSpeedState(Record):
    """Memory of the engine-speed control."""

    throttle: float = quantity("1", 0, 1, "throttle of the last step")
    error: float = quantity("rad/s", -2000, 2000, "speed error of the last step")
    error_before: float = quantity("rad/s", -2000, 2000, "speed error of the step before that")


@kernel
def engine_speed_reset(s: EngineSpeedState, throttle: float) -> None:
    """Take over from a throttle, 0..1, without a bump."""
    s.throttle = clamp(throttle, 0.0, 1.0)
    s.error = 0.0
    s.error_before = 0.0


@kernel
def engine_speed_step(c: EngineSpeedCalibration, s: EngineSpeedState, target: float, speed: float, dt: float) -> float:
    """Return the throttle, 0..1, for the next dt (s) from the target and the measured speed (rad/s)."""
    error = clamp(target - speed, -2000.0, 2000.0)
    change = c.kp * (error - s.error) + c.ki * dt * error + c.kd * (error - 2.0 * s.error + s.error_before) / dt
    change = clamp(change, -c.rate_limit * dt, c.rate_limit * dt)
    s.throttle = clamp(s.throttle + change, 0.0, 1.0)
    s.error_before = s.error
    s.error = error
    return s.throttle


@kernel
def engine_speed_hand_over(s: EngineSpeedState, pedal: float, change: float) -> float:
    """Return the throttle, 0..1, on its way to the pedal, 0..1, by at most `change` in this step."""
    s.throttle = clamp(pedal, s.throttle - change, s.throttle + change)
    return s.throttle


def idle_throttle(engine: RecordArray) -> Floats:
    """Return the throttle that holds each engine at its idle speed, clutch open, shape (n,)."""
    speed = engine["idle_speed"].copy()
    return throttle_for.run(engine.copy(), engine["friction"] * speed, speed, life="interpreted")
