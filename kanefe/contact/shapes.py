"""Shapes of surfaces: signed distances for what touches them, and probes by which they touch others."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


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
        Radius of the circle of centres of which the lowest is in contact, m; 0: none.
    axis : ndarray, shape (3,)
        Of that circle.
    """

    point: Vector
    radius: float = 0.0
    share: float = 1.0
    ring: float = 0.0
    axis: Vector = np.array(AXES["z"])


class SurfaceShape(ABC):
    """The shape of a surface, in the axes of the frame that the surface was given.

    Attributes
    ----------
    kind : int
        By which kernels know it: see `kanefe.kernels.force_elements.contact_shapes`.
    """

    kind: ClassVar[int]

    @abstractmethod
    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point x (3,) from the surface, m, and its normal there, away from it."""

    @property
    @abstractmethod
    def numbers(self) -> Vector:
        """What kernels are given of it."""

    def probes(self) -> tuple[Probe, ...]:
        """Return what it touches other surfaces with; none: others touch it."""
        return ()

    @property
    def title(self) -> str:
        """Its name in messages."""
        return type(self).__name__.lower()


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
    def numbers(self) -> Vector:
        """Its normal."""
        return np.array(self.normal)


@dataclass(frozen=True, eq=False)
class Sphere(SurfaceShape):
    """A ball about the origin of its frame; `inside`: the room in it."""

    radius: float
    inside: bool = False
    kind = 1

    def __post_init__(self) -> None:
        positive(self.radius, "radius of a sphere")

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal."""
        length, along = _length(np.asarray(x, dtype=float))
        return _side(self.inside, length - self.radius, along)

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

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal."""
        x = np.asarray(x, dtype=float)
        along = float(np.clip(self.axis @ x, -0.5 * self.length, 0.5 * self.length))
        length, normal = _length(x - along * self.axis)
        return length - self.radius, normal

    @property
    def numbers(self) -> Vector:
        """Radius, length, axis."""
        return np.array((self.radius, self.length, *self.axis))

    def probes(self) -> tuple[Probe, ...]:
        """Return the balls at its ends, between which a plane cannot reach."""
        return tuple(Probe(end * 0.5 * self.length * self.axis, self.radius, 0.5) for end in (-1.0, 1.0))


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

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal."""
        x = np.asarray(x, dtype=float)
        height = float(self.axis @ x)
        rho, outward = _length(x - height * self.axis)
        end = math.copysign(1.0, height) * self.axis
        over, beyond = rho - self.radius, abs(height) - 0.5 * self.length
        if over > 0.0 and beyond > 0.0:
            distance = math.hypot(over, beyond)
            return _side(self.inside, distance, (over * outward + beyond * end) / distance)
        return _side(self.inside, over, outward) if over > beyond else _side(self.inside, beyond, end)

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

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal."""
        x = np.asarray(x, dtype=float)
        sides = np.where(x < 0.0, -1.0, 1.0)
        over = np.abs(x) - 0.5 * self.size
        if over.max() > 0.0:
            outside = np.maximum(over, 0.0)
            length = float(np.linalg.norm(outside))
            return _side(self.inside, length, sides * outside / length)
        nearest = int(np.argmax(over))
        return _side(self.inside, float(over[nearest]), sides * np.eye(3)[nearest])

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
        if self.tube != 0.0:
            positive(self.tube, "tube of a torus")
        object.__setattr__(self, "axis", direction(self.axis, "axis of a torus"))

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal."""
        x = np.asarray(x, dtype=float)
        _, outward = _length(x - (self.axis @ x) * self.axis)
        length, normal = _length(x - self.radius * outward)
        return length - self.tube, normal

    @property
    def numbers(self) -> Vector:
        """Radius, tube, axis."""
        return np.array((self.radius, self.tube, *self.axis))

    def probes(self) -> tuple[Probe, ...]:
        """Return the ring."""
        return (Probe(np.zeros(3), self.tube, 1.0, self.radius, self.axis),)


