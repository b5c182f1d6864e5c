"""Surfaces of STL files that are closed but for round-off and triangles without area."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.contact.geometry.stl_repair import together

CUBE = 0.1 * np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4)]
FACES += [(1, 5, 7), (1, 7, 3)]


def write(path: Path, corners: np.ndarray, is_text: bool = False) -> Path:
    """Write triangles (m, 3, 3) to a binary file in single precision, or to a text with all digits."""
    if is_text:
        rows = ("outer loop " + " ".join(f"vertex {x!r} {y!r} {z!r}" for x, y, z in one.tolist()) for one in corners)
        path.write_text("solid a\n" + "\n".join(rows) + "\nendsolid a\n")
    else:
        facets = (bytes(12) + one.astype("<f4").tobytes() + bytes(2) for one in corners)
        path.write_bytes(bytes(80) + len(corners).to_bytes(4, "little") + b"".join(facets))
    return path


def volume(mesh: shapes.Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


@pytest.mark.parametrize("jitter", [1e-18, 1.7e-12, 5e-9])
@pytest.mark.parametrize("is_text", [False, True])
def test_vertices_that_differ_by_round_off_are_one(jitter: float, is_text: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    corners = CUBE[np.array(FACES)] + jitter * rng.choice((-0.5, 0.0, 0.5), (12, 3, 3))  # a step at 0.1 m is 7.5e-9 m
    mesh = shapes.Mesh.from_stl(write(tmp_path / "cube.stl", corners, is_text))
    assert mesh.vertices.shape == (8, 3)
    assert volume(mesh) == pytest.approx(1e-3, rel=1e-6)


def test_what_is_closed_keeps_its_vertices_and_what_is_open_stays_open(tmp_path: Path) -> None:
    corners = 1e-6 * CUBE[np.array(FACES)] + np.array((1.0, 0.0, 0.0))  # its vertices are within a step of 1 m
    assert len(together(corners.reshape(-1, 3))[0]) == 8
    corners = CUBE[np.array(FACES)]
    corners[0, 0] += 1e-7  # more than round-off
    with pytest.raises(kf.ModelError, match="not closed: 4 edges"):
        shapes.Mesh.from_stl(write(tmp_path / "open.stl", corners))


@pytest.mark.parametrize("vertices", [(0, 5, 0), (3, 3, 3)])
def test_triangles_with_equal_vertices_are_left_out(vertices: tuple[int, int, int], tmp_path: Path) -> None:
    mesh = shapes.Mesh.from_stl(write(tmp_path / "cube.stl", CUBE[np.array([*FACES, vertices])]))
    assert len(mesh.triangles) == 12
    assert volume(mesh) == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize("cuts", [1, 2, 5])
def test_a_neighbour_is_cut_where_a_triangle_on_a_line_was(cuts: int, tmp_path: Path) -> None:
    """The edge from 0 to 1 has `cuts` more vertices on one side; triangles without area close the gap as a fan."""
    line = list(range(8, 8 + cuts))
    points = np.vstack((CUBE, [CUBE[0] + (CUBE[1] - CUBE[0]) * (i + 1) / 8 for i in range(cuts)]))
    along = [0, *line, 1]
    split = [(a, b, 3) for a, b in pairwise(along)]
    fan = [(1, line[i], along[i]) for i in range(cuts)]
    mesh = shapes.Mesh.from_stl(write(tmp_path / "cube.stl", points[np.array([*FACES[1:], *split, *fan])], True))
    assert len(mesh.triangles) == 12 + 2 * cuts
    assert len(mesh.vertices) == 8 + cuts
    assert volume(mesh) == pytest.approx(1e-3, rel=1e-12)


def test_two_triangles_on_each_other_without_area_are_left_out(tmp_path: Path) -> None:
    points = np.vstack((CUBE, (0.0, 0.0, 0.05)))
    both = [(0, 1, 8), (1, 0, 8)]
    mesh = shapes.Mesh.from_stl(write(tmp_path / "cube.stl", points[np.array([*FACES, *both])], True))
    assert volume(mesh) == pytest.approx(1e-3, rel=1e-12)


def test_hulls_take_them_too(tmp_path: Path) -> None:
    hull = shapes.Convex.from_stl(write(tmp_path / "cube.stl", CUBE[np.array([*FACES, (0, 5, 0)])]))
    assert hull.vertices.shape == (8, 3)
