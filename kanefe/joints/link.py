"""Links: the parts of joints in the tables of the order-n route."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector, turn_to
from kanefe.kernels.links.places import WrittenMotion
from kanefe.kernels.tree import Kind

Z = (0.0, 0.0, 1.0)
SPEEDS: dict[int, int] = {Kind.FIXED: 0, Kind.SPHERICAL: 3, Kind.FREE: 6}
"""Number of speeds of links that do not have one."""


class LinkKernel(NamedTuple):
    """The compiled function of the motion of a link of one coordinate, and its numbers.

    The function is ``void f(const double *numbers, const double *q, double *out)``. It writes 24 numbers, all of the
    link's frame M seen from its frame F and in components of F, with q in m or rad: position p (3), axes A (9, row by
    row), partial velocities V (3) and W (3) as in `Joint.partial_velocities`, and dV/dq (3) and dW/dq (3), which are
    the remainders (Eq. 15, 16) of a unit speed. `out` is filled with zeros before the call.

    Attributes
    ----------
    real : function or int
        A kernel of `kanefe.kernels`, or the address of such a function from ``numba.cfunc`` or any compiler.
    numbers : ndarray
        Constants passed to the function.
    complex_ : function, int or None
        The function for a complex coordinate (q and `out` are pairs of real and imaginary part; `numbers` stay real),
        for exact derivatives; None: derivatives of the scene are differences.
    """

    real: Callable[..., None] | int
    numbers: Vector
    complex_: Callable[..., None] | int | None = None


class LinkMotion(NamedTuple):
    """Motion of the frame M of a link of one coordinate seen from its frame F, in components of F.

    Attributes
    ----------
    p, V, W, dV, dW : ndarray, shape (3,)
        Position, partial velocities and their derivatives by the coordinate.
    A : ndarray, shape (3, 3)
        Axes of M.
    """

    p: Vector
    A: Matrix
    V: Vector
    W: Vector
    dV: Vector
    dW: Vector


def motion_by(function: Callable[..., None], constants: Vector, q: float) -> LinkMotion:
    """Return the motion by a kernel of the package, called as a plain Python function."""
    out = np.zeros(WrittenMotion.number_count)
    function(constants, (q,), out)
    return motion_in(out)


def motion_in(out: Vector) -> LinkMotion:
    """Return the motion that a kernel has written."""
    p, A, V, W, dV, dW = np.split(out, (3, 12, 15, 18, 21))
    return LinkMotion(p, A.reshape(3, 3), V, W, dV, dW)


@dataclass(frozen=True, eq=False)
class Link:
    """An elementary part of a joint; a joint is a chain of links, each relative to the one before.

    Links are made by the functions below. Axes are given at zero coordinates, in components of the joint's fixed frame
    F, or, after a given link, of its frame M.

    Attributes
    ----------
    kind : int
        Kind of link in `kanefe.kernels.tree.Kind`.
    axis : ndarray, shape (3,)
        Unit vector.
    along, about : float
        Translation (m) along the axis and rotation (rad) about it per unit of the coordinate.
    kernel : LinkKernel or None
        Function of a given link.

    Examples
    --------
    A sleeve that slides on a bar and rotates about it:

    >>> bar = np.array((1.0, 0.0, 0.0))
    >>> links = Link.sliding(bar), Link.turning(bar)
    """

    kind: int
    axis: Vector = field(default_factory=lambda: np.array(Z))
    along: float = 0.0
    about: float = 0.0
    kernel: LinkKernel | None = None

    @classmethod
    def fixed(cls) -> Link:
        """Return a link that does not move."""
        return cls(Kind.FIXED)

    @classmethod
    def turning(cls, axis: Vector) -> Link:
        """Return a link that rotates about an axis: an angle in rad, and its rate."""
        return cls(Kind.REVOLUTE, axis, 0.0, 1.0)

    @classmethod
    def sliding(cls, axis: Vector) -> Link:
        """Return a link that slides along an axis: a distance in m, and its rate."""
        return cls(Kind.AXIS, axis, 1.0, 0.0)

    @classmethod
    def winding(cls, axis: Vector, advance: float) -> Link:
        """Return a link that rotates about an axis and advances along it, in m/rad: an angle in rad, and its rate."""
        return cls(Kind.AXIS, axis, advance, 1.0)

    @classmethod
    def given(cls, kernel: LinkKernel) -> Link:
        """Return a link whose motion is a C function of one coordinate, m or rad; the speed is its rate."""
        return cls(Kind.GIVEN, kernel=kernel)

    @classmethod
    def spherical(cls) -> Link:
        """Return a link that rotates about a point: four Euler parameters, and the angular velocity in its frame."""
        return cls(Kind.SPHERICAL)

    @classmethod
    def free(cls) -> Link:
        """Return a link that moves freely: coordinates and speeds of `kanefe.Free`."""
        return cls(Kind.FREE)

    @property
    def turn(self) -> Matrix:
        """A rotation matrix that maps z to the axis, (3, 3)."""
        return turn_to(self.axis)

    @property
    def speed_count(self) -> int:
        """Number of speeds of the link."""
        return SPEEDS.get(self.kind, 1)

    @property
    def coordinate_count(self) -> int:
        """Number of coordinates of the link: a rotation has four."""
        return self.speed_count + (self.kind in (Kind.SPHERICAL, Kind.FREE))

    @property
    def is_fixed(self) -> bool:
        """Whether it does not move."""
        return self.kind == Kind.FIXED

    @property
    def is_turn(self) -> bool:
        """Whether it only rotates about its axis."""
        return self.kind == Kind.REVOLUTE

    @property
    def is_slide(self) -> bool:
        """Whether it only translates along its axis."""
        return self.kind == Kind.AXIS and (self.along, self.about) == (1.0, 0.0)

    @property
    def is_given(self) -> bool:
        """Whether its motion is a C function."""
        return self.kind == Kind.GIVEN

    @property
    def is_free(self) -> bool:
        """Whether it moves freely in space."""
        return self.kind == Kind.FREE
