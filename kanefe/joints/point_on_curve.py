"""A point that slides on a curve through given points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import factorial
from typing import Any, ClassVar

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, cross, numbers
from kanefe.joints.base import OneCoordinateJoint, axis_direction
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.link import Link, LinkKernel, LinkMotion, motion_by
from kanefe.joints.motion import Motion
from kanefe.joints.quintic import quintic_pieces, quintic_spline
from kanefe.joints.start import Start
from kanefe.kernels.links.curve import curve

ORDER = 12
"""Order of the Gauss quadrature on each piece of the spline: exact to round-off if pieces are accurate to ARC_LENGTH.
"""

ARC_LENGTH = 1e-12
"""Largest deviation of the length of the tangent from 1, dimensionless."""

MOST_PIECES = 20_000
"""Number at which pieces are no longer halved: points this noisy have no smooth curve."""

ALIKE = 1e-9
"""Distance relative to the largest distance of the points below which two points are the same."""

LEAST_RATE = 1e-3
"""Smallest ratio of the rates of arc length and chord length along the spline, normally about 1: below it the spline
has a cusp."""

ALONG_Z = 0.99
"""Cosine of the angle between the start of a curve and z of F above which z does not define a direction across."""

LEAST_ACROSS = 1e-2
"""Sine of the smallest angle between the curve and the up direction; near it the frame turns fast."""


@dataclass(frozen=True, eq=False)
class PointOnCurve(OneCoordinateJoint):
    """A point that slides on a curve through given points, fixed in the parent.

    The curve is the spline of order 5 through the points over their chord lengths, as a function of its arc length:
    quintic, so that the derivative of its curvature, which appears in the accelerations of a frame along it, is
    continuous; an open curve through less than six points is a single polynomial. The coordinate is the arc length s
    from the first point in m, the speed its rate in m/s. On a closed curve s increases from lap to lap; on an open one
    a run that reaches an end fails there with a message.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        In the joint's fixed frame F, m: at least two, or three of a closed curve, whose first is not repeated.
    closed : bool
        Whether the last point is followed by the first.
    turns : bool
        Whether the body rotates with the curve, x of its frame M along the tangent; else it stays parallel to F.
    up : "x", "y", "z" or three numbers, optional
        With `turns`: direction in F to which z of M is as near as possible, as for a rail vehicle. None: M does not
        spin about the tangent (rotation-minimising), and at the first point z is as near as possible to z of F, or to y
        if the curve starts along z. On a closed curve the rotation about the tangent that would remain after a lap is
        distributed over the lap.
    position, speed : float or Guess, optional
        Arc length (m) and its rate (m/s) at the start; without it zero, or it follows where a loop needs it.
    motion : Motion, optional
        Drives the coordinate, which then takes its start from it.
    forces : CoordinateForce, optional
        Spring, damper, friction and limits along the curve.

    Attributes
    ----------
    length : float
        Length of the whole curve, m.

    Raises
    ------
    ModelError
        If the points, the frame or the start are not valid; the message names which.

    Examples
    --------
    A bead in a round groove, given by 60 points:

    >>> angles = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
    >>> groove = np.column_stack((np.cos(angles), np.zeros(60), np.sin(angles)))
    >>> PointOnCurve(groove, closed=True).length.round(8)
    6.28318531
    """

    points: Any
    closed: bool = False
    turns: bool = False
    up: str | Sequence[float] | None = None
    position: Start = None
    speed: Start = None
    motion: Motion | None = None
    forces: CoordinateForce | None = None
    pieces: Any = field(init=False, repr=False)

    coordinate_names: ClassVar[tuple[str, ...]] = ("arc length [m]",)
    speed_names: ClassVar[tuple[str, ...]] = ("rate [m/s]",)
    kind: ClassVar[str] = "point-on-curve"

    def __post_init__(self) -> None:
        for name in ("closed", "turns"):
            if not isinstance(getattr(self, name), (bool, np.bool_)):
                raise ModelError(f"{name} of a {self.kind} joint must be True or False, not {getattr(self, name)!r}")
        points = _checked_points(self.points, self.closed, self.kind)
        if self.up is not None and not self.turns:
            raise ModelError(f"a {self.kind} joint that does not turn has nothing up. Remedy: turns=True")
        starts, nodes, t, pieces = _by_arc_length(points, self.closed, self.kind)
        if self.up is not None:
            up = axis_direction(self.up, self.kind)
            pieces = np.concatenate((pieces, _as_given(starts, t, up, self.kind)), axis=2)
        elif self.turns:
            pieces = np.concatenate((pieces, _rotation_minimising(starts, nodes, t, self.closed)), axis=2)
        from scipy.interpolate import PPoly

        object.__setattr__(self, "pieces", PPoly(pieces, starts))
        self._check_coordinates()
        position = float(self.initial_coordinates()[0])
        if not self.closed and not 0.0 <= position <= self.length:
            raise ModelError(
                f"a {self.kind} joint starts at an arc length of {position:.6g} m, but its curve goes from 0 to "
                f"{self.length:.6g} m. Remedy: a position on it, or closed=True"
            )

    @property
    def length(self) -> float:
        return float(self.pieces.x[-1])

    @property
    def ranges(self) -> tuple[tuple[float, float] | None, ...]:
        return (None if self.closed else (0.0, self.length),)

    def pose(self, q: Vector) -> tuple[Vector, Matrix]:
        found = self._motion(q)
        return found.p, found.A

    def partial_velocities(self, q: Vector) -> tuple[Matrix, Matrix]:
        found = self._motion(q)
        return found.V[:, None], found.W[:, None]

    def remainders(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        found = self._motion(q)
        return u[0] ** 2 * found.dV, u[0] ** 2 * found.dW

    def links(self) -> tuple[Link, ...]:
        return (Link.given(LinkKernel(curve, self._constants, curve)),)

    @cached_property
    def _constants(self) -> Vector:
        starts, pieces = self.pieces.x, self.pieces.c[::-1].transpose(1, 2, 0)
        return np.concatenate(((len(starts) - 1, self.closed, self.turns), starts, pieces.ravel()))

    def _motion(self, q: Vector) -> LinkMotion:
        return motion_by(curve, self._constants, float(q[0]))


def _checked_points(given: object, closed: bool, kind: str) -> Matrix:
    points, least = numbers(given), 3 if closed else 2
    if points.ndim != 2 or points.shape[1:] != (3,) or not np.all(np.isfinite(points)) or len(points) < least:
        raise ModelError(
            f"points of a {kind} joint must be finite numbers of shape (n, 3), {least} of them or more, m; shape "
            f"{points.shape} was given, or a number is not finite"
        )
    near = ALIKE * float(np.ptp(points, axis=0).max())
    if closed and np.linalg.norm(points[-1] - points[0]) <= near:
        raise ModelError(f"the last point of a closed {kind} joint is the first again. Remedy: leave it out")
    alike = np.flatnonzero(np.linalg.norm(np.diff(points, axis=0), axis=1) <= near)
    if len(alike):
        raise ModelError(
            f"points {alike[0]} and {alike[0] + 1} of a {kind} joint coincide. Remedy: leave out one of them"
        )
    return points


def _by_arc_length(points: Matrix, closed: bool, kind: str) -> tuple[Vector, Matrix, Matrix, Matrix]:
    """Return arc lengths (n + 1,), positions and tangents there, and powers 5 to 0 of each piece, (6, n, 3).

    Pieces of the spline through the points are halved until they are quintic in the arc length too, with position,
    tangent and curvature of the spline at their ends.
    """
    from scipy.interpolate import PPoly

    ring = np.vstack((points, points[:1])) if closed else points
    chords = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1)))
    centre = points.mean(axis=0)  # reduces round-off far from F's origin
    spline = quintic_spline(chords, ring - centre, closed)
    edges = spline.x
    places, weights = np.polynomial.legendre.leggauss(ORDER)
    while True:
        half = 0.5 * np.diff(edges)[:, None]
        rates = spline(edges[:-1, None] + half * (1.0 + places), 1)
        sizes = np.linalg.norm(rates, axis=2)
        if sizes.min() < LEAST_RATE:
            at = edges[int(np.argmin(sizes.min(axis=1)))]
            raise ModelError(
                f"the curve of a {kind} joint turns back on itself behind point "
                f"{int(np.searchsorted(chords, at, side='right')) - 1}. Remedy: points in the order in which a smooth "
                "curve passes them"
            )
        h, moved = half * (sizes @ weights)[:, None], half * np.einsum("ijk,j->ik", rates, weights)
        slopes, rest = spline(edges, 1), spline(edges, 2)
        t = slopes / np.linalg.norm(slopes, axis=1)[:, None]
        bend = (rest - np.sum(rest * t, axis=1)[:, None] * t) / np.sum(slopes**2, axis=1)[:, None]
        starts, nodes = np.append(0.0, np.cumsum(h)), spline(edges) + centre
        pieces = quintic_pieces(h, nodes, moved, t, bend)
        between = starts[:-1, None] + h * np.array((0.25, 0.5, 0.75))
        misses = np.abs(np.linalg.norm(PPoly(pieces, starts)(between, 1), axis=2) - 1.0).max(axis=1)
        wrong = misses > ARC_LENGTH
        if not wrong.any() or len(wrong) > MOST_PIECES:
            return starts, nodes, t, pieces
        edges = np.sort(np.concatenate((edges, (edges[:-1] + half[:, 0])[wrong])))


def _as_given(starts: Vector, t: Matrix, up: Vector, kind: str) -> Matrix:
    """Return the powers of a constant direction, (6, n, 3); refuse one that is along the curve somewhere."""
    sines = np.linalg.norm(np.cross(t, up), axis=1)
    if sines.min() < LEAST_ACROSS:
        raise ModelError(
            f"the curve of a {kind} joint runs along up at an arc length of {starts[int(np.argmin(sines))]:.6g} m. "
            "Remedy: another direction, or none: a frame that does not spin about the tangent"
        )
    powers = np.zeros((6, len(starts) - 1, 3))
    powers[5] = up
    return powers


def _rotation_minimising(starts: Vector, nodes: Matrix, t: Matrix, closed: bool) -> Matrix:
    """Return the powers of a direction across the curve that does not spin about it, (6, n, 3).

    Two reflections from node to node (Wang, Juettler, Zheng & Liu, ACM Trans. Graph. 27, 2008), with an error of the
    fourth power of the pieces' length, and a spline between them. The remaining slow spin is included in W and its
    derivative.
    """
    up = np.eye(3)[2 if abs(t[0, 2]) < ALONG_Z else 1]
    normals = [up - (up @ t[0]) * t[0]]
    normals[0] /= np.linalg.norm(normals[0])
    for i in range(len(t) - 1):
        line = nodes[i + 1] - nodes[i]
        mirror = np.eye(3) - 2.0 / (line @ line) * np.outer(line, line)
        line = t[i + 1] - mirror @ t[i]
        mirror = (np.eye(3) - 2.0 / (line @ line) * np.outer(line, line)) @ mirror
        normals.append(mirror @ normals[-1])
    n = np.array(normals)
    if closed:
        missing = np.arctan2(cross(n[-1], n[0]) @ t[0], n[-1] @ n[0]) * starts / starts[-1]
        n = np.cos(missing)[:, None] * n + np.sin(missing)[:, None] * np.cross(t, n)
        n[-1] = n[0]
    spline = quintic_spline(starts, n, closed)
    return np.array([spline(starts[:-1], k) / factorial(k) for k in (5, 4, 3, 2, 1, 0)])
