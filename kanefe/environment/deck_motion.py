"""The motion of a deck: a point of a ship in a sea, which drives a free joint."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe.environment.harmonics import Harmonics, Ramp
from kanefe.frames import Matrix, Vector
from kanefe.joints.given_pose import GivenPose, PoseRates
from kanefe.joints.link import LinkKernel
from kanefe.joints.motion import Motion, clock
from kanefe.kernels.links.deck_motion import POWERS, deck_motion

LONGEST_PIECE = 1.0
"""Longest piece of the piecewise polynomials, s."""

LEFT_OUT = 1e-13
"""Error of the polynomials of a piece, relative to the sum of all amplitudes: pieces are halved until this is reached.
"""


@dataclass(frozen=True, eq=False)
class DeckMotion(GivenPose):
    """The pose of axes that are fixed to a ship, with exact velocities and accelerations, to drive a free joint.

    Returned by `kanefe.Ship.at`. Axes are x forward, y to port, z up; the reference frame is that of the ship at rest,
    with its origin at the mean position of the RAO's reference point, and moves with the ship's mean speed. Rotations
    are ``R = Rz(yaw) Ry(pitch) Rx(roll)`` of the sums, so that the deck is exactly a rigid body for large angles too,
    with consistent angular velocities and accelerations. Compiled code uses polynomials of degree 11 over pieces of a
    second at most, which are computed when a scene is frozen; `at` sums cosines.

    Attributes
    ----------
    harmonics : Harmonics
        Of the reference point.
    point : ndarray, shape (3,)
        From the reference point, m.
    ramp : Ramp
    span : (float, float)
        First and last time for which it is defined, s.
    is_small : bool
        Whether the point moves by linear theory, ``s + theta x point``, as in its RAO; the rotation of the axes is
        exact in either case.
    """

    harmonics: Harmonics
    point: Vector
    ramp: Ramp
    span: tuple[float, float]
    is_small: bool = False

    @property
    def moves(self) -> bool:
        return True

    @cached_property
    def clock(self) -> Motion:
        last = self.span[1]
        return clock(np.append(self.edges[self.edges < last], last))

    def check(self, where: str) -> None:
        """Do nothing: the rates are exact."""

    def at(self, t: float) -> PoseRates:
        """Return pose, velocities and accelerations at time t (s), by the sums of all harmonics.

        Raises
        ------
        ModelError
            If the time is outside of `span`.
        """
        return PoseRates(*(found[0] for found in self.over(np.array([t]))))

    def over(self, times: Vector) -> PoseRates:
        """Return the same at several times."""
        known = self.clock
        for t in (times.min(), times.max()) if len(times) else ():
            known.check_known(float(t), "the motion of a deck")
        motions = self.ramp.of(self.harmonics.at(times), times)
        (s, ds, dds), angles = motions[:, :, :3].swapaxes(0, 1), motions[:, :, 3:].swapaxes(0, 1)
        axes, w, dw = turned(*angles)
        if self.is_small:
            arm, rate, change = (np.cross(angle, self.point) for angle in angles)
        else:
            arm = axes @ self.point
            spin, twist = (np.einsum("tij,tj->ti", axes, item) for item in (w, dw))
            rate = np.cross(spin, arm)
            change = np.cross(twist, arm) + np.cross(spin, rate)
        place = s + arm + (self.point if self.is_small else 0.0)
        return PoseRates(place, ds + rate, dds + change, axes, w, dw)

    @cached_property
    def edges(self) -> Vector:
        """Starts of the pieces of compiled code, and the end of the last one, s."""
        first, last = self.span
        w = self.harmonics.frequencies
        size = np.sum(abs(self.harmonics.amplitudes), axis=1)
        length = LONGEST_PIECE
        while _left_out(w, size, 0.5 * length) > LEFT_OUT:
            length *= 0.5
        return first + length * np.arange(math.ceil((last - first) / length) + 1)

    @cached_property
    def pieces(self) -> np.ndarray:
        """Polynomials of degree 11 of motions, rates and accelerations of the reference point, (pieces, 18, 12).

        The variable runs from -1 to 1 in a piece. A harmonic is ``exp(i z x) = J0(z) + 2 sum i^k Jk(z) Tk(x)`` there
        (Jacobi & Anger), z half a piece times its frequency.
        """
        edges, w = self.edges, self.harmonics.frequencies
        half = 0.5 * (edges[1] - edges[0])
        real, imaginary = self.harmonics.with_rates
        of_waves = ((real + 1j * imaginary)[:, :, None] * _powers(w * half)[:, None, :]).reshape(len(w), -1)
        phases = np.multiply.outer(edges[:-1] + half, w)
        found = np.cos(phases) @ of_waves.real.copy() - np.sin(phases) @ of_waves.imag.copy()
        return found.reshape(-1, 18, POWERS)

    @cached_property
    def _kernel(self) -> LinkKernel:
        edges = self.edges
        head = (
            float(len(self.pieces)),
            edges[0],
            edges[1] - edges[0],
            *self.point,
            self.ramp.start,
            self.ramp.duration,
            float(self.is_small),
        )
        return LinkKernel(deck_motion, np.concatenate((head, self.pieces.ravel())), deck_motion)

    def kernel(self) -> LinkKernel:
        """Return the polynomials of compiled code."""
        return self._kernel


def turned(angles: Matrix, rates: Matrix, accelerations: Matrix) -> tuple[np.ndarray, Matrix, Matrix]:
    """Return ``R = Rz Ry Rx`` of roll, pitch and yaw, and angular velocity and acceleration in its own axes.

    Parameters
    ----------
    angles, rates, accelerations : ndarray, shape (3,) or (T, 3)
        Roll, pitch, yaw and their time derivatives, rad.
    """
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles).T, np.cos(angles).T
    dr, dp, dy = rates.T
    ddr, ddp, ddy = accelerations.T
    axes = np.array((
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    ))  # fmt: skip
    w = np.array((dr - dy * sp, dp * cr + dy * cp * sr, -dp * sr + dy * cp * cr))
    dw = np.array((
        ddr - ddy * sp - dy * dp * cp,
        ddp * cr - dp * dr * sr + ddy * cp * sr - dy * dp * sp * sr + dy * dr * cp * cr,
        -ddp * sr - dp * dr * cr + ddy * cp * cr - dy * dp * sp * cr - dy * dr * cp * sr,
    ))  # fmt: skip
    return axes if axes.ndim == 2 else axes.transpose(2, 0, 1), w.T, dw.T


def _left_out(frequencies: Vector, sizes: Vector, half: float) -> float:
    """Return an upper bound of the relative error of the accelerations of polynomials over a piece."""
    from scipy.special import jv

    z = abs(frequencies) * half
    # 2 |J12| and the remaining terms, which are less than half of it for z < 6
    bound = np.where(z < 6.0, 3.0 * abs(jv(POWERS, np.minimum(z, 6.0))), 2.0)
    weights = sizes * np.maximum(frequencies**2, 1e-300)
    return float(np.sum(bound * weights) / max(np.sum(weights), 1e-300))


def _powers(z: Vector) -> np.ndarray:
    """Return the coefficients of the powers 0 to 11 of x in ``exp(i z x)``, |x| <= 1, shape (n, 12)."""
    from scipy.special import jv

    orders = np.arange(POWERS)
    of_chebyshev = np.zeros((POWERS, POWERS))
    for k in orders:
        of_chebyshev[k, : k + 1] = np.polynomial.chebyshev.cheb2poly(np.eye(POWERS)[k, : k + 1])
    weights = np.where(orders == 0, 1.0, 2.0) * 1j**orders
    return np.asarray((jv(orders, z[:, None]) * weights) @ of_chebyshev)
