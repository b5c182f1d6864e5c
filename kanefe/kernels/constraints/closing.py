"""Closing of loops in order n: the nearest coordinates at which they are closed, and speeds that keep them so.

The nearest in the metric of the inertias that the sweeps eliminate. Newton's step is ``-M^-1 J^T lambda`` with
``J M^-1 J^T lambda = g``: the system that also holds the accelerations. What is eliminated is kept while the loops
close fast, so that what a step of an integrator leaves open costs one elimination and a few sweeps.
`kanefe.literal.loop_closure` is the same in dense matrices.
"""

from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.constraints.loop_tables import Held, LoopFactors, RowWork, holds, rows_of
from kanefe.kernels.constraints.openings import openings, rate_of_row, size_of_rate
from kanefe.kernels.constraints.row_wrenches import clear_all_forces, write_rows
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.kernels.constraints.tree_sweeps import sweep_accelerations, sweep_forces_inward, sweep_inward
from kanefe.kernels.language import Array, RealRows, Reals, copy, entry, kernel
from kanefe.kernels.scene import Scene, State, Work, memory_size, state_in, work_in
from kanefe.kernels.sweeps.advance import advance
from kanefe.kernels.sweeps.implicit import Pushes, stiffen_joints, stiffen_modes
from kanefe.kernels.sweeps.inertia import set_inertia
from kanefe.kernels.sweeps.outward import sweep_outward
from kanefe.kernels.sweeps.unit_mass import scale_beams


class Ended(NamedTuple):
    """How `close_state` ends.

    The literal route may be able to close open loops, and names those that cannot be closed; the same holds for a tree
    in which something has no inertia of its own.
    """

    closed: int = 0
    left_open: int = 1
    without_inertia: int = 2


ENDED = Ended()


class Limits(NamedTuple):
    """From where on numbers count where loops are closed."""

    slow: float = 0.1
    """Fraction of the gaps left by a step above which the inertias are eliminated again."""
    round_off: float = 4.0 * float(np.finfo(float).eps)
    """Gap, relative to the scene's length or in rad, that no step closes further."""
    near: float = 1e-10
    far: float = 1e-6
    """Gap at the start, relative to the weakest pivot: up to the first value speeds are accurate to round-off after one
    solution with the inertias of the start, up to the second after two; beyond, they are eliminated again."""


LIMITS = Limits()


class Closing(LoopFactors):
    """Workspace of `close_state`: what holds the loops at the place of the factors, and what is done with it.

    Attributes
    ----------
    residuals, tried_residuals : ndarray, shape (m,)
    step, reached : ndarray, shape (free,)
        Of Newton's iteration, and the speeds that it has reached.
    place, trial : ndarray, shape (coordinates,)
        Coordinates reached, and those tried.
    tried : ndarray, shape (exerted,)
        `RowWork` at these.
    """

    residuals: Annotated[np.ndarray, Array("m")]
    tried_residuals: Annotated[np.ndarray, Array("m")]
    step: Annotated[np.ndarray, Array("free")]
    reached: Annotated[np.ndarray, Array("free")]
    place: Annotated[np.ndarray, Array("coordinates")]
    trial: Annotated[np.ndarray, Array("coordinates")]
    tried: Annotated[np.ndarray, Array("exerted")]


class Mechanism(NamedTuple):
    """What is closed, and what is written on the way.

    Attributes
    ----------
    scene : Scene
    state : State
        At the start; its internal states say which rows hold.
    here, beside : Work
        At the place of the factors, and at places tried or reached.
    at : Closing
    share_stiffness : float
        Of the stiffness of modes and joints in the metric ``M + r K``, s2: stiff modes, which M alone would move, then
        stay where they are.
    """

    scene: Scene
    state: State
    here: Work
    beside: Work
    at: Closing
    share_stiffness: float


class Progress(NamedTuple):
    """How far Newton's iteration has come.

    Attributes
    ----------
    worst, weakest : float
        Largest opening, and weakest pivot.
    is_factored, is_here : bool
        Whether there are factors, and whether they are those of the place.
    is_swept, is_tried : bool
        Whether the works of the factors, and of what is tried, have no more than a sweep at the place.
    """

    worst: float
    weakest: float
    is_factored: bool
    is_here: bool
    is_swept: bool
    is_tried: bool


