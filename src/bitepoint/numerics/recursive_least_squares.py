"""Recursive least squares with exponential forgetting, by orthogonal rotations, for up to 8 parameters.

After step k the parameters theta minimise

    sum over j <= k of forgetting^(k - j) (y_j - x_j' theta)^2   +   what the floor adds

What is kept is theta and the triangle R of R'R = sum forgetting^(k - j) x_j x_j', a square root of the information. A
step scales R by sqrt(forgetting), rotates the row (x', y - x' theta) into (R, 0) by Givens rotations [1], and adds what
R d = z gives to theta. Nothing is subtracted and nothing squared: R is as well conditioned as the regressors are, where
the covariance of the textbook form has the square of that, loses its symmetry, and turns indefinite in float32. Since
the right side begins at 0 each time, rounding does not add up: where y is as predicted, theta does not move at all.

Forgetting without excitation lets the information of a direction fall to 0, so that the next noise drives the
parameters anywhere: covariance wind-up. So each step also rotates in a row of one parameter, in turn,

    (sqrt(size (1 - forgetting)) floor_n e_n', 0)

which says that the parameter is what it is now, with the weight of a regressor of size `floor_n` seen at each step. It
moves nothing, but the information never falls below about floor^2 in any direction, and what is not excited keeps its
value. With a forgetting of 1 there is nothing to restore.

[1] G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed. (2013), sections 5.1.8 and 6.5.3.
"""

from __future__ import annotations

import math

from bitepoint.kernels import kernel
from bitepoint.records import FloatArray, Record, count, quantity

MOST = 8
"""Most parameters; a record says how many are in use."""

ANY = 1e30

UPDATED, NOT_TAKEN = 0, 1
"""Statuses of a step: the row was taken, or it holds what is no number, or one too large; nothing then changed."""

LARGEST = 1e24
"""Sum of the squares of a row that is still taken: 1e6 of these, and their squares, fit into float32."""


class LeastSquares(Record):
    """Parameters of the method."""

    size: int = count(1, MOST, "parameters in use")
    forgetting: float = quantity("1", 0.5, 1, "weight of a step, over that of the next one", default=0.99)
    prior: FloatArray = quantity("1", -ANY, ANY, "parameters before the first step", shape=(MOST,), default=0.0)
    floor: FloatArray = quantity(
        "1", 1e-6, 1e6, "size of a regressor that counts as no excitation", shape=(MOST,), default=1e-3
    )


class LeastSquaresState(Record):
    """Memory between two steps; `regressors` is written by the caller before each."""

    turn: int = count(0, MOST - 1, "parameter whose floor is next")
    residual: float = quantity("1", -ANY, ANY, "what the parameters of the step before missed of y")
    regressors: FloatArray = quantity("1", -ANY, ANY, "of this step", shape=(MOST,))
    parameters: FloatArray = quantity("1", -ANY, ANY, "the estimate", shape=(MOST,))
    triangle: FloatArray = quantity("1", -ANY, ANY, "R, upper", shape=(MOST, MOST))
    right: FloatArray = quantity("1", -ANY, ANY, "scratch: z, which R takes to the change", shape=(MOST,))
    row: FloatArray = quantity("1", -ANY, ANY, "scratch: the row that is rotated in", shape=(MOST,))


@kernel
def least_squares_reset(p: LeastSquares, s: LeastSquaresState) -> None:
    """Begin with the prior, each parameter with the weight of its floor."""
    s.turn = 0
    s.residual = 0.0
    for i in range(MOST):
        for j in range(MOST):
            s.triangle[i, j] = 0.0
        s.triangle[i, i] = p.floor[i]
        s.parameters[i] = p.prior[i]
        s.right[i] = 0.0
        s.regressors[i] = 0.0
        s.row[i] = 0.0


@kernel
def least_squares_rotate(p: LeastSquares, s: LeastSquaresState, first: int, right: float) -> None:
    """Rotate the row, with its right side, into the triangle; its entries before `first` are 0. The row is lost."""
    rest = right
    for i in range(p.size):
        if i >= first and s.row[i] != 0.0:
            diagonal = s.triangle[i, i]
            length = math.sqrt(diagonal**2 + s.row[i] ** 2)
            cosine = diagonal / length
            sine = s.row[i] / length
            for j in range(i, p.size):
                above = s.triangle[i, j]
                s.triangle[i, j] = cosine * above + sine * s.row[j]
                s.row[j] = cosine * s.row[j] - sine * above
            above = s.right[i]
            s.right[i] = cosine * above + sine * rest
            rest = cosine * rest - sine * above


@kernel
def least_squares_move(p: LeastSquares, s: LeastSquaresState) -> None:
    """Add d of R d = z to the parameters; z is lost."""
    for i in range(p.size - 1, -1, -1):
        total = s.right[i]
        for j in range(i + 1, p.size):
            total -= s.triangle[i, j] * s.right[j]
        s.right[i] = total / s.triangle[i, i]
        s.parameters[i] += s.right[i]


@kernel
def least_squares_restore(p: LeastSquares, s: LeastSquaresState) -> None:
    """Give the parameter whose turn it is the information of its floor, at its present value."""
    n = min(s.turn, p.size - 1)
    for j in range(p.size):
        s.row[j] = 0.0
    s.row[n] = p.floor[n] * math.sqrt(float(p.size) * (1.0 - p.forgetting))
    least_squares_rotate(p, s, n, 0.0)
    s.turn = min(n + 1, MOST - 1) if n < p.size - 1 else 0


@kernel
def least_squares_step(p: LeastSquares, s: LeastSquaresState, y: float) -> int:
    """Take one more y = regressors' theta into account; return UPDATED, or NOT_TAKEN, and then nothing has changed."""
    size = y**2
    residual = y
    for j in range(p.size):
        size += s.regressors[j] ** 2
        residual -= s.regressors[j] * s.parameters[j]
    taken = size <= LARGEST and residual**2 <= LARGEST  # neither is true of what is no number
    if taken:
        s.residual = residual
        memory = math.sqrt(p.forgetting)
        for i in range(p.size):
            s.right[i] = 0.0
            s.row[i] = s.regressors[i]
            for j in range(i, p.size):
                s.triangle[i, j] *= memory
        least_squares_rotate(p, s, 0, residual)
        least_squares_move(p, s)
        if p.forgetting < 1.0:
            least_squares_restore(p, s)
    return UPDATED if taken else NOT_TAKEN
