"""Split meshes: the same shape and groups, sides shared, cells as good, exact fields, and the orders of convergence."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import MIDS, measures, shape
from kanefe.fe_model.skin import skin
from kanefe_fem import Material, Mesh, box_mesh, cylinder_mesh, read_mesh, refined_mesh, solid_body, solid_model
from kanefe_fem.mesh.cell_splits import split_cell
from kanefe_fem.mesh.checks import check_mesh, is_straight
from kanefe_fem.mesh.mesh import to_order

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
BLOCK = (1.0, 0.3, 0.2)
PARTS = {"line": 2, "triangle": 4, "quad": 4, "tetra": 8, "hexahedron": 8, "wedge": 8, "pyramid": 10}


def size(blocks: tuple[Cells, ...], nodes: np.ndarray) -> float:
    """Length, area or volume of some cells."""
    return float(sum(measures(block.kind, nodes[block.nodes], 8)[0].sum() for block in blocks))


def one_cell(kind: str, bend: float) -> Mesh:
    """A single cell, bent by polynomials of the shape's own degree alone where it is of second order."""
    nodes = np.zeros((len(shape(kind).nodes), 3))
    nodes[:, : shape(kind).dimension] = shape(kind).nodes
    if shape(kind).order == 2:
        nodes[:, 0] += bend * nodes[:, 1] ** 2
    table = (Cells(kind, np.arange(len(nodes))[None]),)
    dimension = shape(kind).dimension
    return Mesh(
        nodes, dimension, {"body": table} if dimension > 1 else {}, lines={"span": table} if dimension == 1 else {}
    )


def blocks_of(mesh: Mesh) -> tuple[Cells, ...]:
    return mesh.cell_blocks or mesh.lines["span"]


@pytest.mark.parametrize("kind", MIDS)
def test_parts_fill_their_cell(kind: str):
    """Their number, sizes and sides: the skin of the parts has the area of that of the cell, so all others are shared.

    A parabola is in the space of every shape of second order and, under the rational functions of a pyramid, of
    its parts where the base is flat.
    """
    mesh = one_cell(kind, 0.2 if shape(kind).corner_kind != "pyramid" else 0.0)
    fine = refined_mesh(mesh)
    parts = blocks_of(fine)
    assert sum(len(block.nodes) for block in parts) == PARTS[shape(kind).corner_kind]
    assert {shape(block.kind).order for block in parts} == {shape(kind).order}
    whole = size(blocks_of(mesh), mesh.nodes)
    assert size(parts, fine.nodes) == pytest.approx(whole, rel=1e-12)
    assert np.array_equal(fine.nodes[: len(mesh.nodes)], mesh.nodes)
    distances = np.linalg.norm(fine.nodes[:, None] - fine.nodes[None], axis=2) + np.eye(len(fine.nodes))
    assert distances.min() > 0.05  # no node twice
    if mesh.dimension > 1:
        assert np.isin(np.arange(len(fine.nodes)), fine.body_nodes).all()
        assert size(skin(parts), fine.nodes) == pytest.approx(size(skin(mesh.cell_blocks), mesh.nodes), rel=1e-9)
        check_mesh(fine)  # positive Jacobians, sides that fit


