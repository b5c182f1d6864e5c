"""A scene at rest under its raised loads: balance, its derivatives, and the metric of its arc length.

    f(p, factor) = 0,    H = -df/dp,    g = df/dfactor

f are the accelerations along the independent coordinates p, as forces in coordinates of unit mass; H is the tangent
stiffness there, with all that loads add to it: it is not symmetric under follower loads. Lengths along a path are in
rad or scene lengths, and the factor counts in shares of the given range, so that no coordinate has to be singled out.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.linear.equilibrium.balance import closed
from kanefe.linear.equilibrium.stiffness import stiffness_of
from kanefe.linear.paths.spectrum import MotionSpectrum
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.stability.raised_loads import scaled_model
from kanefe.linear.tangents import large_tangents

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

SYMMETRIC = 1e-7
"""Asymmetry of the scaled stiffness, relative to one, that is round-off."""


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
        return np.asarray(1.0 / large_tangents(self.model))

    def model_at(self, factor: float) -> Model:
        """Return the model under a factor of the loads."""
        return scaled_model(self.model, self.t, self.raised, factor)

    @cached_property
    def _bounds(self) -> tuple[Model, Model]:
        """The models without the raised loads, and under `span` of them."""
        return self.model_at(0.0), self.model_at(self.span)

    def accelerations(self, q: Vector) -> tuple[Vector, Vector]:
        """Return the accelerations at rest without the raised loads, and what `span` of them adds: they are linear."""
        without, under = (
            model.parts(model.rhs(self.t, np.concatenate((q, np.zeros(model.free_count), model.initial_states))))[1]
            for model in self._bounds
        )
        return without, under - without

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


class BorderedStiffness:
    """The equations ``H x - g dfactor = forces`` of a change whose length along a direction is given, scaled.

    Parameters
    ----------
    A : ndarray, shape (n + 1, n + 1)
        Over x and dfactor / span; last the row of the direction.
    along : ndarray, shape (free, n)
        Free tangents of x.
    span : float
        Unit of the factor.
    """

    def __init__(self, A: Matrix, along: Matrix, span: float) -> None:
        self._along, self._span = along, span
        size = np.abs(A).max(axis=1)
        self._rows = 1.0 / np.where(size > 0.0, size, 1.0)
        size = np.abs(A * self._rows[:, None]).max(axis=0)
        self._columns = 1.0 / np.where(size > 0.0, size, 1.0)
        self._A = A * self._rows[:, None] * self._columns

    def solved(self, forces: Vector, length: float) -> Tangent:
        """Return the change for some forces and a length."""
        right = self._rows * np.append(forces, length)
        try:
            x = np.linalg.solve(self._A, right)
        except np.linalg.LinAlgError:  # a branch point to the last digit: of the changes there, the least
            x = np.linalg.lstsq(self._A, right, rcond=None)[0]
        return self._change(x)

    def _change(self, x: Vector) -> Tangent:
        x = self._columns * x
        return Tangent(self._along @ x[:-1], float(self._span * x[-1]))

    def corrections(self) -> Generator[Tangent, Vector, None]:
        """Yield the corrections across the direction for the forces that are sent, by Broyden's method.

        The stiffness is that of the first forces, improved by what the forces of each correction tell of it
        (Broyden, Math. Comput. 19 (1965) 577-593; kept as products: Kelley, Solving Nonlinear Equations with Newton's
        Method, 2003, chapter 4). A LinAlgError: it is singular.
        """
        inverse = np.linalg.inv(self._A)
        forces = yield Tangent(np.zeros(len(self._along)), 0.0)
        steps: list[Vector] = []
        while True:
            x = inverse @ (self._rows * np.append(forces, 0.0))
            for before, after in pairwise(steps):
                x = x + after * (before @ x) / (before @ before)
            if steps:
                x = x / max(0.5, 1.0 - float(steps[-1] @ x) / float(steps[-1] @ steps[-1]))
            steps.append(x)
            forces = yield self._change(x)


HEAVY = ("small", "_reduced", "along", "forces", "load", "stiffnesses", "spectrum")


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
        """Keep what a path lists of its points, and forget matrices."""
        _ = self.unstable, self.is_symmetric
        self.forget()

    def forget(self) -> None:
        """Forget matrices, which are computed again if they are wanted."""
        for name in HEAVY:
            self.__dict__.pop(name, None)

    @cached_property
    def load(self) -> Vector:
        """g, the forces per unit of the factor."""
        added = self.scene.accelerations(self.q)[1]
        return np.asarray(self._weight @ added[self.small.speeds.leading] / self.scene.span)

    def forces_beside(self, q: Vector, factor: float) -> Vector:
        """Return the forces at other coordinates and another factor, by the masses here: they vanish where they do."""
        without, added = self.scene.accelerations(q)
        du = without + factor / self.scene.span * added
        return np.asarray(self._weight @ du[self.small.speeds.leading])

    def bordered(self, row: Tangent) -> BorderedStiffness:
        """Return the equations of a change: see `BorderedStiffness`."""
        w, n, span = self.scene.weights, len(self.H), self.scene.span
        A = np.zeros((n + 1, n + 1))
        A[:n, :n], A[:n, n] = self.H, -span * self.load
        A[n, :n], A[n, n] = (w * w * row.z) @ self.along, row.factor / span
        return BorderedStiffness(A, self.along, span)

    def solved(self, forces: Vector, row: Tangent, length: float) -> Tangent:
        """Return the change for which ``H x - g dfactor = forces`` and that along `row` is a length (Keller, 1977)."""
        return self.bordered(row).solved(forces, length)

    def tangent(self, ahead: Tangent) -> Tangent:
        """Return the unit tangent of the path, in the sense of a direction."""
        return self.scene.unit(self.solved(np.zeros(len(self.H)), ahead, 1.0))

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether the loads have a potential, as far as the stiffness shows."""
        size = np.sqrt(np.abs(self.H).max(axis=0, initial=0.0))
        size[size == 0.0] = 1.0
        scaled = (self.H - self.H.T) / np.outer(size, size)
        return bool(np.abs(scaled).max(initial=0.0) <= SYMMETRIC)

    @cached_property
    def stiffnesses(self) -> Vector:
        """Eigenvalues of the symmetric part of H, ascending, 1/s2."""
        return np.asarray(np.linalg.eigvalsh(0.5 * (self.H + self.H.T)))

    @cached_property
    def negative(self) -> int:
        """Number of negative stiffnesses."""
        return int((self.stiffnesses < 0.0).sum())

    @cached_property
    def unstable(self) -> int:
        """Number of growing motions: of negative stiffnesses, or, without a potential, of growing eigenvalues."""
        if self.is_symmetric:
            return self.negative
        return self.spectrum.unstable

    @cached_property
    def spectrum(self) -> MotionSpectrum:
        """The small motions."""
        if not self._is_damped:
            return MotionSpectrum(self.H, None, self.along)
        by_speed = self.small.along_speeds.ddu[self.small.speeds.leading]
        return MotionSpectrum(self.H, -self._weight @ by_speed @ self._reduced[1].T, self.along)

    @cached_property
    def _is_damped(self) -> bool:
        """Whether anything depends on speeds: a random one shows it."""
        N = self.small.speeds.N
        du = N @ np.random.default_rng(0).standard_normal((N.shape[1], 1))
        return bool(self.small.accelerations(np.zeros_like(du), du, np.zeros_like(du)).any())

    def softest(self, count: int) -> Matrix:
        """Return the tangents of the motions whose stiffness is smallest, (free, count)."""
        if self.is_symmetric:
            values, vectors = np.linalg.eigh(0.5 * (self.H + self.H.T))
            return np.asarray(self.along @ vectors[:, np.abs(values).argsort()[:count]])
        values, vectors = np.linalg.eig(self.H)
        return np.asarray(self.along @ vectors[:, np.abs(values).argsort()[:count]].real)
