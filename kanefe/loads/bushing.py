"""Bushings: springs and dampers in all six directions between two markers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, cross, skew
from kanefe.kernels.force_elements.bushing import BushingNumbers, bushing, in_blocks, seen_from_a
from kanefe.kernels.values.filled import filled
from kanefe.loads.action import End, LoadKernel, Tangent
from kanefe.loads.base import Load
from kanefe.loads.by_kernel import numbers_of

ROUND_OFF = 1e-12
"""Eigenvalue of a damping matrix, relative to its largest entry, that counts as zero."""


@dataclass(frozen=True, eq=False)
class Bushing(Load):
    """A force and moment between two markers that hold b at a, in the axes of a.

    With x = (d, theta), d from the origin of a to that of b and theta the rotation vector of b seen from a, and their
    rates (dd, w_ab), where ``w_ab = T(theta) dtheta``, b feels at its origin

        (force, T^T moment) = -K x,    and    (force, moment) = -C (dd, w_ab)

    The symmetric part of K has the potential ``1/2 x K x``; the work of its skew part, such as the cross-coupled
    stiffness of a journal bearing, counts as work of loads. The opposite wrench acts on a, at the same point.

    Attributes
    ----------
    name : str
    ends : (Marker, Marker)
        a and b.
    stiffness, damping : ndarray, shape (6, 6)
        K and C along x, y, z of a and about them: N/m, N/rad, N m/m, N m/rad; N s/m and so on.
    function : callable or None
        Law of the user instead of the springs: (d and theta (6,), dd and w_ab (6,)) -> force and moment on b (6,).
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
        """Whether it dissipates or supplies energy."""
        circulates = bool((self.stiffness != self.stiffness.T).any())
        return bool(self.damping.any() or circulates or self.function is not None)

    @property
    def turns_by_half_at_most(self) -> bool:
        """Whether its springs resist rotation: the rotation vector jumps at half a turn."""
        return bool(self.stiffness[3:].any() or self.stiffness[:, 3:].any())

    def offset(self, ends: Sequence[End]) -> tuple[Vector, Vector]:
        """Return position and rotation vector of b seen from a, (6,), m and rad, and (dd, w_ab), (6,), in axes of a."""
        d, theta, rate, spin = seen_from_a(numbers_of(ends))
        return np.array((*d, *theta)), np.array((*rate, *spin))

    def tangent(self, t: float, ends: Sequence[End], states: Vector) -> Tangent:
        """Return stiffness and damping along their principal directions.

        Without the geometric stiffness of rotation under load, and without the skew parts.
        """
        return principal_tangent(relative_rows(*ends), self.stiffness, self.damping)

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return offset (m, rad), and force and moment on b (N, N m), in the axes of a."""
        on_b = self.action(t, ends, states).wrenches[1]
        return np.concatenate((self.offset(ends)[0], on_b[:3] @ ends[0].A, on_b[3:] @ ends[0].A))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        K, C = in_blocks(self.stiffness), in_blocks(self.damping)
        return LoadKernel(bushing, filled(BushingNumbers, stiffness=K, damping=C, inputs=self.input_count), bushing)

    @property
    def input_count(self) -> int:
        """Six with a law of the user, else none."""
        return 0 if self.function is None else 6

    def inputs(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return force and moment by the user's law, in the axes of a."""
        if self.function is None:
            return np.zeros(0)
        value = np.asarray(self.function(*self.offset(ends)), dtype=float)
        if value.shape != (6,) or not np.all(np.isfinite(value)):
            raise ModelError(
                f"the law of bushing {self.name!r} must give six finite numbers; at t = {t:.6g} s it gave {value!r}"
            )
        return value

    def input_wrenches(self, t: float, ends: Sequence[End]) -> np.ndarray:
        """Return the wrenches of one newton along and one newton metre about each axis of a."""
        return np.array([on_both(ends, unit) for unit in np.eye(6)])


def relative_rows(a: End, b: End) -> Matrix:
    """Return the matrix of b's rates seen from a, in axes of a, over the velocities of both in N, (6, 12)."""
    back, none = a.A.T, np.zeros((3, 3))
    of_d = np.hstack((-back, back @ skew(b.p - a.p), back, none))
    return np.vstack((of_d, np.hstack((none, -back, none, back))))


def check_damps(damping: np.ndarray, label: str) -> None:
    """Raise a ModelError if damping matrices, (..., n, n), supply energy."""
    even = damping + np.swapaxes(damping, -1, -2)
    if np.linalg.eigvalsh(even).min() < -ROUND_OFF * np.abs(even).max():
        raise ModelError(f"damping of {label} drives: its symmetric part has negative eigenvalues. Remedy: signs")


def principal_tangent(rows: Matrix, stiffness: Matrix, damping: Matrix) -> Tangent:
    """Return the symmetric parts of stiffness and damping over relative rates as independent springs and dampers."""
    if not np.any(stiffness - np.diag(np.diag(stiffness))) and not np.any(damping - np.diag(np.diag(damping))):
        return Tangent(rows, np.diag(stiffness), np.diag(damping))
    (k, along_k), (c, along_c) = (np.linalg.eigh(0.5 * (matrix + matrix.T)) for matrix in (stiffness, damping))
    none = np.zeros(len(rows))
    return Tangent(np.vstack((along_k.T @ rows, along_c.T @ rows)), np.append(k, none), np.append(none, c))


def on_both(ends: Sequence[End], wrench: Vector) -> Matrix:
    """Return the wrenches on a and b in N from that on b in the axes of a; the one on a is opposite, at one point."""
    a, b = ends
    force, moment = a.A @ wrench[:3], a.A @ wrench[3:]
    on_a = np.append(-force, -(moment + cross(b.p - a.p, force)))
    return np.array((on_a, np.append(force, moment)))
