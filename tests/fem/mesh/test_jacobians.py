"""The Jacobian is bounded inside cells: those that fold between their nodes are refused, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.errors import MeshError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import quadrature, shape
from kanefe_fem.mesh.checks import check_mesh
from kanefe_fem.mesh.jacobians import folded_inside
from kanefe_fem.mesh.mesh import Mesh

KINDS = ["quad9", "tetra10", "hexahedron", "hexahedron20", "hexahedron27", "wedge15", "wedge18", "pyramid", "pyramid13"]


def grid(kind: str) -> np.ndarray:
    """Points all over a reference cell, its boundary included."""
    element = shape(kind)
    steps = [np.linspace(0, 1, 11)] * element.dimension
    points = np.stack(np.meshgrid(*steps, indexing="ij"), -1).reshape(-1, element.dimension)
    if element.corner_kind == "pyramid":
        points[:, 2] = np.minimum(points[:, 2], 1 - 1e-9)  # the gradients have no limit at the apex
        points[:, :2] = (2 * points[:, :2] - 1) * (1 - points[:, 2:])
        return points
    flat = element.dimension if element.is_simplex else 2 if element.corner_kind == "wedge" else 0
    return points[points[:, :flat].sum(axis=1) < 1 + 1e-9]


def seen(kind: str) -> np.ndarray:
    """Points that are looked at first: nodes, of a pyramid points of quadrature."""
    element = shape(kind)
    return quadrature(kind, 2 * element.order)[0] if element.corner_kind == "pyramid" else np.array(element.nodes)


def determinants(kind: str, cells: np.ndarray, points: np.ndarray) -> np.ndarray:
    gradients = np.array(list(shape(kind).gradients(points)))
    return np.asarray(np.linalg.det(np.einsum("knx,pni->kpxi", cells, gradients)))


@pytest.mark.parametrize("kind", KINDS)
def test_folds_between_nodes_are_found(kind: str) -> None:
    rng = np.random.default_rng(4)
    nodes = np.array(shape(kind).nodes)
    spread = 0.13 if shape(kind).order == 2 else 0.35
    cells = nodes + spread * rng.uniform(-1, 1, (400, *nodes.shape))
    cells = cells[determinants(kind, cells, seen(kind)).min(axis=1) > 0]
    found = folded_inside(kind, cells, 1e-12)
    least = determinants(kind, cells, grid(kind)).min(axis=1)
    assert not (found & (least > 0.02)).any()  # what the grid misses is small
    assert found[least <= 0].all()
    if kind in ("hexahedron27", "wedge18", "pyramid13"):
        assert 5 < found.sum() < 0.2 * len(cells)


def test_affine_and_straight_cells_are_none() -> None:
    for kind in KINDS:
        nodes = np.array(shape(kind).nodes)
        turn = np.eye(nodes.shape[1]) + 0.4 * np.tri(nodes.shape[1], k=-1)
        assert not folded_inside(kind, (nodes @ turn)[None], 1e-12).any()


@pytest.mark.parametrize("kind", ["hexahedron27", "pyramid13"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_folded_cell_is_refused(kind: str, mirrored: bool) -> None:
    rng = np.random.default_rng(0)
    element, refused = shape(kind), 0
    for _ in range(25):
        nodes = np.array(element.nodes, dtype=float)
        nodes[element.corners :] += 0.16 * rng.uniform(-1, 1, (len(nodes) - element.corners, 3))
        low = determinants(kind, nodes[None], np.vstack((seen(kind), grid(kind)))).min()
        at_nodes = determinants(kind, nodes[None], seen(kind)).min()
        if mirrored:
            nodes[:, 0] *= -1.0
        mesh = Mesh(nodes, 3, {"body": (Cells(kind, np.arange(len(nodes))[None]),)})
        if low <= 0.0:
            refused += at_nodes > 0.0
            with pytest.raises(MeshError, match="changes its sign inside cell 0"):
                check_mesh(mesh)
        elif low > 0.05:
            check_mesh(mesh)
    assert refused > 0
