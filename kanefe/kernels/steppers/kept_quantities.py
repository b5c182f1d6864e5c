"""What a step of the energy-momentum method keeps: the memory of the method, and corrections of a step by what is not.

Letters are those of `kanefe.kernels.steppers.energy_momentum`.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import (
    copy,
    cross,
    dot,
    minus,
    plus,
    put_three,
    six,
    symmetric_inverse,
    symmetric_times,
    three,
    times,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING
from kanefe.kernels.steppers.step_commands import (
    CENTRE,
    COORDINATES,
    ENERGY,
    ENERGY_SIZE,
    KEEPS_MOMENTA,
    KINETIC,
    LOCKED,
    MOMENTUM,
    OF_METHOD,
    REALS_OF_METHOD,
    RIGID,
    ROTORS,
    SPEEDS,
    SPIN,
    STATE,
    STEP,
    TIME,
    TOTAL_MASS,
    move,
)

# Integers of the method: sweeps of a step, corrections of it, and whether its directions are known
SWEEPS, CORRECTIONS, HAS_DIRECTIONS = range(OF_METHOD, OF_METHOD + 3)

# Reals of the method: what is kept, since when; d, of which turns are zero; parts of u' and z as of one rigid body, the
# second with g; the last changes of r and d; g; by how much b changes the energy; the sum of the sizes of all
# energies, the largest so far; how much the last iteration has changed
KEPT_ENERGY, KEPT_TIME = REALS_OF_METHOD, REALS_OF_METHOD + 1
KEPT_CENTRE, KEPT_MOMENTUM, KEPT_SPIN = range(REALS_OF_METHOD + 2, REALS_OF_METHOD + 11, 3)
SHIFT, RIGID_PART, RIGID_PART_OF_Z = range(REALS_OF_METHOD + 11, REALS_OF_METHOD + 29, 6)
LAST_PUSH, LAST_SHIFT, TURN = REALS_OF_METHOD + 29, REALS_OF_METHOD + 35, REALS_OF_METHOD + 38
GROWTH, LARGEST_ENERGY, CHANGE = range(REALS_OF_METHOD + 41, REALS_OF_METHOD + 44)
REALS = REALS_OF_METHOD + 44

# Rows of the method, after the rigid motions at the last balance: those in the middle of the step; unknowns as they are
# tried, as they follow from that, and those of the last step; the weighted difference of the first two; what is mixed;
# state at the end and move of the coordinates to it; and frequencies of modes in rad/s, given
DIRECTIONS = RIGID + 6
TRIED, FOUND, OLD, RESIDUAL = range(DIRECTIONS + 6, DIRECTIONS + 10)
MEMORY = DIRECTIONS + 10
NEW, MOVE, FREQUENCIES = range(MEMORY + ROWS_OF_MIXING, MEMORY + ROWS_OF_MIXING + 3)
ROWS = FREQUENCIES + 1

# Places in rows of unknowns: b, and r where momenta are kept, which takes a free body of seven coordinates; z is in the
# places of the speeds
SHARE, PUSH = 0, 1

CLOSE = 1e-13
"""Accuracy to which quantities are conserved, relative to speeds and to the largest energies so far."""

DIAGONAL = 0, 3, 5
"""Indices of the diagonal among the six numbers of a symmetric matrix."""


@inlined
def _total(integers: np.ndarray, reals: np.ndarray, state: np.ndarray) -> float:
    """Return energy + dissipated - work."""
    return reals[ENERGY] + state[len(state) - 2] - state[len(state) - 1]


@kernel
def _put_rigid_part(integers: np.ndarray, reals: np.ndarray, place: int) -> float:
    """Write v and w of the motion as of one rigid body; return twice the kinetic energy beyond."""
    if not integers[KEEPS_MOMENTA]:
        return 2.0 * reals[KINETIC]
    momentum, spin = three(reals, MOMENTUM), minus(three(reals, SPIN), three(reals, ROTORS))
    v = times(1.0 / reals[TOTAL_MASS], momentum)
    w = symmetric_times(symmetric_inverse(six(reals, LOCKED)), spin)
    put_three(reals, place, v)
    put_three(reals, place + 3, w)
    return max(2.0 * reals[KINETIC] - dot(v, momentum) - dot(w, spin), 0.0)


@kernel
def put_middle(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Take over directions in the middle of the step; the turn g is added to what j leaves of z later."""
    reals[GROWTH] = _put_rigid_part(integers, reals, RIGID_PART)
    if integers[KEEPS_MOMENTA]:
        for k in range(6):
            copy(vectors[RIGID + k], vectors[DIRECTIONS + k])
        steepest = cross(three(reals, RIGID_PART + 3), three(reals, SPIN))
        turn = symmetric_times(symmetric_inverse(six(reals, LOCKED)), steepest)
        put_three(reals, TURN, turn)
        reals[GROWTH] += 0.25 * reals[STEP] ** 2 * dot(turn, steepest)