@dataclass(frozen=True, eq=False)
class Points(SurfaceShape):
    """Balls or points that touch other surfaces: an edge, a skid, the feet of a table.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        Centres, m.
    radius : float
        Of each, m; 0: points.
    """

    points: Any
    radius: float = 0.0
    kind = 6

    def __post_init__(self) -> None:
        places = numbers(self.points)
        if places.ndim != 2 or places.shape[1:] != (3,) or not len(places) or not np.all(np.isfinite(places)):
            raise ModelError(f"points of a surface must be finite, shape (n, 3), m, not {self.points!r}")
        if self.radius != 0.0:
            positive(self.radius, "radius of points")
        object.__setattr__(self, "points", places)

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from the nearest, m, and the normal of its ball."""
        offsets = np.asarray(x, dtype=float) - self.points
        length, normal = _length(offsets[int(np.argmin(np.linalg.norm(offsets, axis=1)))])
        return length - self.radius, normal

    @property
    def numbers(self) -> Vector:
        """Nothing: others do not touch it."""
        return np.zeros(0)

    def probes(self) -> tuple[Probe, ...]:
        """Return each, with its share."""
        return tuple(Probe(point, self.radius, 1.0 / len(self.points)) for point in self.points)


@dataclass(frozen=True, eq=False)
class HeightField(SurfaceShape):
    """Heights z over a grid of x and y, with slopes that are continuous, and all that is below.

    Parameters
    ----------
    x, y : array_like, shapes (m,), (n,)
        Places of the grid, evenly spaced, m; three or more. Beyond it the surface goes on level.
    heights : array_like, shape (m, n)
        m.
    """

    x: Any
    y: Any
    heights: Any
    kind = 7

    def __post_init__(self) -> None:
        x, y, heights = numbers(self.x), numbers(self.y), numbers(self.heights)
        for name, places in (("x", x), ("y", y)):
            steps = np.diff(places) if places.ndim == 1 else np.zeros(0)
            if len(steps) < 2 or not np.all(steps > 0.0) or not np.allclose(steps, steps[0], rtol=1e-6, atol=0.0):
                raise ModelError(
                    f"{name} of a height field must be three or more numbers, evenly spaced and increasing"
                )
        if heights.shape != (len(x), len(y)) or not np.all(np.isfinite(heights)):
            raise ModelError(
                f"heights of a height field must be finite, shape {(len(x), len(y))} as x and y, not {heights.shape}"
            )
        for name, value in (("x", x), ("y", y), ("heights", heights)):
            object.__setattr__(self, name, value)

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the distance of a point from the tangent plane below it, m, and its normal."""
        place = np.asarray(x, dtype=float)
        (i, a, da), (j, b, db) = _weights(self.x, place[0]), _weights(self.y, place[1])
        near = self.heights[np.ix_(i, j)]
        gradient = np.array((da @ near @ b, a @ near @ db))
        stretch = math.sqrt(1.0 + gradient @ gradient)
        return float(place[2] - a @ near @ b) / stretch, np.append(-gradient, 1.0) / stretch

    @property
    def numbers(self) -> Vector:
        """First place and step of both directions, how many places, and heights."""
        dx, dy = self.x[1] - self.x[0], self.y[1] - self.y[0]
        return np.concatenate(((self.x[0], dx, len(self.x), self.y[0], dy, len(self.y)), self.heights.ravel()))


def _weights(places: Vector, x: float) -> tuple[list[int], Vector, Vector]:
    """Return four places about x and the weights of values and slopes there, of cubic convolution (Keys 1981)."""
    n, step = len(places), places[1] - places[0]
    s = (x - places[0]) / step
    held = min(max(s, 0.0), n - 1.0)
    at = min(int(held), n - 2)
    f = held - at
    rate = (1.0 if held == s else 0.0) / step
    weights = 0.5 * np.array((-f + 2 * f**2 - f**3, 2 - 5 * f**2 + 3 * f**3, f + 4 * f**2 - 3 * f**3, -(f**2) + f**3))
    slopes = 0.5 * rate * np.array((-1 + 4 * f - 3 * f**2, -10 * f + 9 * f**2, 1 + 8 * f - 9 * f**2, -2 * f + 3 * f**2))
    return [min(max(at + k, 0), n - 1) for k in (-1, 0, 1, 2)], weights, slopes


def direction(value: object, what: str) -> Vector:
    """Return a unit vector from "x", "-z" or three numbers; a ModelError names what it is."""
    if isinstance(value, str) and value.removeprefix("-") in AXES:
        return np.array(AXES[value.removeprefix("-")]) * (-1.0 if value.startswith("-") else 1.0)
    given = numbers(value) if not isinstance(value, str) else np.zeros(0)
    length = float(np.linalg.norm(given)) if given.shape == (3,) else 0.0
    if not (length > 0.0 and math.isfinite(length)):
        raise ModelError(f"{what} must be 'x', 'y', 'z', one of these with a minus, or three numbers, not {value!r}")
    return given / length


def positive(value: object, what: str) -> float:
    """Return a finite number above zero; a ModelError names what it is."""
    number = numbers(value)
    if number.shape != () or not np.isfinite(number) or number <= 0.0:
        raise ModelError(f"{what} must be one number, finite and > 0, not {value!r}")
    return float(number)


def _length(x: Matrix) -> tuple[float, Vector]:
    """Return the length of a vector, and its direction; z where it has none."""
    length = float(np.linalg.norm(x))
    return length, x / length if length > 0.0 else np.array(AXES["z"])


def _sign(inside: bool) -> float:
    return -1.0 if inside else 1.0


def _side(inside: bool, distance: float, normal: Vector) -> tuple[float, Vector]:
    sign = _sign(inside)
    return sign * distance, sign * normal


SHAPES: Sequence[type[SurfaceShape]] = (Plane, Sphere, Capsule, Cylinder, Box, Torus, Points, HeightField)
