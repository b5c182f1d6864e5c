"""Shapes of surfaces: `kanefe.shapes`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked, positive
from kanefe.contact.geometry.convex import Convex as Convex
from kanefe.contact.geometry.height_field import HeightField as HeightField
from kanefe.contact.geometry.look import Look as Look
from kanefe.contact.geometry.mesh import Mesh as Mesh
from kanefe.contact.geometry.points import Points as Points
from kanefe.contact.geometry.points import on_box, on_circle, on_cylinder, on_line, standing_for
from kanefe.contact.geometry.shape import Probe, axes_about, length_and_direction
from kanefe.contact.geometry.shape import SurfaceShape as SurfaceShape
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, direction, numbers
from kanefe.loads.reach import Bounds

__all__ = ["Box", "Capsule", "Convex", "Cylinder", "HeightField", "Look", "Mesh", "Plane", "Points", "Sphere", "Torus"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True, eq=False)
class Plane(SurfaceShape):
    """A plane through the origin of its frame, and all that is behind it.

    Parameters
    ----------
    normal : "x", "y", "z", "-x", "-y", "-z" or array_like, shape (3,)
        Outwards.

    Examples
    --------
    >>> import kanefe as kf
    >>> distance, normal = kf.shapes.Plane("z").distance((0.3, 0.0, 0.1))
    >>> float(distance)
    0.1
    """

    normal: Any = "z"
    kind = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", direction(self.normal, "normal of a plane"))

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal."""
        return float(self.normal @ np.asarray(x, dtype=float)), self.normal

    @property
    def bounds(self) -> Bounds:
        """Half of space."""
        axes = np.linalg.svd(self.normal[None])[2].T[:, ::-1]
        axes[:, 2] = self.normal
        return Bounds(upper=np.array((np.inf, np.inf, 0.0)), axes=axes)

    @property
    def is_smooth(self) -> bool:
        """It is flat."""
        return True

    @property
    def numbers(self) -> Vector:
        """Its normal."""
        return np.array(self.normal)


@checked("inside")
@dataclass(frozen=True, eq=False)
class Sphere(SurfaceShape):
    """A ball about the origin of its frame; `inside`: the room in it."""

    radius: float
    inside: bool = False
    kind = 1

    def __post_init__(self) -> None:
        positive(self.radius, "radius of a sphere")

    @property
    def bounds(self) -> Bounds:
        """The ball itself; of a room the cube in it."""
        if self.inside:
            return _room(np.full(3, self.radius / math.sqrt(3.0)))
        return Bounds(np.zeros(3), np.zeros(3), rounding=self.radius)

    @property
    def is_smooth(self) -> bool:
        """But for its centre."""
        return True

    def curvature(self, x: Vector) -> Matrix:
        """Return the second derivatives of the distance, 1/m."""
        length, along = length_and_direction(np.asarray(x, dtype=float))
        return _sign(self.inside) * (np.eye(3) - np.outer(along, along)) / length

    @property
    def numbers(self) -> Vector:
        """Radius, and side."""
        return np.array((self.radius, _sign(self.inside)))

    def probes(self) -> tuple[Probe, ...]:
        """Return the ball itself."""
        return () if self.inside else (Probe(np.zeros(3), self.radius),)


@dataclass(frozen=True, eq=False)
class Capsule(SurfaceShape):
    """A cylinder along an axis with a half ball at both ends.

    Parameters
    ----------
    radius : float
        m.
    length : float
        Between the centres of the half balls, m; its middle is the origin of its frame.
    axis : "x", "y", "z" or array_like, shape (3,)
    """

    radius: float
    length: float
    axis: Any = "x"
    kind = 2

    def __post_init__(self) -> None:
        positive(self.radius, "radius of a capsule")
        positive(self.length, "length of a capsule")
        object.__setattr__(self, "axis", direction(self.axis, "axis of a capsule"))

    @property
    def bounds(self) -> Bounds:
        """The box about its axis, rounded."""
        half = 0.5 * self.length * np.abs(self.axis)
        return Bounds(-half, half, rounding=self.radius)

    @property
    def numbers(self) -> Vector:
        """Radius, length, axis."""
        return np.array((self.radius, self.length, *self.axis))

    def probes(self) -> tuple[Probe, ...]:
        """Return the balls at its ends, between which a plane cannot reach."""
        return tuple(Probe(end * 0.5 * self.length * self.axis, self.radius, 0.5) for end in (-1.0, 1.0))

    def sampled(self, spacing: float) -> Points:
        """Return balls along its axis: see `SurfaceShape.sampled`."""
        half = 0.5 * self.length * self.axis
        balls = on_line(-half, half, positive(spacing, "spacing"))
        return standing_for(self.title, balls, len(balls), self.radius)


