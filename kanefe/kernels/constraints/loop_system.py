"""The system of the multipliers of loops by the ways of their rows: what loops have in common, and nothing else.

A wrench on its way inward leaves at each joint, and at the modes of each body, a force that is given way to. With
``k`` that force, ``D`` the inertia that the sweep inward has eliminated there, and ``e = D^-1 k``,

    J_i M^-1 J_j^T = sum of k_i e_j over all joints and modes that both rows visit,

since the sweeps are a factorisation ``M^-1 = Psi^T D^-1 Psi`` (Rodriguez 1987, Jain 1991). Rows that share nothing
do not meet in the system. It is that of the links between their ends, with the link that carries them all at rest.
"""

import numpy as np

from kanefe.kernels.constraints.loop_tables import Held, LoopFactors, holds, rows_of
from kanefe.kernels.constraints.row_paths import Guests, Meetings, Visits
from kanefe.kernels.constraints.row_visits import put_visits
from kanefe.kernels.joints.by_kind import shared_answer
from kanefe.kernels.language import inlined
from kanefe.kernels.scene import Scene, Work, links_of
from kanefe.kernels.sweeps.elastic import total


@inlined
def put_loop_system(scene: Scene, work: Work, held: Held, at: int, is_implicit: bool) -> None:
    """Write A and the scales of the rows that are eliminated at a row of the scene, -1 N; all they visit is.

    A row that does not hold, or no place where `places_only` is asked for, is left out: its scale is zero.
    """
    kept, paths, rows = held.kept, scene.loops.paths, rows_of(scene.loops)
    A, scale, begin, end = kept.A, kept.scale, paths.places[at + 1], paths.places[at + 2]
    for place in range(begin, end):
        j = paths.order[place]
        A[paths.ends[place] : paths.ends[place + 1]] = 0.0
        scale[j] = 0.0
        if holds(rows[j], held.z) and (rows[j].holds_place or not held.places_only):
            scale[j] = put_visits(scene, work, held, j, is_implicit)
    for meeting in range(paths.meetings_at[at + 1], paths.meetings_at[at + 2]):
        _sum_meeting(scene, work, kept, meeting)
    for place in range(begin, end):
        j = paths.order[place]
        # a row of unit length if it pointed along the motion of its ends
        size = A[paths.ends[place + 1] - 1]
        if size == 0.0:
            scale[j] = 0.0
        if scale[j] != 0.0:
            # a negative one is of something whose inertia is below zero: its pivot tells it
            scale[j] = np.sqrt(scale[j] / (size if size.real > 0.0 else -size))


@inlined
def _sum_meeting(scene: Scene, work: Work, kept: LoopFactors, number: int) -> None:
    """Add what rows of constraints have in common at a joint, or at the modes of a body, to A."""
    paths = scene.loops.paths
    meetings, guests, visits = Meetings(paths.meetings), Guests(paths.guests), Visits(paths.visits, kept.visited)
    meeting, A, scale = meetings[number], kept.A, kept.scale
    link, frame, first = links_of(scene)[meeting.row], work.frames[meeting.row], meeting.first_guest
    for a in range(first, meetings[number + 1].first_guest):
        if scale[guests[a].row] == 0.0:
            continue
        own, place = visits[guests[a].visit], paths.place[guests[a].row]
        row = paths.ends[place + 1] - 1 - place
        for b in range(first, a + 1):
            if scale[guests[b].row] == 0.0:
                continue
            other = visits[guests[b].visit]
            if meeting.is_modes:
                shared = total(own.p, other.x) - total(own.on, other.moved)
            else:
                shared = shared_answer(link, frame, own.force, own.moment, own.answer, other.answer)
            A[row + paths.place[guests[b].row]] += shared
