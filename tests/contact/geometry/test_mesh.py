"""Meshes of triangles that things touch: distances, the tree, files, and meshes that are refused."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.kernels.contact.contact_mesh import Mesh, mesh_distance, on_triangle
from kanefe.kernels.values.tensors import Vector
from touched_shapes import ball_mesh

CUBE = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.4, 0.4) for z in (-0.3, 0.3)])
FACES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
     (1, 5, 7), (1, 7, 3)]
)  # fmt: skip


def brute_distance(mesh: shapes.Mesh, x: np.ndarray) -> tuple[float, np.ndarray]:
    """Return distance and direction from the nearest of all places of all triangles; the sign is that of the place.

    A place on a triangle is the nearest of its plane, where that is within, and else the nearest of its sides.
    """
    best, found, solid = np.inf, x, 0.0
    for a, b, c in mesh.vertices[mesh.triangles]:
        for p, q in ((a, b), (b, c), (c, a)):
            foot = p + np.clip((x - p) @ (q - p) / ((q - p) @ (q - p)), 0.0, 1.0) * (q - p)
            if np.linalg.norm(x - foot) < best:
                best, found = float(np.linalg.norm(x - foot)), foot
        n = np.cross(b - a, c - a)
        foot = x - (x - a) @ n / (n @ n) * n
        shares = [np.cross(q - p, foot - p) @ n for p, q in ((a, b), (b, c), (c, a))]
        if min(shares) >= 0.0 and np.linalg.norm(x - foot) < best:
            best, found = float(np.linalg.norm(x - foot)), foot
        # the solid angle of a triangle (Van Oosterom & Strackee 1983): in sum 4 pi within, 0 without
        u, v, w = a - x, b - x, c - x
        p, q, r = (np.linalg.norm(side) for side in (u, v, w))
        solid += 2.0 * np.arctan2(u @ np.cross(v, w), p * q * r + (u @ v) * r + (u @ w) * q + (v @ w) * p)
    sign = -1.0 if solid > 2.0 * np.pi else 1.0
    return sign * best, sign * (x - found) / best


def test_a_mesh_of_a_box_is_as_far_as_the_box():
    mesh, box = shapes.Mesh(CUBE, FACES), shapes.Box((1.0, 0.8, 0.6))
    for x in np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3)):
        ours, theirs = mesh.distance(x), box.distance(x)
        assert ours[0] == pytest.approx(theirs[0], rel=1e-12)
        np.testing.assert_allclose(ours[1], theirs[1], atol=1e-12)


def test_places_on_vertices_and_edges_have_a_normal():
    mesh = shapes.Mesh(CUBE, FACES)
    for x in (CUBE[3], 0.5 * (CUBE[0] + CUBE[1]), 0.5 * (CUBE[0] + CUBE[3])):
        distance, normal = mesh.distance(x)
        assert distance == 0.0
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        assert normal @ x > 0.0


def test_the_tree_finds_the_nearest_and_looks_at_few(monkeypatch):
    """Of 2,400 triangles some tens are looked at for a place near the mesh."""
    mesh = shapes.Mesh(*ball_mesh(rings=30, sectors=40))
    numbers, looked = Mesh(mesh.listed), []
    module = mesh_distance.__globals__

    def counted(*arguments):
        looked.append(1)
        return on_triangle(*arguments)

    monkeypatch.setitem(module, "on_triangle", counted)
    for x in np.random.default_rng(2).standard_normal((4, 3)):
        x *= 0.72 / np.linalg.norm(x)
        found = mesh_distance(numbers, Vector(*x))
        distance, normal = brute_distance(mesh, x)
        np.testing.assert_allclose(
            (found.gap, *found.normal), (distance, *normal), rtol=1e-9, atol=1e-11
        )  # directions over a small distance
    assert len(mesh.triangles) == 2400
    assert len(looked) / 4 < 100


def test_a_ball_rests_on_a_mesh():
    scene = kf.System(gravity=(0, 0, -9.81))
    block = scene.add_surface("block", scene.ground, shapes.Mesh(CUBE, FACES))
    ball = scene.add_rigid_body("ball", 1.0, 0.4e-2, joint=kf.Free(position=(0.1, 0.1, 0.4)))
    skin = scene.add_surface("skin", ball, shapes.Sphere(0.1))
    scene.add_contact("c", skin, block, normal=kf.HuntCrossley(1e5, damping=5.0), friction=kf.Coulomb(0.5))
    assert scene.simulate((0.0, 0.5)).position("ball")[-1, 2] == pytest.approx(0.4 - 9.81e-5, abs=1e-7)


@pytest.mark.parametrize("is_text", [False, True])
def test_files_are_read(tmp_path, is_text):
    path, corners = tmp_path / "cube.stl", CUBE[FACES].astype("<f4")
    if is_text:
        facets = (
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}\n" for p in corner)
            + "endloop\nendfacet\n"
            for corner in corners
        )
        path.write_text("solid cube\n" + "".join(facets) + "endsolid cube\n")
    else:
        facets = (bytes(12) + corner.tobytes() + bytes(2) for corner in corners)
        path.write_bytes(b"cube".ljust(80) + len(corners).to_bytes(4, "little") + b"".join(facets))
    mesh = shapes.Mesh.from_stl(path, scale=2.0)
    assert mesh.vertices.shape == (8, 3)
    assert mesh.distance((0.0, 0.0, 0.7))[0] == pytest.approx(0.1, rel=1e-6)


def test_what_is_refused_by_name(tmp_path):
    with pytest.raises(kf.ModelError, match=r"not closed: 3 edges have no triangle on their other side"):
        shapes.Mesh(CUBE, FACES[:-1])
    with pytest.raises(kf.ModelError, match=r"not closed: .* 3 have two on one"):
        shapes.Mesh(CUBE, np.vstack((FACES[:-1], FACES[-1:, ::-1])))
    with pytest.raises(kf.ModelError, match=r"inside out: its volume is -0\.48 m3\. Remedy: .*triangles\[:, ::-1\]"):
        shapes.Mesh(CUBE, FACES[:, ::-1])
    with pytest.raises(kf.ModelError, match=r"1 of 13 triangles of a mesh have no area"):
        shapes.Mesh(CUBE, np.vstack((FACES, [(0, 1, 1)])))
    with pytest.raises(kf.ModelError, match="none of its 8"):
        shapes.Mesh(CUBE, FACES + 1)
    with pytest.raises(kf.ModelError, match="triangles of a mesh must be whole numbers"):
        shapes.Mesh(CUBE, FACES + 0.5)
    with pytest.raises(kf.ModelError, match="vertices of a mesh must be finite"):
        shapes.Mesh(np.full((4, 3), np.nan), FACES)
    (tmp_path / "no.stl").write_text("vertex one two three")
    with pytest.raises(kf.FileError, match="is not an STL file"):
        shapes.Mesh.from_stl(tmp_path / "no.stl")
    with pytest.raises(kf.FileError, match=r"there is no file .*none\.stl"):
        shapes.Mesh.from_stl(tmp_path / "none.stl")
