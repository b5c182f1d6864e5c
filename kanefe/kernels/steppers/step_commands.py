"""How a method of integration and the equations talk: by commands, and through a record.

A method is a function ``advance(integers, reals, vectors, table)`` that returns what it wants done next: an evaluation,
a projection onto the loops, or that a step is accepted. It knows nothing of the scene, and the scene nothing of it, so
that one implementation serves scenes of every kind, in compiled code as well as where Python functions are called, and
a run can be left and taken up again at any command, from a file too. The arrays are the memory of a `Step`, to which
each method adds its own fields.
"""

from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import Advance, Integers, Interpolate, RealRows, Reals
from kanefe.kernels.language import Array, Record, Start, copy, entry, inlined, kernel, vector_kernel
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.values.tensors import Symmetric, Vector


class Command(IntEnum):
    """What a method wants."""

    START = 0  # nothing yet
    RATES = 1  # dy/dt of the state `at` at the time `time_at`, in `slope`
    IMPLICIT = 2  # the same with (M + s C + r K) in place of M, and forces C, K times the two directions
    ACCEPTED = 3  # nothing: a step has been taken, `time` and `state` are further
    PROJECT = 4  # `state` put onto the loops, to the nearest place in the metric M + r K
    JACOBIAN = 5  # derivatives of the rates of `at` at `time_at`, in the rows from `jacobian_row` on: `derivatives`
    FAILED = 6  # nothing: no step is small enough, or a solution could not be found
    DONE = 7  # nothing: `time` is `stop`
    BALANCE = 8  # energy and, where kept, momenta and rigid motions of the state `at` at `time_at`
    DIRECTIONS = 9  # as IMPLICIT, and then Z, W and X from `jacobian_row` on: `put_directions`
    SAMPLE = 10  # the function of a sampled controller called: `kanefe.kernels.steppers.sampling`
    SETTLE = 11  # the loops of the first output that waits closed: `kanefe.kernels.steppers.settled_outputs`


RATES, NO_INERTIA, NOT_FINITE = 1, -1, -2
"""How an evaluation ends: with rates, as nothing moves along a joint, or as the rates are no numbers."""


class VectorRows(NamedTuple):
    """First rows of the vectors of every method, for evaluations, which take nothing else of it."""

    at: int = 0
    slope: int = 1
    damping_direction: int = 2
    stiffness_direction: int = 3
    state: int = 4
    """First rows of the vectors of every method, for evaluations, which take nothing else of it."""


VECTOR = VectorRows()


class Reason(IntEnum):
    """Why a method failed."""

    TOO_SMALL = 1
    NO_CONVERGENCE = 2
    NO_NUMBERS = 3
    HELD = 4


Row = Annotated[np.ndarray, Array("size")]
"""A number for each of a state: q, u, internal states, dissipated energy, work."""


