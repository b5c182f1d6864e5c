"""One shape of each kind that contacts can touch, of about 1 m."""

from __future__ import annotations

import numpy as np

from kanefe import shapes


def ball_mesh(rings: int = 5, sectors: int = 8, radius: float = 0.7) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles of a ball of rings between two poles, with a dent."""
    height, turn = np.pi * np.arange(1, rings + 1) / (rings + 1), 2.0 * np.pi * np.arange(sectors) / sectors
    rows = [(np.sin(h) * np.cos(t), np.sin(h) * np.sin(t), np.cos(h)) for h in height for t in turn]
    vertices = radius * np.array([*rows, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)])
    vertices[sectors] *= 0.6
    top, bottom = len(rows), len(rows) + 1
    triangles = []
    for j in range(sectors):
        k = (j + 1) % sectors
        triangles.append((top, j, k))
        triangles.append((bottom, (rings - 1) * sectors + k, (rings - 1) * sectors + j))
        for i in range(rings - 1):
            a, b = i * sectors, (i + 1) * sectors
            triangles += [(a + j, b + j, b + k), (a + j, b + k, a + k)]
    return vertices, np.array(triangles)


GRID = np.linspace(-1.0, 1.0, 9)
HILLS = 0.1 * np.outer(np.sin(2.0 * GRID), np.cos(GRID))

TOUCHED = {
    "plane": shapes.Plane((0.2, -0.1, 1.0)),
    "sphere": shapes.Sphere(0.7),
    "room of a sphere": shapes.Sphere(0.9, inside=True),
    "capsule": shapes.Capsule(0.5, 0.8, axis=(1.0, 0.3, 0.0)),
    "cylinder": shapes.Cylinder(0.6, 1.0),
    "room of a cylinder": shapes.Cylinder(0.9, 1.4, inside=True),
    "box": shapes.Box((1.1, 1.0, 0.9)),
    "room of a box": shapes.Box((1.4, 1.5, 1.6), inside=True),
    "torus": shapes.Torus(0.5, 0.3, axis="z"),
    "mesh": shapes.Mesh(*ball_mesh()),
    "hills": shapes.HeightField(GRID, GRID, HILLS),
}
