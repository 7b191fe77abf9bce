"""Electric motor with its inverter: torque follows a command within torque, power and rate limits.

    tau dT/dt = limited(command) - T        |T| <= min(torque limit, power limit / |speed|)

The power limit falls with the bus voltage, since the speed at which the field has to be weakened does; torque and power
limits fall with the temperature of the winding. The bus gives power / efficiency and takes power * efficiency back;
what is lost heats the winding, one mass that a coolant cools:

    C dTw/dt = loss - G (Tw - Tc)

An efficiency says nothing of a motor that gives torque at standstill: there the model has no loss.
"""

from __future__ import annotations

from bitepoint.kernels import clamp, kernel
from bitepoint.numerics.tables import lookup, lookup_map
from bitepoint.records import Curve, Map, Record, characteristic_map, curve, quantity


class Motor(Record):
    """An electric motor with its inverter, on a bus of constant voltage."""

    inertia: float = quantity("kg*m^2", 0.005, 20, "rotor, driven side of the clutch, gearbox input")
    lag: float = quantity("s", 0.001, 1, "time constant with which the torque follows", default=0.01)
    delay: float = quantity("s", 0, 0.25, "dead time of the command, a multiple of the step of the plant", default=0.0)
    torque_limit: float = quantity("N*m", 0, 5000, "peak torque, cold, driving or generating")
    torque_rate_limit: float = quantity("N*m/s", 1, 1e6, "fastest change of the command", default=10_000.0)
    power_limit: float = quantity("W", 0, 1e6, "peak power at the shaft, cold, at the nominal voltage")
    voltage: float = quantity("V", 10, 2000, "of the bus")
    nominal_voltage: float = quantity("V", 10, 2000, "at which the power limit holds")
    derating: Curve = curve(("temperature", "K", 200, 600), ("share", "1", 0, 1), "what is left of both limits")
    efficiency: Map = characteristic_map(
        ("speed", "rad/s", 0, 3000),
        ("torque", "N*m", 0, 5000),
        ("efficiency", "1", 0.05, 1),
        "motor and inverter over magnitudes of speed and torque, driving and generating",
    )
    temperature: float = quantity("K", 200, 600, "of the winding at the start", default=338.15)
    heat_capacity: float = quantity("J/K", 10, 1e6, "of the winding and what is warm with it", default=10_000.0)
    cooling: float = quantity("W/K", 0, 1e5, "heat that the coolant takes per difference of temperature", default=150.0)
    coolant_temperature: float = quantity("K", 200, 600, "of the coolant", default=338.15)


LEAST_SPEED = 1.0
"""Speed below which the power limit is not asked, rad/s: a motor at standstill gives torque, not power."""


@kernel
def hot_share(e: Motor, temperature: float) -> float:
    """Return the share of the limits that is left at a temperature of the winding, K."""
    return lookup(e.derating, temperature)


@kernel
def power_now(e: Motor, temperature: float) -> float:
    """Return the highest power at the shaft, W, at a temperature of the winding (K) and the voltage there is."""
    return e.power_limit * hot_share(e, temperature) * (e.voltage / e.nominal_voltage)


@kernel
def torque_bound(peak: float, power: float, speed: float) -> float:
    """Return the highest torque, N m, >= 0, at `speed` (rad/s): the peak (N m), or what the power (W) leaves."""
    return min(peak, power / max(abs(speed), LEAST_SPEED))


@kernel
def rate_limited(before: float, target: float, change: float) -> float:
    """Return `before` moved towards `target` by at most `change`."""
    return clamp(target, before - change, before + change)


@kernel
def electric_power(e: Motor, torque: float, speed: float) -> float:
    """Return the power, W, that the bus gives at a torque (N m) and a speed (rad/s); below 0 it takes."""
    efficiency = lookup_map(e.efficiency, abs(speed), abs(torque))
    power = torque * speed
    return power / efficiency if power > 0.0 else power * efficiency


@kernel
def warming(e: Motor, loss: float, temperature: float) -> float:
    """Return the rate of the temperature of the winding, K/s, at a loss (W) and that temperature (K)."""
    return (loss - e.cooling * (temperature - e.coolant_temperature)) / e.heat_capacity
