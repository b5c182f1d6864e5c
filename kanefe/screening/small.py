"""Small motions of a scene on its carrier at rest, while everything sticks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.screening.riders import Motions
from kanefe.screening.sticking import Sticking

LEAST_DECAY = 1e-3
"""Decay rate below which a motion is not superposed, 1/s."""


class NotSuperposed(Exception):
    """Superposition does not converge to the full equations; the message gives the reason."""


@dataclass(frozen=True, eq=False)
class Small:
    """Small motions x = (xi, dxi/dt) on the carrier at rest: ``A = V diag(rates) V^-1``; anchors follow, z = W xi.

    ``pulls``, (free, states): derivatives of the accelerations by the anchors. ``follows``, (states, states), projects
    their rates on those that follow motions; those that decay by themselves are taken as zero.
    """

    rates: np.ndarray
    V: np.ndarray
    inverse: np.ndarray
    W: Matrix
    pulls: Matrix
    follows: Matrix

    @classmethod
    def about(cls, sticking: Sticking, q: Vector, z: Vector) -> Small:
        """Linearise about a configuration on the carrier at rest; raise NotSuperposed if a motion does not decay."""
        model = sticking.held_at_rest
        n, m = model.coordinate_count, model.free_count
        J = model.jacobian(0.0, np.concatenate((q, np.zeros(m), z)))
        tangents = model.coordinate_map(q)
        rows, W = J[n : n + m], J[n + m :, n : n + m]
        stiff = rows[:, :n] @ tangents + rows[:, n + m :] @ W
        A = np.block([[np.zeros((m, m)), np.eye(m)], [stiff, rows[:, n : n + m]]])
        own = J[n + m :, n + m :]
        follows = np.eye(len(own)) - np.linalg.pinv(own, rcond=1e-9) @ own
        rates, V = np.linalg.eig(A)
        if rates.real.max() > -LEAST_DECAY:
            raise NotSuperposed("a motion on the carrier is free or undamped")
        return cls(rates, V, np.linalg.inv(V), W, rows[:, n + m :], follows)

    def response(self, left: np.ndarray, step: float) -> Motions:
        """Return the motions forced by accelerations (T, free) at equal steps, taken as periodic."""
        count, m = left.shape
        frequencies = 2.0 * np.pi * np.fft.rfftfreq(count, step)
        forced = np.fft.rfft(left, axis=0) @ self.inverse[:, m:].T
        x = (forced / (1j * frequencies[:, None] - self.rates)) @ self.V.T
        if count % 2 == 0:
            x[-1] = 0.0
        xi, rate = x[:, :m], x[:, m:]
        return Motions(*(np.fft.irfft(part, count, axis=0) for part in (xi, rate, 1j * frequencies[:, None] * rate)))

    def transient(self, begun: Vector, times: Vector) -> np.ndarray:
        """Return the decay of initial small motions (2 free,), (T, 2 free)."""
        grown = np.exp(np.multiply.outer(times, self.rates)) * (self.inverse @ begun)
        return np.asarray((grown @ self.V.T).real)
