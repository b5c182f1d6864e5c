"""A contact about a state of rest: what sticks is held by springs to marks on the surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix


class Rest(NamedTuple):
    """Where the points of a contact were when it was at rest.

    Attributes
    ----------
    material : ndarray, shape (probes, 3)
        Points of what touches that were in contact, from its frame in its axes, m.
    marks : ndarray, shape (probes, 3)
        Where they were on the surface, from its frame in its axes, m.
    turns : ndarray, shape (probes, 3, 3)
        From the axes of what touches to those of the surface, then.
    softness : float
        Depth s over which the normal force begins, m: its law is given ``s ln(1 + exp(depth / s))``, so that it acts
        from afar too, and a search for rest feels it. 0: it begins where the contact does.
    """

    material: Matrix
    marks: Matrix
    turns: np.ndarray
    softness: float
