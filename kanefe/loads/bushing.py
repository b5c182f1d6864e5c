"""Bushings: springs and dampers in all six directions between two markers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.bodies.slopes import slope_measure
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, cross, euler_parameters_from_matrix, rotation_vector, skew
from kanefe.loads.base import Action, End, Load, LoadKernel, Tangent

ROTATION_VECTOR = slope_measure("rotation-vector")

ROUND_OFF = 1e-12
"""Eigenvalue of a damping matrix, of its largest entry, that is none."""


class Offset(NamedTuple):
    """Where b is seen from a, in a's axes: d (3,) and the rotation vector (3,), m and rad, and their rates (6,)."""

    d: Vector
    theta: Vector
    rates: Vector


@dataclass(frozen=True, eq=False)
class Bushing(Load):
    """A force and moment between two markers that hold b at a, in the axes of a.

    With x = (d, theta), d from the origin of a to that of b and theta the rotation vector of b seen from a, and their
    rates (dd, w_ab), where ``w_ab = T(theta) dtheta``, b feels at its origin

        (force, T^T moment) = -K x,    and    (force, moment) = -C (dd, w_ab)

    The symmetric part of K has the potential ``1/2 x K x``; what its skew part does, as the cross-coupled stiffness of
    a journal bearing, is work of loads. a feels the same reversed, at the same point.

    Attributes
    ----------
    name : str
    ends : (Marker, Marker)
        a and b.
    stiffness, damping : ndarray, shape (6, 6)
        K and C along x, y, z of a and about them: N/m, N/rad, N m/m, N m/rad; N s/m and so on.
    function : callable or None
        Law of the user in place of the springs: (d and theta (6,), dd and w_ab (6,)) -> force and moment on b (6,).
    """

    name: str
    ends: tuple[Marker, ...]
    stiffness: np.ndarray
    damping: np.ndarray
    function: Callable[[Vector, Vector], Any] | None

    kind = "bushing"
    columns = (
        *(f"offset {c} [m]" for c in "xyz"),
        *(f"rotation {c} [rad]" for c in "xyz"),
        *(f"force {c} [N]" for c in "xyz"),
        *(f"moment {c} [N m]" for c in "xyz"),
    )

    @property
    def exchanges_energy(self) -> bool:
        """Whether it takes energy from the scene or gives it."""
        return bool(self.damping.any() or self._circulates or self.function is not None)

    @property
    def _circulates(self) -> bool:
        return bool((self.stiffness != self.stiffness.T).any())

    def offset(self, ends: Sequence[End]) -> Offset:
        """Return where b is seen from a, and how it moves: rate of d in a (m/s), and w_ab (rad/s)."""
        a, b = ends
        line = b.p - a.p
        rates = np.concatenate((a.A.T @ (b.v - a.v - cross(a.w, line)), a.A.T @ (b.w - a.w)))
        return Offset(a.A.T @ line, relative_rotation(a.A.T @ b.A), rates)

    def wrench(self, t: float, offset: Offset) -> tuple[Vector, Vector]:
        """Return force and moment on b about its origin, in the axes of a, and what of it gives work, (6,) each."""
        x = np.concatenate((offset.d, offset.theta))
        skew_part = 0.5 * (self.stiffness - self.stiffness.T)
        given = self.given(t, offset)
        wrench = given - _on_axes(offset.theta, self.stiffness @ x) - self.damping @ offset.rates
        return wrench, given - _on_axes(offset.theta, skew_part @ x)

    def given(self, t: float, offset: Offset) -> Vector:
        """Return the part of the wrench that the user's law gives, shape (6,)."""
        if self.function is None:
            return np.zeros(6)
        value = np.asarray(self.function(np.concatenate((offset.d, offset.theta)), offset.rates), dtype=float)
        if value.shape != (6,) or not np.all(np.isfinite(value)):
            raise ModelError(
                f"the law of bushing {self.name!r} must give six finite numbers; at t = {t:.6g} s it gave {value!r}"
            )
        return value

    def action(self, t: float, ends: Sequence[End], states: Vector) -> Action:
        """Return what it exerts on a and b (Eq. 11); the work of a law counts as given."""
        offset = self.offset(ends)
        wrench, given = self.wrench(t, offset)
        displacement = np.concatenate((offset.d, offset.theta))
        return Action(
            on_both(ends, wrench),
            potential=float(0.5 * displacement @ self.stiffness @ displacement),
            taken=float(offset.rates @ self.damping @ offset.rates),
            given=float(given @ offset.rates),
        )

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent:
        """Return stiffness and damping along their principal directions.

        Without what turning the axes does under load, and without the skew parts.
        """
        return principal_tangent(relative_rows(*ends), self.stiffness, self.damping)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return offset (m, rad), and force and moment on b (N, N m), in the axes of a."""
        offset = self.offset(ends)
        return np.concatenate((offset.d, offset.theta, self.wrench(t, offset)[0]))

    @property
    def kernel(self) -> LoadKernel:
        """Numbers: stiffness and damping row by row, inputs (0 or 6)."""
        from kanefe.kernels.force_elements.bushing import bushing

        constants = (self.stiffness.ravel(), self.damping.ravel(), (float(self.input_count),))
        return LoadKernel(bushing, np.concatenate(constants), bushing)

    @property
    def input_count(self) -> int:
        """Six for a law of the user's."""
        return 0 if self.function is None else 6

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return what the user's law gives, in the axes of a."""
        return self.given(t, self.offset(ends))

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return what one newton and one newton metre along and about each axis of a do."""
        return np.array([on_both(ends, unit) for unit in np.eye(6)])


def relative_rotation(A_ab: Matrix) -> Vector:
    """Return the rotation vector of b seen from a, shape (3,), rad; it jumps at half a turn."""
    return rotation_vector(euler_parameters_from_matrix(A_ab))


def _on_axes(theta: Vector, forces: Vector) -> Vector:
    """Return force and moment of forces over d and the rotation vector, (6,)."""
    return np.append(forces[:3], np.linalg.solve(ROTATION_VECTOR.tangent(theta).T, forces[3:]))


def relative_rows(a: End, b: End) -> Matrix:
    """Return the rates of b seen from a, in the axes of a, over velocity and angular velocity of both in N, (6, 12)."""
    back, none = a.A.T, np.zeros((3, 3))
    of_d = np.hstack((-back, back @ skew(b.p - a.p), back, none))
    return np.vstack((of_d, np.hstack((none, -back, none, back))))


def check_damps(damping: np.ndarray, label: str) -> None:
    """Raise a ModelError if damping matrices, (..., n, n), drive a motion."""
    even = damping + np.swapaxes(damping, -1, -2)
    if np.linalg.eigvalsh(even).min() < -ROUND_OFF * np.abs(even).max():
        raise ModelError(f"damping of {label} drives: its symmetric part has negative eigenvalues. Remedy: signs")


def principal_tangent(rows: Matrix, stiffness: Matrix, damping: Matrix) -> Tangent:
    """Return the symmetric parts of stiffness and damping matrices over some relative rates as springs and dampers."""
    if not np.any(stiffness - np.diag(np.diag(stiffness))) and not np.any(damping - np.diag(np.diag(damping))):
        return Tangent(rows, np.diag(stiffness), np.diag(damping))
    (k, along_k), (c, along_c) = (np.linalg.eigh(0.5 * (matrix + matrix.T)) for matrix in (stiffness, damping))
    none = np.zeros(len(rows))
    return Tangent(np.vstack((along_k.T @ rows, along_c.T @ rows)), np.append(k, none), np.append(none, c))


def on_both(ends: Sequence[End], wrench: Vector) -> Matrix:
    """Return a wrench on b about its origin, in the axes of a, as those on a and b in N: reversed on a at one point."""
    a, b = ends
    force, moment = a.A @ wrench[:3], a.A @ wrench[3:]
    on_a = np.append(-force, -(moment + cross(b.p - a.p, force)))
    return np.array((on_a, np.append(force, moment)))
