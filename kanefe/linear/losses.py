"""Losses of flexible bodies in small motions: arms of viscoelastic ones, and structural damping.

The equations are those of the scene with arms that follow at once. With the tangents z of the modal coordinates the
arms add the forces ``-L (L^T z - s)`` and the states s, in sqrt(J),

    ds/dt = (L^T z - s) / tau,

so that what is slow against tau meets the long-term stiffness alone; structural damping adds ``-i H z``, in harmonic
motions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from kanefe.frames import Matrix, Vector

if TYPE_CHECKING:
    from kanefe.equations.model import Model


@dataclass(frozen=True, eq=False)
class Arms:
    """The arms of all viscoelastic bodies.

    Attributes
    ----------
    factors : ndarray, shape (free, m)
        L over the free speeds.
    rates : ndarray, shape (m,)
        1 / tau, 1/s.
    places : ndarray of int, shape (m,)
        Indices of their states in z of the model.
    """

    factors: Matrix
    rates: Vector
    places: np.ndarray

    def __len__(self) -> int:
        return len(self.rates)


def arms_of(model: Model) -> Arms:
    """Return the arms of a model."""
    n = model.free_count
    factors, rates, places = [np.zeros((n, 0))], [np.zeros(0)], [np.zeros(0, dtype=int)]
    for load, where in zip(model.loads, model.load_states, strict=True):
        if load.kind != "relaxation":
            continue
        terms = model.bodies[load.ends[0].body].flexible
        own = None if terms is None else terms.body.relaxation
        if terms is None or own is None:
            continue
        wide = np.zeros((n, len(own.times)))
        wide[terms.speeds] = own.factors
        factors.append(wide)
        rates.append(1.0 / own.times)
        places.append(np.arange(where.start, where.stop))
    return Arms(np.hstack(factors), np.concatenate(rates), np.concatenate(places))


def structural_forces(model: Model) -> Matrix | None:
    """Return H of all bodies over the free speeds, (free, free); None: none has structural damping."""
    n = model.free_count
    found = None
    for body in model.bodies:
        own = None if body.flexible is None else body.flexible.body.structural
        if body.flexible is not None and own is not None:
            found = np.zeros((n, n)) if found is None else found
            found[body.flexible.speeds, body.flexible.speeds] = own
    return found


def condensed(A: Matrix, count: int) -> Matrix:
    """Return A over its first states, with those of the arms behind them following at once."""
    if len(A) == count:
        return A
    return np.asarray(A[:count, :count] - A[:count, count:] @ following(A, count))


def following(A: Matrix, count: int) -> Matrix:
    """Return minus the states of the arms that follow the first states of A at once, (m, count)."""
    return np.asarray(scipy.linalg.solve(A[count:, count:], A[count:, :count]))
