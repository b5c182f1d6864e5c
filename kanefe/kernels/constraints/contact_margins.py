"""How far points of rigid contacts are from their next events, in states: `ContactMargins` in compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import Prepared, RealBlocks, RealRows, Reals
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.constraints.contact_shares import least_margins, share_otherwise
from kanefe.kernels.constraints.least_forces import share_forces
from kanefe.kernels.constraints.loop_tables import UnitResponses, head_of, unit_responses_in
from kanefe.kernels.contact.rigid_points import HAS_FRICTION, is_closed, is_slipping, left_of_gap, left_of_slip, meet
from kanefe.kernels.scene import Scene
from kanefe.kernels.tables import Loops

FAR = 1.0
"""Value of a margin of what cannot happen, m, N or m/s."""

NEVER, GAP, NORMAL, SLIP_MARGIN, LEFT_OF_SLIP, LARGEST = range(6)
"""Columns of the values of all rigid contacts of a scene: one that stays, the least of their margins, and the largest
force, N."""
MARGINS = 6


class Looked(NamedTuple):
    """One evaluation, and where what it writes is in its memory.

    Attributes
    ----------
    evaluation : Prepared
        Call of `kanefe.kernels.evaluation.evaluation.evaluate` with the arrays below.
    time_at : int
        Of the time among its numbers.
    speeds, first_state : int
        How many free and driven speeds there are, and where the internal states begin.
    drives : ndarray, shape (driven, 3)
    inputs : ndarray
    vectors : ndarray, shape (2 or more, state and quadratures)
    work : ndarray, shape (rows, WORK)
    multipliers, holding : ndarray
        See `kanefe.kernels.scene.Work`.
    """

    evaluation: Prepared
    time_at: int
    speeds: int
    first_state: int
    drives: RealRows
    inputs: Reals
    vectors: RealRows
    work: RealRows
    multipliers: Reals
    holding: Reals


class Watched(NamedTuple):
    """States that are looked at, and what is found.

    Attributes
    ----------
    times : ndarray, shape (T,)
    drives : ndarray, shape (T, driven, 3)
    inputs : ndarray, shape (T, inputs)
    states : ndarray, shape (T, state)
        Each begins with q, u and z.
    found : ndarray, shape (T, values)
        Of loads, and then of rigid contacts.
    """

    times: Reals
    drives: RealBlocks
    inputs: RealRows
    states: RealRows
    found: RealRows


@entry()
def watch_contacts(looked: Looked, loads: Prepared, scene: Scene, watched: Watched) -> None:
    """Write the event values of loads, and then those of rigid contacts, in some states.

    Parameters
    ----------
    looked : Looked
    loads : Prepared
        Call of `kanefe.kernels.loads.watching.watch_states` with the arrays below; address 0: there are none.
    scene : Scene
    watched : Watched
    """
    if loads.address != 0:
        call_address(loads.address, (loads.places, loads.numbers))
    states, found = watched.states, watched.found
    width = min(states.shape[1], looked.vectors.shape[1])
    for row in range(len(states)):
        copy(watched.inputs[row], looked.inputs)
        for i in range(len(looked.drives)):
            copy(watched.drives[row, i], looked.drives[i])
        copy(states[row, :width], looked.vectors[0, :width])
        looked.evaluation.numbers[looked.time_at] = watched.times[row]
        call_address(looked.evaluation.address, (looked.evaluation.places, looked.evaluation.numbers))
        _put_margins(looked, scene, states[row, looked.first_state :], found[row, found.shape[1] - MARGINS :])


@kernel
def _put_margins(looked: Looked, scene: Scene, z: np.ndarray, found: np.ndarray) -> None:
    """Write the least margins of a state that has been evaluated."""
    loops, points, work, forces = scene.loops, scene.loops.points, looked.work, looked.multipliers
    kept = unit_responses_in(looked.holding, loops)
    normal = slip = gap = left = np.inf
    touches, largest, met = False, 0.0, kept.met
    for p in range(len(points.places)):
        if not is_closed(points, p, z):
            meet(points, p, scene.tables.gravity, work, met)
            gap = min(gap, left_of_gap(points, p, z, met))
            continue
        touches = True
        if is_slipping(points, p, z) and points.places[p, HAS_FRICTION] != 0:
            left = min(left, left_of_slip(points, p, z, work, met))
    if touches:
        normal, slip = find_forces(loops, z, forces, kept)
        for p in range(len(points.places)):
            if is_closed(points, p, z):
                largest = max(largest, abs(forces[head_of(loops, p)]))
    found[NEVER], found[LARGEST] = FAR, largest
    found[GAP], found[NORMAL], found[SLIP_MARGIN], found[LEFT_OF_SLIP] = gap, normal, slip, left
    for c in (GAP, NORMAL, SLIP_MARGIN, LEFT_OF_SLIP):
        if not abs(found[c]) < np.inf:
            found[c] = FAR


@kernel
def find_forces(loops: Loops, z: np.ndarray, forces: np.ndarray, kept: UnitResponses) -> tuple[float, float]:
    """Share the forces of what touches, after an evaluation, so that they can be; return their least margins, N."""
    if kept.live_count < 0.0:
        share_forces(loops, z, False, forces, kept)
    normal, slip = least_margins(loops, z, forces)
    if min(normal, slip) < 0.0:
        share_otherwise(loops, z, forces, kept)
        normal, slip = least_margins(loops, z, forces)
    return normal, slip
