"""Observer of the road torque: what grade, rolling and air resistance take at the wheels, during a launch.

The driveline is taken as stiff. All that turns with the wheels is reduced to them [1, eqs. 9 and 10]:

    slipping   J dw/dt = eta i Tc - Tv                J = Iv + J6 + eta i^2 I1
    locked     J dw/dt = eta i (Te - ce we) - Tv      J = Iv + J6 + eta i^2 (Ie + I1)

with the clutch torque Tc, and the engine torque Te less its transient loss; in overrun 1 / eta takes the place of eta.
The road torque Tv is a second state, constant but for what the measured wheel speed says. In a step dt

    w- = w + dt (drive - Tv) / J,    e = measured - w-,    w = w- + alpha e,    Tv = Tv - beta e J / dt

alpha = 1 - z^2 and beta = (1 - z)^2 put both poles at z = exp(-dt / time_constant), whatever J: the critically damped
alpha-beta filter. What is left of an error after n time constants is the share (1 + n) exp(-n).

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014
"""

from __future__ import annotations

import math

import numpy as np

from bitepoint.errors import InputError
from bitepoint.kernels import is_finite, kernel
from bitepoint.models.launch import wheel_side_inertia
from bitepoint.parts.gears import overall_ratio
from bitepoint.records import Record, RecordArray, count, quantity


class RoadObserver(Record):
    """Parameters: the reduced driveline and the gains. `design_road_observer` makes them."""

    period: float = quantity("s", 1e-4, 1, "time between two steps")
    speed_gain: float = quantity("1", 0, 1, "alpha: share of the speed error that corrects the speed")
    torque_gain: float = quantity("1", 0, 1, "beta: share that corrects the road torque")
    ratio: float = quantity("1", 0.1, 2500, "clutch speed over wheel speed")
    efficiency: float = quantity("1", 0.5, 1, "share of the power that passes the gears")
    slipping_inertia: float = quantity("kg*m^2", 0.1, 1e6, "at the wheels, behind the clutch")
    locked_inertia: float = quantity("kg*m^2", 0.1, 1e6, "at the wheels, with plate and engine")
    engine_friction: float = quantity("N*m*s/rad", 0, 1, "viscous friction of the crankshaft")
    moving_speed: float = quantity("rad/s", 0.001, 10, "wheel speed, filtered, above which the vehicle moves")
    lock_slip: float = quantity("rad/s", 0.1, 100, "slip, filtered, below which the clutch counts as locked")


class RoadObserverState(Record):
    """Memory between two steps."""

    moving: int = count(0, 1, "0 until the vehicle has moved: the road torque is then the prior, not an estimate")
    locked: int = count(0, 1, "1 while the clutch counts as locked")
    wheel_speed: float = quantity("rad/s", -1e6, 1e6, "estimated wheel speed")
    road_torque: float = quantity("N*m", -1e9, 1e9, "estimated road torque at the wheels, or the prior")


@kernel
def observer_reset(s: RoadObserverState, prior: float) -> None:
    """Begin at standstill, clutch open, with what is known of the road torque (N m): from a slope sensor, or 0."""
    s.moving = 0
    s.locked = 0
    s.wheel_speed = 0.0
    # never: else, in a part whose prior is a number
    s.road_torque = prior if is_finite(prior) else 0.0


@kernel
def observer_locks(p: RoadObserver, locked: int, slip: float, spare: float) -> int:
    """Return 1 where the clutch counts as locked, else 0.

    It locks at a small slip. Afterwards shafts swing and the measured slip with them, so it comes apart only where the
    slip is large and there is nothing to spare: what it can carry less what the engine gives (N m) is below 0.
    """
    small = abs(slip) < p.lock_slip
    holds = locked == 1 and (spare >= 0.0 or abs(slip) < 2.0 * p.lock_slip)
    return 1 if small or holds else 0


