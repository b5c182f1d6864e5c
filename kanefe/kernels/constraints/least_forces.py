"""Multipliers where points of rigid contacts touch: those of least norm, if friction leaves them determined."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.algebra.pivoted import factor, solve
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW
from kanefe.kernels.constraints.loop_tables import (
    KIND_OF,
    LIVE,
    RANK,
    RANK_TOLERANCE,
    UnitResponses,
    has_loops,
    is_rubbing,
)
from kanefe.kernels.tables import Loops

# Share of what a normal force does without friction, below which friction takes away all that it does
LEAST_GAIN = 1e-9


@kernel
def share_forces(loops: Loops, z: np.ndarray, is_skew: bool, multipliers: np.ndarray, kept: UnitResponses) -> Any:
    """Write the multipliers where points touch: of several the least ones; return the weakest pivot of loops, if any.

    Where a force presses a slipping point more than it can hold it out, they are not a number (Painleve's paradox).
    """
    m, closes = len(loops.rows), has_loops(loops, kept)
    if is_skew and not _is_determined(loops, z, closes, multipliers, kept):
        multipliers[:] = np.nan
        return 1.0
    n = 0
    for j in range(m):
        multipliers[j] = 0.0
        if kept.scale[j] != 0.0:
            kept.live[n] = j
            n += 1
    for a in range(n):
        i = int(kept.live[a].real)
        kept.column[a] = kept.scale[i] * kept.rest[i]
        for b in range(n):
            j = int(kept.live[b].real)
            entry = kept.A[i, j] if is_skew or j <= i else kept.A[j, i]
            kept.L[a, b] = kept.scale[i] * entry * kept.scale[j]
    rank, weakest = factor_least(
        kept.L, kept.column, n, loops.limits[RANK_TOLERANCE], kept.order, kept.inverses, kept.spare
    )
    solve_least(kept.L, kept.column, n, rank, kept.order, kept.inverses, kept.spare)
    for a in range(n):
        j = int(kept.live[a].real)
        multipliers[j] = kept.scale[j] * kept.column[a]
    kept.told[LIVE], kept.told[RANK] = n, rank
    return weakest if closes else 1.0


@kernel
def _is_determined(loops: Loops, z: np.ndarray, closes: bool, y: np.ndarray, kept: UnitResponses) -> bool:
    """Return whether the normal force of each slipping point holds it out, the loops held; y is workspace (m,)."""
    m, rank = len(loops.rows), 0
    for j in range(m):
        is_loop = loops.rows[j, KIND_OF] != CONTACT_ROW
        kept.spare[j] = kept.scale[j] if is_loop else 0.0 * kept.scale[j]
    for j in range(m):
        if kept.scale[j] == 0.0 or not is_rubbing(loops, j, z):
            continue
        gained, plain = kept.A[j, j].real, kept.plain[j].real
        if closes:
            if rank == 0:
                rank, _ = factor(
                    kept.A, kept.spare, loops.limits[RANK_TOLERANCE], kept.L, kept.inverses, kept.order, kept.column
                )
            for by in range(2):
                for i in range(m):
                    kept.live[i] = (
                        (kept.A[j, i] if by else kept.A[i, j]) if kept.spare[i] != 0.0 else 0.0 * kept.rest[i]
                    )
                solve(kept.L, kept.inverses, kept.order, rank, kept.spare, kept.live, kept.column, y)
                lost = 0.0
                for i in range(m):
                    if kept.spare[i] != 0.0:
                        lost += (kept.A[j, i] * y[i]).real
                gained, plain = (gained, plain - lost) if by else (gained - lost, plain)
        if not gained > LEAST_GAIN * plain:
            return False
    return True
