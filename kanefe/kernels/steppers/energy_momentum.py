"""The energy-momentum method: implicit midpoint on the group, with what the motion keeps kept by every step.

A step solves for accelerations z, and where the scene flies freely for a rigid motion r = (v, w) and a shift d of it:

    u+ = u + h z + b i + R r,    q+ = q moved by  s = h u' + b h^2/4 (R g - j) + T d,    u' = (u + u+) / 2,
    M z = F  where q is moved by s / 2, with the speeds u' and at half the step,
    energy + dissipated - work, momentum, angular momentum and straight flight of the centre of mass as at the start.

Columns of R and T are rigid motions and translations of the whole scene, i and j the parts of u' and z beyond those of
one rigid body, and g turns that body: with given momenta its energy depends on its attitude alone. So b changes the
energy by ``2 E_kin(i) + h^2/2 (E_kin(j) + E_kin(g))``, which is zero only where nothing changes. b, r and d are of the
size of the error of the midpoint rule, h^3, and order 2 stays (Hairer, Lubich & Wanner, Geometric Numerical
Integration, 2006, IV.4). All directions are those in the middle: the step is symmetric (V.4.1), a run backwards
returns.

Accelerations are iterated by the linearly implicit sweep, ``(M + h/2 C + h^2/4 K) dz = F - M z``: at once right for
stiff modes and springs; what is gyroscopic converges with the step. The end of the step is weighed with the z just
found, in which these are in balance with b and r: with the z before, a change of b strains modes by ``b i h / 2``,
whose energy is many times what b changes in truth, and b runs away as soon as ``h omega > 1``. z, b and r together are
then mixed by Anderson's acceleration, which finds the few directions in which they answer each other. They start
straight on from the last two steps; z of a mode turns by ``2 atan(h omega / 2)`` in each, and is turned on by that.

What is kept is compared with its value at the start of the run, so that neither round-off nor an iteration left early
adds up over the steps.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import ADVANCE, INTERPOLATE
from kanefe.kernels.compiler.entries import pointer
from kanefe.kernels.steppers.kept_quantities import (
    CHANGE,
    CLOSE,
    CORRECTIONS,
    DIRECTIONS,
    FOUND,
    FREQUENCIES,
    HAS_DIRECTIONS,
    MEMORY,
    MOVE,
    NEW,
    OLD,
    PUSH,
    RESIDUAL,
    RIGID_PART,
    RIGID_PART_OF_Z,
    SHARE,
    SHIFT,
    SWEEPS,
    TRIED,
    correct,
    finish,
    keep,
    put_middle,
    put_z,
)
from kanefe.kernels.steppers.mixing import ROWS_OF_MIXING, mix
from kanefe.kernels.steppers.step_commands import (
    ACCEPTED,
    AT,
    BALANCE,
    COORDINATES,
    DAMPING_DIRECTION,
    DONE,
    FAILED,
    IMPLICIT,
    KEEPS_MOMENTA,
    NEXT_STEP,
    NO_CONVERGENCE,
    REASON,
    SCALE,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    SPEEDS,
    STAGE,
    STATE,
    STATE_OLD,
    STEP,
    STIFFNESS_DIRECTION,
    STOP,
    TIME,
    TIME_AT,
    TIME_OLD,
    accept,
    ask,
    clip,
    largest_share,
    move,
    move_within,
)

MANY_SWEEPS, MOST_SWEEPS = 30, 60

SOLVED = 10.0
"""Tolerance of the unknowns in multiples of `CLOSE`; the conserved quantities do not depend on it."""

ROUGH = 1e7
"""Accuracy of the accelerations, in multiples of `CLOSE`, that suffices to see which quantities are not conserved."""

BEGIN, REFERENCE, ITERATED, OF_MIDDLE, OF_Z, WEIGHED, NEXT = range(7)


@kernel
def _put_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, x: np.ndarray) -> None:
    """Write the speeds in the middle and at the end and the move of the coordinates that follow from unknowns x."""
    n, m, h, b = integers[COORDINATES], integers[SPEEDS], reals[STEP], x[SHARE]
    state, at, new, s = vectors[STATE], vectors[AT], vectors[NEW], vectors[MOVE]
    turn = 0.25 * b * h * h
    for i in range(n, n + m):
        pushed, shifted = h * x[i], -turn * x[i]
        if integers[KEEPS_MOMENTA]:
            for k in range(6):
                direction = vectors[DIRECTIONS + k, i]
                pushed += (x[PUSH + k] - b * reals[RIGID_PART + k]) * direction
                shifted += (turn * reals[RIGID_PART_OF_Z + k] + reals[SHIFT + k]) * direction
        at[i] = (state[i] + 0.5 * pushed) / (1.0 - 0.5 * b)
        new[i] = 2.0 * at[i] - state[i]
        s[i] = h * at[i] + shifted


@kernel
def _ask_middle(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Ask for z in the middle of the step."""
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[STEP]
    state, at, z, half = vectors[STATE], vectors[AT], vectors[TRIED], vectors[SLOPE]
    _put_step(integers, reals, vectors, z)
    for i in range(n, n + m):
        half[i] = 0.5 * vectors[MOVE, i]
        vectors[DAMPING_DIRECTION, i] = 0.5 * h * z[i]
        vectors[STIFFNESS_DIRECTION, i] = 0.25 * h * h * z[i]
    move(integers, state, half, n, at)
    for i in range(n + m, len(state)):
        at[i] = state[i]
    reals[SHARE_DAMPING], reals[SHARE_STIFFNESS] = 0.5 * h, 0.25 * h * h
    reals[TIME_AT] = reals[TIME] + 0.5 * h
    integers[SWEEPS] += 1
    return ask(integers, IMPLICIT, ITERATED)


