"""Poses through the points of a table, with continuous accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, multiply, numbers, orientation_parameters
from kanefe.joints.given_pose import GivenPose, PoseRates
from kanefe.joints.link import LinkKernel, motion_by
from kanefe.joints.motion import LEAST_POINTS, Motion, check_between, check_increasing, clock
from kanefe.joints.quintic import quintic_pieces
from kanefe.kernels.links.pose_table import pose_table

LEAST_COSINE = 0.7
"""Smallest cosine of half the angle between two points of a table: Euler parameters between them do not vanish, and the
direction of rotation is unambiguous."""

CONTRADICTION = 0.5
"""Largest root-mean-square deviation of given rates from a spline through the values, relative to the rates: rates in
degrees, in another frame or with another sign exceed it."""


@dataclass(frozen=True, eq=False)
class PoseTable(GivenPose):
    """The pose of a frame through the points of a table, also of measured records with their own rates.

    Positions and Euler parameters are piecewise polynomials with continuous second derivatives, and the rotation is
    that of the normalised parameters; velocities and accelerations are its exact derivatives. Without velocities the
    polynomials are cubic splines (not-a-knot); the error of poses is then of the fourth power of the distance of the
    points, that of accelerations of the second. With velocities, polynomials of the fifth degree have the given values
    and rates at every point, and accelerations there are those of the spline through the velocities (third power) or
    the given ones (fourth). Runs stay in compiled code. Outside the table the pose is not defined, and evaluating it is
    an error.

    Parameters
    ----------
    times : array_like, shape (n,)
        Increasing, at least four, s; two with accelerations.
    positions : array_like, shape (n, 3), optional
        Components of the joint's fixed frame F, m. None: no translation.
    orientations : array_like, shape (n, 4) or (n, 3, 3), or Rotation of scipy, optional
        Euler parameters, scalar first, of any length and sign, or matrices A_FM. None: no rotation.
    velocities, accelerations : array_like, shape (n, 3), optional
        Rates of the positions, m/s, m/s2; accelerations only with velocities.
    angular_velocities, angular_accelerations : array_like, shape (n, 3), optional
        In components of the moving frame M, as measured by gyroscopes, rad/s, rad/s2.

    Attributes
    ----------
    pieces : ndarray, shape (n - 1, 7, 6)
        Coefficients of each piece in the powers 0 to 5 of the time since its start, of position and Euler parameters.

    Raises
    ------
    ModelError
        If the times do not increase or are too few, a shape differs, a number is not finite, Euler parameters are zero,
        the frame rotates by more than a right angle between two points, or rates contradict their values.

    Examples
    --------
    >>> import numpy as np
    >>> import kanefe as kf
    >>> times = np.linspace(0.0, 10.0, 101)
    >>> turns = [kf.rotation_about("x", 0.1 * np.sin(t)) for t in times]
    >>> deck = kf.PoseTable(times, np.outer(np.sin(times), (0.0, 0.0, 1.0)), turns)
    >>> bool(abs(deck.at(5.0).velocity[2] - np.cos(5.0)) < 1e-5)
    True
    >>> joint = kf.Free(motion=deck)
    """

    times: Any
    positions: Any = None
    orientations: Any = None
    velocities: Any = field(default=None, kw_only=True, repr=False)
    accelerations: Any = field(default=None, kw_only=True, repr=False)
    angular_velocities: Any = field(default=None, kw_only=True, repr=False)
    angular_accelerations: Any = field(default=None, kw_only=True, repr=False)
    pieces: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.positions is None and self.orientations is None:
            raise ModelError("a PoseTable needs positions or orientations; neither is given")
        t = _checked_times(self.times)
        for rates, values in (
            ("velocities", "positions"),
            ("accelerations", "velocities"),
            ("angular_velocities", "orientations"),
            ("angular_accelerations", "angular_velocities"),
        ):
            if getattr(self, rates) is not None and getattr(self, values) is None:
                raise ModelError(f"a PoseTable with {rates} needs {values} too")
        zero = np.zeros((len(t), 3))
        p, dp, ddp = (self._rows(name, t) for name in ("positions", "velocities", "accelerations"))
        e = self._parameters(t)
        w, dw = (self._rows(name, t) for name in ("angular_velocities", "angular_accelerations"))
        if e is None:
            e, w, dw = np.tile((1.0, 0.0, 0.0, 0.0), (len(t), 1)), zero, zero
        if p is None:
            p, dp, ddp = zero, zero, zero
        de = None if w is None else 0.5 * multiply(e, _pure(w))
        dde = None if de is None or w is None or dw is None else 0.5 * (multiply(de, _pure(w)) + multiply(e, _pure(dw)))
        pieces = np.concatenate(
            (_pieces(t, p, dp, ddp, "velocities"), _pieces(t, e, de, dde, "angular_velocities")), axis=2
        )
        object.__setattr__(self, "times", t)
        object.__setattr__(self, "pieces", np.ascontiguousarray(pieces[::-1].transpose(1, 2, 0)))

    @property
    def moves(self) -> bool:
        return self.positions is not None

    @property
    def clock(self) -> Motion:
        return clock(self.times)

    def at(self, t: float) -> PoseRates:
        p, A, V, W, dV, dW = motion_by(pose_table, self._constants, t)
        return PoseRates(p, V, dV, A, W @ A, dW @ A)

    def check(self, where: str) -> None:
        """Do nothing: a table is checked when it is made."""

    def kernel(self) -> LinkKernel:
        return LinkKernel(pose_table, self._constants, pose_table)

    @cached_property
    def _constants(self) -> Vector:
        return np.concatenate(((len(self.pieces),), self.times, self.pieces.ravel()))

    def _rows(self, name: str, t: Vector) -> Matrix | None:
        given = getattr(self, name)
        if given is None:
            return None
        rows = numbers(given)
        if rows.shape != (len(t), 3) or not np.all(np.isfinite(rows)):
            raise ModelError(
                f"{name} of a PoseTable with {len(t)} times must be finite numbers of shape ({len(t)}, 3); shape "
                f"{rows.shape} was given, or a number is not finite"
            )
        return rows

    def _parameters(self, t: Vector) -> Matrix | None:
        """Return Euler parameters of unit length, (n, 4), with signs for the shortest rotation between points."""
        if self.orientations is None:
            return None
        given = self.orientations.as_matrix() if hasattr(self.orientations, "as_matrix") else self.orientations
        rows = numbers(given)
        if rows.shape not in ((len(t), 4), (len(t), 3, 3)):
            raise ModelError(
                f"orientations of a PoseTable with {len(t)} times must be Euler parameters ({len(t)}, 4) or matrices "
                f"({len(t)}, 3, 3); shape {rows.shape} was given"
            )
        e = np.array([orientation_parameters(row, f"orientation {i} of a PoseTable") for i, row in enumerate(rows)])
        cosines = np.sum(e[1:] * e[:-1], axis=1)
        if (worst := int(np.argmin(abs(cosines)))) >= 0 and abs(cosines[worst]) < LEAST_COSINE:
            angle = np.degrees(2.0 * np.arccos(abs(cosines[worst])))
            raise ModelError(
                f"a PoseTable turns by {angle:.3g} degrees from {t[worst]:.6g} to {t[worst + 1]:.6g} s: the way "
                "between is not known. Remedy: more points, a right angle apart at most"
            )
        e[1:] *= np.cumprod(np.where(cosines < 0.0, -1.0, 1.0))[:, None]
        return np.asarray(e)


def _checked_times(given: Sequence[float] | np.ndarray) -> Vector:
    t = numbers(given)
    if t.ndim != 1 or len(t) < 2 or not np.all(np.isfinite(t)):
        raise ModelError(f"the times of a PoseTable must be finite numbers of shape (n,), not of shape {t.shape}")
    check_increasing(t, "the times of a PoseTable")
    return t


def _pure(w: Matrix) -> Matrix:
    return np.column_stack((np.zeros(len(w)), w))


def _pieces(t: Vector, y: Matrix, dy: Matrix | None, ddy: Matrix | None, rates: str) -> np.ndarray:
    """Return the powers 5 to 0 of the pieces through values and given derivatives, (6, n - 1, columns)."""
    from scipy.interpolate import CubicSpline

    if ddy is None and len(t) < LEAST_POINTS:
        raise ModelError(
            f"a PoseTable of {len(t)} times has too few for a spline, which needs {LEAST_POINTS}. Remedy: more times, "
            "or velocities and accelerations"
        )
    if dy is None:
        spline = CubicSpline(t, y, bc_type="not-a-knot")
        check_between(spline, y, "a PoseTable")
        cubic = np.asarray(spline.c)
        return np.concatenate((np.zeros((2, *cubic.shape[1:])), cubic))
    if len(t) >= LEAST_POINTS:
        found = CubicSpline(t, y, bc_type="not-a-knot")(t, 1)
        wrong, size = np.linalg.norm(found - dy), max(np.linalg.norm(found), np.linalg.norm(dy))
        if wrong > CONTRADICTION * size and wrong > 1e-9 * np.linalg.norm(y) / np.diff(t).min():
            raise ModelError(
                f"the {rates} of a PoseTable are not those of its values: a spline through these changes at rates that "
                f"differ by {100 * wrong / size:.3g} %. Remedy: rad/s in components of the moving frame, m/s in those "
                "of the fixed one; more points; or leave them out"
            )
    if ddy is None:
        ddy = CubicSpline(t, dy, bc_type="not-a-knot")(t, 1)
    return quintic_pieces(np.diff(t)[:, None], y, np.diff(y, axis=0), dy, ddy)