@kernel
def put_z(integers: np.ndarray, reals: np.ndarray) -> None:
    """Take over the part of z as of one rigid body."""
    reals[GROWTH] += 0.25 * reals[STEP] ** 2 * _put_rigid_part(integers, reals, RIGID_PART_OF_Z)
    for k in range(3):
        reals[RIGID_PART_OF_Z + 3 + k] += reals[TURN + k]


@kernel
def correct(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Correct the unknowns beside z by what is not kept; return how much energy that is, of what is round-off.

    That is what would be left after `finish`.
    """
    found, residual = vectors[FOUND], vectors[RESIDUAL]
    size = reals[LARGEST_ENERGY] = max(reals[ENERGY_SIZE], reals[LARGEST_ENERGY])
    excess = left = _total(integers, reals, vectors[NEW]) - reals[KEPT_ENERGY]
    slip = 0.0
    if integers[KEEPS_MOMENTA]:
        h = reals[STEP]
        momentum = minus(three(reals, KEPT_MOMENTUM), three(reals, MOMENTUM))
        spin = minus(three(reals, KEPT_SPIN), three(reals, SPIN))
        v = times(1.0 / reals[TOTAL_MASS], momentum)
        w = symmetric_times(symmetric_inverse(six(reals, LOCKED)), spin)
        flown = times((reals[TIME] + h - reals[KEPT_TIME]) / reals[TOTAL_MASS], three(reals, KEPT_MOMENTUM))
        shift = minus(plus(three(reals, KEPT_CENTRE), flown), three(reals, CENTRE))
        put_three(reals, LAST_PUSH, v)
        put_three(reals, LAST_PUSH + 3, w)
        put_three(reals, LAST_SHIFT, shift)
        put_three(reals, SHIFT, plus(three(reals, SHIFT), shift))
        for k in range(6):
            found[PUSH + k] += reals[LAST_PUSH + k]
            inertia = reals[TOTAL_MASS] if k < 3 else reals[LOCKED + DIAGONAL[k - 3]]
            residual[PUSH + k] = reals[LAST_PUSH + k] * np.sqrt(inertia / size) / CLOSE if size > 0.0 else 0.0
            slip = max(slip, abs(residual[PUSH + k]))
        excess += dot(three(reals, RIGID_PART), momentum) + dot(three(reals, RIGID_PART + 3), spin)
        left += dot(v, three(reals, MOMENTUM)) + dot(w, minus(three(reals, SPIN), three(reals, ROTORS)))
        left += 0.5 * (dot(v, momentum) + dot(w, spin))
    residual[SHARE] = 0.0
    if abs(excess) > CLOSE * size and reals[GROWTH] > 0.0:
        change = min(max(excess / reals[GROWTH], -0.1), 0.1)
        found[SHARE] -= change
        residual[SHARE] = -change * np.sqrt(reals[GROWTH] / size) / CLOSE
    reals[CHANGE] = max(reals[CHANGE], slip)
    return abs(left) / (CLOSE * size) if left != 0.0 else 0.0


@kernel
def finish(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Take off what is left of momenta and of straight flight: far from N's origin it would weigh in those about it."""
    n, m, new = integers[COORDINATES], integers[SPEEDS], vectors[NEW]
    for i in range(n, n + m):
        for k in range(6):
            new[i] += reals[LAST_PUSH + k] * vectors[RIGID + k, i]
        for k in range(3):
            vectors[MOVE, i] += reals[LAST_SHIFT + k] * vectors[RIGID + k, i]
    move(integers, vectors[STATE], vectors[MOVE], n, new)


@kernel
def keep(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Take over what is to be kept from here on."""
    reals[KEPT_ENERGY] = _total(integers, reals, vectors[STATE])
    reals[KEPT_TIME] = reals[TIME]
    put_three(reals, KEPT_CENTRE, three(reals, CENTRE))
    put_three(reals, KEPT_MOMENTUM, three(reals, MOMENTUM))
    put_three(reals, KEPT_SPIN, three(reals, SPIN))
    reals[LARGEST_ENERGY] = reals[ENERGY_SIZE]
    for k in range(6):
        reals[SHIFT + k] = 0.0
    for row in (FOUND, OLD, RESIDUAL):
        vectors[row, :] = 0.0
