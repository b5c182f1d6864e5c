"""Multipliers where points of rigid contacts touch: those of least norm, if friction leaves them determined."""

from typing import Any

import numpy as np

from kanefe.kernels.algebra.least_norm import factor_least, solve_least
from kanefe.kernels.algebra.pivoted import factor, pivots_of, solve
from kanefe.kernels.constraints.constraint_rows import RowKind
from kanefe.kernels.constraints.loop_tables import Limits, UnitResponses, has_loops, rows_of, rubs_at
from kanefe.kernels.language import kernel
from kanefe.kernels.tables import Loops

LEAST_GAIN = 1e-9
"""Fraction of what a normal force does without friction, below which friction takes away all that it does."""


@kernel
def share_forces(loops: Loops, z: np.ndarray, is_skew: bool, multipliers: np.ndarray, kept: UnitResponses) -> Any:
    """Write the multipliers where points touch: of several the least ones; return the weakest pivot of loops, if any.

    Where a force presses a slipping point more than it can hold it out, they are not a number (Painleve's paradox).
    """
    closes, A, L, column, live, scale = has_loops(loops, kept), kept.A, kept.L, kept.column, kept.live, kept.scale
    if is_skew and not _is_determined(loops, z, closes, multipliers, kept):
        multipliers[:] = np.nan
        return 1.0
    n = 0
    for j in range(len(multipliers)):
        multipliers[j] = 0.0
        if scale[j] != 0.0:
            live[n] = j
            n += 1
    for a in range(n):
        i = int(live[a].real)
        column[a] = scale[i] * kept.rest[i]
        for b in range(n):
            j = int(live[b].real)
            entry = A[i, j] if is_skew or j <= i else A[j, i]
            L[a, b] = scale[i] * entry * scale[j]
    tolerance = Limits(loops.limits).rank_tolerance
    rank, weakest = factor_least(L, column, n, tolerance, kept.order, kept.inverses, kept.spare)
    solve_least(L, column, n, rank, kept.order, kept.inverses, kept.spare)
    for a in range(n):
        j = int(live[a].real)
        multipliers[j] = scale[j] * column[a]
    kept.live_count, kept.rank = n, rank
    return weakest if closes else 1.0


@kernel
def _is_determined(loops: Loops, z: np.ndarray, closes: bool, y: np.ndarray, kept: UnitResponses) -> bool:
    """Return whether the normal force of each slipping point holds it out, the loops held; y is workspace (m,)."""
    rows, A, of_loops, rank = rows_of(loops), kept.A, kept.spare, 0
    for j in range(len(rows)):
        of_loops[j] = kept.scale[j] if rows[j].kind != RowKind.CONTACT else 0.0 * kept.scale[j]
    if closes:
        tolerance = Limits(loops.limits).rank_tolerance
        rank, _ = factor(A, of_loops, tolerance, pivots_of(kept))
    for j in range(len(rows)):
        if kept.scale[j] == 0.0 or not rubs_at(loops, rows[j], z):
            continue
        gained, plain = A[j, j].real, kept.plain[j].real
        if closes:
            gained -= _lost(kept, rank, A[:, j], A[j], y)
            plain -= _lost(kept, rank, A[j], A[j], y)
        if not gained > LEAST_GAIN * plain:
            return False
    return True


@kernel
def _lost(kept: UnitResponses, rank: int, right: np.ndarray, row: np.ndarray, y: np.ndarray) -> float:
    """Return what loops take of what a force does along a row; `right` is what it does along theirs."""
    live, of_loops, lost = kept.live, kept.spare, 0.0
    for i in range(len(live)):
        live[i] = right[i] if of_loops[i] != 0.0 else 0.0 * right[i]
    solve(pivots_of(kept), rank, of_loops, live, y)
    for i in range(len(live)):
        if of_loops[i] != 0.0:
            lost += (row[i] * y[i]).real
    return lost