@kernel
def observer_update(
    p: RoadObserver, s: RoadObserverState, engine_speed: float, wheel_speed: float, clutch: float, engine: float
) -> None:
    """Predict with the torque that drives, and correct by the measured wheel speed; see the head of this file."""
    slip = engine_speed - p.ratio * s.wheel_speed
    net = engine - p.engine_friction * engine_speed
    s.locked = observer_locks(p, s.locked, slip, clutch - abs(net))
    torque = clutch if slip > 0.0 else -clutch
    inertia = p.slipping_inertia
    if s.locked == 1:
        torque = net
        inertia = p.locked_inertia
    share = p.efficiency if torque > 0.0 else 1.0 / p.efficiency
    predicted = s.wheel_speed + p.period * (share * p.ratio * torque - s.road_torque) / inertia
    error = wheel_speed - predicted
    s.wheel_speed = predicted + p.speed_gain * error
    s.road_torque = s.road_torque - p.torque_gain * error * inertia / p.period


@kernel
def observer_step(
    p: RoadObserver, s: RoadObserverState, engine_speed: float, wheel_speed: float, clutch: float, engine: float
) -> float:
    """Return the road torque at the wheels, N m, > 0 where it slows the vehicle.

    Until the vehicle has moved, the balance of torques holds for any road that is steep enough, so that the prior stays
    and `s.moving` is 0. A number that is not finite leaves the state as it is, and the last result stands.

    Args:
        engine_speed, wheel_speed: measured now, rad/s.
        clutch: torque that the clutch carried since the last step while slipping, N m, >= 0: as commanded, or from its
            pressure.
        engine: torque of the engine since the last step, less its transient loss, N m; used where the clutch is locked.
    """
    # never: else, in a part that holds back measurements that are no numbers
    if is_finite(engine_speed) and is_finite(wheel_speed) and is_finite(clutch) and is_finite(engine):
        if s.moving == 1:
            observer_update(p, s, engine_speed, wheel_speed, clutch, engine)
        else:
            s.wheel_speed = s.wheel_speed + p.speed_gain * (wheel_speed - s.wheel_speed)
            s.moving = 1 if abs(s.wheel_speed) > p.moving_speed else 0
    return s.road_torque


def design_road_observer(
    vehicle: RecordArray,
    period: float = 0.01,
    time_constant: float = 0.1,
    *,
    moving_speed: float = 0.15,
    lock_slip: float = 3.0,
) -> RecordArray:
    """Return observers, shape (n,), for vehicles, shape (n,), with the blocks vehicle, engine, clutch and gearbox.

    Args:
        period: time between two steps, s.
        time_constant: of the estimate, s, at least twice the period.
        moving_speed, lock_slip: rad/s; the defaults are five and six standard deviations of what they are compared
            with, at 0.1 rad/s of noise on either speed and a time constant of ten periods.

    Raises:
        InputError: a period that is not positive, or a time constant below twice the period.
    """
    if not 0.0 < 2.0 * period <= time_constant < math.inf:
        mend = "expected a time constant of at least twice a positive period"
        raise InputError("road observer", f"got a period of {period:g} s and {time_constant:g} s", mend)
    gearbox = vehicle["gearbox"].copy()
    pole = math.exp(-period / time_constant)
    result = RoadObserver.zeros(len(vehicle))
    result["period"], result["speed_gain"], result["torque_gain"] = period, 1.0 - pole**2, (1.0 - pole) ** 2
    result["ratio"], result["efficiency"] = overall_ratio.run(gearbox, life="interpreted"), gearbox["efficiency"]
    result["slipping_inertia"] = wheel_side_inertia(vehicle)
    result["locked_inertia"] = wheel_side_inertia(vehicle, with_engine=True)
    result["engine_friction"] = vehicle["engine"]["friction"]
    result["moving_speed"], result["lock_slip"] = moving_speed, lock_slip
    return result


def torque_noise(observer: RecordArray, sigma: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the standard deviation of the road torque, N m, that white noise of the wheel speed makes (rad/s).

    sigma (J / dt) sqrt(2 ((1 - z) / (1 + z))^3), while the clutch slips.
    """
    pole = 1.0 - np.sqrt(observer["torque_gain"])
    share = np.sqrt(2.0 * ((1.0 - pole) / (1.0 + pole)) ** 3)
    return sigma * observer["slipping_inertia"] / observer["period"] * share
