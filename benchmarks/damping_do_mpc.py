"""The programme of a step of `damping_mpc` by do-mpc: the same cost and limits, not condensed, solved by IPOPT.

Held moves are a state that keeps its value, by a time-varying parameter: so the moves, their weights and their limits
are those of the kernel.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from bitepoint.assembly import assemble
from bitepoint.controllers.damping_mpc_records import TORQUE_SCALE, WEIGHT_SCALE
from bitepoint.models.driveline import DrivelineModel
from bitepoint.recording import Floats

PERIOD = 0.01


def do_mpc_solver(scenario: str) -> Callable[[Floats], float] | None:
    """Return what finds the first move, N m, from the numbers that the future follows from; None without do-mpc."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import do_mpc
    except ImportError:
        return None
    library: Any = do_mpc
    system = assemble(scenario, {}).system
    parameters, vehicle = system.controllers[-1].parameters, system.plant.parameters
    model = _model(library, parameters, DrivelineModel.of(vehicle, int(vehicle["gearbox"]["gear"][0])))
    limit = float(vehicle["motor"]["torque_limit"][0])
    change = PERIOD * float(vehicle["motor"]["torque_rate_limit"][0])
    requests = np.zeros(2)
    controller = _controller(library, model, parameters, (limit, change), requests)

    def solve(past: Floats) -> float:
        requests[:] = past[10], past[13]
        controller.x0 = np.concatenate([past[:10], past[14:15], [0.0]])
        controller.set_initial_guess()
        return TORQUE_SCALE * float(controller.make_step(controller.x0)[0, 0])

    return solve


def _model(library: Any, parameters: Any, driveline: DrivelineModel) -> Any:
    import casadi

    ca: Any = casadi
    a, b = driveline.difference(PERIOD)
    c = parameters["calibration"][0]
    share, time = float(parameters["shaping_share"][0]), float(parameters["shaping_time"][0])
    lag = 1.0 - np.exp(-PERIOD / driveline.engine_lag)
    model = library.model.Model("discrete", "SX")
    x = model.set_variable("_x", "x", (8, 1))
    first, second, before, kept = (model.set_variable("_x", name) for name in ("first", "second", "before", "kept"))
    move, held = model.set_variable("_u", "move"), model.set_variable("_tvp", "held")
    request, engine = model.set_variable("_p", "request"), model.set_variable("_p", "engine")
    new_first = first + share * (request - first)
    new_second = second + share * (new_first - second)
    torque, correction = x[5], held * kept + (1.0 - held) * move
    needed = 0.5 * (second + new_second - torque - (torque + lag * (engine - torque)))
    motor = needed + TORQUE_SCALE * correction
    after = ca.mtimes(a, x) + ca.mtimes(b, ca.vertcat(engine, motor))
    swing = ca.mtimes(driveline.output.reshape(1, -1), after)
    error = swing - driveline.twist_speed * (new_first - new_second) / time
    for name, value in (
        ("x", after), ("first", new_first), ("second", new_second), ("before", motor), ("kept", correction)
    ):  # fmt: skip
        model.set_rhs(name, value)
    changed = (1.0 - held) * (motor - before)
    cost = float(c["q"]) * error**2 + float(c["rho"]) * (TORQUE_SCALE * correction / WEIGHT_SCALE) ** 2
    model.set_expression("cost", cost + float(c["r"]) * (changed / WEIGHT_SCALE) ** 2 + 1e-9 * held * move**2)
    model.set_expression("motor", (1.0 - held) * motor)
    model.set_expression("change", changed)
    model.setup()
    return model


def _controller(library: Any, model: Any, parameters: Any, limits: Sequence[float], requests: Floats) -> Any:
    c = parameters["calibration"][0]
    horizon, moves = int(c["prediction_horizon"]), int(parameters["moves"][0])
    controller = library.controller.MPC(model)
    quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-9}
    controller.set_param(n_horizon=horizon, t_step=PERIOD, n_robust=0, store_full_solution=False, nlpsol_opts=quiet)
    controller.set_objective(mterm=0.0 * model.x["kept"], lterm=model.aux["cost"])
    controller.set_rterm(move=0.0)
    for name, limit in zip(("motor", "change"), limits, strict=True):
        controller.set_nl_cons(f"{name}_high", model.aux[name], ub=limit)
        controller.set_nl_cons(f"{name}_low", -model.aux[name], ub=limit)
    given, varying = controller.get_p_template(1), controller.get_tvp_template()

    def parameters_now(_: float) -> Any:
        given["_p", 0] = requests
        return given

    def held_moves(_: float) -> Any:
        for k in range(horizon + 1):
            varying["_tvp", k, "held"] = float(k >= moves)
        return varying

    controller.set_p_fun(parameters_now)
    controller.set_tvp_fun(held_moves)
    controller.setup()
    return controller
