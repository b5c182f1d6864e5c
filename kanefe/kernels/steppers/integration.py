"""Runs in order n: a method of integration gets what it wants evaluated until its outputs or steps are done.

The scene is behind prepared calls of its kernels: one function serves scenes of every kind, in space and in the plane.
"""

from typing import NamedTuple

from kanefe.kernels.compiler.arrays import Filler
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.evaluation.evaluation import (
    AT_TIME,
    DONE_AS,
    IS_IMPLICIT,
    LEAST_PIVOT,
    SHARE_OF_DAMPING,
    SHARE_OF_RATES,
    SHARE_OF_STIFFNESS,
)
from kanefe.kernels.evaluation.momenta import BALANCE_TIME
from kanefe.kernels.events.closing_call import ClosingCall, close_at
from kanefe.kernels.language import IntegerRows, Prepared, RealRows, Reals, call_address, copy, entry, inlined, kernel
from kanefe.kernels.steppers.settled_outputs import go_on
from kanefe.kernels.steppers.step_commands import NO_INERTIA, Command, Run, step_of
from kanefe.kernels.sweeps.drives import Drives, put_drives


class JacobianCall(NamedTuple):
    """What differentiates the rates along tangents of the coordinates, speeds and internal states.

    A tangent is a change of the coordinates in the direction of a speed; of a rotation it is the rotation vector in the
    moving frame.

    Attributes
    ----------
    is_there : bool
    call, evaluation : Prepared
        Calls of the kernels `derivatives` and, by this, `evaluate` with complex numbers, with the arrays below.
    done_at : int
        Where among the numbers of `call` it is told whether all is finite.
    state : ndarray, shape (2, 2 state)
        State and rates: complex numbers as pairs of real ones.
    drives : ndarray, shape (driven, 3)
    inputs : ndarray
    turning : ndarray of int, shape (rotations, 2)
        First of the Euler parameters, and of the speeds, of each rotation.
    directions, found : ndarray, shape (tangents, state)
        Tangents, but those of rotations written for the other speeds; and derivatives along them.
    """

    is_there: bool
    call: Prepared
    evaluation: Prepared
    done_at: int
    state: RealRows
    drives: RealRows
    inputs: Reals
    turning: IntegerRows
    directions: RealRows
    found: RealRows


class Scene(NamedTuple):
    """What a run needs of a scene.

    Attributes
    ----------
    evaluation, balance : Prepared
        Calls of the kernels `evaluate` or `evaluate_planar` and `balance`, both with `drives`, `inputs` and the vectors
        of the run.
    closing : ClosingCall
        With `motions` and `drives`.
    directions : Prepared
        A call of `put_directions` with the same, and the memory of `evaluation`.
    derivatives : Derivatives
        Of methods that ask for them.
    drives : ndarray, shape (driven, 3)
        Written by `motions` at each time.
    motions : Drives
    fill : function (t, y, inputs)
        Writes the values of loads that are compiled functions.
    inputs : ndarray
        Values of loads, the constant ones written.
    asked : ndarray, shape (state,)
        Where the state that was asked for is kept, while another is in its place.
    """

    evaluation: Prepared
    closing: ClosingCall
    balance: Prepared
    directions: Prepared
    derivatives: JacobianCall
    drives: RealRows
    motions: Drives
    fill: Filler
    inputs: Reals
    asked: Reals


@entry()
def integrate(scene: Scene, run: Run) -> tuple[int, float]:
    """Continue with a run until its method wants what is not to be had here.

    Parameters
    ----------
    scene : Scene
    run : Run

    Returns
    -------
    command : int
        What the method wants: ACCEPTED where the outputs or the steps have come to their end; RATES, IMPLICIT, JACOBIAN
        or PROJECT where the loops could not be closed, or only they hold what has no inertia. Or NO_INERTIA.
    weakest : float
        Smallest pivot of a constraint met, of 1.
    """
    step = step_of(run)
    weakest, closed = 1.0, step.stored
    while True:
        command = go_on(run)
        for stored in range(closed, step.stored if scene.closing.has_loops else closed):
            _close_output(scene, run, stored)
        closed = step.stored
        if command == Command.SETTLE:
            _close_output(scene, run, closed - step.waiting)
        elif command == Command.PROJECT:
            if not close_at(scene.closing, step.time, step.share_stiffness, step.state):
                return command, weakest
        elif command == Command.JACOBIAN:
            if not (scene.derivatives.is_there and _put_jacobian(scene, run)):
                return command, weakest
        elif command == Command.BALANCE:
            _put_drives(scene, run)
            scene.balance.numbers[BALANCE_TIME] = step.time_at
            call_address(scene.balance.address, (scene.balance.places, scene.balance.numbers))
        elif command == Command.RATES or command == Command.IMPLICIT or command == Command.DIRECTIONS:
            is_there, pivot = _evaluate(scene, run, command)
            weakest = min(weakest, pivot)
            if not is_there:
                return command, weakest
            if scene.evaluation.numbers[DONE_AS] == NO_INERTIA:
                return NO_INERTIA, weakest
            if command == Command.DIRECTIONS:
                call_address(scene.directions.address, (scene.directions.places, scene.directions.numbers))
        else:
            return command, weakest


