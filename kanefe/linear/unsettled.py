"""Whether a scene is linearised where it is in balance, and by how much it is not.

Small motions go with the stiffness that loads make in balance: a column that carries its weight is softer than one that
is about to. What is left over accelerates the scene away from the state, and its small motions change as it goes.
"""

from __future__ import annotations

import warnings

import numpy as np

from kanefe.errors import outside
from kanefe.linear.imbalance import Imbalance, worst_imbalance
from kanefe.linear.modes.unresisted import Unresisted
from kanefe.linear.small_motions import SmallMotions

REPORTED = 1e-3
"""Remaining force, relative to those that act in the same motion, from which a warning is issued: it is missing, by
about as much, in the stiffness that these forces cause."""


class UnsettledWarning(UserWarning):
    """Small motions about a state that is not in balance."""


def unsettled(small: SmallMotions, free: Unresisted) -> Imbalance:
    """Return what is out of balance, less what accelerates motions that nothing resists: these change nothing."""
    n = small.model.free_count
    N = small.speeds.N[:, : len(free.drifts)]
    leading = small.speeds.leading[: len(free.drifts)]
    M = N.T @ small.mass @ N
    du, drifts = small.du[leading], free.drifts
    if drifts.shape[1]:
        du = du - drifts @ np.linalg.solve(drifts.T @ M @ drifts, drifts.T @ M @ du)
    return worst_imbalance(small.here, N[:n] @ du, N[:n], leading)


def imbalance_in_words(found: Imbalance) -> list[str]:
    """Return the line of a listing that gives the imbalance; none if it is too small."""
    return [f"  out of balance: {found}, {found.ratio:.2g} of the forces there"] if found.ratio > REPORTED else []


def warn_of_imbalance(found: Imbalance, what: str, remedy: str = "kanefe.equilibrium(scene).linearise()") -> None:
    """Warn of a state that is not in balance; `what` names the analysis."""
    if found.ratio > REPORTED:
        warnings.warn(
            f"{what}: the state is not in equilibrium: {found} remains, {found.ratio:.2g} of the forces that act "
            f"there, and the stiffness due to loads is wrong by as much. Remedy: {remedy}, which finds the equilibrium "
            "first",
            UnsettledWarning,
            stacklevel=outside(),
        )
