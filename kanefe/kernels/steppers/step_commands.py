"""How a method of integration and the equations talk: by commands, and through arrays with named places.

A method is a function ``advance(integers, reals, vectors, table)`` that returns what it wants done next: an evaluation,
a projection onto the loops, or that a step is accepted. It knows nothing of the scene, and the scene nothing of it, so
that one implementation serves scenes of every kind, in compiled code as well as where Python functions are called, and
a run can be left and taken up again at any command, from a file too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel, vector_kernel
from kanefe.kernels.compiler.arrays import Advance, Integers, Interpolate, RealRows, Reals
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.joints.ball import put_turned
from kanefe.kernels.sweeps.elastic import total

# Commands
START = 0
RATES = 1  # write dy/dt of the state AT at the time TIME_AT to SLOPE
IMPLICIT = 2  # the same with (M + s C + r K) in place of M, see `Reals`, and forces C, K times the pushes
ACCEPTED = 3  # a step has been taken: TIME and STATE are further
PROJECT = 4  # put STATE onto the loops, to the nearest place in the metric M + r K
JACOBIAN = 5  # write derivatives of the rates of AT at TIME_AT to the rows from JACOBIAN_ROW on: see `derivatives`
FAILED = 6  # no step is small enough, or a solution could not be found
DONE = 7  # TIME is STOP
BALANCE = 8  # write energy and, where kept, momenta and rigid motions of the state AT at the time TIME_AT
SETTLE = 11  # close the loops of the first output that is WAITING: see `kanefe.kernels.steppers.settled_outputs`
SAMPLE = 10  # call the function of a sampled controller: see `kanefe.kernels.steppers.sampling`
NO_INERTIA, NOT_FINITE = -1, -2  # of an evaluation: nothing moves along a joint, or the rates are no numbers

# Places in `integers`
(
    COMMAND,
    STAGE,
    STEPS,
    REJECTED,
    EVALUATIONS,
    FACTORISATIONS,
    JACOBIANS,
    COORDINATES,
    SPEEDS,
    IS_FIXED,
    HAS_LOOPS,
    WANTS_DENSE,
    WORST,
    REASON,
    STORED,
    LAST_STEP,
    MAP_SIZE,
    JACOBIAN_ROW,
    KEEPS_MOMENTA,
    IS_STIFF,
    IS_LEFT_OPEN,
    BREAKPOINTS,
    BENDS,
    LOCKED_SPEEDS,
    CONTINUES,  # begin with what is known of the scene: since the last step only what controllers hold has changed
    LOOKS_FOR_JUMPS,  # where steps become short is kept, since functions of the state may jump there
    SETTLES,
    WAITING,
) = range(28)
OF_METHOD = 28  # from here on a method has its own
MAP = 60  # triples of kind, coordinate and speed: how a coordinate moves

# Behind it, from the place BENDS on where that is not 0: the flexible bodies that are watched, see `kernels.bends`

# Why a method failed
TOO_SMALL, NO_CONVERGENCE, NO_NUMBERS, HELD = 1, 2, 3, 4

# How coordinates move
STRAIGHT, TURNING = 0, 1

# Places in `reals`
(
    TIME,
    TIME_OLD,
    TIME_AT,
    STEP,
    NEXT_STEP,
    STOP,
    SMALLEST,
    RELATIVE,
    NEXT_OUTPUT,
    SHARE_DAMPING,
    SHARE_STIFFNESS,
    ERROR,
    WEAKEST,
    LARGEST,
    LARGEST_OF_DRIVES,
) = range(15)

# What BALANCE writes to `reals`: energies, the second the sum of the sizes of its parts; and where KEEPS_MOMENTA is set
# the mass of the scene, its centre, its momentum, its angular momentum about the centre with that of rotors, that of
# rotors, and the inertia about the centre as of one rigid body
ENERGY, ENERGY_SIZE, KINETIC, TOTAL_MASS = range(15, 19)
CENTRE, MOMENTUM, SPIN, ROTORS, LOCKED = range(19, 32, 3)
TIME_EXCESS = 37  # by how much TIME is above the sum of fixed steps: taken off the next one
TO_EVENT = 38  # the longest next step that passes no event that is foreseen
REACH = 39  # how far behind the end of a step its polynomial is as good as within, in steps
LONGEST_RESTART = 40  # the longest first step after an event
# Of the accepted step that was the shortest of all relative to the longest before it, after others were rejected there:
# that share, and its start, whose state is in the row AT_SHORTEST; and the longest step, and the rejected ones, so far
SHORTEST_SHARE, TIME_OF_SHORTEST, LONGEST, REJECTED_SO_FAR = range(41, 45)
# What is allowed along modes, relative to the largest force, 0 where that is not asked; and the least, relative to what
# moves a body by its size: see `kanefe.kernels.steppers.force_scales`
OF_FORCES, LEAST_ALLOWED = range(45, 47)
REALS_OF_METHOD = 47

# From the place BREAKPOINTS on in `reals`, where it is not 0: the place of the next breakpoint, that of the last at
# which steps have to end, how many these are at a time, the rejected steps at the last look; then 0, or the place of
# as many times behind the breakpoints: the last ones before each at which functions of time have their values from
# before it (where none jumps, itself); then all breakpoints, s
NEXT_BREAKPOINT, LAST_KEPT, KEPT_AT_ONCE, REJECTED_BEFORE, LEFT_SIDES, FIRST_BREAKPOINT = range(6)
FEWEST_KEPT, MOST_KEPT = 8, 1024
EPSILON = 2.220446049250313e-16  # of numbers
PIECES_OF_FREE_STEP = 4.0  # steps that want more pieces of a table than these pass over its knots

# From the place LOCKED_SPEEDS on in `reals`, where it is not 0: the time between samples, s; for each speed the place
# of a row, or 0; and the rows: see `kanefe.integrate.locked_speeds`

# Rows of `vectors`, each of the length of a state (q, u, dissipated energy, work). ELASTIC is 1 at the speeds of modes
# of bodies, whose coordinates are settled. LARGE is SCALE for positions. UNIT is for modes one over a coordinate that
# moves their body by its size, and at their speeds the number of the body, from 1 on; LARGEST_FORCES at the first
# coordinate of each body the square of its largest force
AT, SLOPE, DAMPING_DIRECTION, STIFFNESS_DIRECTION, STATE, STATE_OLD, SCALE, AT_SHORTEST, ELASTIC = range(9)
LARGE, UNIT, LARGEST_FORCES = range(9, 12)
ROWS_OF_METHOD = 12
RIGID = ROWS_OF_METHOD  # with BALANCE six rows: speeds of the rigid motions of the scene, about its centre of mass


class Run(NamedTuple):
    """A method in the middle of a run.

    Attributes
    ----------
    advance, interpolate : functions
        Of the method; compiled: pointers of one type for all.
    integers, reals, table : ndarray
        Its memory, beside the vectors, and its coefficients.
    times : ndarray
        Output times, ascending.
    states : ndarray, shape (times, state)
    most_steps : int
        Count of accepted steps, from the start of the run, at which to return.
    clock : ndarray of int
        How long steps take: see `kanefe.kernels.steppers.step_times`; a zero alone measures nothing.
    """

    advance: Advance
    interpolate: Interpolate
    integers: Integers
    reals: Reals
    table: RealRows
    times: Reals
    states: RealRows
    most_steps: int
    clock: Integers


@inlined
def ask(integers: np.ndarray, command: int, stage: int) -> int:
    """Store where to continue, and return the command."""
    integers[COMMAND] = command
    integers[STAGE] = stage
    if command in (RATES, IMPLICIT):
        integers[EVALUATIONS] += 1
    return command


@kernel
def scaled_size(
    integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, error: np.ndarray, a: np.ndarray, b: np.ndarray
) -> float:
    """Return the largest component of an error, of what is allowed there; infinite if it is not finite.

    Allowed is the absolute tolerance and the relative one of the larger of two states. Of joint speeds counts what is
    left without vibrations. The worst that is told is a coordinate or a speed: energies only follow.
    """
    n, m, locked = integers[COORDINATES], integers[SPEEDS], integers[LOCKED_SPEEDS]
    largest, moving, share = 0.0, n + m, 0.0
    if locked > 0:
        every = reals[locked]
        share = min(every * max(1.0, every / reals[STEP]), 1.0)
    for i in range(len(error)):
        allowed = vectors[SCALE, i] + reals[RELATIVE] * max(abs(a[i]), abs(b[i]))
        off = error[i]
        if locked > 0 and n <= i < moving:
            row = int(reals[locked + 1 + i - n])
            if row > 0:
                off += total(reals[row : row + m], error[n:moving])
                off = max(abs(off), share * abs(error[i]))
        size = abs(off) / allowed
        if not size <= largest:
            largest = size
            if i < moving:
                integers[WORST] = i
            if not size < np.inf:
                return np.inf
    return largest


@kernel
def largest_share(integers: np.ndarray, shares: np.ndarray, first: int, end: int) -> float:
    """Return the largest of some shares of what is allowed, infinite if one is not finite; WORST is where it is."""
    largest = 0.0
    for i in range(first, end):
        size = abs(shares[i])
        if not size <= largest:
            largest = size
            integers[WORST] = i
            if not size < np.inf:
                return np.inf
    return largest


@kernel
def first_step(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, rates: np.ndarray) -> float:
    """Return a step that moves the state by a hundredth of what such rates do in one unit of error."""
    largest, span = 0.0, reals[STOP] - reals[TIME]
    for i in range(integers[COORDINATES] + integers[SPEEDS]):
        allowed = vectors[SCALE, i] + reals[RELATIVE] * abs(vectors[STATE, i])
        largest = max(largest, abs(rates[i]) / allowed)
    return min(1e-3 * span, 0.01 / (reals[RELATIVE] * largest) if largest > 0.0 else span)


@inlined
def end_of_breakpoints(integers: np.ndarray, reals: np.ndarray) -> int:
    """Return the place behind the last breakpoint."""
    sides = int(reals[integers[BREAKPOINTS] + LEFT_SIDES])
    return sides if sides > 0 else len(reals)


@kernel
def next_breakpoint(integers: np.ndarray, reals: np.ndarray) -> int:
    """Return the place of the first breakpoint after TIME, and keep it; one that is there but for round-off is met."""
    at, t = integers[BREAKPOINTS], reals[TIME]
    i, end = int(reals[at + NEXT_BREAKPOINT]), end_of_breakpoints(integers, reals)
    while i < end and reals[i] <= t + 1e-9 * (reals[i] - reals[i - 1]):
        i += 1
    while i > at + FIRST_BREAKPOINT + 1 and reals[i - 1] > t + 1e-9 * (reals[i - 1] - reals[i - 2]):
        i -= 1
    reals[at + NEXT_BREAKPOINT] = i
    return i


@kernel
def _meet_breakpoint(integers: np.ndarray, reals: np.ndarray) -> None:
    """Let a step that has come to a breakpoint but for the round-off of its length end there."""
    i = int(reals[integers[BREAKPOINTS] + NEXT_BREAKPOINT])
    if i < end_of_breakpoints(integers, reals) and abs(reals[TIME] - reals[i]) <= 4.0 * EPSILON * abs(reals[i]):
        reals[TIME] = reals[i]


@kernel
def has_jumped(integers: np.ndarray, reals: np.ndarray) -> bool:
    """Return whether a function of time jumps where the last step has ended, so that its last rates are not the next.

    A method asks this after each step, and then begins anew with its step and what it knows of the scene.
    """
    if integers[BREAKPOINTS] == 0 or integers[IS_FIXED]:
        return False
    first, sides = integers[BREAKPOINTS] + FIRST_BREAKPOINT, int(reals[integers[BREAKPOINTS] + LEFT_SIDES])
    i = next_breakpoint(integers, reals) - 1
    return sides > 0 and reals[TIME_OLD] < reals[i] and reals[sides + i - first] < reals[i]


@kernel
def stay_on_side(integers: np.ndarray, reals: np.ndarray) -> None:
    """Bring TIME_AT between the breakpoints about the step, to the sides of them on which the step is.

    A step that ends where a function of time jumps is with the value from before, the one that begins there with that
    from then on.
    """
    at = integers[BREAKPOINTS]
    sides = int(reals[at + LEFT_SIDES])
    if sides == 0:
        return
    i = next_breakpoint(integers, reals)
    reals[TIME_AT] = max(reals[TIME_AT], reals[i - 1])
    if i < sides:
        reals[TIME_AT] = min(reals[TIME_AT], reals[sides + i - at - FIRST_BREAKPOINT])


@kernel
def accept(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, new: np.ndarray) -> int:
    """Make `new` the state at the end of the step, and say so; a step to what is no number fails."""
    for i in range(len(new)):
        if not abs(new[i]) < np.inf:
            integers[REASON], integers[WORST] = NO_NUMBERS, i
            return FAILED
    copy(vectors[STATE], vectors[STATE_OLD])
    copy(new, vectors[STATE])
    reals[TIME_OLD] = reals[TIME]
    if integers[LAST_STEP]:
        reals[TIME] = reals[STOP]
    elif not integers[IS_FIXED]:
        reals[TIME] += reals[STEP]
        if integers[BREAKPOINTS] > 0:
            _meet_breakpoint(integers, reals)
    else:  # Kahan's sum: a million rounded steps would end beside the outputs, and what is kept is so at their ends
        step = reals[STEP] - reals[TIME_EXCESS]
        reals[TIME] += step
        reals[TIME_EXCESS] = (reals[TIME] - reals[TIME_OLD]) - step
    integers[STEPS] += 1
    return ACCEPTED


@inlined
def begin_at(integers: np.ndarray, reals: np.ndarray, t: float) -> None:
    """Let the next step begin at a time, from what is in STATE then."""
    reals[TIME], reals[TIME_OLD], reals[TIME_EXCESS] = t, t, 0.0
    integers[COMMAND], integers[STAGE], integers[CONTINUES] = START, 0, 0


@kernel
def watch_steps(integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray) -> None:
    """Keep where an accepted step is the shortest, relative to the longest before it, since others were rejected there.

    Across a jump of a function of the state no step keeps its order: they are rejected until they are short.
    """
    step, rejected = reals[TIME] - reals[TIME_OLD], integers[REJECTED] - reals[REJECTED_SO_FAR]
    reals[REJECTED_SO_FAR] = integers[REJECTED]
    if rejected > 0.0 and step < reals[SHORTEST_SHARE] * reals[LONGEST]:
        reals[SHORTEST_SHARE], reals[TIME_OF_SHORTEST] = step / reals[LONGEST], reals[TIME_OLD]
        copy(vectors[STATE_OLD], vectors[AT_SHORTEST])
    reals[LONGEST] = max(reals[LONGEST], step)


@inlined
def await_output(run: Run) -> None:
    """Write when the next output is."""
    stored = run.integers[STORED]
    run.reals[NEXT_OUTPUT] = run.times[stored] if stored < len(run.times) else np.inf


@inlined
def take_back_outputs(run: Run, t: float) -> None:
    """Let outputs after a time be written again."""
    stored = run.integers[STORED]
    while stored > 0 and run.times[stored - 1] > t:
        stored -= 1
    run.integers[STORED] = stored
    await_output(run)


@vector_kernel
def is_finite(x: np.ndarray) -> bool:
    """Return whether no number of x is infinite or not a number."""
    total = 0.0
    for i in range(len(x)):
        total += abs(x[i].real) + abs(x[i].imag)
    return total < np.inf


@kernel
def breakpoint_ahead(integers: np.ndarray, reals: np.ndarray, wanted: float) -> float:
    """Return the breakpoint of a table at which the step must end, s; infinity if steps may pass over breakpoints.

    No method is of its order across a kink. Where a step that passes over knots is rejected until few are left, the
    next steps end at them: `FEWEST_KEPT` at first, twice as many each time that a longer step fails at once again.
    """
    at, t = integers[BREAKPOINTS], reals[TIME]
    i = next_breakpoint(integers, reals)
    is_rejected = integers[REJECTED] > reals[at + REJECTED_BEFORE]
    reals[at + REJECTED_BEFORE] = integers[REJECTED]
    if i == end_of_breakpoints(integers, reals):
        return np.inf
    free = PIECES_OF_FREE_STEP * (reals[i] - reals[i - 1])
    last = reals[at + LAST_KEPT]
    if i > last:
        if not (is_rejected and t + reals[STEP] > reals[i] and wanted < free):
            return np.inf
        is_same = i <= last + 2.0 * PIECES_OF_FREE_STEP
        reals[at + KEPT_AT_ONCE] = min(2.0 * reals[at + KEPT_AT_ONCE], MOST_KEPT) if is_same else FEWEST_KEPT
        reals[at + LAST_KEPT] = i + reals[at + KEPT_AT_ONCE]
    reals[NEXT_STEP] = min(reals[NEXT_STEP], free)  # steps that end at knots have errors so small that they say nothing
    return reals[i]


@inlined
def even_part(wanted: float, rest: float) -> float:
    """Return the step wanted, or all that is left, or half of it: two even steps are better than one and a sliver."""
    if wanted >= rest * (1.0 - 1e-9):
        return rest
    return wanted if wanted <= 0.5 * rest else 0.5 * rest


@inlined
def clip(integers: np.ndarray, reals: np.ndarray, wanted: float) -> None:
    """Set the step: the one wanted, or an even part of what is left; fixed ones are cut at the end alone."""
    rest, next_break = reals[STOP] - reals[TIME], np.inf
    if not integers[IS_FIXED]:
        wanted = min(wanted, reals[LARGEST], reals[LARGEST_OF_DRIVES], reals[TO_EVENT])
        if integers[BREAKPOINTS] > 0:
            next_break = breakpoint_ahead(integers, reals, wanted) - reals[TIME]
    integers[LAST_STEP] = 1 if min(wanted, next_break) >= rest * (1.0 - 1e-9) else 0
    rest = min(rest, next_break)
    is_whole = integers[IS_FIXED] and wanted < rest * (1.0 - 1e-9)
    reals[STEP] = wanted if is_whole else even_part(wanted, rest)


@kernel
def move(integers: np.ndarray, q: np.ndarray, step: np.ndarray, first: int, moved: np.ndarray) -> None:
    """Write coordinates moved along the speeds by ``step[first:]``; rotations by the exponential map."""
    for row in range(integers[MAP_SIZE]):
        kind, at, speed = integers[MAP + 3 * row], integers[MAP + 3 * row + 1], first + integers[MAP + 3 * row + 2]
        if kind == STRAIGHT:
            moved[at] = q[at] + step[speed]
            continue
        put_turned(moved, at, q, step[speed], step[speed + 1], step[speed + 2])


@kernel
def move_within(
    integers: np.ndarray,
    old: np.ndarray,
    new: np.ndarray,
    s: np.ndarray,
    x: float,
    h: float,
    part: np.ndarray,
    out: np.ndarray,
) -> None:
    """Write coordinates and speeds at a share x of a step h of move s: a cubic that meets the speeds at both ends."""
    n, m = integers[COORDINATES], integers[SPEEDS]
    for i in range(n, n + m):
        start, end = h * old[i], h * new[i]
        part[i] = x * (1.0 - x) ** 2 * start + x * x * (x - 1.0) * end + x * x * (3.0 - 2.0 * x) * s[i]
        out[i] = ((1.0 - x) * (1.0 - 3.0 * x) * start + x * (3.0 * x - 2.0) * end + 6.0 * x * (1.0 - x) * s[i]) / h
    move(integers, old, part, n, out)


@kernel
def turn(integers: np.ndarray, q: np.ndarray, h: float, speeds: np.ndarray, first: int, changes: np.ndarray) -> None:
    """Add to small changes of the coordinates q those of speeds ``speeds[first:]`` in a time h, to first order."""
    for row in range(integers[MAP_SIZE]):
        kind, at, speed = integers[MAP + 3 * row], integers[MAP + 3 * row + 1], first + integers[MAP + 3 * row + 2]
        if kind == STRAIGHT:
            changes[at] += h * speeds[speed]
            continue
        x, y, z = 0.5 * h * speeds[speed], 0.5 * h * speeds[speed + 1], 0.5 * h * speeds[speed + 2]
        e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
        changes[at] -= e1 * x + e2 * y + e3 * z
        changes[at + 1] += e0 * x + e2 * z - e3 * y
        changes[at + 2] += e0 * y - e1 * z + e3 * x
        changes[at + 3] += e0 * z + e1 * y - e2 * x


@entry()
def interpolated(
    interpolate: Interpolate, integers: Integers, reals: Reals, vectors: RealRows, table: RealRows, t: float, out: Reals
) -> None:
    """Write the state at a time of the last step, for a call from Python."""
    interpolate(integers, reals, vectors, table, t, out)
