"""What shapes of surfaces look like: triangles, for views and files of results."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.contact.geometry.height_field import heights_at
from kanefe.contact.geometry.shape import axes_about
from kanefe.contact.shapes import Box, Capsule, Cylinder, HeightField, Look, Mesh, Plane, Points, Sphere, Torus
from kanefe.frames import Matrix, Vector

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import SurfaceShape

AROUND = 40
"""Number of sides of a drawn circle."""

AROUND_POINTS = 12
"""Number of sides of a drawn circle of one ball among many."""

MOST_VERTICES = 20_000
"""Number of vertices up to which a height field is drawn finer than its grid."""

FINEST = 4

POINT = 1e-3
"""Radius of a ball that represents a point, m."""

NO_LINES = np.zeros((0, 2), dtype=int)


class Outline(NamedTuple):
    """Triangles of a shape in its own axes.

    Attributes
    ----------
    vertices : ndarray, shape (n, 3)
        m.
    triangles : ndarray of int, shape (m, 3)
    is_endless : bool
        Whether it is a square of 1 m cut out of a plane.
    lines : ndarray of int, shape (e, 2)
        Of vertices, drawn upon it: the grid of a field of heights.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    is_endless: bool = False
    lines: np.ndarray = NO_LINES


def outline(shape: SurfaceShape) -> Outline | None:
    """Return the triangles of a shape; None: it is not known what one of the user looks like.

    Examples
    --------
    >>> import kanefe as kf
    >>> outline(kf.shapes.Box((1, 2, 3))).vertices.max(axis=0)
    array([0.5, 1. , 1.5])
    """
    if isinstance(shape, Plane):
        square = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])
        return Outline(square @ axes_about(shape.normal).T, np.array([(0, 1, 2), (0, 2, 3)]), is_endless=True)
    if isinstance(shape, Sphere):
        return _turned(_arc(shape.radius, 0.0), np.array((0.0, 0.0, 1.0)))
    if isinstance(shape, Capsule):
        return _turned(_arc(shape.radius, shape.length), shape.axis)
    if isinstance(shape, Cylinder):
        half, r = 0.5 * shape.length, shape.radius
        return _turned(np.array([(0.0, -half), (r, -half), (r, half), (0.0, half)]), shape.axis)
    if isinstance(shape, Torus):
        angles = np.linspace(0.0, 2.0 * np.pi, AROUND // 2 + 1)
        ring = np.column_stack((shape.radius + shape.tube * np.cos(angles), shape.tube * np.sin(angles)))
        return _turned(ring, shape.axis)
    if isinstance(shape, Box):
        return _box(0.5 * shape.size)
    if isinstance(shape, Mesh | Look):
        return Outline(np.asarray(shape.vertices), np.asarray(shape.triangles))
    if isinstance(shape, HeightField):
        return _heights(shape)
    if isinstance(shape, Points):
        return _spots(shape.points, shape.radius or POINT)
    return None


def _arc(radius: float, length: float, around: int = AROUND) -> Matrix:
    """Return radius and height of the half circle of a ball, its halves apart by a length."""
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, around // 2 + 1)
    profile = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    middle = len(profile) // 2
    apart = np.array((0.0, 0.5 * length))
    parts = profile[: middle + 1] - apart, profile[middle:] + apart
    return np.vstack(parts) if length > 0.0 else profile


def _turned(profile: Matrix, axis: Vector, around: int = AROUND) -> Outline:
    """Return what a profile of radius and height (n, 2) becomes that goes round an axis."""
    angles = np.arange(around) * (2.0 * np.pi / around)
    circle = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(around)))
    places = profile[:, None, :1] * circle + profile[:, None, 1:] * np.array((0.0, 0.0, 1.0))
    rows, columns = np.meshgrid(np.arange(len(profile) - 1), np.arange(around), indexing="ij")
    a, b = rows * around + columns, rows * around + (columns + 1) % around
    on_axis = profile[:, 0] < 1e-9 * profile[:, 0].max()  # where one of two triangles has no area
    low = np.stack((a, b, b + around), axis=-1)[~on_axis[:-1]]
    high = np.stack((a, b + around, a + around), axis=-1)[~on_axis[1:]]
    triangles = np.concatenate((low.reshape(-1, 3), high.reshape(-1, 3)))
    # on the axis all columns are one place, and the profile of a ring ends where it begins
    rounded = np.round(places.reshape(-1, 3) / np.abs(places).max(), 9) + 0.0
    _, first, same = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return Outline(places.reshape(-1, 3)[first] @ axes_about(axis).T, same.ravel()[triangles])


def _box(half: Vector) -> Outline:
    signs = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return Outline(signs * half, np.array([(a, b, c) for a, b, c, _ in faces] + [(a, c, d) for a, _, c, d in faces]))


def _heights(shape: HeightField) -> Outline:
    """Return the surface at the places of its grid, and between them where the grid is coarse."""
    finer = min(max(int((MOST_VERTICES / shape.heights.size) ** 0.5), 1), FINEST)
    x, y = (np.interp(np.arange(finer * (len(p) - 1) + 1) / finer, np.arange(len(p)), p) for p in (shape.x, shape.y))
    m, n = len(x), len(y)
    places = np.stack((*np.meshgrid(x, y, indexing="ij"), heights_at(shape, x, y)), axis=-1)
    numbers = np.arange(m * n).reshape(m, n)
    a = numbers[:-1, :-1].ravel()
    triangles = np.concatenate((np.column_stack((a, a + n, a + n + 1)), np.column_stack((a, a + n + 1, a + 1))))
    along, across = numbers[:, ::finer].T, numbers[::finer]
    lines = [np.column_stack((rows[:, :-1].ravel(), rows[:, 1:].ravel())) for rows in (along, across)]
    return Outline(places.reshape(-1, 3), triangles, lines=np.concatenate(lines))


def _spots(centres: Matrix, radius: float) -> Outline:
    ball = _turned(_arc(radius, 0.0, AROUND_POINTS), np.array((0.0, 0.0, 1.0)), AROUND_POINTS)
    starts = len(ball.vertices) * np.arange(len(centres))
    places = (centres[:, None] + ball.vertices).reshape(-1, 3)
    return Outline(places, (starts[:, None, None] + ball.triangles).reshape(-1, 3))
