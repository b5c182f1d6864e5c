"""Serendipity bricks, wedges, pyramids and mixtures: assembled by numpy, against textbook formulas and exact fields."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import MIDS, shape
from kanefe.fe_model.skin import skin
from kanefe_fem import Material, box_mesh, cylinder_mesh, solid_body, solid_model
from kanefe_fem.mesh.checks import check_mesh
from kanefe_fem.mesh.mesh import Mesh, to_order
from kanefe_fem.mesh.surfaces import loaded_face

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
BRICK = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def mixed_mesh(order: int) -> Mesh:
    """Three bent bricks in a row: a hexahedron, two wedges, six pyramids."""
    places = np.array(list(product(range(4), range(2), range(2))), dtype=float)
    nodes = np.vstack((places, [[2.5, 0.5, 0.5]]))
    nodes += 0.08 * np.sin(3.0 * nodes[:, [1, 2, 0]] + nodes)

    def at(x, corner):
        return int(4 * (x + corner[0]) + 2 * corner[1] + corner[2])

    bricks = [[at(x, corner) for corner in BRICK] for x in range(3)]
    wedges = [[bricks[1][i] for i in wedge] for wedge in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))]
    faces = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    pyramids = [[*(bricks[2][i] for i in face[::-1]), 16] for face in faces]
    blocks = (
        Cells("hexahedron", np.array(bricks[:1])),
        Cells("wedge", np.array(wedges)),
        Cells("pyramid", np.array(pyramids)),
    )
    return to_order(check_mesh(Mesh(nodes, 3, {"body": blocks})), order)


def serendipity(mesh: Mesh) -> Mesh:
    """The bricks of a mesh with 20 nodes."""
    lifted = to_order(mesh, 2)
    cells = {g: tuple(Cells("hexahedron20", b.nodes[:, :20]) for b in blocks) for g, blocks in lifted.cells.items()}
    facets = {g: tuple(Cells("quad8", b.nodes[:, :8]) for b in blocks) for g, blocks in lifted.facets.items()}
    return Mesh(lifted.nodes, 3, cells, facets)


def textbook_brick(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """K (60, 60) and Ms (20, 20) of one brick by the printed shape functions, point after point."""
    signs = 2.0 * shape("hexahedron20").nodes - 1.0
    lame, mu = STEEL.lame, STEEL.shear_modulus
    C = np.diag([2 * mu] * 3 + [mu] * 3)
    C[:3, :3] += lame

    def N_of(s):
        values = []
        for i, c in enumerate(signs):
            terms = 1.0 + s * c
            if i < 8:
                values.append(terms.prod() * (s @ c - 2.0) / 8.0)
            else:
                free = int(np.argmin(abs(c)))
                values.append((1.0 - s[free] ** 2) * np.delete(terms, free).prod() / 4.0)
        return np.array(values)

    def gradient(s, step=1e-200):  # complex steps: exact to round-off
        return np.stack([N_of(s + 1j * step * np.eye(3)[a]).imag / step for a in range(3)], axis=1)

    def integral(count, integrand):
        points, weights = np.polynomial.legendre.leggauss(count)
        total = 0.0
        for index in product(range(count), repeat=3):
            total = total + weights[list(index)].prod() * integrand(points[list(index)])
        return total

    def stiffness(s):
        g = gradient(s)
        J = x.T @ g
        d = g @ np.linalg.inv(J)
        B = np.zeros((6, 60))
        for n, (dx, dy, dz) in enumerate(d):
            B[:, 3 * n : 3 * n + 3] = [[dx, 0, 0], [0, dy, 0], [0, 0, dz], [0, dz, dy], [dz, 0, dx], [dy, dx, 0]]
        return np.linalg.det(J) * B.T @ C @ B

    def mass(s):
        return STEEL.rho * np.linalg.det(x.T @ gradient(s)) * np.outer(N_of(s), N_of(s))

    return integral(3, stiffness), integral(5, mass)


def test_a_brick_of_20_nodes_is_the_textbooks():
    mesh = serendipity(box_mesh((0.3, 0.2, 0.1), (1, 1, 1)))
    bent = np.array(mesh.nodes) + 0.01 * np.sin(20.0 * mesh.nodes[:, [2, 0, 1]])
    model = solid_model(Mesh(bent, 3, mesh.cells), STEEL)
    order = model.cells[0].nodes[0]
    dofs = (order[:, None] * 3 + np.arange(3)).ravel()
    K, M = textbook_brick(model.nodes[order])
    assert model.stiffness.toarray()[np.ix_(dofs, dofs)] == pytest.approx(K, abs=1e-10 * abs(K).max())
    scalar = model.mass.toarray()[np.ix_(dofs[::3], dofs[::3])]
    assert scalar == pytest.approx(M, abs=1e-10 * abs(M).max())


@pytest.mark.parametrize("order", [1, 2])
def test_a_mixture_of_shapes_carries_every_linear_field_exactly(order):
    mesh = mixed_mesh(order)
    model = solid_model(mesh, STEEL, order=order)
    n, x = len(model.nodes), model.nodes
    assert {block.kind: len(block.nodes) for block in model.cells} == (
        {"hexahedron": 1, "wedge": 2, "pyramid": 6} if order == 1 else {"hexahedron20": 1, "wedge15": 2, "pyramid13": 6}
    )
    # the stress of a linear displacement is constant: the interior is in balance, and the energy that of the volume
    H = np.array([[1.0, 0.3, -0.2], [0.1, -0.5, 0.4], [0.6, 0.2, 0.8]]) * 1e-3
    u = (x @ H.T).ravel()
    e = 0.5 * (H + H.T)
    density = STEEL.lame * np.trace(e) ** 2 + 2.0 * STEEL.shear_modulus * (e * e).sum()
    volume = model.mass_field.mass.sum() / STEEL.rho
    assert u @ model.stiffness @ u == pytest.approx(density * volume, rel=1e-12)
    force = (model.stiffness @ u).reshape(n, 3)
    inside = np.setdiff1d(np.arange(n), np.concatenate([b.nodes.ravel() for b in skin(model.cells)]))
    assert len(inside) == (1 if order == 1 else 9)  # the apex, and the middles of the edges to it
    assert abs(force[inside]).max() < 1e-12 * abs(force).max()
    # and the flux of x through the skin is the volume thrice
    whole = Mesh(mesh.nodes, 3, mesh.cells, {"skin": skin(mesh.cell_blocks)})
    flux = -NodalPattern.of_face(loaded_face(whole, "skin")).pressure @ mesh.nodes.ravel()
    assert flux == pytest.approx(3.0 * volume, rel=1e-12)
    assert abs(model.stiffness @ model.rigid_modes()).max() < 1e-12 * abs(model.stiffness).max()


def test_a_stressed_mixture_resists_no_rigid_turn():
    model = solid_model(mixed_mesh(2), STEEL)
    u = (model.nodes @ np.diag([1e-3, 0.0, 0.0])).ravel()
    translations = model.rigid_modes()[:, :3]
    K_g = model.stress_stiffness(u)
    assert abs(K_g @ translations).max() < 1e-12 * abs(K_g).max()
    # turning a bar in tension stretches it to second order: theta^2 times the integral of the stress along x and z
    stress = (STEEL.lame + 2 * STEEL.shear_modulus) * 1e-3, STEEL.lame * 1e-3
    volume = model.mass_field.mass.sum() / STEEL.rho
    turn = model.rigid_modes()[:, 4]  # about y: u = (z, 0, -x)
    assert turn @ K_g @ turn == pytest.approx((stress[0] + stress[1]) * volume, rel=1e-10)


def test_20_node_bricks_bend_as_27_node_bricks_do():
    box = box_mesh((1.0, 0.1, 0.08), (10, 2, 2))
    free = {"root": "clamped"}
    frequencies = [
        solid_body(mesh, STEEL, free, reduction=kf.CraigBampton(modes=4), cache=False).frequencies[:4]
        for mesh in (box, serendipity(box))
    ]
    # Q3 elements: 66.804, 83.227, 406.76, 499.14 Hz; the mesh has 0.4 to 0.7 % left of either
    assert frequencies[1] == pytest.approx(frequencies[0], rel=3e-3)
    assert frequencies[1] == pytest.approx([66.804, 83.227, 406.76, 499.14], rel=8e-3)


def test_shapes_that_do_not_fit_are_refused():
    box = box_mesh((1.0, 1.0, 1.0), (2, 1, 1))
    lifted = to_order(box, 2)
    block = lifted.cell_blocks[0]
    mixed = {"body": (Cells(block.kind, block.nodes[:1]), Cells("hexahedron20", block.nodes[1:, :20]))}
    with pytest.raises(MeshError, match="do not fit each other"):
        check_mesh(Mesh(lifted.nodes, 3, mixed))


def test_every_shape_reproduces_its_nodes_and_linear_fields():
    for kind in MIDS:
        element = shape(kind)
        assert element.values(element.nodes) == pytest.approx(np.eye(len(element.nodes)), abs=1e-12), kind
        inner = element.nodes.mean(axis=0)[None] + 0.03
        assert element.values(inner) @ element.nodes == pytest.approx(inner, abs=1e-12), kind
        J = np.einsum("pna,nb->pab", element.gradients(inner), element.nodes)
        assert J[0] == pytest.approx(np.eye(element.dimension), abs=1e-11), kind


def test_simple_meshes_have_the_volume_and_surface_of_what_they_are():
    bar, tube = cylinder_mesh(1.0, 0.05, (2, 2, 12)), cylinder_mesh(1.0, 0.05, (2, 1, 12), inner_radius=0.03)
    model = solid_model(bar, STEEL)
    # quadratic arcs over 30 degrees: relative error of the area 0.5236^4 / 480 = 1.57e-4
    assert model.mass_field.mass.sum() / STEEL.rho == pytest.approx(np.pi * 0.05**2, rel=1.7e-4)
    assert model.group("outside").measure.sum() == pytest.approx(0.1 * np.pi, rel=2e-4)
    assert solid_model(tube, STEEL).group("inside").measure.sum() == pytest.approx(0.06 * np.pi, rel=2e-4)
    assert "round bar" in str(bar)
    assert "outside" in str(bar)
    with pytest.raises(ModelError, match="multiple of four around"):
        cylinder_mesh(1.0, 0.05, (2, 2, 10))
    with pytest.raises(ModelError, match="counts"):
        box_mesh((1.0, 1.0, 1.0), (1, 1, 0))
