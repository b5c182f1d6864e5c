"""Forces of contacts that can be shared in several ways, as they are told: see `told_multipliers`.

Multipliers y that together do nothing are those of which the unit responses add up to nothing, ``X^T y = 0``. Where
friction rubs these are fewer than what the rows do not see, ``A y = 0``: the rest changes the motion.
"""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, leave_spare
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.constraints.contact_shares import is_head, least_margins
from kanefe.kernels.constraints.loop_tables import IS_ANGLE, LENGTH, LIVE, POINT, RANK, UnitResponses
from kanefe.kernels.contact.falling import AT
from kanefe.kernels.contact.rigid_points import OF_POINT, is_slipping
from kanefe.kernels.tables import Loops

# Pivot of the products of unit responses, of the largest, below which it is round-off; they square what rows lack
ROUND_OFF = 1e-13
# Pivot above which it is none, see `kanefe.kane.rigid_contacts.contact_shares.DEPENDENT`: the literal route tells what
# is in between
SHARP = 1e-9
NOT_SHARP = -1


@kernel
def told_multipliers(loops: Loops, z: np.ndarray, count: int, multipliers: np.ndarray, kept: UnitResponses) -> bool:
    """Share the forces of what touches, after an evaluation, as they are told; return whether they are known.

    As `kanefe.kane.rigid_contacts.contact_shares.shared_forces`: the least ones, else with friction by the normal
    forces; what else can be, the literal route has to find.

    Parameters
    ----------
    z : ndarray, shape (states,)
    count : int
        Of free speeds.
    multipliers : ndarray, shape (m,)
        Of `kanefe.kernels.constraints.multipliers.hold`.
    kept : UnitResponses
        Likewise; what is not a response is lost.
    """
    n, left_out, touches = 0, 0, False
    for j in range(len(multipliers)):
        if kept.scale[j] != 0.0:
            kept.live[n] = j
            kept.rest[n] = loops.limits[LENGTH] if loops.rows[j, IS_ANGLE] else 1.0
            n += 1
            if multipliers[j] == 0.0:
                left_out += 1
        touches = touches or is_head(loops, j, z)
    if kept.told[LIVE] >= 0.0:
        left_out = int(kept.told[LIVE] - kept.told[RANK])
    if left_out == 0:
        return True
    spare = _share(loops, n, count, multipliers, kept) if touches else NOT_SHARP
    if spare <= 0:
        return spare == 0
    if min(least_margins(loops, z, multipliers)) >= 0.0:
        return True
    n = 0
    for j in range(len(multipliers)):
        if not is_head(loops, j, z) or is_slipping(loops.points, loops.rows[j, POINT], z):
            continue
        room = loops.points.numbers[loops.rows[j, POINT], int(OF_POINT.friction) + int(AT.holding)] * multipliers[j]
        for i in (j + 1, j + 2):
            if not room > 0.0:
                return False
            if kept.scale[i] != 0.0:
                kept.live[n], kept.rest[n] = i, np.sqrt(room)
                n += 1
    if n == 0 or _share(loops, n, count, multipliers, kept) <= 0:
        return False
    return min(least_margins(loops, z, multipliers)) >= 0.0


@inlined
def _share(loops: Loops, n: int, count: int, multipliers: np.ndarray, kept: UnitResponses) -> int:
    """Take away of n live multipliers what does nothing, measured in units: their norm is the least one then.

    Return in how many ways they can do nothing; NOT_SHARP, where round-off may hide that.
    """
    products, units, x, weights = kept.L, kept.rest, kept.column, kept.reach
    for k in range(count):
        weights[k] = 1.0 / (loops.extents[k] * loops.extents[k])
    for a in range(n):
        i = int(kept.live[a])
        x[a] = multipliers[i] / units[a]
        kept.plain[a] = 0.0
        for b in range(a + 1):
            j, total = int(kept.live[b]), 0.0
            for k in range(count):
                total += kept.unit_responses[i, k] * kept.unit_responses[j, k] * weights[k]
            products[a, b] = products[b, a] = units[a] * units[b] * total
    rank, weakest = factor_least(products, kept.plain, n, ROUND_OFF, kept.order, kept.inverses, kept.spare)
    if weakest < SHARP:
        return NOT_SHARP
    if rank < n:
        leave_spare(products, x, n, rank, kept.order, kept.inverses, kept.spare)
        for a in range(n):
            multipliers[int(kept.live[a])] -= units[a] * x[a]
    return n - rank
