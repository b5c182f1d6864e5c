"""Surfaces of shells: sides made consistent, folds, triangles joined in pairs."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.errors import MeshError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import measures, shape
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import corner_normals, directors
from kanefe_fem.shells.orientation import consistent
from kanefe_fem.shells.pairs import of_nine_nodes
from shell_meshes import grid

NOTHING = np.zeros(0, dtype=int)


@pytest.mark.parametrize("kind", ["quad9", "triangle6"])
def test_cells_that_are_turned_are_turned_back(kind):
    block = grid("half cylinder", 6, 5, kind=kind).cell_blocks[0]
    nodes = grid("half cylinder", 6, 5, kind=kind).nodes
    rng = np.random.default_rng(3)
    wrong = rng.random(len(block.nodes)) < 0.3
    table = block.nodes.copy()
    table[wrong] = table[wrong][:, shape(kind).reversal()]
    (found,), turned = consistent([Cells(kind, table)], "a mesh")
    assert turned == wrong.sum()
    np.testing.assert_allclose(corner_normals(nodes, found).mean(axis=1), corner_normals(nodes, block).mean(axis=1))


def test_a_moebius_strip_is_refused():
    low, high = np.arange(12), 12 + np.arange(12)
    cells = [[low[i], low[i + 1], high[i + 1], high[i]] for i in range(11)] + [[low[11], high[0], low[0], high[11]]]
    with pytest.raises(MeshError, match=r"one side only, as a Moebius strip"):
        consistent([Cells("quad", np.array(cells))], "strip.msh")


def test_a_fold_has_a_director_for_each_side():
    for angle, sides in ((10.0, 1), (30.0, 2)):
        a = np.radians(angle)
        y = np.array([-1.0, 0.0, np.cos(a)])
        z = np.array([0.0, 0.0, np.sin(a)])
        mesh = Mesh(
            np.array([(x, y[i], z[i]) for i in range(3) for x in (0.0, 1.0)]),
            2,
            {"body": (Cells("quad", np.array([[0, 1, 3, 2], [2, 3, 5, 4]])),)},
        ).with_order(2)
        found = directors(np.asarray(mesh.nodes), mesh.cell_blocks, np.radians(20.0))
        assert len(found.node) == len(mesh.nodes) + 3 * (sides - 1)
        assert len(found.folded) == 3 * (sides - 1)
    one = found.normal[found.node == found.folded[0]]
    assert np.degrees(np.arccos(one[0] @ one[1])) == pytest.approx(30.0)


def test_triangles_are_joined_to_the_quadrangles_they_were_cut_from():
    mesh = grid("saddle", 5, 4, distort=0.1, kind="triangle6")
    nodes, blocks = of_nine_nodes(np.asarray(mesh.nodes), mesh.cell_blocks[0], NOTHING)
    assert [(block.kind, len(block.nodes)) for block in blocks] == [("quad9", 20)]
    whole = grid("saddle", 5, 4, distort=0.1)
    expected = measures("quad9", whole.nodes[whole.cell_blocks[0].nodes])[0].sum()
    assert measures("quad9", nodes[blocks[0].nodes])[0].sum() == pytest.approx(expected, rel=1e-5)
    centres = np.sort(nodes[blocks[0].nodes[:, 8]], axis=0)
    # the middle of sides of second order against the surface: fourth order of a cell of a fifth
    np.testing.assert_allclose(centres, np.sort(whole.nodes[whole.cell_blocks[0].nodes[:, 8]], axis=0), atol=2e-3)


def test_sides_of_groups_stay():
    mesh = grid("plate", 3, 3, kind="triangle6")
    block = mesh.cell_blocks[0]
    diagonal = block.nodes[0, 5]  # of the first triangle's third side
    _, blocks = of_nine_nodes(np.asarray(mesh.nodes), block, np.array([diagonal]))
    assert {one.kind: len(one.nodes) for one in blocks} == {"quad9": 8, "triangle6": 2}


def test_few_triangles_stay_alone():
    rng = np.random.default_rng(5)
    from scipy.spatial import Delaunay

    points = rng.random((150, 2))
    corners = Delaunay(points).simplices
    mesh = Mesh(points, 2, {"body": (Cells("triangle", corners),)}).with_order(2)
    (block,), _ = consistent(mesh.cell_blocks, "points")
    _, blocks = of_nine_nodes(np.asarray(mesh.nodes), block, NOTHING)
    left = {one.kind: len(one.nodes) for one in blocks}
    assert 2 * left["quad9"] + left["triangle6"] == len(corners)


def test_quadrangles_of_eight_nodes_get_a_ninth():
    mesh = grid("plate", 3, 2, distort=0.2)
    eight = Cells("quad8", mesh.cell_blocks[0].nodes[:, :8])
    nodes, (block,) = of_nine_nodes(np.asarray(mesh.nodes), eight, NOTHING)
    corners = nodes[block.nodes[:, :4]].mean(axis=1)
    np.testing.assert_allclose(nodes[block.nodes[:, 8]], corners, atol=1e-15)
