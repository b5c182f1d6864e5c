"""Places: sets of nodes of a body given by position instead of a group of the mesh.

A place selects parts of the surface of a body (`kanefe.fe_model.skin`): the facets of its skin whose corners are all in
the place, or else the single nodes of the skin in it. For a body without cells (matrices of another program) or made of
beams it selects nodes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers, unit_vector

SLACK = 1e-6
"""Largest distance of a node from its plane, or from its place, relative to the size of the body."""


class Place(ABC):
    """A region of space, in the axes of the mesh."""

    @abstractmethod
    def contains(self, points: np.ndarray, slack: float) -> np.ndarray:
        """Return which points (n, 3) are in the place, or no further from it than the slack in m; bool, shape (n,)."""


@dataclass(frozen=True)
class Near(Place):
    """The region within a distance of a point.

    Parameters
    ----------
    point : array_like, shape (3,)
        m.
    distance : float
        m.

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> import kanefe as kf
    >>> pin = kf.Interface(at=kf.Near((1, 0, 0), 0.01))
    """

    point: Sequence[float]
    distance: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", _three("Near", "point", self.point))
        object.__setattr__(self, "distance", _length("Near", "distance", self.distance))

    def contains(self, points: np.ndarray, slack: float) -> np.ndarray:
        """Return which points are near."""
        return np.asarray(np.linalg.norm(points - np.array(self.point), axis=1) <= self.distance + slack)


@dataclass(frozen=True)
class OnPlane(Place):
    """The points on a plane.

    Parameters
    ----------
    point, normal : array_like, shape (3,)
        A point of the plane in m, and its normal, of any length.
    distance : float
        Largest distance from the plane, m. Default: round-off.

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> import kanefe as kf
    >>> root = kf.Interface("all", at=kf.OnPlane((0, 0, 0), (1, 0, 0)))
    """

    point: Sequence[float]
    normal: Sequence[float]
    distance: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", _three("OnPlane", "point", self.point))
        normal = unit_vector(np.array(_three("OnPlane", "normal", self.normal)), "the normal of OnPlane")
        object.__setattr__(self, "normal", tuple(normal.tolist()))
        object.__setattr__(self, "distance", _length("OnPlane", "distance", self.distance))

    def contains(self, points: np.ndarray, slack: float) -> np.ndarray:
        """Return which points lie on the plane."""
        return np.asarray(abs((points - np.array(self.point)) @ np.array(self.normal)) <= self.distance + slack)


@dataclass(frozen=True)
class InBox(Place):
    """A box along the axes of the mesh, its sides included.

    Parameters
    ----------
    low, high : array_like, shape (3,)
        Its corners with the smallest and the largest coordinates in m; may be infinite.

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> inf = float("inf")
    >>> left_half = InBox((-inf, -inf, -inf), (0.0, inf, inf))
    """

    low: Sequence[float]
    high: Sequence[float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "low", _three("InBox", "low", self.low, finite=False))
        object.__setattr__(self, "high", _three("InBox", "high", self.high, finite=False))
        if any(low > high for low, high in zip(self.low, self.high, strict=True)):
            raise ModelError(f"InBox: low={self.low} is above high={self.high}. Remedy: the smaller coordinates first")

    def contains(self, points: np.ndarray, slack: float) -> np.ndarray:
        """Return which points are in the box."""
        inside = (points >= np.array(self.low) - slack) & (points <= np.array(self.high) + slack)
        return np.asarray(inside.all(axis=1))


@dataclass(frozen=True)
class InCylinder(Place):
    """A cylinder, or the region between two coaxial cylinders.

    Parameters
    ----------
    start, end : array_like, shape (3,)
        Ends of its axis in m.
    radius : float
        Outer radius in m; the wall of a bore of this radius is included.
    inner_radius : float
        Radius in m within which points are left out.

    Raises
    ------
    ModelError
        If a number is not valid.

    Examples
    --------
    >>> bore = InCylinder((0.1, 0, -1), (0.1, 0, 1), radius=0.005)
    """

    start: Sequence[float]
    end: Sequence[float]
    radius: float
    inner_radius: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", _three("InCylinder", "start", self.start))
        object.__setattr__(self, "end", _three("InCylinder", "end", self.end))
        object.__setattr__(self, "radius", _length("InCylinder", "radius", self.radius))
        object.__setattr__(self, "inner_radius", _length("InCylinder", "inner_radius", self.inner_radius))
        if self.start == self.end or self.inner_radius > self.radius:
            raise ModelError(f"{self!r} is empty. Remedy: two different ends, and inner_radius below radius")

    def contains(self, points: np.ndarray, slack: float) -> np.ndarray:
        """Return which points are in the cylinder."""
        line = np.array(self.end) - np.array(self.start)
        length = float(np.linalg.norm(line))
        offsets = points - np.array(self.start)
        along = offsets @ line / length
        across = np.linalg.norm(offsets - np.outer(along, line / length), axis=1)
        within = (along >= -slack) & (along <= length + slack)
        return np.asarray(within & (across <= self.radius + slack) & (across >= self.inner_radius - slack))


PlaceLike: TypeAlias = Place | Callable[[np.ndarray], np.ndarray]
"""A place, or a function of points (n, 3) in m that returns a bool of shape (n,) for the points that belong to it."""


def contained(nodes: np.ndarray, place: PlaceLike, label: str) -> np.ndarray:
    """Return which nodes (n, 3) are in a place, bool of shape (n,)."""
    if isinstance(place, Place):
        return place.contains(nodes, SLACK * float(np.ptp(nodes, axis=0).max()))
    if not callable(place):
        raise ModelError(
            f"{label}: {place!r} is not a place. Remedy: Near, OnPlane, InBox, InCylinder, or a function of points (n, "
            "3)"
        )
    inside = np.asarray(place(np.array(nodes)))
    if inside.shape != (len(nodes),) or inside.dtype != bool:
        raise ModelError(
            f"{label}: the function of points returned {inside.dtype} of shape {inside.shape} for {len(nodes)} points. "
            "Remedy: one bool for each, such as points[:, 0] < 0.1"
        )
    return inside.copy()


def _three(what: str, name: str, given: object, finite: bool = True) -> tuple[float, ...]:
    values = numbers(given)
    if values.shape != (3,) or np.isnan(values).any() or (finite and not np.isfinite(values).all()):
        raise ModelError(f"{what}: {name}={given!r}. Remedy: three numbers in m")
    return tuple(values.tolist())


def _length(what: str, name: str, given: object) -> float:
    value = numbers(given)
    if value.shape != () or not 0.0 <= float(value) < np.inf:
        raise ModelError(f"{what}: {name}={given!r}. Remedy: a length in m, at least 0")
    return float(value)
