"""Forces of contacts that can be shared in several ways: shared so that none pulls or holds by more than its friction.

What `kanefe.kane.contact_shares` finds by linear programs is looked for here by descent: along what the equations leave
free, of half the squares of the distances from the cones of friction. These are convex, and their slopes have slopes in
turn but where a cone begins: Newton's steps by conjugate gradients, as far as they descend (Nocedal & Wright,
"Numerical Optimization", 2006, chapters 3 and 7; of such slopes Qi & Sun, Math. Programming 58 (1993) 353-367).
"""

import numpy as np

from kanefe.kernels.algebra.least_norm import leave_spare
from kanefe.kernels.constraints.loop_tables import UnitResponses, head_of
from kanefe.kernels.contact.rigid_points import given_points, is_closed, is_slipping
from kanefe.kernels.joints.motion import put_three, three
from kanefe.kernels.language import Vector, dot, inlined, kernel
from kanefe.kernels.tables import Loops

ROOMS = 1e-3, 1e-6, 1e-9
"""Margins that are looked for one after the other, relative to the largest force: a search ends at half of its own.
Where there is no room so large, a compromise of least squares can be below zero, by part of that room, though other
forces are not."""

MOST_STEPS, MOST_HALVINGS = 100, 30
"""Largest number of Newton's steps of a search, of which a few are common, and of halvings of one."""

LEVEL = 1e-13
"""Slope along what the equations leave free, relative to that along all forces, below which it is round-off; likewise
curvature, relative to the largest, descent that is promised, and the residual of the equations of a step."""


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
    if kept.rank == kept.live_count:
        return
    largest = 0.0
    for a in range(int(kept.live_count)):
        largest = max(largest, abs(multipliers[int(kept.live[a])]))
    for share in ROOMS:
        if _descend(loops, z, share * largest, multipliers, kept):
            return
        normal, slip = least_margins(loops, z, multipliers)
        if min(normal, slip) < -share * largest:  # more is missing than the room: there are none
            return


@kernel
def _descend(loops: Loops, z: np.ndarray, room: float, multipliers: np.ndarray, kept: UnitResponses) -> bool:
    """Change the multipliers until the margins are half of what is looked for; return whether they are."""
    left = _put_beyond(loops, z, room, multipliers, kept.plain)
    for _ in range(MOST_STEPS):
        normal, slip = least_margins(loops, z, multipliers)
        if min(normal, slip) >= 0.5 * room:
            return True
        if not _find_step(loops, z, room, multipliers, kept) > LEVEL * left:
            return False
        found = _go(loops, z, room, multipliers, kept, left)
        if not found < left:
            return False
        left = found
    return False


@kernel
def _put_beyond(loops: Loops, z: np.ndarray, room: float, multipliers: np.ndarray, beyond: np.ndarray) -> float:
    """Write how far forces are beyond those with the room that points can have; return half the squares of that."""
    points, left = given_points(loops.points), 0.0
    beyond[:] = 0.0
    for p in range(len(points)):
        given, j = points[p], head_of(loops, p)
        if not is_closed(given, z):
            continue
        if is_slipping(given, z):
            beyond[j] = min(multipliers[j] - room, 0.0)
            left += 0.5 * beyond[j] * beyond[j]
        else:
            mu, force = given.friction.holding, three(multipliers, j)
            normal, size, nearest = _nearest(room, mu, force)
            if size > mu * normal:
                share = mu * nearest / size
                own = Vector(normal - nearest, (1.0 - share) * force.y, (1.0 - share) * force.z)
                left += 0.5 * dot(own, own)
                put_three(beyond, j, own)
    return left


@inlined
def _nearest(room: float, mu: float, force: Vector) -> tuple[float, float, float]:
    """Return the normal force beyond the room, the friction, and the normal force of the nearest one in the cone."""
    normal = force.x - room * (max(1.0, 1.0 / mu) if mu > 0.0 else 1.0)
    size = np.hypot(force.y, force.z)
    return normal, size, max((normal + mu * size) / (1.0 + mu * mu), 0.0)


