"""How solids of the current model of gmsh lie to each other, and their surfaces as triangles. Lengths in mm."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.fe_model.shapes import quadrature, shape
from kanefe_fem import _gmsh

TRIANGLE6 = 9
"""Number of gmsh for triangles of order 2."""

AROUND = 12
"""Number of triangles around a full turn of a curved surface."""


def common_volume(gmsh: Any, one: int, other: int) -> float | None:
    """Return the volume that two solids have in common; None where OpenCASCADE fails, as on faces that coincide."""
    try:
        found, _ = gmsh.model.occ.intersect([(3, one)], [(3, other)], removeObject=False, removeTool=False)
        volume = sum(float(gmsh.model.occ.getMass(d, tag)) for d, tag in found if d == 3)
        gmsh.model.occ.remove(found, recursive=True)
        gmsh.model.occ.synchronize()
    except Exception:  # noqa: BLE001 - gmsh raises bare Exception
        return None
    return volume


class Surface(NamedTuple):
    """The surface of a solid as triangles, and what it encloses by triangles of order 2, which follow curved faces.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
        mm.
    triangles : ndarray of int, shape (m, 3)
        Counterclockwise from outside.
    volume : float
        mm^3.
    centre : ndarray, shape (3,)
        Of volume, mm.
    moments : ndarray, shape (3, 3)
        Inertia about the centre at density one, mm^5.
    """

    points: np.ndarray
    triangles: np.ndarray
    volume: float
    centre: np.ndarray
    moments: np.ndarray


def surfaces_of(gmsh: Any, size: float) -> dict[int, Surface]:
    """Return the surface of each solid, with sides of at most a size, and smaller ones on curved faces."""
    gmsh.option.setNumber("Mesh.CharacteristicLengthMax", size)
    gmsh.option.setNumber("Mesh.CharacteristicLengthMin", size / AROUND)
    _gmsh.set_per_turn(gmsh, AROUND)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(max(tags, default=0)) + 1, dtype=np.int64)
    row[np.asarray(tags, dtype=np.int64)] = np.arange(len(tags))
    points = np.reshape(coordinates, (-1, 3))
    found = {}
    for _, solid in gmsh.model.getEntities(3):
        faces = [np.zeros((0, 6), dtype=np.int64)]
        for _, face in gmsh.model.getBoundary([(3, solid)], combined=False, oriented=False):
            kinds, _, nodes = gmsh.model.mesh.getElements(2, face)
            for kind, ids in zip(kinds, nodes, strict=True):
                if kind == TRIANGLE6:
                    faces.append(_outward(gmsh, face, points, row[np.reshape(np.asarray(ids, np.int64), (-1, 6))]))
        cells = np.concatenate(faces)
        used, inverse = np.unique(cells[:, :3], return_inverse=True)
        found[int(solid)] = Surface(points[used], np.reshape(inverse, (-1, 3)), *_enclosed(points[cells]))
    return found


def _outward(gmsh: Any, face: int, points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the triangles of a face, turned where the normal of the face, which is outward, is against theirs."""
    a, b, c = (points[triangles[0, i]] for i in range(3))
    low, high = gmsh.model.getParametrizationBounds(2, face)
    n = 24
    u, v = np.meshgrid(*(p + (q - p) * (np.arange(n) + 0.5) / n for p, q in zip(low, high, strict=True)))
    places = np.column_stack([u.ravel(), v.ravel()]).ravel()
    there = np.reshape(gmsh.model.getValue(2, face, places), (-1, 3))
    nearest = int(np.argmin(np.linalg.norm(there - (a + b + c) / 3.0, axis=1)))
    normal = np.array(gmsh.model.getNormal(face, places[2 * nearest : 2 * nearest + 2]))
    return triangles if np.cross(b - a, c - a) @ normal > 0.0 else triangles[:, [0, 2, 1, 5, 4, 3]]


def _enclosed(nodes: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return volume, centre and inertia that triangles of six nodes (m, 6, 3) enclose, by the divergence theorem.

    The integral of a function f of degree k over the volume is that of f x.n / (k + 3) over the surface.
    """
    if not len(nodes):
        return 0.0, np.zeros(3), np.zeros((3, 3))
    element = shape("triangle6")
    places, weights = quadrature("triangle6", 6)
    middle = nodes[:, :3].mean(axis=(0, 1))
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for value, gradient, weight in zip(element.values(places), element.gradients(places), weights, strict=True):
        x = np.einsum("mnx,n->mx", nodes - middle, value)
        tangents = np.einsum("mnx,na->max", nodes, gradient)
        flux = weight * np.einsum("mx,mx->m", x, np.cross(tangents[:, 0], tangents[:, 1]))
        volume += float(flux.sum()) / 3.0
        first += flux @ x / 4.0
        second += np.einsum("m,mi,mj->ij", flux, x, x) / 5.0
    offset = first / volume if volume else np.zeros(3)
    second -= volume * np.outer(offset, offset)
    return volume, middle + offset, np.eye(3) * np.trace(second) - second
