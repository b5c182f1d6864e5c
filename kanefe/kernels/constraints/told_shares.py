"""Forces of contacts that can be shared in several ways, as they are told: see `told_multipliers`.

Multipliers y that together do nothing are those of which the unit responses add up to nothing, ``X^T y = 0``. Where
friction rubs these are fewer than what the rows do not see, ``A y = 0``: the rest changes the motion.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, leave_spare
from kanefe.kernels.constraints.contact_shares import least_margins
from kanefe.kernels.constraints.loop_tables import Limits, UnitResponses, head_of, rows_of
from kanefe.kernels.contact.rigid_points import given_points, is_closed, is_slipping, touches
from kanefe.kernels.language import kernel
from kanefe.kernels.tables import Loops


class Pivots(NamedTuple):
    """Pivots that count."""

    round_off: float = 1e-13
    """Pivot of the products of unit responses, of the largest, below which it is round-off; they square what rows
    lack."""
    sharp: float = 1e-9
    """Pivot, relative to the largest, above which it is none, see
    `kanefe.kane.contact_shares.DEPENDENT`: the literal route tells what is in between."""
    not_sharp: int = -1


PIVOT = Pivots()


@kernel
def told_multipliers(loops: Loops, z: np.ndarray, multipliers: np.ndarray, kept: UnitResponses) -> bool:
    """Share the forces of what touches, after an evaluation, as they are told; return whether they are known.

    As `kanefe.kane.contact_shares.shared_forces`: the least ones, else with friction by the normal
    forces; what else can be, the literal route has to find.

    Parameters
    ----------
    z : ndarray, shape (states,)
    multipliers : ndarray, shape (m,)
        Of `kanefe.kernels.constraints.multipliers.hold`.
    kept : UnitResponses
        Likewise; what is not a response is lost.
    """
    rows, points, n, left_out = rows_of(loops), given_points(loops.points), 0, 0
    for j in range(len(rows)):
        if kept.scale[j] != 0.0:
            kept.live[n] = j
            kept.rest[n] = Limits(loops.limits).length if rows[j].is_angle else 1.0
            n += 1
            if multipliers[j] == 0.0:
                left_out += 1
    if kept.live_count >= 0.0:
        left_out = int(kept.live_count - kept.rank)
    if left_out == 0:
        return True
    spare = _share(loops, n, multipliers, kept) if touches(points, z) else PIVOT.not_sharp
    if spare <= 0:
        return spare == 0
    if min(least_margins(loops, z, multipliers)) >= 0.0:
        return True
    n = 0
    for p in range(len(points)):
        given, j = points[p], head_of(loops, p)
        if not is_closed(given, z) or is_slipping(given, z):
            continue
        room = given.friction.holding * multipliers[j]
        for i in (j + 1, j + 2):
            if not room > 0.0:
                return False
            if kept.scale[i] != 0.0:
                kept.live[n], kept.rest[n] = i, np.sqrt(room)
                n += 1
    if n == 0 or _share(loops, n, multipliers, kept) <= 0:
        return False
    return min(least_margins(loops, z, multipliers)) >= 0.0


@kernel
def _share(loops: Loops, n: int, multipliers: np.ndarray, kept: UnitResponses) -> int:
    """Take away of n live multipliers what does nothing, measured in units: their norm is the least one then.

    Return in how many ways they can do nothing; `PIVOT.not_sharp`, where round-off may hide that.
    """
    products, units, x, live, responses = kept.L, kept.rest, kept.column, kept.live, kept.unit_responses
    weights = kept.reach
    for k in range(kept.free):
        weights[k] = 1.0 / (loops.extents[k] * loops.extents[k])
    for a in range(n):
        i = int(live[a])
        x[a] = multipliers[i] / units[a]
        kept.plain[a] = 0.0
        for b in range(a + 1):
            j, total = int(live[b]), 0.0
            for k in range(kept.free):
                total += responses[i, k] * responses[j, k] * weights[k]
            products[a, b] = products[b, a] = units[a] * units[b] * total
    rank, weakest = factor_least(products, kept.plain, n, PIVOT.round_off, kept.order, kept.inverses, kept.spare)
    if weakest < PIVOT.sharp:
        return PIVOT.not_sharp
    if rank < n:
        leave_spare(products, x, n, rank, kept.order, kept.inverses, kept.spare)
        for a in range(n):
            multipliers[int(live[a])] -= units[a] * x[a]
    return n - rank