@kernel
def _close_output(scene: Scene, run: Run, number: int) -> None:
    """Close the loops of an output, or keep that it is left open."""
    step = step_of(run)
    if not close_at(scene.closing, run.times[number], step.share_stiffness, run.states[number]):
        step.is_left_open = True


@kernel
def _put_drives(scene: Scene, run: Run) -> None:
    """Write the drives where the method evaluates; they say how long its next step may be."""
    step = step_of(run)
    longest = put_drives(scene.motions, step.time_at, scene.drives)
    if step.waiting == 0:
        step.largest_of_drives = longest


@kernel
def _evaluate(scene: Scene, run: Run, command: int) -> tuple[bool, float]:
    """Write the rates that a method asks for; return whether they are to be had here, and the smallest pivot."""
    step, places, numbers = step_of(run), scene.evaluation.places, scene.evaluation.numbers
    t, at, weakest = step.time_at, step.at, 1.0
    _put_drives(scene, run)
    places[IS_IMPLICIT], numbers[AT_TIME] = command != Command.RATES, t
    numbers[SHARE_OF_DAMPING], numbers[SHARE_OF_STIFFNESS] = step.share_damping, step.share_stiffness
    numbers[SHARE_OF_RATES] = step.share_of_rates
    for is_beside in range(2):  # a second time where the loops are nearly singular
        scene.fill(t, at, scene.inputs)
        call_address(scene.evaluation.address, (places, numbers))
        is_regular, pivot = numbers[DONE_AS] != NO_INERTIA, numbers[LEAST_PIVOT]
        weakest = min(weakest, pivot)
        if not scene.closing.has_loops:
            break
        if is_beside:
            copy(scene.asked, at)
            break
        step.weakest = pivot
        if is_regular and not pivot < NEAR_SINGULAR:
            break
        if not is_regular or not _step_beside(scene, t, at):
            return False, weakest
    return True, weakest


@inlined
def put_four(x: Reals, at: int, a: float, b: float, c: float, d: float) -> None:
    """Write four numbers."""
    x[at], x[at + 1], x[at + 2], x[at + 3] = a, b, c, d


@kernel
def _put_jacobian(scene: Scene, run: Run) -> bool:
    """Write the derivatives of the rates that a method asks for; return whether all are finite.

    Of the rates of speeds, internal states and quadratures, a row each, along the tangents.
    """
    step, given = step_of(run), scene.derivatives
    y, t, n = step.at, step.time_at, step.coordinates
    for i in range(len(given.turning)):
        at, row = given.turning[i, 0], given.turning[i, 1]
        e0, e1, e2, e3 = 0.5 * y[at], 0.5 * y[at + 1], 0.5 * y[at + 2], 0.5 * y[at + 3]
        put_four(given.directions[row], at, -e1, e0, e3, -e2)
        put_four(given.directions[row + 1], at, -e2, -e3, e0, e1)
        put_four(given.directions[row + 2], at, -e3, e2, -e1, e0)
    put_drives(scene.motions, t, given.drives)
    copy(scene.inputs, given.inputs)
    scene.fill(t, y, given.inputs)
    for i in range(len(y)):
        given.state[0, 2 * i] = y[i]
    given.evaluation.numbers[AT_TIME] = t
    call_address(given.call.address, (given.call.places, given.call.numbers))
    if given.call.numbers[given.done_at] == 0.0:
        return False
    jacobian = run.vectors[step.jacobian_row :]
    for i in range(len(y) - n):
        for k in range(len(given.found)):
            jacobian[i, k] = given.found[k, n + i]
    return True


@kernel
def _step_beside(scene: Scene, t: float, at: Reals) -> bool:
    """Put the nearest closed state in the place of one near a singular position, whose rates are then its own.

    Off the constraints they would be without bounds. Tells whether there is one.
    """
    copy(at, scene.asked)
    return close_at(scene.closing, t, 0.0, at)
