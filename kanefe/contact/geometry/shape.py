"""Shapes of surfaces: signed distances, and the points by which they touch other shapes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import AXES, Matrix, Vector
from kanefe.kernels.contact.contact_shapes import distance
from kanefe.kernels.values.tensors import Vector as Numbers
from kanefe.loads.reach import Bounds


class Probe(NamedTuple):
    """A ball, a point or a ring by which a body touches a surface.

    Attributes
    ----------
    point : ndarray, shape (3,)
        Its centre, from the origin of the frame that it is fixed in, in its axes, m.
    radius : float
        Of the ball, or of the ring's cross-section, m; 0: a point, or an edge.
    share : float
        Of the stiffness of the contact; of all probes that touch a plane at once together 1.
    ring : float
        Radius of the circle of centres of which the lowest is in contact, m; 0: none. Below 0: -1 less a slot of a box
        on a box, see `kanefe.contact.box_pair`.
    axis : ndarray, shape (3,)
        Of that circle; of a slot half the size of the box, m.
    """

    point: Vector
    radius: float = 0.0
    share: float = 1.0
    ring: float = 0.0
    axis: Vector = np.array(AXES["z"])

    @property
    def lever(self) -> float:
        """From its centre to what it rolls on, m."""
        return self.radius + max(self.ring, 0.0)

    @property
    def extent(self) -> float:
        """Radius of the ball about its centre that all of it is in, m."""
        return self.radius + self.ring if self.ring >= 0.0 else float(np.linalg.norm(self.axis))


class SurfaceShape(ABC):
    """The shape of a surface, in the axes of the frame that the surface was given.

    Attributes
    ----------
    kind : int
        By which kernels know it: see `kanefe.kernels.contact.contact_shapes`.
    """

    kind: ClassVar[int]

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point x (3,) from the surface, m, and its normal there, away from it."""
        found = distance(self.listed, 0, Numbers(*np.asarray(x, dtype=float).tolist()))
        return float(found.gap), np.array(found.normal.numbers)

    @cached_property
    def listed(self) -> list[float]:
        """Its kind and numbers, as compiled code has them."""
        return [self.kind, *self.numbers.tolist()]

    @property
    @abstractmethod
    def numbers(self) -> Vector:
        """What kernels are given of it."""

    @property
    def bounds(self) -> Bounds:
        """Bounds of the shape; pairs out of reach are not evaluated. By default it is everywhere."""
        return Bounds()

    @property
    def is_smooth(self) -> bool:
        """Whether its distance has second derivatives all around, as `curvature` gives them."""
        return False

    def curvature(self, x: Vector) -> Matrix | None:
        """Return the second derivatives of the distance at a point x (3,), 1/m, shape (3, 3); None: it is flat."""
        return None

    def probes(self) -> tuple[Probe, ...]:
        """Return what it touches other surfaces with; none: others touch it."""
        return ()

    def sampled(self, spacing: float) -> SurfaceShape:
        """Return points or balls in its place, which touch ground of any shape.

        Parameters
        ----------
        spacing : float
            At most between two of them, m: what is sharper than that may come in between.

        Returns
        -------
        Points
            Those of them that lie on flat ground at once have the stiffness of the contact together, on the largest
            face of the shape.

        Raises
        ------
        ModelError
            If it cannot be stood for by points, or would be by too many.

        Examples
        --------
        >>> import kanefe as kf
        >>> brick = kf.shapes.Box((0.4, 0.2, 0.1)).sampled(0.1)
        >>> len(brick.points), round(brick.share, 6)  # of 5 by 3 places of a face
        (30, 0.066667)
        """
        raise ModelError(f"a {self.title} is not represented by points: it is unbounded, or one of the user's")

    @property
    def title(self) -> str:
        """Its name in messages."""
        return type(self).__name__.lower()


def length_and_direction(x: Vector) -> tuple[float, Vector]:
    """Return the length of a vector, and its direction; z where it has none."""
    length = float(np.linalg.norm(x))
    return length, x / length if length > 0.0 else np.array(AXES["z"])


def axes_about(direction: Vector) -> Matrix:
    """Return axes (3, 3, columns) of which the third is a unit vector; along z they are those of the frame."""
    helper = np.array((0.0, 1.0, 0.0)) if abs(direction[1]) < 0.9 else np.array((0.0, 0.0, 1.0))
    first = np.cross(helper, direction)
    first /= np.linalg.norm(first)
    return np.column_stack((first, np.cross(direction, first), direction))
