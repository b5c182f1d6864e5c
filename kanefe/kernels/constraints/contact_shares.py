"""Forces of contacts that can be shared in several ways: shared so that none pulls or holds by more than its friction.

What `kanefe.kane.contact_shares` finds by linear programs is looked for here by descent: along what the
equations leave free, of half the squares of the distances from the cones of friction, with Nesterov's momentum
(Nesterov, "Introductory Lectures on Convex Optimization", 2004, section 2.2).
"""

import numpy as np

from kanefe.kernels.algebra.least_norm import leave_spare
from kanefe.kernels.constraints.loop_tables import UnitResponses, head_of
from kanefe.kernels.contact.rigid_points import given_points, is_closed, is_slipping
from kanefe.kernels.language import inlined, kernel
from kanefe.kernels.tables import Loops

MOST_ROUNDS, ROOMS = 2000, (1e-3, 1e-6, 1e-9)
"""Largest number of steps of each search; margins that are looked for one after the other, relative to the largest
force: a search ends at half of its own. Where there is no room so large, a compromise of least squares can be below
zero, by part of that room, though other forces are not."""


@kernel
def least_margins(loops: Loops, z: np.ndarray, multipliers: np.ndarray) -> tuple[float, float]:
    """Return the least normal force, and the least that friction could still hold, N; infinite where there is none."""
    points, normal, slip = given_points(loops.points), np.inf, np.inf
    for p in range(len(points)):
        given, j = points[p], head_of(loops, p)
        if is_closed(given, z):
            normal = min(normal, multipliers[j])
            if not is_slipping(given, z):
                held = given.friction.holding * multipliers[j]
                slip = min(slip, held - np.hypot(multipliers[j + 1], multipliers[j + 2]))
    return normal, slip


@kernel
def share_otherwise(loops: Loops, z: np.ndarray, multipliers: np.ndarray, kept: UnitResponses) -> None:
    """Change the multipliers of `hold` along what they leave free, until the margins are above zero, if they can be."""
    n, rank, scale, live = int(kept.live_count), int(kept.rank), kept.scale, kept.live
    if rank == n:
        return
    steepest, largest = 0.0, 0.0
    for a in range(n):
        j = int(live[a])
        steepest = max(steepest, scale[j] ** 2)
        largest = max(largest, abs(multipliers[j]))
        kept.rest[a] = multipliers[j] / scale[j]
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
    n, rank, slope, scale, live = int(kept.live_count), int(kept.rank), kept.column, kept.scale, kept.live
    points = given_points(loops.points)
    for k in range(MOST_ROUNDS):
        normal, slip = least_margins(loops, z, multipliers)
        if min(normal, slip) >= 0.5 * room:
            return True
        kept.plain[:] = 0.0
        for p in range(len(points)):
            given, j = points[p], head_of(loops, p)
            if is_closed(given, z):
                mu = -1.0 if is_slipping(given, z) else given.friction.holding
                _put_beyond(mu, room, multipliers[j : j + 3], kept.plain[j : j + 3])
        for a in range(n):
            j = int(live[a])
            slope[a] = scale[j] * kept.plain[j]
        leave_spare(kept.L, slope, n, rank, kept.order, kept.inverses, kept.spare)
        for a in range(n):
            j = int(live[a])
            reached = multipliers[j] / scale[j] - step * slope[a]
            multipliers[j] = scale[j] * (reached + k / (k + 3.0) * (reached - kept.rest[a]))
            kept.rest[a] = reached
    return False


@inlined
def _put_beyond(mu: float, room: float, forces: np.ndarray, beyond: np.ndarray) -> None:
    """Write how far the forces of a point are beyond those with some room that it can have; mu below zero: it slips."""
    if mu < 0.0:
        beyond[0] = min(forces[0] - room, 0.0)
        return
    normal = forces[0] - room * (max(1.0, 1.0 / mu) if mu > 0.0 else 1.0)
    size = np.hypot(forces[1], forces[2])
    if size <= mu * normal:
        return
    nearest = max((normal + mu * size) / (1.0 + mu * mu), 0.0)
    share = mu * nearest / size if size > 0.0 else 0.0
    beyond[0], beyond[1], beyond[2] = normal - nearest, (1.0 - share) * forces[1], (1.0 - share) * forces[2]
