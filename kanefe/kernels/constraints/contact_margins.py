"""How far points of rigid contacts are from their next events, in states: `ContactMargins` in compiled code."""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.constraints.contact_shares import least_margins, share_otherwise
from kanefe.kernels.constraints.least_forces import share_forces
from kanefe.kernels.constraints.loop_tables import UnitResponses, head_of, unit_responses_in
from kanefe.kernels.contact import rigid_points
from kanefe.kernels.contact.output_places import Margins
from kanefe.kernels.language import Prepared, RealRows, Reals, call_address, copy, entry, inlined, kernel
from kanefe.kernels.loads.telling import States
from kanefe.kernels.scene import Scene
from kanefe.kernels.tables import Loops
from kanefe.kernels.tree import Frames

FAR = 1.0
"""Value of a margin of what cannot happen, m, N or m/s."""


class LeastMargins(Margins):
    """The least margins of all rigid contacts of a scene; a value that stays, and the largest force, N."""

    never: float
    largest: float


MARGINS = LeastMargins.number_count


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
    frames : ndarray
        `kanefe.kernels.tree.Frames`.
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
    frames: RealRows
    multipliers: Reals
    holding: Reals


@entry()
def watch_contacts(looked: Looked, loads: Prepared, scene: Scene, states: States, found: RealRows) -> None:
    """Write the event values of loads, and then those of rigid contacts, in some states.

    Parameters
    ----------
    looked : Looked
    loads : Prepared
        Call of `kanefe.kernels.loads.watching.watch_states` with the states and what is found; address 0: there are
        none.
    scene : Scene
    states : States
    found : ndarray, shape (T, values)
        Of loads, and then of rigid contacts.
    """
    if loads.address != 0:
        call_address(loads.address, (loads.places, loads.numbers))
    y, own = states.states, found.shape[1] - MARGINS
    width = min(y.shape[1], looked.vectors.shape[1])
    for row in range(len(y)):
        copy(states.inputs[row], looked.inputs)
        for i in range(len(looked.drives)):
            copy(states.drives[row, i], looked.drives[i])
        copy(y[row, :width], looked.vectors[0, :width])
        looked.evaluation.numbers[looked.time_at] = states.times[row]
        call_address(looked.evaluation.address, (looked.evaluation.places, looked.evaluation.numbers))
        _put_margins(looked, scene.loops, y[row, looked.first_state :], LeastMargins(found[row], own))


@kernel
def _put_margins(looked: Looked, loops: Loops, z: np.ndarray, found: LeastMargins) -> None:
    """Write the least margins of a state that has been evaluated."""
    points, frames, forces = rigid_points.given_points(loops.points), Frames(looked.frames), looked.multipliers
    kept = unit_responses_in(looked.holding, loops)
    gap = normal = slip = left = np.inf
    largest = 0.0
    for p in range(len(points)):
        given, met = points[p], kept.met[p]
        if not rigid_points.is_closed(given, z):
            rigid_points.meet(given, loops.points.shapes, frames, met)
            gap = min(gap, rigid_points.left_of_gap(given, z, met))
        elif rigid_points.is_rubbing(given, z):
            left = min(left, rigid_points.left_of_slip(given, z, met))
    if rigid_points.touches(points, z):
        normal, slip = find_forces(loops, z, forces, kept)
        for p in range(len(points)):
            if rigid_points.is_closed(points[p], z):
                largest = max(largest, abs(forces[head_of(loops, p)]))
    found.never, found.largest = FAR, largest
    found.gap, found.normal, found.slip_margin = _or_far(gap), _or_far(normal), _or_far(slip)
    found.left_of_slip = _or_far(left)


@inlined
def _or_far(margin: float) -> float:
    """Return a margin, of what cannot happen one that is far."""
    return margin if abs(margin) < np.inf else FAR


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
