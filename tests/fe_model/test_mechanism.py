"""A body that can move without force is refused, and the nodes that move are named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import SingularStiffness
from kanefe.reduction import flexible_body
from scenes import lattice_model

CB = kf.CraigBampton(modes=2)
CLAMPED = {"root": "clamped", "tip": "rigid"}


def loosened(nodes: list[int]) -> kf.FiniteElementModel:
    """Return a lattice of which some nodes feel nothing along z."""
    model = lattice_model(1)
    free = np.ones(model.size)
    free[[3 * node + 2 for node in nodes]] = 0.0
    mask = sp.diags(free)
    return replace(model, stiffness=(mask @ model.stiffness @ mask).tocsr())


def inner_nodes() -> list[int]:
    model = lattice_model(1)
    held = np.concatenate([group.nodes for group in model.groups.values()])
    return [node for node in range(len(model.nodes)) if node not in held]


def test_a_loose_node_is_named() -> None:
    node = inner_nodes()[0]
    model = loosened([node])
    x, y, z = (f"{c:.4g}" for c in model.nodes[node])
    with pytest.raises(SingularStiffness, match="singular") as error:
        flexible_body(model, CLAMPED, reduction=CB)
    assert f"What moves without force: it is node {node} at ({x}, {y}, {z}) m" in str(error.value)


def test_a_sound_body_is_not_blamed() -> None:
    # the factors fail for another reason: nothing is found that moves without force
    def failing(matrix: sp.csc_matrix, /, *, definite: bool = True) -> object:
        raise RuntimeError("out of luck")

    with pytest.raises(SingularStiffness, match="out of luck") as error:
        flexible_body(lattice_model(1), CLAMPED, reduction=CB, factorise=failing)
    assert "What moves" not in str(error.value)


@pytest.mark.fenicsx
def test_parts_hinged_along_an_edge_are_named() -> None:
    from kanefe.fe_model.model import Cells
    from kanefe_fem import Material, solid_body
    from kanefe_fem.mesh.mesh import Mesh

    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    order = [0, 4, 6, 2, 1, 5, 7, 3]
    nodes, number = [], {}
    cells = []
    for shift in ((0, 0, 0), (1, 1, 0)):  # they share the edge from (1, 1, 0) to (1, 1, 1)
        for corner in (corners + shift)[order]:
            key = tuple(corner)
            if key not in number:
                number[key] = len(nodes)
                nodes.append(key)
        cells.append([number[tuple(corner)] for corner in (corners + shift)[order]])
    points = 0.1 * np.array(nodes)
    root = np.array([[number[0, 0, 0], number[0, 1, 0], number[0, 1, 1], number[0, 0, 1]]])
    mesh = Mesh(
        points, 3, {"body": (Cells("hexahedron", np.array(cells)),)}, {"root": (Cells("quad", root),)}, source="hinge"
    )
    with pytest.raises(kf.ModelError, match="What moves without force") as error:
        solid_body(mesh, Material(E=210e9, nu=0.3, rho=7850.0), {"root": "clamped"}, reduction=CB, order=1, cache=False)
    # the far edge of the second box swings most
    assert "(0.2, 0.2, 0" in str(error.value)
