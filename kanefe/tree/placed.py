"""Position and motion of a frame, without partial velocities: for views, loads and functions of the user."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.slopes import SlopeMeasure
from kanefe.frames import Matrix, Vector, cross
from kanefe.loads.action import End

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


@dataclass(slots=True)
class Placed:
    """Motion of a frame F seen from N.

    Attributes
    ----------
    A_NF : ndarray, shape (3, 3)
    p_NoFo_N : ndarray, shape (3,)
        Position in N, m.
    v, w : ndarray, shape (3,)
        Velocity of the origin (m/s) and angular velocity (rad/s), in components of F.
    """

    A_NF: Matrix
    p_NoFo_N: Vector
    v: Vector
    w: Vector

    @property
    def end(self) -> End:
        """Return this motion in components of N."""
        A = self.A_NF
        return End(self.p_NoFo_N, A, A @ self.v, A @ self.w)


INERTIAL = Placed(np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3))
"""The inertial frame N."""


def fixed_in(F: Placed, p: Vector, A: Matrix) -> Placed:
    """Return the motion of a frame fixed in F at p with orientation A_FM."""
    return Placed(F.A_NF @ A, F.p_NoFo_N + F.A_NF @ p, A.T @ (F.v + cross(F.w, p)), A.T @ F.w)


def moving_in(F: Placed, p: Vector, A: Matrix, v: Vector, w: Vector) -> Placed:
    """Return the motion of a frame at p with orientation A_FM that moves with v and w seen from F, in components of F.

    The velocities of Eq. 13 and 14, differentiated from ``p_NoMo_N = p_NoFo_N + A_NF p`` (Eq. 3).
    """
    At = A.T
    return Placed(F.A_NF @ A, F.p_NoFo_N + F.A_NF @ p, At @ (F.v + cross(F.w, p) + v), At @ (F.w + w))


def interface_placed(G: Placed, frame: InterfaceFrame, eta: Vector, deta: Vector, slopes: SlopeMeasure) -> Placed:
    """Return the motion of an interface frame n of a flexible body (Eq. 22, 24, 25)."""
    inner = frame.inner_motion(eta, deta, slopes)
    return moving_in(G, inner.p, inner.A, inner.v, inner.w)