# Of a prepared call of `close_state`: its number, and what is returned
SHARE_IN_METRIC, ENDED_AS = range(2)


@entry()
def close_state(share_stiffness: float, scene: Scene, drives: RealRows, y: Reals, memory: Reals) -> tuple[int, float]:
    """Close the loops of a state ``(q, u, z, ...)``; return how it ended and the weakest pivot.

    Changes q and then u, both to the nearest, unless it does not end as CLOSED. `share_stiffness`: see `Mechanism`;
    `memory` has as many numbers as `closing_memory_size` tells.
    """
    state, at = state_in(scene.tables, 0.0, y, drives, y), Closing(scene.loops.sizes, memory)
    here = work_in(scene, memory[at.closing :])
    beside = work_in(scene, memory[at.closing + here.size :])
    return _close(Mechanism(scene, state, here, beside, at, share_stiffness))


def closing_memory_size(scene: Scene) -> int:
    """Return how many numbers the memory of `close_state` has."""
    return RowWork(scene.loops.sizes, scene.loops.extents).closing + 2 * memory_size(scene)


@kernel
def _close(mechanism: Mechanism) -> tuple[int, float]:
    state, at = mechanism.state, mechanism.at
    copy(state.q, at.place)
    _sweep(mechanism, mechanism.here, at.place, state.u)
    start, total = openings(mechanism.scene, state, mechanism.here, RowWork(at), at.residuals)
    progress = _close_places(mechanism, start, total)
    if progress.weakest == 0.0:
        return ENDED.without_inertia, 0.0
    if not progress.worst <= CLOSING.largest_opening:
        return ENDED.left_open, progress.weakest
    if progress.is_swept and not progress.is_tried and _has_closed_speeds(mechanism):
        return ENDED.closed, progress.weakest
    weakest = _close_speeds(mechanism, progress, start)
    if weakest == 0.0:
        return ENDED.without_inertia, 0.0
    copy(at.place, state.q)
    copy(at.reached, state.u)
    return ENDED.closed, weakest


@kernel
def _close_places(mechanism: Mechanism, worst: float, total: float) -> Progress:
    """Close the loops by Newton's method from where they are open by `worst`, with `total` the sum of the squares."""
    is_factored = is_here = is_tried = False
    is_swept, weakest, at = True, 1.0, mechanism.at
    for _ in range(CLOSING.largest_iterations):
        if worst <= LIMITS.round_off:
            break
        if not is_factored:
            if not is_swept:
                _sweep(mechanism, mechanism.here, at.place, mechanism.state.u)
            weakest = _eliminate(mechanism, True, min(CLOSING.unknown * worst * worst, CLOSING.largest_unknown))
            if weakest == 0.0:
                break
            is_factored, is_here, is_swept = True, True, False
        _move(mechanism)
        # what is closed but for round-off gets better by a whole step or not at all
        is_tried, opening, square = _try(
            mechanism, CLOSING.most_halvings if is_here and worst > CLOSING.tolerance else 1, total
        )
        if is_tried:
            is_factored = opening <= CLOSING.tolerance or square <= LIMITS.slow * LIMITS.slow * total
            worst, total, is_here = opening, square, False
            copy(at.trial, at.place)
            copy(at.tried_residuals, at.residuals)
        elif is_here or worst <= CLOSING.tolerance:
            break
        else:
            is_factored = False
    return Progress(worst, weakest, is_factored, is_here, is_swept, is_tried)


@kernel
def _try(mechanism: Mechanism, tries: int, total: float) -> tuple[bool, float, float]:
    """Go a step that makes the openings less, halved if need be; return whether there is one, and openings there."""
    scene, state, at, shrink, moves = mechanism.scene, mechanism.state, mechanism.at, 1.0, mechanism.scene.loops.moves
    step, tried = at.step, RowWork(scene.loops.sizes, at.tried)
    for i in range(len(step)):
        shrink = max(shrink, abs(step[i]) / moves[i])
    share = -1.0 / shrink
    for _ in range(tries):
        advance(scene.tables, scene.flexible, at.place, step, share, at.trial)
        _sweep(mechanism, mechanism.beside, at.trial, state.u)
        beside = State(0.0, at.trial, state.u, state.z, state.drives, state.inputs)
        opening, square = openings(scene, beside, mechanism.beside, tried, at.tried_residuals)
        if square < total:
            return True, opening, square
        share *= 0.5
    return False, np.inf, np.inf


