"""Bushings: springs and dampers in all six directions between two markers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.bodies.slopes import slope_measure
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, euler_parameters_from_matrix, rotation_vector

ROTATION_VECTOR = slope_measure("rotation-vector")


@dataclass(frozen=True, eq=False)
class Bushing:
    """A force and moment between two markers that hold b at a, in the axes of a.

    With d from the origin of a to that of b, and theta the rotation vector of b seen from a, b feels the force
    ``-(K_d d + C_d dd)`` at its origin and the moment ``-T(theta)^-T K_r theta - C_r w_ab``, where ``w_ab = T dtheta``:
    the springs have the potential ``1/2 d K_d d + 1/2 theta K_r theta``. a feels the same reversed, at the same point.

    Attributes
    ----------
    name : str
    a, b : Marker
    stiffness, damping : ndarray, shape (6,)
        Along x, y, z of a (N/m, N s/m) and about them (N m/rad, N m s/rad).
    function : callable or None
        Law of the user in place of the springs: (d and theta (6,), dd and w_ab (6,)) -> force and moment on b (6,).
    """

    name: str
    a: Marker
    b: Marker
    stiffness: np.ndarray
    damping: np.ndarray
    function: Callable[[Vector, Vector], Any] | None

    @property
    def exchanges_energy(self) -> bool:
        """Whether it takes energy from the scene or gives it."""
        return bool(self.damping.any() or self.function is not None)

    def wrench(self, t: float, A_ab: Matrix, d: Vector, rates: Vector) -> Vector:
        """Return force and moment on b about its origin, in the axes of a, shape (6,).

        Parameters
        ----------
        t : float
            s, for messages.
        A_ab : ndarray, shape (3, 3)
        d : ndarray, shape (3,)
            From a to b, m.
        rates : ndarray, shape (6,)
            Rate of d in a (m/s), and w_ab (rad/s).
        """
        theta = relative_rotation(A_ab)
        force = -self.stiffness[:3] * d
        moment = np.linalg.solve(ROTATION_VECTOR.tangent(theta).T, -self.stiffness[3:] * theta)
        return np.concatenate((force, moment)) - self.damping * rates + self.given(t, A_ab, d, rates)

    def given(self, t: float, A_ab: Matrix, d: Vector, rates: Vector) -> Vector:
        """Return the part of the wrench that the user's law gives, shape (6,)."""
        if self.function is None:
            return np.zeros(6)
        value = np.asarray(self.function(np.concatenate((d, relative_rotation(A_ab))), rates), dtype=float)
        if value.shape != (6,) or not np.all(np.isfinite(value)):
            raise ModelError(
                f"the law of bushing {self.name!r} must give six finite numbers; at t = {t:.6g} s it gave {value!r}"
            )
        return value

    def potential(self, A_ab: Matrix, d: Vector) -> float:
        """Return the energy of the springs, J."""
        displacement = np.concatenate((d, relative_rotation(A_ab)))
        return float(0.5 * displacement @ (self.stiffness * displacement))

    def dissipation(self, rates: Vector) -> float:
        """Return the power that the dampers take, W."""
        return float(rates @ (self.damping * rates))


def relative_rotation(A_ab: Matrix) -> Vector:
    """Return the rotation vector of b seen from a, shape (3,), rad; it jumps at half a turn."""
    return rotation_vector(euler_parameters_from_matrix(A_ab))
