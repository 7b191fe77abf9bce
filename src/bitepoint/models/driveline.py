"""The control model of a parallel hybrid's driveline: three inertias, two springs, two lagged torques.

    J1 dw1 = T1 - Tc            Tc = k1 th + c1 (w1 - w2),      dth = w1 - w2
    J2 dw2 = Tc + T2 - Ts / i   Ts = k2 phi + c2 y,             dphi = y = w2 / i - w3
    J3 dw3 = Ts - T3            tau1 dT1 = r1 - T1,  tau2 dT2 = r2 - T2,  dT3 = 0

Engine 1, motor and gearbox input 2, wheels with the vehicle 3: the tyres roll without slip, which takes the wheels'
inertia and the vehicle's mass together. T3 is the torque of all resistances at the wheels, r1 and r2 are the torques
that are asked of engine and motor, and y is the torsional speed, which is to be damped. With the clutch open the engine
stands outside: k1 = c1 = 0.

Source: the system of page 2 of the specification, in its corrected form; the load as a state is ours.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bitepoint.numerics.discretisation import zero_order_hold
from bitepoint.recording import Floats
from bitepoint.records import RecordArray
from bitepoint.units import STANDARD_GRAVITY

STATES = (
    "engine_speed", "clutch_twist", "motor_speed", "halfshaft_twist", "wheel_speed", "engine_torque", "motor_torque",
    "road_torque",
)  # fmt: skip
"""x = [w1, th, w2, phi, w3, T1, T2, T3]."""

ENGINE_SPEED, CLUTCH_TWIST, MOTOR_SPEED, HALFSHAFT_TWIST, WHEEL_SPEED, ENGINE_TORQUE, MOTOR_TORQUE, ROAD_TORQUE = range(
    8
)


@dataclass(frozen=True)
class DrivelineModel:
    """A parallel hybrid in one gear, reduced to its driveline.

    Attributes:
        engine_inertia, motor_inertia: J1, J2, kg m^2; vehicle_inertia: J3, at the wheels, kg m^2.
        clutch_stiffness: k1, N m/rad; clutch_damping: c1, N m s/rad; both 0 with the clutch open.
        halfshaft_stiffness, halfshaft_damping: k2, c2, at the wheels.
        ratio: i, motor speed over wheel speed.
        engine_lag, motor_lag: tau1, tau2, s.
        rolling_torque: T3 of a rolling vehicle on a level road, without air, N m.
    """

    engine_inertia: float
    motor_inertia: float
    vehicle_inertia: float
    clutch_stiffness: float
    clutch_damping: float
    halfshaft_stiffness: float
    halfshaft_damping: float
    ratio: float
    engine_lag: float
    motor_lag: float
    rolling_torque: float

    @staticmethod
    def of(vehicle: RecordArray, gear: int) -> DrivelineModel:
        """Return the model of a vehicle, one record with the blocks of a `p2_hybrid`, in a gear (1 is the first)."""
        body, engine, clutch, motor, gearbox, shaft, tyre = (
            vehicle[block][0] for block in ("vehicle", "engine", "clutch", "motor", "gearbox", "halfshaft", "tyre")
        )
        mass, radius = float(body["mass"]), float(body["wheel_radius"])
        return DrivelineModel(
            engine_inertia=float(engine["inertia"]),
            motor_inertia=float(motor["inertia"]),
            vehicle_inertia=float(tyre["wheel_inertia"]) + mass * radius**2,
            clutch_stiffness=float(clutch["stiffness"]),
            clutch_damping=float(clutch["damping"]),
            halfshaft_stiffness=float(shaft["stiffness"]),
            halfshaft_damping=float(shaft["damping"]),
            ratio=float(gearbox["ratios"][gear - 1]) * float(gearbox["final_drive"]),
            engine_lag=float(engine["lag"]),
            motor_lag=float(motor["lag"]),
            rolling_torque=float(body["rolling_resistance"]) * mass * STANDARD_GRAVITY * radius,
        )

    def opened(self) -> DrivelineModel:
        """Return the model with the clutch open."""
        return replace(self, clutch_stiffness=0.0, clutch_damping=0.0)

    @property
    def twist_speed(self) -> float:
        """Torsional speed per change rate of the torque at the gearbox input, rad/s per N m/s.

        The twist of the half-shafts follows the torque that the vehicle gets of it, slowly enough that nothing swings.
        """
        turning = (self.engine_inertia * bool(self.clutch_stiffness) + self.motor_inertia) * self.ratio**2
        share = self.vehicle_inertia / (self.vehicle_inertia + turning)
        return self.ratio * share / self.halfshaft_stiffness

    @property
    def output(self) -> Floats:
        """c of y = c x, shape (8,)."""
        c = np.zeros(len(STATES))
        c[MOTOR_SPEED], c[WHEEL_SPEED] = 1.0 / self.ratio, -1.0
        return c

    def differential(self) -> tuple[Floats, Floats]:
        """Return a, shape (8, 8), and b, shape (8, 2), of dx/dt = a x + b [r1, r2]."""
        i, j1, j2, j3 = self.ratio, self.engine_inertia, self.motor_inertia, self.vehicle_inertia
        clutch = np.array([self.clutch_damping, self.clutch_stiffness, -self.clutch_damping, 0, 0, 0, 0, 0])
        shaft = self.halfshaft_damping * self.output
        shaft[HALFSHAFT_TWIST] = self.halfshaft_stiffness
        engine, motor, road = np.eye(8)[[ENGINE_TORQUE, MOTOR_TORQUE, ROAD_TORQUE]]
        a = np.zeros((8, 8))
        a[ENGINE_SPEED] = (engine - clutch) / j1
        a[CLUTCH_TWIST, [ENGINE_SPEED, MOTOR_SPEED]] = 1.0, -1.0
        a[MOTOR_SPEED] = (clutch + motor - shaft / i) / j2
        a[HALFSHAFT_TWIST] = self.output
        a[WHEEL_SPEED] = (shaft - road) / j3
        a[ENGINE_TORQUE, ENGINE_TORQUE] = -1.0 / self.engine_lag
        a[MOTOR_TORQUE, MOTOR_TORQUE] = -1.0 / self.motor_lag
        if not self.clutch_stiffness:
            a[[ENGINE_SPEED, CLUTCH_TWIST]] = 0.0
        b = np.zeros((8, 2))
        b[ENGINE_TORQUE, 0], b[MOTOR_TORQUE, 1] = 1.0 / self.engine_lag, 1.0 / self.motor_lag
        return a, b

    def difference(self, period: float, *, euler: bool = False) -> tuple[Floats, Floats]:
        """Return the same of x(k + 1) = a x(k) + b [r1, r2](k): exact for requests held over `period` (s), or Euler's.

        Forward Euler is stable below `euler_limit` only.
        """
        a, b = self.differential()
        if euler:
            return np.eye(8) + period * a, period * b
        return zero_order_hold(a, b, period)

    def euler_limit(self) -> float:
        """Return the period, s, below which forward Euler keeps every decaying motion of the model decaying."""
        rates = np.linalg.eigvals(self.differential()[0])
        decaying = rates[rates.real < -1e-6]
        return float((-2.0 * decaying.real / np.abs(decaying) ** 2).min())