class Step(Record):
    """A method in the middle of a run. Times and steps are in s."""

    size: int
    coordinates: int
    speeds: int
    move_count: int
    bend_count: int
    command: int
    stage: int  # where to go on, 0 at the start
    reason: int
    steps: int
    rejected: int
    evaluations: int
    factorisations: int
    jacobians: int
    is_fixed: bool
    has_loops: bool
    looks_for_jumps: bool  # where steps become short is kept, since functions of the state may jump there
    wants_dense: bool  # states within the next step are wanted
    is_last: bool  # the step ends at `stop`
    continues: bool  # begin with what is known: since the last step only what controllers hold has changed
    worst: int  # component of the state whose error was the largest
    stored: int  # outputs that are written, of which the last ones wait until they are settled
    waiting: int
    settles: int
    is_left_open: bool  # the loops of an output could not be closed
    jacobian_row: int  # first of a Jacobian, or of directions; 0: the method has none
    sampled_speeds: int  # of speeds, and of those of joints, whose errors are taken without vibrations; 0: none
    joint_speeds: int
    breakpoint_count: int  # see `kanefe.kernels.steppers.breakpoints`
    side_count: int
    next_breakpoint: int
    last_kept: int
    kept_at_once: int
    rejected_before: int
    time: float
    time_old: float  # start of the last step
    time_at: float
    stop: float
    next_output: float
    h: float  # the step
    next_step: float
    smallest: float
    largest: float
    largest_of_drives: float
    time_excess: float  # by how much `time` is above the sum of fixed steps: taken off the next one
    relative: float  # tolerance
    error: float  # of what is allowed
    weakest: float  # smallest pivot of a constraint, of 1
    share_damping: float  # s and r of a linearly implicit evaluation
    share_stiffness: float
    share_of_rates: float  # of internal states in what they are at the end of a step; 0: not followed
    to_event: float  # the longest next step that passes no event that is foreseen
    longest_restart: float  # the longest first step after an event
    reach: float  # how far behind the end of a step its polynomial is as good as within, in steps
    shortest_share: float  # the shortest step after rejections, of the longest before it; its start and state there
    time_of_shortest: float
    longest: float
    rejected_so_far: float
    of_forces: float  # see `kanefe.kernels.steppers.force_scales`
    least_allowed: float
    every: float  # the time between samples of controllers, 0 without
    behind_integers: Annotated[int, Start("integers")]
    moves: Annotated[np.ndarray, Array("move_count", 3)]  # kind, coordinate and speed: how a coordinate moves
    bends: Annotated[np.ndarray, Array("bend_count")]  # see `kanefe.kernels.evaluation.bending`
    behind_numbers: Annotated[int, Start("numbers")]
    breakpoints: Annotated[np.ndarray, Array("breakpoint_count")]
    left_sides: Annotated[np.ndarray, Array("side_count")]
    joint_of_speed: Annotated[np.ndarray, Array("sampled_speeds")]  # number of a row, from 1 on, or 0
    shaken: Annotated[np.ndarray, Array("joint_speeds", "speeds")]  # see `kanefe.integrate.locked_speeds`
    first: Annotated[int, Start("vectors")]
    at: Row  # what is evaluated
    slope: Row  # its rates
    damping_direction: Row
    stiffness_direction: Row
    state: Row
    state_old: Row
    scale: Row  # absolute tolerance
    at_shortest: Row
    elastic: Row  # 1 at the speeds of modes of bodies, whose coordinates are settled
    large: Row  # `scale` for positions
    unit: Row  # for modes one over a coordinate that moves their body by its size; at their speeds its number, from 1
    largest_forces: Row  # at the first coordinate of each body the square of its largest force


class BalancedStep(Step):
    """A step of a method that asks for balances, with what they write."""

    keeps_momenta: bool
    energy: float
    energy_size: float  # the sum of the sizes of its parts
    kinetic: float
    mass: float
    centre: Vector  # of mass
    momentum: Vector
    spin: Vector  # angular momentum about the centre, with that of rotors
    rotors: Vector
    locked: Symmetric  # inertia about the centre as of one rigid body
    rigid: Annotated[np.ndarray, Array(6, "size")]  # speeds of the rigid motions of the scene, about its centre


class DirectedStep(Step):
    """A step of a method that may ask for directions in which loads are stiff."""

    most_directions: int  # how many there is room for, 0 if none are wanted
    rank: int  # how many were found


class StepArrays(NamedTuple):
    """The memory of a step: see `Run`."""

    integers: Integers
    reals: Reals
    vectors: RealRows


