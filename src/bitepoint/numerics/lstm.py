"""A layer of long short-term memory and a linear read-out, one sample per step.

    i, f, g, o = W x + U h + b                         (rows of W, U and b in this order, as in PyTorch)
    c <- logistic(f) c + logistic(i) tanh(g)
    h <- logistic(o) tanh(c)
    scores = V h + d

Hochreiter and Schmidhuber, doi:10.1162/neco.1997.9.8.1735, with the forget gate of Gers et al.,
doi:10.1162/089976600300015015.
"""

from __future__ import annotations

from bitepoint.kernels import kernel
from bitepoint.numerics.activation import rational_logistic, rational_tanh
from bitepoint.records import FloatArray, Record, quantity

INPUTS, HIDDEN, CLASSES = 3, 8, 3
GATES = 4 * HIDDEN
FORGET, FRESH, OUTPUT = HIDDEN, 2 * HIDDEN, 3 * HIDDEN
"""First rows of f, g and o."""


class LstmWeights(Record):
    """What is trained. Inputs come as they are: their scaling is part of the input weights."""

    input_weights: FloatArray = quantity("1", -1000, 1000, "W", shape=(GATES, INPUTS))
    recurrent_weights: FloatArray = quantity("1", -1000, 1000, "U", shape=(GATES, HIDDEN))
    biases: FloatArray = quantity("1", -1000, 1000, "b", shape=(GATES,))
    score_weights: FloatArray = quantity("1", -1000, 1000, "V", shape=(CLASSES, HIDDEN))
    score_biases: FloatArray = quantity("1", -1000, 1000, "d", shape=(CLASSES,))


class LstmState(Record):
    """Memory, and what is computed on the way."""

    inputs: FloatArray = quantity("1", -1e6, 1e6, "x, written by whoever calls", shape=(INPUTS,))
    gates: FloatArray = quantity("1", -1e12, 1e12, "i, f, g and o before their activation", shape=(GATES,))
    cells: FloatArray = quantity("1", -1e6, 1e6, "c", shape=(HIDDEN,))
    outputs: FloatArray = quantity("1", -1, 1, "h", shape=(HIDDEN,))
    scores: FloatArray = quantity("1", -1e6, 1e6, "of the classes: logarithms of odds", shape=(CLASSES,))


@kernel
def lstm_reset(s: LstmState) -> None:
    """Forget all."""
    for k in range(HIDDEN):
        s.cells[k] = 0.0
        s.outputs[k] = 0.0
    for k in range(CLASSES):
        s.scores[k] = 0.0


@kernel
def lstm_step(w: LstmWeights, s: LstmState) -> None:
    """Take in `s.inputs` and write the scores."""
    for k in range(GATES):
        total = w.biases[k]
        for j in range(INPUTS):
            total += w.input_weights[k, j] * s.inputs[j]
        for j in range(HIDDEN):
            total += w.recurrent_weights[k, j] * s.outputs[j]
        s.gates[k] = total
    for k in range(HIDDEN):
        kept = rational_logistic(s.gates[k + FORGET]) * s.cells[k]
        s.cells[k] = kept + rational_logistic(s.gates[k]) * rational_tanh(s.gates[k + FRESH])
        s.outputs[k] = rational_logistic(s.gates[k + OUTPUT]) * rational_tanh(s.cells[k])
    for k in range(CLASSES):
        total = w.score_biases[k]
        for j in range(HIDDEN):
            total += w.score_weights[k, j] * s.outputs[j]
        s.scores[k] = total


@kernel
def highest_score(s: LstmState) -> int:
    """Return the class with the highest score, 0 .. CLASSES - 1; the first of equals."""
    best = 0
    score = s.scores[0]
    for k in range(1, CLASSES):
        if s.scores[k] > score:
            best = k
            score = s.scores[k]
    return best
