"""What Radau's method keeps, and the polynomial through the nodes of a step: states within it, guesses of the next."""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import INTERPOLATE, Array, Columns, Start, copy, inlined, kernel, pointer, vector_kernel
from kanefe.kernels.steppers.moves import STRAIGHT
from kanefe.kernels.steppers.step_commands import Row, Step
from kanefe.kernels.values.tensors import Matrix

FARTHEST = 16.0
"""Longest step for which the polynomial of the last one is extrapolated, in multiples of that: behind a very short
step, such as one across an event, it is round-off."""

STAGES = 3


class RadauStep(Step):
    """A step of Radau's method."""

    followed: int  # internal states of loads that are solved for as speeds are
    unknowns: int  # they and the speeds
    jacobian_rows: int
    factor_size: int  # unknowns of dense systems, 0: they are those of a tree, see `tree_systems`
    tree_size: int  # unknowns of these, how many rows begin or end, and how many speeds and unknowns are of them
    row_ends: int
    tree_speeds: int
    tree_unknowns: int
    entry_count: int
    mass_count: int
    node: int
    iteration: int
    is_first: int  # no step has been accepted since the start, or since what is held has changed
    was_rejected: bool
    is_fresh: bool  # the Jacobian is that of this state
    is_wanted: bool  # a Jacobian
    has_polynomial: bool  # of a step, to extrapolate
    factored: float  # step of the factors, 0: none
    polynomial_step: float  # of the polynomial
    differentiated_step: float  # for which the Jacobian was made
    correction: float  # size of the last one
    ratio: float  # to the one before
    rate_of_convergence: float
    remaining: float  # share of the last correction in the remaining error
    old_step: float
    old_error: float
    nodes: Annotated[np.ndarray, Columns(STAGES)]
    weights: Annotated[np.ndarray, Columns(STAGES)]  # of the estimate of errors
    T: Matrix  # transformation of the stages
    T_inverse: Matrix
    gamma: float  # eigenvalues
    alpha: float
    beta: float
    behind_moves: Annotated[int, Start("integers")]
    row_starts: Annotated[np.ndarray, Array("row_ends")]  # pattern of the factors of a tree
    columns: Annotated[np.ndarray, Array("entry_count")]
    diagonals: Annotated[np.ndarray, Array("tree_size")]
    mass_places: Annotated[np.ndarray, Array("mass_count")]  # of masses among the entries, their rows and speeds
    mass_rows: Annotated[np.ndarray, Array("mass_count")]
    mass_speeds: Annotated[np.ndarray, Array("mass_count")]
    turn_places: Annotated[np.ndarray, Array("tree_speeds", 3)]  # among the entries, of a speed: how coordinates follow
    of_coordinates: Annotated[np.ndarray, Array("tree_speeds")]  # rows of coordinates, and of speeds and states
    of_unknowns: Annotated[np.ndarray, Array("tree_unknowns")]
    behind_step: Annotated[int, Start("vectors")]
    start: Row  # rates at the start of the step
    changes: Annotated[np.ndarray, Array(STAGES, "size")]  # at the nodes
    transformed: Annotated[np.ndarray, Array(STAGES, "size")]
    rates_at: Annotated[np.ndarray, Array(STAGES, "size")]  # the nodes
    polynomial: Annotated[np.ndarray, Array(STAGES, "size")]  # changes of the last accepted step
    estimate: Row  # the error
    jacobian: Annotated[
        np.ndarray, Array("jacobian_rows", "size")
    ]  # of the rates of speeds, states and quadratures by tangents, then by speeds and states
    room: Annotated[np.ndarray, Array("2size")]
    tangents: Annotated[np.ndarray, Array("2speeds")]
    turns: Annotated[np.ndarray, Array("speeds")]  # rates of rotations with which the matrices were made
    factors: Annotated[np.ndarray, Array("factor_size", "factor_size")]
    pivots: Annotated[np.ndarray, Array("factor_size")]
    complex_factors: Annotated[np.ndarray, Array("2factor_size", "factor_size")]
    complex_pivots: Annotated[np.ndarray, Array("factor_size")]
    known: Annotated[np.ndarray, Array("entry_count")]  # entries of a tree
    masses: Annotated[np.ndarray, Array("mass_count")]
    tree_factors: Annotated[np.ndarray, Array("entry_count")]
    complex_tree_factors: Annotated[np.ndarray, Array("2entry_count")]
    tree_row: Annotated[np.ndarray, Array("2tree_size")]


@inlined
def _weights(nodes: np.ndarray, x: float) -> tuple[float, float, float]:
    """Return at x, of the step, the polynomials that are one at a node and zero at the start and the other nodes."""
    a, b, c = nodes[0], nodes[1], nodes[2]
    return (
        x / a * ((x - b) / (a - b)) * ((x - c) / (a - c)),
        x / b * ((x - a) / (b - a)) * ((x - c) / (b - c)),
        x / c * ((x - a) / (c - a)) * ((x - b) / (c - b)),
    )


@kernel
def guess_changes(step: RadauStep) -> None:
    """Write the changes of a step to come by extrapolating the polynomial of the last one, if that was long enough."""
    changes, polynomial = step.changes, step.polynomial
    if not (step.has_polynomial and step.h <= FARTHEST * step.polynomial_step):
        changes[:] = 0.0
        return
    for k in range(STAGES):
        a, b, c = _weights(step.nodes, 1.0 + step.nodes[k] * (step.h / step.polynomial_step))
        for i in range(step.size):
            changes[k, i] = a * polynomial[0, i] + b * polynomial[1, i] + (c - 1.0) * polynomial[2, i]


@pointer(INTERPOLATE)
def interpolate_radau(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: the collocation polynomial, of order 3."""
    step = RadauStep(integers, reals, vectors)
    if t == step.time:
        copy(step.state, out)
        return
    a, b, c = _weights(step.nodes, (t - step.time_old) / step.polynomial_step)
    _go_along(step.state_old, step.polynomial, a, b, c, out)
    normalise(step, out)


@vector_kernel
def _go_along(old: np.ndarray, rows: np.ndarray, a: float, b: float, c: float, out: np.ndarray) -> None:
    """Write a state and so many times three changes of it."""
    for i in range(len(out)):
        out[i] = old[i] + (a * rows[0, i] + b * rows[1, i] + c * rows[2, i])


@kernel
def normalise(step: Step, q: np.ndarray) -> None:
    """Bring Euler parameters to unit length."""
    moves = step.moves
    for row in range(len(moves)):
        if moves[row, 0] != STRAIGHT:
            at = moves[row, 1]
            length = np.sqrt(q[at] ** 2 + q[at + 1] ** 2 + q[at + 2] ** 2 + q[at + 3] ** 2)
            for i in range(at, at + 4):
                q[i] /= length
