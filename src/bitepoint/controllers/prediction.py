"""Predictions of a difference model in its changes: what the outputs will be, from the recent past and future moves.

With the change dy(k) = y(k) - y(k-1), a model without its constant terms predicts

    y(k+i) = y(k) + free_i h + sum_{j<i} response_ij du(k+j),

where h is the recent past of the changes, and disturbances stay as they are. Nothing that is constant, such as an
unknown load, enters: the prediction has no offset. Powers of the companion matrix of all orders, not of each order by
itself as in eq. 6 of [1], whose error over four steps is four times as large.

[1] Yang et al., doi:10.11835/j.issn.1000-582X.2020.014
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bitepoint.models.arx import ArxModel
from bitepoint.recording import Floats


class Prediction(NamedTuple):
    """How the outputs follow from the past and from moves.

    Attributes:
        response: shape (outputs, steps, steps): change of output i after each step for each move of the input.
        free: shape (outputs, steps, past): the same for each number of the past.
    """

    response: Floats
    free: Floats


def predict(model: ArxModel, steps: int, depth: int) -> Prediction:
    """Return the prediction of a model of one input over `steps` steps.

    Args:
        depth: rows of the past, at least every order of the model. The past is dy(k), dy(k-1), ... of `depth` rows of
            all outputs, then du(k-1), ... of depth - 1 rows, then dd(k), ... of `depth` rows of all disturbances.
    """
    outputs, disturbances = len(model.outputs), len(model.disturbances)
    sizes = (depth * outputs, depth - 1, depth * disturbances)
    past, total = sum(sizes), sum(sizes) + steps
    unit = np.eye(total)
    y = list(unit[: sizes[0]].reshape(depth, outputs, total)[::-1])  # oldest first; each a map from past and moves
    u = [
        *unit[sizes[0] : sizes[0] + sizes[1]].reshape(depth - 1, 1, total)[::-1],
        *unit[past:].reshape(steps, 1, total),
    ]
    d = list(unit[sizes[0] + sizes[1] : past].reshape(depth, disturbances, total)[::-1])
    d += [np.zeros((disturbances, total))] * (steps - 1)
    sums = np.zeros((outputs, steps, total))
    level = np.zeros((outputs, total))
    for step in range(steps):
        now = depth + step
        y.append(
            sum((p @ y[now - i] for i, p in enumerate(model.past_outputs, 1)), np.zeros((outputs, total)))
            + sum((q @ u[now - i] for i, q in enumerate(model.past_inputs, 1)), np.zeros((outputs, total)))
            + sum((g @ d[now - i] for i, g in enumerate(model.past_disturbances, 1)), np.zeros((outputs, total)))
        )
        level = level + y[now]
        sums[:, step] = level
    return Prediction(sums[:, :, past:], sums[:, :, :past])
