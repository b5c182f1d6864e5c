"""Inertia of a beam that bends far: sums over its sections (Eq. 12, 37, 38 with exact rotations)."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.bodies.exact.beam_line import BeamLine
from kanefe.bodies.mass_moments import MassMoments
from kanefe.frames import Matrix, Vector, skews
from kanefe.storage.pickled import PickledByFields
from kanefe.storage.serialise import NOT_SAVED


@dataclass(frozen=True, eq=False)
class BeamInertia(PickledByFields):
    """Inertia of a `BeamLine`, with the methods that other bodies' mass moments have.

    Attributes
    ----------
    line : BeamLine
    quadratic_first, quadratic_second : None
        There is no expansion, so nothing to complete by second-order displacements.
    """

    line: BeamLine = field(default=None, metadata=NOT_SAVED)  # type: ignore[assignment]
    quadratic_first = None
    quadratic_second = None

    @property
    def mass(self) -> np.ndarray:
        """Mass in kg."""
        return np.asarray(self.line.masses.sum())

    @cached_property
    def at_rest(self) -> MassMoments:
        """Moments of the undeformed beam as a rigid body."""
        rigid, _ = self.terms(np.zeros(self.line.count), np.zeros(self.line.count), np.zeros(3))
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
        terms = (self.terms(row, np.zeros_like(row), still)[0] for row in eta)
        return np.array([(m[5, 1], m[3, 2], m[4, 0]) for m in terms]).reshape(-1, 3)

    def terms(self, eta: Vector, deta: Vector, w: Vector) -> tuple[Matrix, Vector]:
        """Return the generalised mass and the velocity-dependent inertia forces in G, as `MassMoments.terms` does.

        Each section is a rigid body with its exact rotation (Eq. 12, 37, 38).
        """
        n = self._sections_at(eta, deta, w)
        width = n.V.shape[2]
        flat, turned = n.V.reshape(-1, width), n.W.reshape(-1, width)
        mass = flat.T @ (n.m[:, :, None] * n.V).reshape(-1, width) + turned.T @ (n.inertia @ n.W).reshape(-1, width)
        return mass, flat.T @ (n.m * n.a).ravel() + turned.T @ n.moment.ravel()

    def wrenches(self, eta: Vector, deta: Vector, w: Vector, rates: Vector) -> Matrix:
        """Return the inertia forces of the Gauss points, and their moments about the axis, in G, (C P, 6), N and N m.

        `rates` are those of the speeds of G and of the coordinates, (6 + k,).
        """
        n = self._sections_at(eta, deta, w)
        force = -n.m * (n.V @ rates + n.a)
        moment = -np.squeeze(n.inertia @ (n.W @ rates)[..., None], -1) - n.moment
        return np.hstack((force, moment + np.cross(n.arm, force)))

    def _sections_at(self, eta: Vector, deta: Vector, w: Vector) -> _Sections:
        line, k = self.line, self.line.count
        motion = line.motion(eta, deta)
        gauss = line.gauss_nodes.ravel()
        m, inertias = line.masses.reshape(-1, 1), line.inertias.reshape(-1, 3, 3)
        A, own, y = motion.A[gauss], motion.w[gauss], motion.y[gauss]
        arm = np.squeeze(A @ line.centres.reshape(-1, 3, 1), -1)
        r = motion.p[gauss] + arm
        inertia = A @ inertias @ A.swapaxes(1, 2)
        V = np.zeros((len(gauss), 3, 6 + k))
        W = np.zeros_like(V)
        V[:, :, :3] = W[:, :, 3:6] = np.eye(3)
        V[:, :, 3:6] = -skews(r)
        W[:, :, 6:] = motion.W[gauss]
        V[:, :, 6:] = motion.V[gauss] - skews(arm) @ motion.W[gauss]
        swing = np.cross(own, arm)
        inner = motion.z[gauss] + np.cross(y, arm) + np.cross(own, swing)
        a = inner + 2.0 * np.cross(w, motion.v[gauss] + swing) + np.cross(w, np.cross(w, r))
        spin, alpha = w + own, y + np.cross(w, own)
        momentum = np.squeeze(inertia @ spin[..., None], -1)
        moment = np.squeeze(inertia @ alpha[..., None], -1) + np.cross(spin, momentum)
        return _Sections(m, inertia, arm, V, W, a, moment)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return nothing: the arrays are those of the line."""
        return {}


class _Sections(NamedTuple):
    """Inertia of the sections at the Gauss points.

    Attributes
    ----------
    m, inertia : ndarray, shapes (n, 1), (n, 3, 3)
        kg, and about the centres of mass, in G, kg m2.
    arm : ndarray, shape (n, 3)
        Centres of mass from the axis, in G, m.
    V, W : ndarray, shape (n, 3, 6 + k)
        Velocities of the centres and angular velocities by the speeds of G and the rates of the coordinates.
    a, moment : ndarray, shape (n, 3)
        Accelerations of the centres while these have none, and the moments of inertia then.
    """

    m: np.ndarray
    inertia: np.ndarray
    arm: np.ndarray
    V: np.ndarray
    W: np.ndarray
    a: np.ndarray
    moment: np.ndarray
