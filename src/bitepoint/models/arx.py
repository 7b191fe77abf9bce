"""Linear difference models of several inputs and outputs, with measured disturbances.

    y(k+1) = sum_i P_i y(k+1-i) + sum_i Q_i u(k+1-i) + sum_i G_i d(k+1-i) + e(k+1) + sum_i C_i e(k+1-i)

with outputs y, controlled inputs u, measured disturbances d and prediction errors e; i counts from 1. Without C it is
an ARX model, with it an ARMAX model. Coefficients are in the units of the signals: SI.

A model file is JSON: what the model is, and where it comes from.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np

from bitepoint.errors import InputError, brief
from bitepoint.files import read_json, save_json
from bitepoint.recording import Floats

_COEFFICIENTS = ("past_outputs", "past_inputs", "past_disturbances", "past_errors")


@dataclass(frozen=True)
class ArxModel:
    """A linear difference model.

    Attributes:
        outputs, inputs, disturbances: names of the signals, in SI units.
        period: time between two rows, s.
        past_outputs: P, shape (n_a, outputs, outputs); past_inputs: Q, (n_b, outputs, inputs);
        past_disturbances: G, (n_g, outputs, disturbances); past_errors: C, (n_c, outputs, outputs), n_c = 0 for ARX.
        about: where it comes from; what JSON can hold.
    """

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    disturbances: tuple[str, ...]
    period: float
    past_outputs: Floats
    past_inputs: Floats
    past_disturbances: Floats
    past_errors: Floats
    about: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def __post_init__(self) -> None:
        """Hold that shapes fit the names.

        Raises:
            ValueError: they do not.
        """
        rows = len(self.outputs)
        widths = (rows, len(self.inputs), len(self.disturbances), rows)
        for name, width in zip(_COEFFICIENTS, widths, strict=True):
            found: tuple[int, ...] = getattr(self, name).shape
            if len(found) != 3 or found[1:] != (rows, width):
                raise ValueError(f"{name} is {found}, expected (order, {rows}, {width})")
        if not self.period > 0.0:
            raise ValueError(f"period is {self.period}, expected a time above 0 s")

    @property
    def orders(self) -> tuple[int, int, int, int]:
        """The orders n_a, n_b, n_g, n_c."""
        n_a, n_b, n_g, n_c = (len(getattr(self, name)) for name in _COEFFICIENTS)
        return n_a, n_b, n_g, n_c

    @property
    def kind(self) -> str:
        """What the model is called: "arx" or "armax"."""
        return "armax" if len(self.past_errors) else "arx"

    def poles(self) -> np.ndarray[Any, np.dtype[np.complex128]]:
        """Return the poles, eigenvalues of the companion matrix, largest magnitude first."""
        n_a, rows = len(self.past_outputs), len(self.outputs)
        companion = np.zeros((n_a * rows, n_a * rows))
        companion[:rows] = np.hstack(list(self.past_outputs)) if n_a else 0.0
        companion[rows:, :-rows] = np.eye((n_a - 1) * rows)
        values = np.linalg.eigvals(companion).astype(np.complex128)
        return values[np.argsort(-np.abs(values))]

    @property
    def warm_up(self) -> int:
        """Rows that must be known before the first that is predicted."""
        return max(self.orders)

    def one_step(self, y: Floats, u: Floats, d: Floats) -> Floats:
        """Return what the model predicts for each row from the measured rows before it, shape (n, outputs).

        Args:
            y, u, d: measured, shapes (n, outputs), (n, inputs), (n, disturbances).

        The first `warm_up` rows are those of y; an ARMAX model starts with prediction errors of 0.
        """
        predicted = y.copy()
        errors = np.zeros_like(y)
        for k in range(self.warm_up, len(y)):
            predicted[k] = self._next(k, y, u, d, errors)
            errors[k] = y[k] - predicted[k]
        return predicted

    def free_run(self, y: Floats, u: Floats, d: Floats) -> Floats:
        """Return the outputs simulated from the first `warm_up` measured rows on, fed with its own past; (n, outputs).

        A model that is not stable may overflow: what comes out is then infinite or NaN.
        """
        simulated = y.copy()
        errors = np.zeros_like(y)
        with np.errstate(over="ignore", invalid="ignore"):
            for k in range(self.warm_up, len(y)):
                simulated[k] = self._next(k, simulated, u, d, errors)
        return simulated

    def _next(self, k: int, y: Floats, u: Floats, d: Floats, errors: Floats) -> Floats:
        total = np.zeros(len(self.outputs))
        for coefficients, signal in zip(
            (self.past_outputs, self.past_inputs, self.past_disturbances, self.past_errors),
            (y, u, d, errors),
            strict=True,
        ):
            for i, matrix in enumerate(coefficients, 1):
                total += matrix @ signal[k - i]
        return total

    def to_json(self) -> dict[str, Any]:
        """Return what a model file holds."""
        n_a, n_b, n_g, n_c = self.orders
        return {
            "model": self.kind,
            "orders": [n_a, n_b, n_g, *([n_c] if n_c else [])],
            "period": self.period,
            "outputs": list(self.outputs),
            "inputs": list(self.inputs),
            "disturbances": list(self.disturbances),
            **{name: getattr(self, name).tolist() for name in _COEFFICIENTS},
            "about": dict(self.about),
        }

    def save(self, path: str | Path) -> None:
        """Write a model file.

        Raises:
            InputError: the file cannot be written.
        """
        save_json(path, self.to_json())

    @staticmethod
    def load(path: str | Path) -> ArxModel:
        """Read a model file.

        Raises:
            InputError: no such file, or no model of this kind in it.
        """
        where = str(path)
        found: object = read_json(Path(path), "expected a model that `bitepoint identify` wrote")
        if not isinstance(found, dict):
            raise InputError(where, f"holds {brief(found)}", "expected a model that `bitepoint identify` wrote")
        return _parsed(cast("dict[str, Any]", found), where)


def _parsed(data: Mapping[str, Any], where: str) -> ArxModel:
    mend = "expected a model that `bitepoint identify` wrote"
    if data.get("model") not in ("arx", "armax"):
        raise InputError(where, f"model: got {brief(data.get('model'))}", "expected arx or armax")
    try:
        names = [tuple(str(name) for name in data[key]) for key in ("outputs", "inputs", "disturbances")]
        widths = (len(names[0]), len(names[1]), len(names[2]), len(names[0]))
        arrays = [
            np.asarray(data[key], float).reshape(-1, len(names[0]), width)
            for key, width in zip(_COEFFICIENTS, widths, strict=True)
        ]
        model = ArxModel(*names, float(data["period"]), *arrays, about=dict(data.get("about", {})))  # type: ignore[arg-type]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(where, f"is no complete model ({brief(str(error))})", mend) from None
    if not all(np.isfinite(array).all() for array in arrays):
        raise InputError(where, "holds coefficients that are not finite", mend)
    return model
