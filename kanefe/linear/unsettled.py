"""The imbalance of a state of linearisation.

The stiffness due to loads is that of their internal forces in balance: a column that carries its weight is softer than
one that is not loaded yet. Remaining forces accelerate the scene away from the state, so that its small motions change.
"""

from __future__ import annotations

import warnings

import numpy as np

from kanefe.errors import outside
from kanefe.linear.imbalance import Imbalance, worst_imbalance
from kanefe.linear.modes.unresisted import Unresisted
from kanefe.linear.small_motions import SmallMotions

REPORTED = 5e-3
"""Remaining force, relative to those that act in the same motion, above which a warning is issued: the stiffness that
these forces cause has about the same relative error."""


class UnsettledWarning(UserWarning):
    """Small motions about a state that is not in balance."""


def unsettled(small: SmallMotions, free: Unresisted) -> Imbalance:
    """Return the imbalance without accelerations of free motions, which do not change the stiffness."""
    n = small.model.free_count
    N = small.speeds.N[:, : len(free.drifts)]
    leading = small.speeds.leading[: len(free.drifts)]
    M = N.T @ small.mass @ N
    du, drifts = small.du[leading], free.drifts
    if drifts.shape[1]:
        du = du - drifts @ np.linalg.solve(drifts.T @ M @ drifts, drifts.T @ M @ du)
    return worst_imbalance(small.here, small.mass[:n, :n], N[:n] @ du, N[:n], leading)


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