class Run(NamedTuple):
    """A method in the middle of a run.

    Attributes
    ----------
    advance, interpolate : functions
        Of the method; compiled: pointers of one type for all.
    integers, reals, vectors, table : ndarray
        The memory of its step, and its coefficients.
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
    vectors: RealRows
    table: RealRows
    times: Reals
    states: RealRows
    most_steps: int
    clock: Integers


@inlined
def step_of(run: Run) -> Step:
    """Return the step of a run."""
    return Step(run.integers, run.reals, run.vectors)


@inlined
def ask(step: Step, command: int, stage: int) -> int:
    """Store where to continue, and return the command."""
    step.command = command
    step.stage = stage
    if command == Command.RATES or command == Command.IMPLICIT:
        step.evaluations += 1
    return step.command


@inlined
def ask_rates(step: Step, stage: int) -> int:
    """Ask for the rates of the state that has been reached."""
    copy(step.state, step.at)
    step.time_at = step.time
    return ask(step, Command.RATES, stage)


@inlined
def fail(step: Step, reason: int, stage: int) -> int:
    """Say that there is no next step, and why."""
    step.reason = reason
    return ask(step, Command.FAILED, stage)


@kernel
def scaled_size(step: Step, error: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Return the largest component of an error, of what is allowed there; infinite if it is not finite.

    Allowed is the absolute tolerance and the relative one of the larger of two states. Of joint speeds counts what is
    left without vibrations. The worst that is told is a coordinate or a speed: energies only follow.
    """
    n, moving, scale, relative = step.coordinates, step.coordinates + step.speeds, step.scale, step.relative
    has_locked, joints, shaken = step.sampled_speeds > 0, step.joint_of_speed, step.shaken
    largest, share = 0.0, min(step.every * max(1.0, step.every / step.h), 1.0) if has_locked else 0.0
    for i in range(len(error)):
        off = error[i]
        if has_locked and n <= i < moving and joints[i - n] > 0.0:
            off += total(shaken[int(joints[i - n]) - 1], error[n:moving])
            off = max(abs(off), share * abs(error[i]))
        size = abs(off) / (scale[i] + relative * max(abs(a[i]), abs(b[i])))
        if not size <= largest:
            largest = size
            if i < moving:
                step.worst = i
            if not size < np.inf:
                return np.inf
    return largest


@kernel
def largest_share(step: Step, shares: np.ndarray, first: int, end: int) -> float:
    """Return the largest of some shares of what is allowed, infinite if one is not finite; keep which is the worst."""
    largest = 0.0
    for i in range(first, end):
        size = abs(shares[i])
        if not size <= largest:
            largest = size
            step.worst = i
            if not size < np.inf:
                return np.inf
    return largest


@kernel
def first_step(step: Step, rates: np.ndarray) -> float:
    """Return a step that moves the state by a hundredth of what such rates do in one unit of error."""
    largest, span, scale, state = 0.0, step.stop - step.time, step.scale, step.state
    for i in range(step.coordinates + step.speeds):
        largest = max(largest, abs(rates[i]) / (scale[i] + step.relative * abs(state[i])))
    return min(1e-3 * span, 0.01 / (step.relative * largest) if largest > 0.0 else span)


@inlined
def wish(step: Step, wanted: float) -> None:
    """Set the next step; one cut short says little about it."""
    step.next_step = max(wanted, step.next_step) if step.h < step.next_step else wanted


@inlined
def begin_at(step: Step, t: float) -> None:
    """Let the next step begin at a time, from the state as it is then."""
    step.time, step.time_old, step.time_excess = t, t, 0.0
    step.command, step.stage, step.continues = Command.START, 0, False


@kernel
def watch_steps(step: Step) -> None:
    """Keep where an accepted step is the shortest, relative to the longest before it, since others were rejected there.

    Across a jump of a function of the state no step keeps its order: they are rejected until they are short.
    """
    h, rejected = step.time - step.time_old, step.rejected - step.rejected_so_far
    step.rejected_so_far = step.rejected
    if rejected > 0.0 and h < step.shortest_share * step.longest:
        step.shortest_share, step.time_of_shortest = h / step.longest, step.time_old
        copy(step.state_old, step.at_shortest)
    step.longest = max(step.longest, h)


@inlined
def await_output(run: Run) -> None:
    """Write when the next output is."""
    step = step_of(run)
    step.next_output = run.times[step.stored] if step.stored < len(run.times) else np.inf


@inlined
def take_back_outputs(run: Run, t: float) -> None:
    """Let outputs after a time be written again."""
    step = step_of(run)
    while step.stored > 0 and run.times[step.stored - 1] > t:
        step.stored -= 1
    await_output(run)


@vector_kernel
def is_finite(x: np.ndarray) -> bool:
    """Return whether no number of x is infinite or not a number."""
    total = 0.0
    for i in range(len(x)):
        total += abs(x[i].real) + abs(x[i].imag)
    return total < np.inf


@entry()
def interpolated(run: Run, t: float, out: Reals) -> None:
    """Write the state at a time of the last step, for a call from Python."""
    run.interpolate(run.integers, run.reals, run.vectors, run.table, t, out)
