"""Inertia of a beam that bends far: sums over its sections (Eq. 12, 37, 38 with exact rotations)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe.bodies.exact.beam_line import BeamLine
from kanefe.bodies.mass_moments import MassMoments
from kanefe.frames import Matrix, Vector, cross, skew
from kanefe.storage.pickled import PickledByFields


@dataclass(frozen=True, eq=False)
class BeamInertia(PickledByFields):
    """Inertia of a `BeamLine`, with the methods that other bodies' mass moments have.

    Attributes
    ----------
    line : BeamLine
    quadratic_first, quadratic_second : None
        There is no expansion, so nothing to complete by second-order displacements.
    """

    line: BeamLine
    quadratic_first = None
    quadratic_second = None

    @property
    def mass(self) -> np.ndarray:
        """kg."""
        return np.asarray(self.line.masses.sum())

    @cached_property
    def at_rest(self) -> MassMoments:
        """Moments of the undeformed beam as a rigid body."""
        rigid, _ = self._terms_at(np.zeros(self.line.count), np.zeros(self.line.count), np.zeros(3))
        first = np.array((rigid[5, 1], rigid[3, 2], rigid[4, 0]))
        second = 0.5 * np.trace(rigid[3:6, 3:6]) * np.eye(3) - rigid[3:6, 3:6]
        none = np.zeros((3, 0)), np.zeros((3, 3, 0)), np.zeros((3, 3, 0, 0))
        return MassMoments(self.mass, first, second, *none)

    @cached_property
    def elastic_mass(self) -> np.ndarray:
        """Mass of the coordinates at rest, (k, k)."""
        k = self.line.count
        return self.terms(np.zeros(k), np.zeros(k), np.zeros(3))[0][6:, 6:]

    def leading(self, count: int) -> BeamInertia | MassMoments:
        """Return the inertia of the first coordinates: of all, or of none."""
        if count == self.line.count:
            return self
        return self.at_rest.leading(count)

    def first_moments(self, eta: np.ndarray) -> np.ndarray:
        """Return int rho r at some coordinates eta (T, k), in G, kg m, shape (T, 3)."""
        still = np.zeros(3)
        terms = (self._terms_at(row, np.zeros_like(row), still)[0] for row in eta)
        return np.array([(m[5, 1], m[3, 2], m[4, 0]) for m in terms]).reshape(-1, 3)

    def terms(self, eta: Vector, deta: Vector, w: Vector) -> tuple[Matrix, Vector]:
        """Return the generalised mass and the velocity-dependent inertia forces in G, as `MassMoments.terms` does."""
        return self._terms_at(eta, deta, w)

    def _terms_at(self, eta: Vector, deta: Vector, w: Vector) -> tuple[Matrix, Vector]:
        line, k = self.line, self.line.count
        motion = line.motion(eta, deta)
        mass, bias = np.zeros((6 + k, 6 + k)), np.zeros(6 + k)
        for c, nodes in enumerate(line.gauss_nodes):
            for g, node in enumerate(nodes):
                A, own = motion.A[node], motion.w[node]
                arm = A @ line.centres[c, g]
                r = motion.p[node] + arm
                inertia = A @ line.inertias[c, g] @ A.T
                J = np.zeros((6, 6 + k))  # of the centre of mass, and of the axes
                J[:3, :3] = J[3:, 3:6] = np.eye(3)
                J[:3, 3:6] = -skew(r)
                J[:3, 6:] = motion.V[node] - skew(arm) @ motion.W[node]
                J[3:, 6:] = motion.W[node]
                velocity = motion.v[node] + cross(own, arm)
                inner = motion.z[node] + cross(motion.y[node], arm) + cross(own, cross(own, arm))
                a = inner + 2.0 * cross(w, velocity) + cross(w, cross(w, r))
                spin = w + own
                alpha = motion.y[node] + cross(w, own)
                moment = inertia @ alpha + cross(spin, inertia @ spin)
                mass += line.masses[c, g] * J[:3].T @ J[:3] + J[3:].T @ inertia @ J[3:]
                bias += line.masses[c, g] * J[:3].T @ a + J[3:].T @ moment
        return mass, bias

    def arrays(self) -> dict[str, np.ndarray]:
        """Return nothing: the arrays are those of the line."""
        return {}
