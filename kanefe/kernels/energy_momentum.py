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
stiff modes and springs; what is gyroscopic converges with the step. What is kept is compared with its value at the
start of the run, so that neither round-off nor an iteration left early adds up over the steps.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels._numba import inlined, kernel
from kanefe.kernels.stepping import (
    ACCEPTED,
    AT,
    BALANCE,
    CENTRE,
    COORDINATES,
    DONE,
    ENERGY,
    ENERGY_SIZE,
    FAILED,
    IMPLICIT,
    KEEPS_MOMENTA,
    KINETIC,
    LOCKED,
    MOMENTUM,
    NEXT_STEP,
    NO_CONVERGENCE,
    OF_METHOD,
    PUSH_DAMPING,
    PUSH_STIFFNESS,
    REALS_OF_METHOD,
    REASON,
    RIGID,
    ROTORS,
    SCALE,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    SLOPE,
    SPEEDS,
    SPIN,
    STAGE,
    STATE,
    STATE_OLD,
    STEP,
    STOP,
    TIME,
    TIME_AT,
    TIME_OLD,
    TOTAL_MASS,
    WORST,
    accept,
    ask,
    clip,
    move,
)
from kanefe.kernels.vectors import (
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

# Integers of the method: sweeps of a step, and whether its directions are known
SWEEPS, HAS_DIRECTIONS = OF_METHOD, OF_METHOD + 1

# Reals of the method: what is kept, since when; r; d, of which turns are zero; parts of u' and z as of one rigid body,
# the second with g; the last change of r; g; b, and by how much it changes the energy; the sum of the sizes of all
# energies, the largest so far; how much the last sweep has changed
KEPT_ENERGY, KEPT_TIME = REALS_OF_METHOD, REALS_OF_METHOD + 1
KEPT_CENTRE, KEPT_MOMENTUM, KEPT_SPIN = range(REALS_OF_METHOD + 2, REALS_OF_METHOD + 11, 3)
PUSH, SHIFT, RIGID_PART, RIGID_PART_OF_Z = range(REALS_OF_METHOD + 11, REALS_OF_METHOD + 35, 6)
LAST_PUSH, TURN = REALS_OF_METHOD + 35, REALS_OF_METHOD + 41
SHARE, GROWTH, LARGEST_ENERGY, CHANGE = range(REALS_OF_METHOD + 44, REALS_OF_METHOD + 48)
REALS = REALS_OF_METHOD + 48

# Rows of the method, after the rigid motions at the last balance: those in the middle of the step, z of this step and
# of the last one, state at the end and move of the coordinates to it
DIRECTIONS = RIGID + 6
Z, Z_OLD, NEW, MOVE = range(DIRECTIONS + 6, DIRECTIONS + 10)
ROWS = DIRECTIONS + 10

MANY_SWEEPS, MOST_SWEEPS = 20, 60

CLOSE = 1e-13
"""Of speeds, and of the largest energies so far: a step is solved and what is kept is kept to this."""

ROUGH = 1e5
"""Times as much: accelerations good enough to see by them what is not kept."""

BEGIN, REFERENCE, ITERATED, OF_MIDDLE, OF_Z, WEIGHED, NEXT = range(7)


@kernel
def _put_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Write the speeds in the middle and at the end and the move of the coordinates that follow from the unknowns."""
    n, m, h, b = integers[COORDINATES], integers[SPEEDS], reals[STEP], reals[SHARE]
    state, at, z, new, s = vectors[STATE], vectors[AT], vectors[Z], vectors[NEW], vectors[MOVE]
    turn = 0.25 * b * h * h
    for i in range(n, n + m):
        pushed, shifted = h * z[i], -turn * z[i]
        if integers[KEEPS_MOMENTA]:
            for k in range(6):
                direction = vectors[DIRECTIONS + k, i]
                pushed += (reals[PUSH + k] - b * reals[RIGID_PART + k]) * direction
                shifted += (turn * reals[RIGID_PART_OF_Z + k] + reals[SHIFT + k]) * direction
        at[i] = (state[i] + 0.5 * pushed) / (1.0 - 0.5 * b)
        new[i] = 2.0 * at[i] - state[i]
        s[i] = h * at[i] + shifted


@kernel
def _ask_middle(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Ask for z in the middle of the step."""
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[STEP]
    state, at, z, s, half = vectors[STATE], vectors[AT], vectors[Z], vectors[MOVE], vectors[SLOPE]
    _put_step(integers, reals, vectors)
    for i in range(n, n + m):
        half[i] = 0.5 * s[i]
        vectors[PUSH_DAMPING, i] = 0.5 * h * z[i]
        vectors[PUSH_STIFFNESS, i] = 0.25 * h * h * z[i]
    move(integers, state, half, n, at)
    for i in range(n + m, len(state)):
        at[i] = state[i]
    reals[SHARE_DAMPING], reals[SHARE_STIFFNESS] = 0.5 * h, 0.25 * h * h
    reals[TIME_AT] = reals[TIME] + 0.5 * h
    integers[SWEEPS] += 1
    return ask(integers, IMPLICIT, ITERATED)


@kernel
def _change(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Take z over; return by how much the speeds change by it, of what is round-off."""
    n, m, largest = integers[COORDINATES], integers[SPEEDS], 0.0
    for i in range(n, n + m):
        change = abs(reals[STEP] * (vectors[SLOPE, i] - vectors[Z, i]))
        size = change / (CLOSE * abs(vectors[AT, i]) + 0.1 * vectors[SCALE, i])
        vectors[Z, i] = vectors[SLOPE, i]
        if not size <= largest:
            largest = size
            integers[WORST] = i
            if not size < np.inf:
                return np.inf
    return largest


@kernel
def _complete(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Write coordinates and works at the end of the step."""
    n, m, new = integers[COORDINATES], integers[SPEEDS], vectors[NEW]
    _put_step(integers, reals, vectors)
    move(integers, vectors[STATE], vectors[MOVE], n, new)
    for i in range(n + m, len(new)):
        new[i] = vectors[STATE, i] + reals[STEP] * vectors[SLOPE, i]


@kernel
def _ask_balance(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Ask for the balance at the end of the step."""
    copy(vectors[NEW], vectors[AT])
    reals[TIME_AT] = reals[TIME] + reals[STEP]
    return ask(integers, BALANCE, WEIGHED)


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
def _put_middle(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
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
def _put_z(integers: np.ndarray, reals: np.ndarray) -> None:
    """Take over the part of z as of one rigid body."""
    reals[GROWTH] += 0.25 * reals[STEP] ** 2 * _put_rigid_part(integers, reals, RIGID_PART_OF_Z)
    for k in range(3):
        reals[RIGID_PART_OF_Z + 3 + k] += reals[TURN + k]


@kernel
def _correct(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> float:
    """Correct the unknowns beside z by what is not kept; return how much that is, of what is round-off."""
    size = reals[LARGEST_ENERGY] = max(reals[ENERGY_SIZE], reals[LARGEST_ENERGY])
    excess = _total(integers, reals, vectors[NEW]) - reals[KEPT_ENERGY]
    missing = abs(excess)
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
        for k in range(6):
            reals[PUSH + k] += reals[LAST_PUSH + k]
        put_three(reals, SHIFT, plus(three(reals, SHIFT), shift))
        missing = max(missing, np.sqrt(0.5 * (dot(v, momentum) + dot(w, spin)) * size))
        excess += dot(three(reals, RIGID_PART), momentum) + dot(three(reals, RIGID_PART + 3), spin)
    if abs(excess) > CLOSE * size and reals[GROWTH] > 0.0:
        reals[SHARE] -= min(max(excess / reals[GROWTH], -0.1), 0.1)
    return missing / (CLOSE * size) if missing > 0.0 else 0.0


@kernel
def _finish_momenta(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Take off what the iteration leaves of the momenta: far from N's origin it would weigh in those about it."""
    n, new = integers[COORDINATES], vectors[NEW]
    for i in range(n, n + integers[SPEEDS]):
        for k in range(6):
            new[i] += reals[LAST_PUSH + k] * vectors[RIGID + k, i]


@kernel
def _keep(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Take over what is to be kept from here on."""
    reals[KEPT_ENERGY] = _total(integers, reals, vectors[STATE])
    reals[KEPT_TIME] = reals[TIME]
    put_three(reals, KEPT_CENTRE, three(reals, CENTRE))
    put_three(reals, KEPT_MOMENTUM, three(reals, MOMENTUM))
    put_three(reals, KEPT_SPIN, three(reals, SPIN))
    reals[SHARE] = 0.0
    reals[LARGEST_ENERGY] = reals[ENERGY_SIZE]
    for k in range(6):
        reals[PUSH + k] = reals[SHIFT + k] = 0.0
    vectors[Z, :] = 0.0
    vectors[Z_OLD, :] = 0.0


@kernel
def _begin_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> int:
    """Begin a step from the unknowns of the last one."""
    clip(integers, reals, reals[NEXT_STEP])
    z, old = vectors[Z], vectors[Z_OLD]
    for i in range(len(z)):  # straight on from the last two steps
        z[i], old[i] = 2.0 * z[i] - old[i], z[i]
    integers[SWEEPS] = integers[HAS_DIRECTIONS] = 0
    reals[CHANGE] = np.inf
    return _ask_middle(integers, reals, vectors)


@kernel
def _fail(integers: np.ndarray) -> int:
    integers[REASON] = NO_CONVERGENCE
    return ask(integers, FAILED, NEXT)


def advance_keeping(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray) -> int:
    """Go on with the method: see `kanefe.kernels.stepping`."""
    stage = integers[STAGE]
    if stage == BEGIN:
        copy(vectors[STATE], vectors[AT])
        reals[TIME_AT] = reals[TIME]
        return ask(integers, BALANCE, REFERENCE)
    if stage == ITERATED:
        before = reals[CHANGE]
        reals[CHANGE] = _change(integers, reals, vectors)
        diverges = integers[SWEEPS] > 4 and reals[CHANGE] > max(1e12, 0.5 * before)
        if diverges or not reals[CHANGE] < np.inf or integers[SWEEPS] > MOST_SWEEPS:
            return _fail(integers)
        if reals[CHANGE] > ROUGH:
            return _ask_middle(integers, reals, vectors)
        _complete(integers, reals, vectors)
        if not integers[HAS_DIRECTIONS]:
            return ask(integers, BALANCE, OF_MIDDLE)
        return _ask_balance(integers, reals, vectors)
    if stage == OF_MIDDLE:
        _put_middle(integers, reals, vectors)
        n = integers[COORDINATES]
        copy(vectors[Z, n : n + integers[SPEEDS]], vectors[AT, n:])
        return ask(integers, BALANCE, OF_Z)
    if stage == OF_Z:
        _put_z(integers, reals)
        integers[HAS_DIRECTIONS] = 1
        return _ask_balance(integers, reals, vectors)
    if stage == WEIGHED:
        missing = _correct(integers, reals, vectors)
        if not missing < np.inf:
            return _fail(integers)
        # where round-off is above what is aimed at, what many sweeps leave is small enough
        if max(missing, reals[CHANGE]) > (1.0 if integers[SWEEPS] < MANY_SWEEPS else 1e2):
            return _ask_middle(integers, reals, vectors)
        if integers[KEEPS_MOMENTA]:
            _finish_momenta(integers, reals, vectors)
        ask(integers, ACCEPTED, NEXT)
        return accept(integers, reals, vectors, vectors[NEW])
    if stage == REFERENCE:
        _keep(integers, reals, vectors)
    if reals[TIME] >= reals[STOP]:
        return ask(integers, DONE, NEXT)
    return _begin_step(integers, reals, vectors)


def interpolate_keeping(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, table: np.ndarray, t: float, out: np.ndarray
) -> None:
    """Write the state at a time of the last step: a cubic move that meets the speeds at both ends."""
    copy(vectors[STATE], out)
    if t >= reals[TIME]:
        return
    n, m, h = integers[COORDINATES], integers[SPEEDS], reals[STEP]
    old, s, part = vectors[STATE_OLD], vectors[MOVE], vectors[SLOPE]
    x = (t - reals[TIME_OLD]) / h
    for i in range(n, n + m):
        start, end = h * old[i], h * vectors[STATE, i]
        part[i] = x * (1.0 - x) ** 2 * start + x * x * (x - 1.0) * end + x * x * (3.0 - 2.0 * x) * s[i]
        out[i] = ((1.0 - x) * (1.0 - 3.0 * x) * start + x * (3.0 * x - 2.0) * end + 6.0 * x * (1.0 - x) * s[i]) / h
    move(integers, old, part, n, out)
    for i in range(n + m, len(out)):
        out[i] = (1.0 - x) * old[i] + x * vectors[STATE, i]
