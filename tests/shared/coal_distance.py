"""How convex shapes are to each other by coal, or by hpp-fcl, its older name (GJK, EPA): an oracle."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.contact.geometry.convex import Convex
from kanefe.contact.geometry.shape import axes_about
from kanefe.contact.shapes import Box, Capsule, Cylinder, Sphere
from kanefe.frames import Matrix, Vector

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import SurfaceShape

TOLERANCE = 1e-13
"""Tolerance of the search for the nearest points, m: outside the shapes the result is accurate to round-off."""
MOST_TRIALS = 1000

BEYOND = 1e-3
"""Distance by which penetrating shapes are moved apart, relative to the size of the larger one."""

MOST_TURNS, SAME_NORMAL = 30, 1e-8
"""Largest number of iterations and tolerance of the normal. Each iteration reduces the error of the normal by the depth
over the radius of curvature, and its square enters the depth."""

_geometries: WeakKeyDictionary[SurfaceShape, Any] = WeakKeyDictionary()


@cache
def _library() -> Any:
    try:
        import coal
    except ImportError:
        import hppfcl

        return hppfcl
    return coal


def nearest(one: SurfaceShape, rotation: Matrix, place: Vector, other: SurfaceShape) -> tuple[float, Vector, Vector]:
    """Return how far a convex shape is from another, m, the normal away from the other, and the place between them.

    Parameters
    ----------
    one, other : SurfaceShape
        Spheres, capsules, cylinders, boxes, `Convex`.
    rotation, place : ndarray, shapes (3, 3) and (3,)
        Of the axes of `one` in those of the other, in which the results are.
    """
    gap, normal, point = _asked(one, rotation, place, other)
    if gap > 0.0:
        return gap, normal, point
    # Within each other they are found to some digits alone. Moved apart along the normal, to round-off: where the
    # normal is then the same, it is that of the least depth, and the gap tells how deep they were.
    aside = BEYOND * max(one.bounds.size, other.bounds.size)
    for _ in range(MOST_TURNS):
        way = (aside - gap) * normal
        left, turned, between = _asked(one, rotation, place + way, other)
        if left <= 0.0:
            break
        is_found = float(np.linalg.norm(turned - normal)) < SAME_NORMAL
        gap, normal = left - (aside - gap), turned
        if is_found:
            return gap, normal, between - 0.5 * way
    return gap, normal, point


def _asked(one: SurfaceShape, rotation: Matrix, place: Vector, other: SurfaceShape) -> tuple[float, Vector, Vector]:
    """Return the same as the library has it."""
    of = _library()
    (a, turned_a, middle_a), (b, turned_b, middle_b) = _geometry(of, one), _geometry(of, other)
    pose = of.Transform3f if of.__name__ == "hppfcl" else of.Transform3s
    request, found = of.DistanceRequest(), of.DistanceResult()
    request.gjk_tolerance, request.gjk_max_iterations = TOLERANCE, MOST_TRIALS
    if of.__name__ == "hppfcl":
        request.enable_nearest_points = True
    else:
        request.epa_tolerance, request.epa_max_iterations = TOLERANCE, MOST_TRIALS
    gap = of.distance(a, pose(rotation @ turned_a, place), b, pose(turned_b, np.zeros(3)), request, found)
    at_one, at_other = np.array(found.getNearestPoint1()), np.array(found.getNearestPoint2())
    normal = np.array(found.normal)
    # its sign differs from version to version: that which leads from the middle of one to that of the other
    apart = (place + rotation @ middle_a - at_one) - (middle_b - at_other)
    return float(gap), normal if normal @ apart >= 0.0 else -normal, 0.5 * (at_one + at_other)


def _geometry(of: Any, shape: SurfaceShape) -> tuple[Any, Matrix, Vector]:
    """Return a shape of the library, how it is turned, and a place in it."""
    if shape not in _geometries:
        turned, middle = np.eye(3), np.zeros(3)
        if isinstance(shape, Sphere):
            made = of.Sphere(shape.radius)
        elif isinstance(shape, Box):
            made = of.Box(*map(float, shape.size))
        elif isinstance(shape, (Capsule, Cylinder)):
            turned = axes_about(shape.axis)
            made = (of.Capsule if isinstance(shape, Capsule) else of.Cylinder)(shape.radius, shape.length)
        elif isinstance(shape, Convex):
            middle = shape.vertices.mean(axis=0)
            points = of.StdVec_Vec3f() if of.__name__ == "hppfcl" else of.StdVec_Vec3s()
            triangles = of.StdVec_Triangle()
            points.extend(list(shape.vertices))
            triangles.extend([of.Triangle(*map(int, corners)) for corners in shape.triangles])
            made = of.Convex(points, triangles)
        else:
            raise TypeError(f"{shape.title} is not convex")
        _geometries[shape] = made, turned, middle
    return _geometries[shape]  # type: ignore[no-any-return]