@kernel
def _take_over(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Write what is found of z, and the residual; return by how much the speeds change by it, of what is round-off."""
    n, end = integers[COORDINATES], integers[COORDINATES] + integers[SPEEDS]
    copy(vectors[TRIED], vectors[FOUND])
    for i in range(n, end):
        vectors[FOUND, i] = vectors[SLOPE, i]
        allowed = CLOSE * abs(vectors[STATE, i]) + 0.1 * vectors[SCALE, i]
        vectors[RESIDUAL, i] = reals[STEP] * (vectors[SLOPE, i] - vectors[TRIED, i]) / allowed
    return largest_share(integers, vectors[RESIDUAL], n, end)


@kernel
def _complete(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Write the state at the end of the step that follows from what is found."""
    n, m, new = integers[COORDINATES], integers[SPEEDS], vectors[NEW]
    _put_step(integers, reals, vectors, vectors[FOUND])
    move(integers, vectors[STATE], vectors[MOVE], n, new)
    for i in range(n + m, len(new)):
        new[i] = vectors[STATE, i] + reals[STEP] * vectors[SLOPE, i]


@kernel
def _ask_balance(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Ask for the balance at the end of the step."""
    copy(vectors[NEW], vectors[AT])
    reals[TIME_AT] = reals[TIME] + reals[STEP]
    return ask(integers, BALANCE, WEIGHED)


@kernel
def _begin_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Begin a step: straight on from the unknowns of the last two; modes that it does not resolve turn in each step."""
    clip(integers, reals, reals[NEXT_STEP])
    tried, found, old = vectors[TRIED], vectors[FOUND], vectors[OLD]
    for i in range(len(tried)):
        square = (0.5 * reals[STEP] * vectors[FREQUENCIES, i]) ** 2
        tried[i] = 2.0 * (1.0 - square) / (1.0 + square) * found[i] - old[i]
    copy(found, old)
    integers[SWEEPS] = integers[CORRECTIONS] = integers[HAS_DIRECTIONS] = 0
    reals[CHANGE] = np.inf
    return _ask_middle(integers, reals, vectors)


@kernel
def _fail(integers: np.ndarray) -> int:
    integers[REASON] = NO_CONVERGENCE
    return ask(integers, FAILED, NEXT)


@pointer(ADVANCE)
def advance_keeping(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Continue the method: see `kanefe.kernels.steppers.step_commands`."""
    stage = integers[STAGE]
    if stage == BEGIN:
        copy(vectors[STATE], vectors[AT])
        reals[TIME_AT] = reals[TIME]
        return ask(integers, BALANCE, REFERENCE)
    if stage == ITERATED:
        before = reals[CHANGE]
        reals[CHANGE] = _take_over(integers, reals, vectors)
        diverges = integers[SWEEPS] > 4 and reals[CHANGE] > max(1e12, 0.5 * before)
        if diverges or not reals[CHANGE] < np.inf or integers[SWEEPS] > MOST_SWEEPS:
            return _fail(integers)
        if reals[CHANGE] > ROUGH and not integers[HAS_DIRECTIONS]:
            copy(vectors[FOUND], vectors[TRIED])
            return _ask_middle(integers, reals, vectors)
        if not integers[HAS_DIRECTIONS]:
            _put_step(integers, reals, vectors, vectors[FOUND])
            return ask(integers, BALANCE, OF_MIDDLE)
        _complete(integers, reals, vectors)
        return _ask_balance(integers, reals, vectors)
    if stage == OF_MIDDLE:
        put_middle(integers, reals, vectors)
        n = integers[COORDINATES]
        copy(vectors[FOUND, n : n + integers[SPEEDS]], vectors[AT, n:])
        return ask(integers, BALANCE, OF_Z)
    if stage == OF_Z:
        put_z(integers, reals)
        integers[HAS_DIRECTIONS] = 1
        _complete(integers, reals, vectors)
        return _ask_balance(integers, reals, vectors)
    if stage == WEIGHED:
        missing = correct(integers, reals, vectors)
        if not missing < np.inf:
            return _fail(integers)
        # where round-off is above what is aimed at, what many sweeps leave is small enough
        if max(missing, reals[CHANGE] / SOLVED) > (1.0 if integers[SWEEPS] < MANY_SWEEPS else 1e2):
            mix(
                vectors[MEMORY : MEMORY + ROWS_OF_MIXING],
                integers[CORRECTIONS],
                vectors[RESIDUAL],
                vectors[FOUND],
                vectors[TRIED],
            )
            integers[CORRECTIONS] += 1
            return _ask_middle(integers, reals, vectors)
        if integers[KEEPS_MOMENTA]:
            finish(integers, reals, vectors)
        ask(integers, ACCEPTED, NEXT)
        return accept(integers, reals, vectors, vectors[NEW])
    if stage == REFERENCE:
        keep(integers, reals, vectors)
    if reals[TIME] >= reals[STOP]:
        return ask(integers, DONE, NEXT)
    return _begin_step(integers, reals, vectors)


@pointer(INTERPOLATE)
def interpolate_keeping(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: a cubic move that meets the speeds at both ends."""
    copy(vectors[STATE], out)
    if t == reals[TIME]:
        return
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[STEP]
    old, s, part = vectors[STATE_OLD], vectors[MOVE], vectors[SLOPE]
    x = (t - reals[TIME_OLD]) / h
    move_within(integers, old, vectors[STATE], s, x, h, part, out)
    for i in range(n + m, len(out)):
        out[i] = (1.0 - x) * old[i] + x * vectors[STATE, i]
