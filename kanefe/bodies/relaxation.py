"""Relaxation of the stress in a flexible body: arms of springs and dampers in series beside its long-term stiffness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Relaxation:
    """Arms of a generalised Maxwell model in the coordinates eta of a body.

    With states z the arms pull with ``-L (L^T eta - z)``, store ``1/2 |L^T eta - z|^2`` and relax,

        dz_i/dt = (L^T eta - z)_i / tau_i,

    so that a harmonic motion meets the stiffness ``K + L diag(i w tau / (1 + i w tau)) L^T`` (Christensen, Theory of
    Viscoelasticity, 1982, 1.6).

    Attributes
    ----------
    factors : ndarray, shape (k, m)
        L, in sqrt(J) per unit of eta: the stiffness of the arms is ``L L^T``.
    times : ndarray, shape (m,)
        tau, relaxation times in s.
    """

    factors: np.ndarray
    times: np.ndarray

    def __post_init__(self) -> None:
        for array in (self.factors, self.times):
            array.flags.writeable = False