@checked("inside")
@dataclass(frozen=True, eq=False)
class Cylinder(SurfaceShape):
    """A cylinder with flat ends; it touches planes with the edges of its ends.

    Parameters
    ----------
    radius, length : float
        m; its middle is the origin of its frame.
    axis : "x", "y", "z" or array_like, shape (3,)
    inside : bool
        True: the room in it.
    """

    radius: float
    length: float
    axis: Any = "z"
    inside: bool = False
    kind = 3

    def __post_init__(self) -> None:
        positive(self.radius, "radius of a cylinder")
        positive(self.length, "length of a cylinder")
        object.__setattr__(self, "axis", direction(self.axis, "axis of a cylinder"))

    @property
    def bounds(self) -> Bounds:
        """The box about it; of a room the cube in it."""
        if self.inside:
            return _room(np.full(3, min(self.radius, 0.5 * self.length) / math.sqrt(3.0)))
        half = 0.5 * self.length * np.abs(self.axis) + self.radius * np.sqrt(1.0 - self.axis**2)
        return Bounds(-half, half)

    @property
    def numbers(self) -> Vector:
        """Radius, length, axis, side."""
        return np.array((self.radius, self.length, *self.axis, _sign(self.inside)))

    def probes(self) -> tuple[Probe, ...]:
        """Return the edges of its ends."""
        if self.inside:
            return ()
        return tuple(
            Probe(end * 0.5 * self.length * self.axis, 0.0, 0.5, self.radius, self.axis) for end in (-1.0, 1.0)
        )

    def sampled(self, spacing: float) -> SurfaceShape:
        """Return points of its side and of its ends: see `SurfaceShape.sampled`."""
        if self.inside:
            return super().sampled(spacing)
        axes = axes_about(self.axis)
        return standing_for(self.title, *on_cylinder(self.radius, self.length, axes, positive(spacing, "spacing")))


@checked("inside")
@dataclass(frozen=True, eq=False)
class Box(SurfaceShape):
    """A box about the origin of its frame, its edges along the axes; it touches others with its corners.

    Parameters
    ----------
    size : array_like, shape (3,)
        Lengths of its edges, m.
    inside : bool
        True: the room in it.
    """

    size: Any
    inside: bool = False
    kind = 4

    def __post_init__(self) -> None:
        size = numbers(self.size)
        if size.shape != (3,) or not np.all(np.isfinite(size)) or np.any(size <= 0.0):
            raise ModelError(f"size of a box must be three finite numbers > 0, m, not {self.size!r}")
        object.__setattr__(self, "size", size)

    @property
    def bounds(self) -> Bounds:
        """The box itself."""
        return _room(0.5 * self.size) if self.inside else Bounds(-0.5 * self.size, 0.5 * self.size)

    @property
    def numbers(self) -> Vector:
        """Size, and side."""
        return np.append(self.size, _sign(self.inside))

    def probes(self) -> tuple[Probe, ...]:
        """Return its corners; those of a face have the whole stiffness together."""
        if self.inside:
            return ()
        corners = 0.5 * self.size * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return tuple(Probe(corner, 0.0, 0.25) for corner in corners)

    def sampled(self, spacing: float) -> SurfaceShape:
        """Return points of its faces: see `SurfaceShape.sampled`."""
        if self.inside:
            return super().sampled(spacing)
        return standing_for(self.title, *on_box(self.size, positive(spacing, "spacing")))


@dataclass(frozen=True, eq=False)
class Torus(SurfaceShape):
    """A tyre: a ball of radius `tube` swept round a circle; thin (`tube=0`) the edge of a disc.

    Parameters
    ----------
    radius : float
        Of the circle of centres, m.
    tube : float
        Of the cross-section, m.
    axis : "x", "y", "z" or array_like, shape (3,)
    """

    radius: float
    tube: float
    axis: Any = "y"
    kind = 5

    def __post_init__(self) -> None:
        positive(self.radius, "radius of a torus")
        if numbers(self.tube).shape or numbers(self.tube) != 0.0:
            positive(self.tube, "tube of a torus")
        object.__setattr__(self, "axis", direction(self.axis, "axis of a torus"))

    @property
    def bounds(self) -> Bounds:
        """The box about the circle of centres, rounded."""
        half = self.radius * np.sqrt(1.0 - self.axis**2)
        return Bounds(-half, half, rounding=self.tube)

    @property
    def numbers(self) -> Vector:
        """Radius, tube, axis."""
        return np.array((self.radius, self.tube, *self.axis))

    def probes(self) -> tuple[Probe, ...]:
        """Return the ring."""
        return (Probe(np.zeros(3), self.tube, 1.0, self.radius, self.axis),)

    def sampled(self, spacing: float) -> Points:
        """Return balls round its circle, each with the whole stiffness: see `SurfaceShape.sampled`.

        From one ball to between two it sinks by ``spacing**2 / (8 radius)``, which is to be small beside how deep it
        presses; where it presses deeper, several carry it.
        """
        ring = on_circle(self.radius, axes_about(self.axis), positive(spacing, "spacing"))
        return standing_for(self.title, ring, 1, self.tube)


def _room(half: Vector) -> Bounds:
    return Bounds(-half, half, is_room=True)


def _sign(inside: bool) -> float:
    return -1.0 if inside else 1.0
