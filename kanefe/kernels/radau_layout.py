"""Where Radau's method keeps what: named places in the memory of `kanefe.kernels.stepping`, and in its table."""

from __future__ import annotations

from kanefe.kernels.stepping import OF_METHOD, REALS_OF_METHOD, ROWS_OF_METHOD

STAGES = 3

# Integers of the method: node and iteration in work; whether no step has been accepted since the start, the last try
# was rejected, the Jacobian is that of this state, is wanted, and a step's polynomial is there to extrapolate
NODE, ITERATION, IS_FIRST, WAS_REJECTED, IS_FRESH, IS_WANTED, HAS_POLYNOMIAL = range(OF_METHOD, OF_METHOD + 7)

# Reals of the method: step of the factors (0: none) and of the polynomial, sizes of the last two corrections, rate of
# convergence, its share of the remaining error, step and error of the last accepted step
FACTORED, POLYNOMIAL_STEP, CORRECTION, RATIO, RATE_OF_CONVERGENCE, REMAINING, OLD_STEP, OLD_ERROR = range(
    REALS_OF_METHOD, REALS_OF_METHOD + 8
)
REALS = REALS_OF_METHOD + 8

# Rows of the method: rates at the start of the step, changes Z at the nodes, the same transformed, rates at the nodes,
# Z of the last accepted step, error, room for a complex vector of the state and for two of the speeds, rates of
# rotations with which the matrices were made, the Jacobian (derivatives of the speeds' and quadratures' rates by
# tangents, then by speeds); and the factors
START = ROWS_OF_METHOD
CHANGES = START + 1
TRANSFORMED = CHANGES + STAGES
RATES_AT = TRANSFORMED + STAGES
POLYNOMIAL = RATES_AT + STAGES
ESTIMATE = POLYNOMIAL + STAGES
ROOM = ESTIMATE + 1
TURNS = ROOM + 4
JACOBIAN_ROWS = TURNS + 1

# Rows of the table: nodes, T and its inverse, weights of the error estimate, and gamma, alpha, beta
NODES, T, INVERSE, WEIGHTS, EIGENVALUES = 0, 1, 1 + STAGES, 1 + 2 * STAGES, 2 + 2 * STAGES


def rows_needed() -> tuple[int, int]:
    """Return how many rows of vectors the method takes: so many, and so many for every speed.

    A row has at least two numbers for every speed, and two more: one for each row of the Jacobian, and two for three
    squares of factors with their pivots.
    """
    return JACOBIAN_ROWS + 2, 3