@kernel
def _close_speeds(mechanism: Mechanism, progress: Progress, start: float) -> float:
    """Write the nearest speeds that keep the loops closed; return the weakest pivot, 0 where something has no inertia.

    `start` is the largest opening at the start.
    """
    scene, state, at, rows = mechanism.scene, mechanism.state, mechanism.at, rows_of(mechanism.scene.loops)
    weakest, is_here, holds_speeds = progress.weakest, progress.is_here, False
    for j in range(len(rows)):
        holds_speeds = holds_speeds or not rows[j].holds_place
    if not progress.is_factored or holds_speeds or (start > LIMITS.far * weakest and not is_here):
        if not progress.is_swept:
            _sweep(mechanism, mechanism.here, at.place, state.u)
        weakest = _eliminate(mechanism, False, 0.0)
        if weakest == 0.0:
            return 0.0
        is_here = True
    copy(state.u, at.reached)
    residuals, reached, step, tried = at.residuals, at.reached, at.step, RowWork(scene.loops.sizes, at.tried)
    moving = State(0.0, at.place, reached, state.z, state.drives, state.inputs)
    for again in range(1 if is_here or start <= LIMITS.near * weakest else 2):
        if again > 0 or not progress.is_tried:
            _sweep(mechanism, mechanism.beside, at.place, reached)
        write_rows(scene, moving, mechanism.beside, tried)
        for j in range(len(rows)):
            residuals[j] = 0.0
            if holds(rows[j], state.z):
                residuals[j] = rate_of_row(scene, moving, mechanism.beside, tried, j)
        _move(mechanism)
        for i in range(len(step)):
            reached[i] -= step[i]
    return weakest


@kernel
def _has_closed_speeds(mechanism: Mechanism) -> bool:
    """Return whether what the speeds open, after a sweep with them, is round-off."""
    scene, state, here, kept = mechanism.scene, mechanism.state, mechanism.here, RowWork(mechanism.at)
    rows, found = rows_of(scene.loops), True
    write_rows(scene, state, here, kept)
    for j in range(len(rows)):
        if found and holds(rows[j], state.z):
            rate = abs(rate_of_row(scene, state, here, kept, j))
            found = rate <= LIMITS.round_off * size_of_rate(rows[j], kept.actions[j], here.frames)
    return found


@kernel
def _sweep(mechanism: Mechanism, work: Work, q: np.ndarray, u: np.ndarray) -> None:
    """Sweep outward with some coordinates and speeds."""
    state = mechanism.state
    sweep_outward(mechanism.scene, State(0.0, q, u, state.z, state.drives, state.inputs), work, False)


@kernel
def _eliminate(mechanism: Mechanism, places_only: bool, tolerance: float) -> float:
    """Eliminate tree and loops after an outward sweep; return the weakest pivot, 0 where something has no inertia."""
    scene, state, work, at = mechanism.scene, mechanism.state, mechanism.here, mechanism.at
    share, none = mechanism.share_stiffness, at.step
    is_implicit = share > 0.0
    write_rows(scene, state, work, RowWork(at))
    at.rest[:] = 0.0
    set_inertia(scene, work)
    work.applied[:] = 0.0
    if is_implicit:
        none[:] = 0.0
        pushes = Pushes(0.0, share, 0.0, none, none)
        here = State(0.0, at.place, state.u, state.z, state.drives, state.inputs)
        stiffen_joints(scene.tables, here, pushes, work.applied, work.added)
        stiffen_modes(scene, work, pushes)
    scale_beams(scene, work)
    held = Held(LoopFactors(at), state.z, places_only, tolerance)
    is_regular, weakest = sweep_inward(scene, work, is_implicit, held)
    return weakest if is_regular else 0.0


@kernel
def _move(mechanism: Mechanism) -> None:
    """Write the nearest step that moves the rows by the residuals."""
    scene, work, at, is_implicit = mechanism.scene, mechanism.here, mechanism.at, mechanism.share_stiffness > 0.0
    copy(at.residuals, at.rest)
    clear_all_forces(scene, work)
    held = Held(LoopFactors(at), mechanism.state.z, False, 0.0)
    sweep_forces_inward(scene, work, is_implicit, held)
    sweep_accelerations(scene, work, is_implicit, held, at.step)
