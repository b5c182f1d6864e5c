"""Forces of contacts that can be shared in several ways: shared so that none pulls or holds by more than its friction.

What `kanefe.kane.rigid_contacts.contact_shares` finds by linear programs is looked for here by descent: along what the
equations leave free, of half the squares of the distances from the cones of friction, with Nesterov's momentum
(Nesterov, "Introductory Lectures on Convex Optimization", 2004, section 2.2).
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.least_norm import leave_spare
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW
from kanefe.kernels.constraints.loop_tables import DIRECTION, KIND_OF, LIVE, POINT, RANK, UnitResponses
from kanefe.kernels.contact.falling import AT
from kanefe.kernels.contact.rigid_points import OF_POINT, is_closed, is_slipping
from kanefe.kernels.tables import Loops

MOST_ROUNDS, ROOMS = 2000, (1e-3, 1e-6, 1e-9)
"""Largest number of steps of each search; margins that are looked for one after the other, relative to the largest
force: a search ends at half of its own. Where there is no room so large, a compromise of least squares can be below
zero, by part of that room, though other forces are not."""


@kernel
def least_margins(loops: Loops, z: np.ndarray, multipliers: np.ndarray) -> tuple[float, float]:
    """Return the least normal force, and the least that friction could still hold, N; infinite where there is none."""
    normal = slip = np.inf
    for j in range(len(loops.rows)):
        if not is_head(loops, j, z):
            continue
        p = loops.rows[j, POINT]
        normal = min(normal, multipliers[j])
        if not is_slipping(loops.points, p, z):
            holding = loops.points.numbers[p, int(OF_POINT.friction) + int(AT.holding)]
            slip = min(slip, holding * multipliers[j] - np.hypot(multipliers[j + 1], multipliers[j + 2]))
    return normal, slip


@inlined
def is_head(loops: Loops, j: int, z: np.ndarray) -> bool:
    """Return whether a row is the normal row of a point that touches."""
    is_normal = loops.rows[j, KIND_OF] == CONTACT_ROW and loops.rows[j, DIRECTION] == 0
    return is_normal and is_closed(loops.points, loops.rows[j, POINT], z)


@kernel
def share_otherwise(loops: Loops, z: np.ndarray, multipliers: np.ndarray, kept: UnitResponses) -> None:
    """Change the multipliers of `hold` along what they leave free, until the margins are above zero, if they can be."""
    n, rank = int(kept.told[LIVE]), int(kept.told[RANK])
    if rank == n:
        return
    steepest, largest = 0.0, 0.0
    for a in range(n):
        j = int(kept.live[a])
        steepest = max(steepest, kept.scale[j] ** 2)
        largest = max(largest, abs(multipliers[j]))
        kept.rest[a] = multipliers[j] / kept.scale[j]
    for share in ROOMS:
        if _descend(loops, z, share * largest, 1.0 / steepest, multipliers, kept):
            return
        normal, slip = least_margins(loops, z, multipliers)
        if min(normal, slip) < -share * largest:  # more is missing than the room: there are none
            return


@kernel
def _descend(
    loops: Loops, z: np.ndarray, room: float, step: float, multipliers: np.ndarray, kept: UnitResponses
) -> bool:
    """Change the multipliers until the margins are half of what is looked for; return whether they are."""
    n, rank, slope = int(kept.told[LIVE]), int(kept.told[RANK]), kept.column
    for k in range(MOST_ROUNDS):
        normal, slip = least_margins(loops, z, multipliers)
        if min(normal, slip) >= 0.5 * room:
            return True
        kept.plain[:] = 0.0
        for j in range(len(loops.rows)):
            if is_head(loops, j, z):
                _put_beyond(loops, j, z, room, multipliers, kept.plain)
        for a in range(n):
            j = int(kept.live[a])
            slope[a] = kept.scale[j] * kept.plain[j]
        leave_spare(kept.L, slope, n, rank, kept.order, kept.inverses, kept.spare)
        for a in range(n):
            j = int(kept.live[a])
            reached = multipliers[j] / kept.scale[j] - step * slope[a]
            multipliers[j] = kept.scale[j] * (reached + k / (k + 3.0) * (reached - kept.rest[a]))
            kept.rest[a] = reached
    return False


@inlined
def _put_beyond(loops: Loops, j: int, z: np.ndarray, room: float, forces: np.ndarray, beyond: np.ndarray) -> None:
    """Write how far the forces of a point are beyond those with some room that it can have."""
    p = loops.rows[j, POINT]
    if is_slipping(loops.points, p, z):
        beyond[j] = min(forces[j] - room, 0.0)
        return
    mu = loops.points.numbers[p, int(OF_POINT.friction) + int(AT.holding)]
    normal = forces[j] - room * (max(1.0, 1.0 / mu) if mu > 0.0 else 1.0)
    size = np.hypot(forces[j + 1], forces[j + 2])
    if size <= mu * normal:
        return
    nearest = max((normal + mu * size) / (1.0 + mu * mu), 0.0)
    share = mu * nearest / size if size > 0.0 else 0.0
    beyond[j] = normal - nearest
    beyond[j + 1], beyond[j + 2] = (1.0 - share) * forces[j + 1], (1.0 - share) * forces[j + 2]
