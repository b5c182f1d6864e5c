"""How well the functions of beams that bend far can show what they did: an estimate from the run itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.bodies.exact.doubt import doubt
from kanefe.frames import Matrix, Vector
from kanefe.tree.model_data import ModelData

COARSE = 1e-2
"""Displacement by the last functions, relative to the length of the beam, above which a run is warned of."""


class Resolution(NamedTuple):
    """What a beam's discretisation leaves open.

    Attributes
    ----------
    body : str
    doubt : float
        Displacement by the last two functions of its strains, and errors of the quadratures of turns and places, m.
    length : float
        Of the beam, m.
    time : float
        s.
    """

    body: str
    doubt: float
    length: float
    time: float

    @property
    def is_coarse(self) -> bool:
        """Whether the estimate is above what a run is warned of."""
        return self.doubt > COARSE * self.length

    def __str__(self) -> str:
        share = self.doubt / self.length
        what = "the last functions, and errors of quadrature, move it"
        return f"of {self.body!r}: {what} by {self.doubt:.2g} m at most, {share:.1g} of its length"

    @property
    def remark(self) -> str:
        """Message for a beam with too few functions, with a remedy."""
        return f"strains {self}, at t = {self.time:.6g} s. Remedy: more functions (basis=...) for this beam"


def worst_resolution(model: ModelData, times: Vector, coordinates: Matrix) -> Resolution | None:
    """Return the resolution of the beam with the largest doubt over its length; None without such beams."""
    found = []
    for body in model.bodies:
        if body.flexible is None or (line := body.flexible.body.line) is None:
            continue
        etas, stiffness = coordinates[:, body.flexible.eta], np.diag(body.flexible.body.stiffness)
        if not line.last.any() or not np.all(np.isfinite(etas)):
            continue
        energies = np.square(etas) * stiffness
        # where the last functions do most, and where the beam turns most
        for row in {int(np.argmax(energies[:, which].sum(axis=1))) for which in (line.last, slice(None))}:
            found.append(Resolution(body.name, doubt(line, etas[row]), float(line.lengths.sum()), float(times[row])))
    return max(found, key=lambda one: one.doubt / one.length, default=None)
