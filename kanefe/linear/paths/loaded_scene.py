"""A scene at rest under its raised loads: balance, its derivatives, and the metric of its arc length.

    f(p, factor) = 0,    H = -df/dp,    g = df/dfactor

f are the accelerations along the independent coordinates p, as forces in coordinates of unit mass; H is the tangent
stiffness there, with all that loads add to it: it is not symmetric under follower loads. Lengths along a path are in
rad or scene lengths, and the factor counts in shares of the given range, so that no coordinate has to be singled out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.linear.equilibrium.balance import closed
from kanefe.linear.equilibrium.stiffness import stiffness_of
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.stability.raised_loads import scaled_model
from kanefe.linear.tangents import DIFFERENCE_STEP, tangent_steps

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

SYMMETRIC = 1e-7
"""Asymmetry of the scaled stiffness, relative to one, that is round-off."""

GROWS = 1e-9
"""Growth of a mode, relative to its eigenvalue, above which it counts: less may be round-off."""

ROUNDED = 1e-13
"""Eigenvalue relative to the largest that is round-off, and whose growth is meaningless."""


class Tangent(NamedTuple):
    """A direction in the space of the scene and the factor: free tangents z (free,), and the change of the factor."""

    z: Vector
    factor: float


@dataclass(frozen=True, eq=False)
class LoadedScene:
    """A scene under kept loads and raised ones, over its coordinates and the factor of the raised ones.

    Attributes
    ----------
    model : Model
        Under the raised loads as they are.
    t : float
        s.
    raised : dict
        The raised loads by name; None: gravity.
    span : float
        Range of factors, the unit of the factor in the metric.
    """

    model: Model
    t: float
    raised: dict[str, SceneLoad | None]
    span: float

    @cached_property
    def weights(self) -> Vector:
        """Displacement per unit of each free tangent, rad or scene lengths."""
        return np.asarray(DIFFERENCE_STEP / tangent_steps(self.model, np.eye(self.model.free_count)))

    def model_at(self, factor: float) -> Model:
        """Return the model under a factor of the loads."""
        return scaled_model(self.model, self.t, self.raised, factor)

    def dot(self, a: Tangent, b: Tangent) -> float:
        """Return the product of two directions in the metric of the path."""
        return float((self.weights * a.z) @ (self.weights * b.z)) + (a.factor / self.span) * (b.factor / self.span)

    def norm(self, a: Tangent) -> float:
        """Return the length of a direction."""
        return float(np.sqrt(self.dot(a, a)))

    def unit(self, a: Tangent) -> Tangent:
        """Return a direction of unit length."""
        size = self.norm(a)
        return Tangent(a.z / size, a.factor / size)

    def largest(self, a: Tangent) -> float:
        """Return the largest component of a direction: of a coordinate, or of the factor over its range."""
        return max(float(np.abs(self.weights * a.z).max(initial=0.0)), abs(a.factor) / self.span)

    def moved(self, q: Vector, z: Vector) -> Vector:
        """Return coordinates moved along a tangent, with closed loops."""
        return closed(self.model, self.t, self.model.advance(q, z), np.zeros(self.model.free_count))[0]

    def between(self, q: Vector, there: Vector, at: Balance) -> Vector:
        """Return the tangent at a balance from some coordinates to others near them, to first order."""
        return np.asarray(np.linalg.pinv(at.small.coordinate_map) @ (there - q))

    def balance(self, q: Vector, factor: float) -> Balance:
        """Return forces and stiffness at coordinates q under a factor of the loads."""
        return Balance(self, np.array(q, dtype=float), float(factor))


HEAVY = ("small", "_reduced", "along", "forces", "load", "stiffnesses")


class Balance:
    """Forces along the independent coordinates and their derivatives, in coordinates of unit mass."""

    def __init__(self, scene: LoadedScene, q: Vector, factor: float) -> None:
        self.scene, self.q, self.factor = scene, q, factor
        self._rest = np.zeros(scene.model.free_count)

    @cached_property
    def small(self) -> SmallMotions:
        """The small motions of the scene at rest."""
        return SmallMotions(self.scene.model_at(self.factor), self.scene.t, self.q, self._rest, checks=False)

    @cached_property
    def _reduced(self) -> tuple[Matrix, Matrix, Matrix]:
        return stiffness_of(self.small)

    @property
    def H(self) -> Matrix:
        """The tangent stiffness, 1/s2."""
        return self._reduced[0]

    @property
    def _weight(self) -> Matrix:
        return self._reduced[2]

    @cached_property
    def along(self) -> Matrix:
        """Free tangents of the coordinates of unit mass."""
        return np.asarray(self.small.positions.N @ self._reduced[1].T)

    @cached_property
    def forces(self) -> Vector:
        """Forces that remain."""
        return np.asarray(self._weight @ self.small.du[self.small.speeds.leading])

    def release(self) -> None:
        """Keep what a path lists of its points, and forget matrices, which are computed again if they are wanted."""
        _ = self.unstable, self.negative, self.is_symmetric
        for name in HEAVY:
            self.__dict__.pop(name, None)

    @cached_property
    def load(self) -> Vector:
        """g, the forces per unit of the factor: a difference, exact as forces are linear in the factor."""
        step = max(self.scene.span, 1.0)
        more = SmallMotions(self.scene.model_at(self.factor + step), self.scene.t, self.q, self._rest)
        change = (more.du - self.small.du)[self.small.speeds.leading]
        return np.asarray(self._weight @ change / step)

    def solved(self, forces: Vector, row: Tangent, length: float) -> Tangent:
        """Return the change for which ``H x - g dfactor = forces`` and that along `row` is a length (Keller, 1977)."""
        w, n, span = self.scene.weights, len(self.H), self.scene.span
        A = np.zeros((n + 1, n + 1))
        A[:n, :n], A[:n, n] = self.H, -span * self.load
        A[n, :n], A[n, n] = (w * w * row.z) @ self.along, row.factor / span
        size = np.abs(A).max(axis=1)
        rows = 1.0 / np.where(size > 0.0, size, 1.0)
        size = np.abs(A * rows[:, None]).max(axis=0)
        columns = 1.0 / np.where(size > 0.0, size, 1.0)
        A, right = A * rows[:, None] * columns, rows * np.append(forces, length)
        try:
            x = columns * np.linalg.solve(A, right)
        except np.linalg.LinAlgError:  # a branch point to the last digit: of the changes there, the least
            x = columns * np.linalg.lstsq(A, right, rcond=None)[0]
        return Tangent(self.along @ x[:n], float(span * x[n]))

    def tangent(self, ahead: Tangent) -> Tangent:
        """Return the unit tangent of the path, in the sense of a direction."""
        return self.scene.unit(self.solved(np.zeros(len(self.H)), ahead, 1.0))

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether the loads have a potential, as far as the stiffness shows."""
        size = np.sqrt(np.abs(self.H).max(axis=0, initial=0.0))
        scaled = (self.H - self.H.T) / np.where(size > 0.0, np.outer(size, size), 1.0)
        return bool(np.abs(scaled).max(initial=0.0) <= SYMMETRIC)

    @cached_property
    def stiffnesses(self) -> Vector:
        """Real eigenvalues of H, ascending, 1/s2."""
        if self.is_symmetric:
            return np.linalg.eigvalsh(0.5 * (self.H + self.H.T))
        values = np.linalg.eigvals(self.H)
        return np.sort(values.real[values.imag == 0.0])

    @cached_property
    def negative(self) -> int:
        """Number of negative stiffnesses."""
        return int((self.stiffnesses < 0.0).sum())

    def signed(self, number: int) -> float:
        """Return a stiffness by its number; without a potential, the smallest, in the sign of the determinant."""
        if self.is_symmetric:
            return float(self.stiffnesses[number])
        return float((-1) ** self.negative * np.abs(np.linalg.eigvals(self.H)).min())

    @cached_property
    def unstable(self) -> int:
        """Number of growing motions: of negative stiffnesses, or, without a potential, of growing eigenvalues."""
        if self.is_symmetric:
            return self.negative
        n, none = len(self.H), np.zeros_like(self.H)
        damping = -self._weight @ self.small.along_speeds.ddu[self.small.speeds.leading] @ self._reduced[1].T
        values = np.linalg.eigvals(np.block([[none, np.eye(n)], [-self.H, -damping]]))
        most = np.abs(values).max(initial=0.0)
        return int((values.real > np.maximum(GROWS * np.abs(values), ROUNDED * most)).sum())

    def softest(self, count: int) -> Matrix:
        """Return the tangents of the motions whose stiffness is smallest, (free, count)."""
        if self.is_symmetric:
            values, vectors = np.linalg.eigh(0.5 * (self.H + self.H.T))
            return np.asarray(self.along @ vectors[:, np.abs(values).argsort()[:count]])
        values, vectors = np.linalg.eig(self.H)
        return np.asarray(self.along @ vectors[:, np.abs(values).argsort()[:count]].real)