@pytest.mark.parametrize("order", [1, 2])
def test_mixed_cells_fit_and_take_linear_fields(order: int):
    """The patch test: K times the nodal values of a linear field is zero inside a random mesh of all solids."""
    places = np.array([(x, y, z) for x in range(4) for y in range(2) for z in range(2)], dtype=float)
    nodes = np.vstack((places, [[2.5, 0.5, 0.5]])) + 0.05 * np.random.default_rng(3).uniform(-1, 1, (17, 3))
    nodes[-1] = nodes[8:16].mean(axis=0)
    brick = np.array([[0, 4, 6, 2, 1, 5, 7, 3]]) + 4 * np.arange(3)[:, None]
    wedges = brick[1][[[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]]
    faces = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
    pyramids = np.array([[*brick[2][list(face)], 16] for face in faces])
    cells = (Cells("hexahedron", brick[:1]), Cells("wedge", wedges), Cells("pyramid", pyramids))
    mesh = to_order(check_mesh(Mesh(nodes, 3, {"body": cells})), order)
    fine = check_mesh(refined_mesh(mesh))
    assert set(fine.kinds) == {*mesh.kinds, "tetra" if order == 1 else "tetra10"}
    model = solid_model(fine, STEEL, order=order)
    A = np.random.default_rng(4).normal(size=(3, 3))
    forces = (model.stiffness @ (model.nodes @ A.T).ravel()).reshape(-1, 3)
    outside = np.zeros(len(model.nodes), dtype=bool)
    for block in skin(model.cells):
        outside[block.nodes] = True
    assert (~outside).sum() > 5
    assert np.abs(forces[~outside]).max() < 1e-11 * np.abs(forces).max()


def test_curves_stay_and_groups_keep_their_parts():
    mesh = cylinder_mesh(0.2, 0.05, (2, 2, 8), order=2)
    mesh = replace(mesh, points={"corner": np.array([3])}, lines={"rim": (Cells("line3", _rim(mesh)),)})
    fine = refined_mesh(mesh, 2)
    assert fine.cell_count == 64 * mesh.cell_count
    assert not is_straight(fine)
    assert size(fine.cell_blocks, fine.nodes) == pytest.approx(size(mesh.cell_blocks, mesh.nodes), rel=1e-10)
    for name, blocks in mesh.facets.items():
        # the area of a curved facet is not a polynomial: the quadrature of one large facet is within 1e-5
        assert size(fine.facets[name], fine.nodes) == pytest.approx(size(blocks, mesh.nodes), rel=1e-5)
        assert np.isin(
            fine.facets[name][0].nodes, np.concatenate([b.nodes.ravel() for b in skin(fine.cell_blocks)])
        ).all()
    assert len(fine.lines["rim"][0].nodes) == 4 * len(mesh.lines["rim"][0].nodes)
    assert np.isin(fine.lines["rim"][0].nodes, fine.body_nodes).all()
    assert np.array_equal(fine.points["corner"], [3])
    parents = mesh.nodes[mesh.connectivity].mean(axis=1)
    children = refined_mesh(mesh).connectivity.reshape(mesh.cell_count, 8, -1)
    middles = refined_mesh(mesh).nodes[children].mean(axis=(1, 2))
    assert np.abs(middles - parents).max() < 2e-3  # parts follow their cell


def _rim(mesh: Mesh) -> np.ndarray:
    facet = mesh.facets["root"][0].nodes
    return np.asarray(facet[:, [0, 1, 4]])


def test_tetrahedra_stay_as_good_as_they_are():
    """The shortest diagonal: the worst angle stays bounded however often cells are split (Bey 1995)."""
    mesh = replace(box_mesh((1.0, 0.7, 0.4), (2, 2, 2), "tetra"), facets={}, lines={})
    nodes = mesh.nodes + 0.05 * np.random.default_rng(5).uniform(-1, 1, mesh.nodes.shape)
    mesh = replace(mesh, nodes=nodes)

    def worst(of: Mesh) -> float:
        x = of.nodes[of.connectivity]
        edges = x[:, [1, 2, 3, 2, 3, 3]] - x[:, [0, 0, 0, 1, 1, 2]]
        volume = np.abs(np.linalg.det(edges[:, :3])) / 6.0
        return float((volume / np.linalg.norm(edges, axis=2).max(axis=1) ** 3).min())

    levels = [worst(refined_mesh(mesh, n)) for n in range(4)]
    assert levels[1] > 0.5 * levels[0]
    assert levels[3] == pytest.approx(levels[2], rel=1e-9)
    along = [worst(_all_along(mesh, diagonal)) for diagonal in range(3)]
    assert levels[1] > max(along)


def _all_along(mesh: Mesh, diagonal: int) -> Mesh:
    """The mesh split with one diagonal for all cells."""
    split = split_cell("tetra", diagonal)
    x = np.einsum("pn,mnx->mpx", shape("tetra").values(split.places), mesh.nodes[mesh.connectivity])
    table = (np.arange(len(x))[:, None, None] * len(split.places) + split.parts[0][1]).reshape(-1, 4)
    return Mesh(x.reshape(-1, 3), 3, {"body": (Cells("tetra", table),)})


@cache
def nearly_exact() -> np.ndarray:
    """Frequencies of the block, Hz, to 1e-6: a tenth of the smallest error that is looked at."""
    fine = solid_body(box_mesh(BLOCK, (16, 6, 4), "hexahedron"), STEEL, {}, kf.FreeInterface(modes=3), cache=False)
    return fine.frequencies[:3]


@pytest.mark.fenicsx
@pytest.mark.parametrize(("kind", "order"), [("tetra", 1), ("tetra", 2), ("hexahedron", 1), ("hexahedron", 2)])
def test_frequencies_converge_at_the_order_of_the_cells(kind: str, order: int):
    """Errors of the frequencies of a free block fall with h^2 and h^4; a clamped face would have a singularity."""
    free = kf.FreeInterface(modes=3)
    counts = (4, 2, 2) if order == 1 else (3, 1, 1)
    body = solid_body(box_mesh(BLOCK, counts, kind), STEEL, {}, free, order=order, cache=False)
    errors = np.array([body.rebuilt(refined=n).frequencies[:3] - nearly_exact() for n in (1, 2)])
    orders = np.log2(errors[0] / errors[1])
    # from below, as the cells are still coarse: on one level more the orders of tetrahedra are 1.93 and 3.88
    assert orders[0] > (1.7 if order == 1 else 3.6)


@pytest.mark.gmsh
@pytest.mark.parametrize("seed", [1, 2])
def test_random_meshes_keep_volume_areas_and_fit(seed: int, tmp_path):
    pytest.importorskip("gmsh")
    x, y = np.random.default_rng(seed).uniform(0.4, 0.6, 2)
    path = tmp_path / "plate.geo"
    path.write_text(
        'SetFactory("OpenCASCADE"); Mesh.MeshSizeMax = 0.4; Mesh.MeshSizeFromCurvature = 10;\n'
        f"Box(1) = {{0, 0, 0, 1, 1, 0.3}}; Cylinder(2) = {{{x}, {y}, 0, 0, 0, 0.3, 0.25}};\n"
        "BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };\n"
        'Physical Volume("body") = {3}; Physical Surface("all") = Boundary{ Volume{3}; };\n'
    )
    mesh = read_mesh(path, order=2)
    fine = check_mesh(refined_mesh(mesh))
    assert fine.cell_count == 8 * mesh.cell_count
    assert size(fine.cell_blocks, fine.nodes) == pytest.approx(size(mesh.cell_blocks, mesh.nodes), rel=1e-10)
    assert sum(len(b.nodes) for b in skin(fine.cell_blocks)) == 4 * sum(len(b.nodes) for b in skin(mesh.cell_blocks))
    for name, blocks in mesh.facets.items():
        assert size(fine.facets[name], fine.nodes) == pytest.approx(size(blocks, mesh.nodes), rel=1e-3)


def test_what_cannot_be_split_is_refused():
    mesh = box_mesh((1.0, 1.0, 1.0), (1, 1, 1), "hexahedron")
    for times in (-1, True, 13):
        with pytest.raises(ModelError, match="times="):
            refined_mesh(mesh, times)
    with pytest.raises(ModelError, match="GiB"):
        refined_mesh(mesh, 12)
    # two tetrahedra whose common side has two nodes in its middle
    nodes = np.vstack((np.eye(3), [[0, 0, 0], [1, 1, 1]]))
    lifted = to_order(Mesh(nodes, 3, {"a": (Cells("tetra", np.array([[0, 1, 2, 3], [0, 2, 1, 4]])),)}), 2)
    table = lifted.connectivity.copy()
    shared = np.intersect1d(*table[:, 4:])[0]
    table[1][table[1] == shared] = len(lifted.nodes)
    open_side = replace(
        lifted,
        nodes=np.vstack((lifted.nodes, lifted.nodes[shared] + 0.01)),
        cells={"a": (Cells("tetra10", table),)},
    )
    with pytest.raises(MeshError, match="do not share the side"):
        refined_mesh(open_side)
