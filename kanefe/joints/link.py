"""Links: the parts of joints that the rows of the order-n route know."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector, turn_to
from kanefe.kernels.layout import AXIS, FIXED, FREE, GIVEN, REVOLUTE, SPHERICAL
from kanefe.kernels.links.places import MOTION_NUMBERS

Z = (0.0, 0.0, 1.0)
SPEEDS = {FIXED: 0, SPHERICAL: 3, FREE: 6}
"""Number of speeds of links that have other than one."""


class LinkKernel(NamedTuple):
    """What compiled code finds the motion of a link of one coordinate by: a function of one C signature, its numbers.

    The function is ``void f(const double *numbers, const double *q, double *out)``. It writes 24 numbers, all of the
    link's frame M seen from its frame F and in components of F, with q in m or rad: position p (3), axes A (9, row by
    row), partial velocities V (3) and W (3) as in `Joint.partial_velocities`, and dV/dq (3) and dW/dq (3), which are
    the remainders (Eq. 15, 16) of a unit speed. `out` comes as zeros.

    Attributes
    ----------
    real : function or int
        A kernel of `kanefe.kernels`, or the address of such a function from ``numba.cfunc`` or any compiler.
    numbers : ndarray
        Constants that the function is given.
    complex_ : function, int or None
        The same for a complex coordinate (q and `out` are pairs of real and imaginary part; `numbers` stay real), from
        which exact derivatives come; None: derivatives of the scene are by differences.
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
    """Return what a kernel of the package writes for a coordinate; it is a plain function until it is compiled."""
    out = np.zeros(MOTION_NUMBERS)
    function(constants, (q,), out)
    p, A, V, W, dV, dW = np.split(out, (3, 12, 15, 18, 21))
    return LinkMotion(p, A.reshape(3, 3), V, W, dV, dW)


@dataclass(frozen=True, eq=False)
class Link:
    """A part of a joint that moves in one way; a joint is a chain of them, each on the one before.

    Made by the functions below. Axes are given at zero coordinates, in components of the joint's fixed frame F; behind
    a given link, of its frame M.

    Attributes
    ----------
    kind : int
        Of the rows of `kanefe.kernels.layout`.
    axis : ndarray, shape (3,)
        Unit vector.
    along, about : float
        Travel (m) along the axis and turn (rad) about it of a unit of the coordinate.
    kernel : LinkKernel or None
        Of a given link.

    Examples
    --------
    A sleeve that slides on a bar and turns about it:

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
        return cls(FIXED)

    @classmethod
    def turning(cls, axis: Vector) -> Link:
        """Return a link that turns about an axis: an angle in rad, and its rate."""
        return cls(REVOLUTE, axis, 0.0, 1.0)

    @classmethod
    def sliding(cls, axis: Vector) -> Link:
        """Return a link that slides along an axis: a distance in m, and its rate."""
        return cls(AXIS, axis, 1.0, 0.0)

    @classmethod
    def winding(cls, axis: Vector, advance: float) -> Link:
        """Return a link that turns about an axis and advances on it, in m/rad: an angle in rad, and its rate."""
        return cls(AXIS, axis, advance, 1.0)

    @classmethod
    def given(cls, kernel: LinkKernel) -> Link:
        """Return a link of one coordinate, m or rad, and its rate, that moves as a function of C says."""
        return cls(GIVEN, kernel=kernel)

    @classmethod
    def spherical(cls) -> Link:
        """Return a link that turns about a point: four Euler parameters, and the angular velocity in what turns."""
        return cls(SPHERICAL)

    @classmethod
    def free(cls) -> Link:
        """Return a link that moves freely: coordinates and speeds of `kanefe.Free`."""
        return cls(FREE)

    @property
    def turn(self) -> Matrix:
        """A rotation that brings z to the axis, (3, 3)."""
        return turn_to(self.axis)

    @property
    def speed_count(self) -> int:
        """How many speeds of the joint are those of the link."""
        return SPEEDS.get(self.kind, 1)

    @property
    def coordinate_count(self) -> int:
        """How many coordinates of the joint are those of the link: a rotation has four."""
        return self.speed_count + (self.kind in (SPHERICAL, FREE))

    @property
    def is_fixed(self) -> bool:
        """Whether it does not move."""
        return self.kind == FIXED

    @property
    def is_turn(self) -> bool:
        """Whether it turns about its axis and does nothing else."""
        return self.kind == REVOLUTE

    @property
    def is_slide(self) -> bool:
        """Whether it slides along its axis and does nothing else."""
        return self.kind == AXIS and (self.along, self.about) == (1.0, 0.0)

    @property
    def is_given(self) -> bool:
        """Whether a function of C says how it moves."""
        return self.kind == GIVEN

    @property
    def is_free(self) -> bool:
        """Whether it moves freely in space."""
        return self.kind == FREE
