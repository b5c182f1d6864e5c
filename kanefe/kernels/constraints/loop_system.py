"""The system of the multipliers of loops by the ways of their rows: what loops have in common, and nothing else.

A wrench on its way inward leaves at each joint, and at the modes of each body, a force that is given way to. With
``k`` that force, ``D`` the inertia that the sweep inward has eliminated there, and ``e = D^-1 k``,

    J_i M^-1 J_j^T = sum of k_i e_j over all joints and modes that both rows visit,

since the sweeps are a factorisation ``M^-1 = Psi^T D^-1 Psi`` (Rodriguez 1987, Jain 1991). Rows that share nothing
do not meet in the system. It is that of the links between their ends, with the link that carries them all at rest.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import dot, three
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.constraints.loop_factors import TURN, LoopFactors
from kanefe.kernels.constraints.loop_tables import HOLDS_PLACE, holds
from kanefe.kernels.constraints.row_paths import (
    FIRST_GUEST,
    GUEST,
    GUEST_VISIT,
    IS_MODES,
    MET_AT,
    OF_JOINT,
    OF_MODES,
    OF_WRENCH,
)
from kanefe.kernels.constraints.row_visits import put_visits
from kanefe.kernels.layout import CARRIED_COUNT, COUNT, FLEXIBLE, FREE, KIND, PIVOT, SPHERICAL
from kanefe.kernels.sweeps.elastic import total
from kanefe.kernels.tables import FlexibleTables, Loops, Tables


@inlined
def put_loop_system(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    at: int,
    z: np.ndarray,
    places_only: bool,
    work: np.ndarray,
    modal: np.ndarray,
    border: np.ndarray,
    is_implicit: bool,
    kept: LoopFactors,
) -> None:
    """Write A and the scales of the rows that are eliminated at a row of the scene; all they visit is.

    A row that does not hold, or no place where `places_only` is asked for, is left out: its scale is zero.

    Parameters
    ----------
    at : int
        -1: N.
    """
    paths = loops.paths
    begin, end = paths.places[at + 1], paths.places[at + 2]
    for place in range(begin, end):
        j = paths.order[place]
        kept.system.A[paths.ends[place] : paths.ends[place + 1]] = 0.0
        kept.system.scale[j] = 0.0
        if holds(loops, j, z) and not (places_only and not loops.rows[j, HOLDS_PLACE]):
            kept.system.scale[j] = put_visits(loops, tables, flexible, j, work, modal, border, is_implicit, kept)
    for meeting in range(paths.meetings_at[at + 1], paths.meetings_at[at + 2]):
        _sum_meeting(loops, tables, flexible, meeting, work, kept)
    for place in range(begin, end):
        j = paths.order[place]
        # a row of unit length if it pointed along the motion of its ends
        size = kept.system.A[paths.ends[place + 1] - 1]
        if size == 0.0:
            kept.system.scale[j] = 0.0
        if kept.system.scale[j] != 0.0:
            # a negative one is of something whose inertia is below zero: its pivot tells it
            kept.system.scale[j] = np.sqrt(kept.system.scale[j] / (size if size.real > 0.0 else -size))


@inlined
def _sum_meeting(
    loops: Loops,
    tables: Tables,
    flexible: FlexibleTables,
    meeting: int,
    work: np.ndarray,
    kept: LoopFactors,
) -> None:
    """Add what rows of constraints have in common at a joint, or at the modes of a body, to A."""
    paths, rows, numbers, A = loops.paths, tables.rows, kept.numbers, kept.system.A
    i, kind = paths.meetings[meeting, MET_AT], rows[paths.meetings[meeting, MET_AT], KIND]
    first, last = paths.meetings[meeting, FIRST_GUEST], paths.meetings[meeting + 1, FIRST_GUEST]
    for a in range(first, last):
        row = paths.guests[a, GUEST]
        if kept.system.scale[row] == 0.0:
            continue
        place, own = paths.place[row], paths.visits[paths.guests[a, GUEST_VISIT]]
        diagonal = paths.ends[place + 1] - 1
        for b in range(first, a + 1):
            other = paths.guests[b, GUEST]
            if kept.system.scale[other] == 0.0:
                continue
            their = paths.visits[paths.guests[b, GUEST_VISIT]]
            if paths.meetings[meeting, IS_MODES]:
                body, p, x = flexible.bodies[rows[i, FLEXIBLE]], own[OF_MODES], their[OF_MODES]
                k, n = body[COUNT], 6 * body[CARRIED_COUNT]
                on, moved = p + 2 * k, x + 2 * k + n
                shared = total(numbers[p : p + k], numbers[x + k : x + 2 * k])
                shared -= total(numbers[on : on + n], numbers[moved : moved + n])
            elif kind == SPHERICAL:
                shared = dot(three(numbers, own[OF_WRENCH] + TURN), three(numbers, their[OF_JOINT]))
            elif kind == FREE:
                at, by = own[OF_WRENCH], their[OF_JOINT]
                shared = -dot(three(numbers, at), three(numbers, by))
                shared -= dot(three(numbers, at + TURN), three(numbers, by + TURN))
            else:
                shared = numbers[own[OF_JOINT]] * numbers[their[OF_JOINT]] / work[i, PIVOT]
            A[diagonal - place + paths.place[other]] += shared
