"""The reduced launch model: an engine, a slipping clutch, and a vehicle on a rigid driveline.

    Je dwe/dt = Te - Tc - ce we            J dwc/dt = eta Tc - Tv / i,   wc = i wv

with everything behind the clutch at the speed of the clutch, wc. The vehicle's motion is free of shaft oscillations,
which a predictive controller cannot damp at 100 Hz, and which cancel over a launch.

    Je = Ie + lambda      J = I1 eta + (J6 + Iv) / i^2     (plate, axle side of the gearbox, vehicle)

Derived from the plant of [1, eq. 9] with rigid shafts.

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bitepoint.errors import InputError
from bitepoint.models.arx import ArxModel
from bitepoint.numerics.discretisation import zero_order_hold
from bitepoint.parts.gears import axle_side_inertia, overall_ratio
from bitepoint.recording import Floats
from bitepoint.records import RecordArray

RESPONSE_STEPS = 20
"""Steps over which the response of a difference model is taken for a straight line (chosen)."""

OUTPUTS = ("engine_speed", "slip")
INPUTS = ("clutch_torque",)
DISTURBANCES = ("engine_torque", "load_torque")


def wheel_side_inertia(vehicle: RecordArray, *, with_engine: bool = False) -> Floats:
    """Return what a clutch torque has to turn, at the wheels, kg m^2, shape (n,): i^2 J.

    Args:
        vehicle: records with the blocks vehicle, engine, clutch and gearbox.
        with_engine: whether the engine, without its transient loss, turns along, as with the clutch locked.
    """
    body, gearbox = vehicle["vehicle"], vehicle["gearbox"].copy()
    ratio, axle = overall_ratio.run(gearbox, life="interpreted"), axle_side_inertia.run(gearbox, life="interpreted")
    turning = vehicle["clutch"]["plate_inertia"] + (vehicle["engine"]["inertia"] if with_engine else 0.0)
    return body["mass"] * body["wheel_radius"] ** 2 + axle + gearbox["efficiency"] * ratio**2 * turning


@dataclass(frozen=True)
class LaunchModel:
    """A vehicle that moves off, reduced to two inertias.

    Attributes:
        engine_inertia: Je, kg m^2; engine_friction: ce, N m s/rad.
        ratio: i, engine side speed over wheel speed; efficiency: eta of the gears, driving.
        inertia: J, of all behind the clutch, at the clutch, kg m^2.
        wheel_radius: m.
        torque_limit: of the clutch, N m; torque_rate_limit: N m/s.
    """

    engine_inertia: float
    engine_friction: float
    ratio: float
    efficiency: float
    inertia: float
    wheel_radius: float
    torque_limit: float
    torque_rate_limit: float

    @staticmethod
    def of(vehicle: RecordArray) -> LaunchModel:
        """Return the model of a vehicle: one record with the blocks vehicle, engine, clutch and gearbox."""
        body, engine, clutch, gearbox = (vehicle[block] for block in ("vehicle", "engine", "clutch", "gearbox"))
        ratio = float(overall_ratio.run(gearbox.copy(), life="interpreted")[0])
        return LaunchModel(
            engine_inertia=float(engine["inertia"][0] + engine["transient_loss"][0]),
            engine_friction=float(engine["friction"][0]),
            ratio=ratio,
            efficiency=float(gearbox["efficiency"][0]),
            inertia=float(wheel_side_inertia(vehicle)[0]) / ratio**2,
            wheel_radius=float(body["wheel_radius"][0]),
            torque_limit=float(clutch["torque_limit"][0]),
            torque_rate_limit=float(clutch["torque_rate_limit"][0]),
        )

    def identified(self, model: ArxModel) -> LaunchModel:
        """Return this model with the inertias that a difference model of the launch shows.

        They are where a held torque takes the speeds: the engine's slows down by 1 / Je per N m of clutch torque, the
        slip closes faster by eta / J. Ratio and efficiency are not in the data and stay.

        Raises:
            InputError: other signals, or a response of the wrong sign.
        """
        if (model.outputs, model.inputs, model.disturbances) != (OUTPUTS, INPUTS, DISTURBANCES):
            expected = ", ".join((*OUTPUTS, *INPUTS, *DISTURBANCES))
            raise InputError("model", "is of other signals", f"expected {expected}")
        steps = model.warm_up + RESPONSE_STEPS
        response = model.free_run(np.zeros((steps, 2)), np.ones((steps, 1)), np.zeros((steps, 2)))
        time = model.period * (RESPONSE_STEPS - 1)
        engine, slip = (response[-1] - response[-RESPONSE_STEPS]) / time
        if not slip < engine < 0.0:
            mend = "identify it anew: a clutch torque has to slow the engine down and to close the slip"
            raise InputError("model", f"changes speed by {engine:.3g} and slip by {slip:.3g} rad/s^2 per N m", mend)
        return replace(self, engine_inertia=-1.0 / float(engine), inertia=self.efficiency / float(engine - slip))

    @property
    def metres_per_radian(self) -> float:
        """Vehicle speed over clutch speed, m."""
        return self.wheel_radius / self.ratio

    def torque_rate(self, jerk: float) -> float:
        """Return the change rate of the clutch torque, N m/s, that makes the vehicle jerk by `jerk` (m/s^3)."""
        return jerk / self.metres_per_radian * self.inertia / self.efficiency

    def arx(self, period: float) -> ArxModel:
        """Return the model as a difference model of order (1, 1, 1), exact for inputs that are held over `period` (s).

        Outputs are engine speed and slip, the input is the clutch torque, disturbances are the engine torque without
        viscous friction, and the load torque at the wheels.
        """
        drag = self.engine_friction / self.engine_inertia
        a = np.array([[-drag, 0.0], [-drag, 0.0]])
        engine, vehicle = 1.0 / self.engine_inertia, 1.0 / self.inertia
        b = np.array(
            [
                [-engine, engine, 0.0],
                [-engine - self.efficiency * vehicle, engine, vehicle / self.ratio],
            ]
        )
        transition, effect = zero_order_hold(a, b, period)
        return ArxModel(
            OUTPUTS, INPUTS, DISTURBANCES, period,
            transition[np.newaxis], effect[np.newaxis, :, :1], effect[np.newaxis, :, 1:], np.zeros((0, 2, 2)),
            {"source": "reduced launch model"},
        )  # fmt: skip