@kernel
def _bend(loops: Loops, z: np.ndarray, room: float, multipliers: np.ndarray, beyond: np.ndarray, x: np.ndarray) -> None:
    """Replace changes of the multipliers by those of what they are beyond."""
    points = given_points(loops.points)
    for p in range(len(points)):
        given, j = points[p], head_of(loops, p)
        if not is_closed(given, z):
            continue
        if is_slipping(given, z):
            x[j] = x[j] if beyond[j] < 0.0 else 0.0
            continue
        mu, force, own = given.friction.holding, three(multipliers, j), three(x, j)
        normal, size, nearest = _nearest(room, mu, force)
        if size <= mu * normal:
            put_three(x, j, 0.0 * own)
        elif nearest > 0.0:  # along the normal of the cone, and across it and the friction
            c, s = force.y / size, force.z / size
            along = (c * own.y + s * own.z - mu * own.x) / (1.0 + mu * mu)
            across = (1.0 - mu * nearest / size) * (c * own.z - s * own.y)
            put_three(x, j, Vector(-mu * along, c * along - s * across, s * along + c * across))


@kernel
def _leave_free(kept: UnitResponses, x: np.ndarray) -> tuple[float, float]:
    """Write the slope along what the equations leave free, in scaled multipliers, to `column`.

    Returns
    -------
    steepest, whole : float
        Largest square of a scale, and sum of the squares of the slope along all.
    """
    n, steepest, whole = int(kept.live_count), 0.0, 0.0
    for a in range(n):
        scale = kept.scale[int(kept.live[a])]
        kept.column[a] = scale * x[int(kept.live[a])]
        steepest, whole = max(steepest, scale * scale), whole + kept.column[a] * kept.column[a]
    leave_spare(kept.L, kept.column, n, int(kept.rank), kept.order, kept.inverses, kept.spare)
    return steepest, whole


@kernel
def _find_step(loops: Loops, z: np.ndarray, room: float, multipliers: np.ndarray, kept: UnitResponses) -> float:
    """Write the step of the scaled multipliers to `rest`; return by how much it would descend at first."""
    n, step, slope, left, way = int(kept.live_count), kept.rest, kept.column, kept.search[0], kept.search[1]
    moved, size, promised = kept.search[2], 0.0, 0.0
    steepest, whole = _leave_free(kept, kept.plain)
    for a in range(n):
        step[a], left[a], way[a] = 0.0, -slope[a], -slope[a]
        size += slope[a] * slope[a]
    if not size > LEVEL * LEVEL * whole:
        return 0.0
    now, along = size, size
    for _ in range(2 * (n - int(kept.rank))):  # as many as there are ways, but for round-off
        if not now > LEVEL * LEVEL * size:
            break
        moved[:] = 0.0
        for a in range(n):
            moved[int(kept.live[a])] = kept.scale[int(kept.live[a])] * way[a]
        _bend(loops, z, room, multipliers, kept.plain, moved)
        _leave_free(kept, moved)
        bent = 0.0
        for a in range(n):
            bent += way[a] * slope[a]
        if not bent > LEVEL * steepest * along:
            break
        share, before = now / bent, now
        promised += share * now
        now = 0.0
        for a in range(n):
            step[a] += share * way[a]
            left[a] -= share * slope[a]
            now += left[a] * left[a]
        along = 0.0
        for a in range(n):
            way[a] = left[a] + now / before * way[a]
            along += way[a] * way[a]
    return promised


@kernel
def _go(loops: Loops, z: np.ndarray, room: float, multipliers: np.ndarray, kept: UnitResponses, left: float) -> float:
    """Change the multipliers by as much of a step as descends, or by nothing; return what is left then."""
    before, share, n = kept.search[0], 1.0, int(kept.live_count)
    for a in range(n):
        before[a] = multipliers[int(kept.live[a])]
    for _ in range(MOST_HALVINGS):
        for a in range(n):
            j = int(kept.live[a])
            multipliers[j] = before[a] + share * kept.scale[j] * kept.rest[a]
        found = _put_beyond(loops, z, room, multipliers, kept.plain)
        if found < left:
            return found
        share *= 0.5
    for a in range(n):
        multipliers[int(kept.live[a])] = before[a]
    return left
