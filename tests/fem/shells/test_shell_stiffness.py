"""Stiffness of shells: equal to that of an oracle by arrays, without energy in rigid motions, alike in any order."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

import shell_by_arrays
from kanefe.fe_model.model import Cells
from kanefe_fem import Laminate, Material, Oriented, Orthotropic, Ply, axes_at_angle, shell_model
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import directors
from kanefe_fem.shells.problem import SAGITTA, SHEAR, TURN, blocks_at_nodes
from kanefe_fem.shells.sections import section
from shell_meshes import SURFACES, grid

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CARBON = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0)
UNEVEN = Laminate([Ply(CARBON, 0.006, 0.3), Ply(STEEL, 0.002), Ply(CARBON, 0.004, -1.0)])


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize(("material", "offset"), [(STEEL, 0.0), (UNEVEN, 0.5)], ids=["steel", "laminate"])
def test_it_equals_the_arrays(surface, material, offset):
    mesh = grid(surface, 3, 2, distort=0.2)
    along = (0.2, 0.7, 0.4)
    axes = np.linalg.qr(np.column_stack((along, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))))[0]
    axes *= np.sign(axes[:, 0] @ along) * np.array((1.0, 1.0, np.linalg.det(axes)))
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    t = 0.012
    model = shell_model(mesh, Oriented(material, axes), t, offset=offset)
    block = mesh.cell_blocks[0]
    found = directors(np.asarray(mesh.nodes), mesh.cell_blocks, np.radians(20.0))
    m = len(block.nodes)
    cells = shell_by_arrays.stiffness(
        mesh.nodes[block.nodes],
        found.normal[found.of_cells[0]],
        np.full((m, 9), t),
        np.tile(axes[:, 0], (m, 1)),
        section(material, offset),
        {"membrane": SAGITTA, "shear": SHEAR["quad9"], "turn": TURN["quad9"]},
    )
    places = (6 * block.nodes[:, :, None] + np.arange(6)).reshape(m, -1)
    rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None, :])
    expected = sp.csr_matrix((cells.ravel(), (rows.ravel(), columns.ravel())), shape=model.stiffness.shape)
    # round-off of sums over 9 points and 54 coordinates
    assert np.abs(model.stiffness - expected).max() < 1e-12 * np.abs(expected).max()


def test_a_matrix_in_blocks_is_moved_to_nodes():
    rng, node, count = np.random.default_rng(0), np.array([3, 0, 6, 1]), 7  # nodes 2, 4 and 5 are of other cells
    pattern = sp.csr_matrix(np.array([[1, 1, 0, 0], [1, 1, 0, 1], [0, 0, 1, 1], [0, 1, 1, 1]]))
    blocks = sp.bsr_matrix((rng.standard_normal((pattern.nnz, 6, 6)), pattern.indices, pattern.indptr)).tocsr()
    moved = blocks_at_nodes(blocks, node, count)
    move = sp.kron(sp.csr_matrix((np.ones(4), (node, range(4))), shape=(count, 4)), sp.identity(6))
    assert moved.has_canonical_format
    assert np.array_equal(moved.toarray(), (move @ blocks @ move.T).toarray())


@pytest.mark.parametrize("kind", ["quad9", "triangle6"])
@pytest.mark.parametrize("surface", SURFACES)
def test_a_free_shell_has_six_motions_without_energy(surface, kind):
    model = shell_model(grid(surface, 4, 3, distort=0.2, kind=kind), STEEL, 0.01)
    R = model.rigid_modes(model.nodes.mean(axis=0))
    energy = np.einsum("ij,ij->j", R, model.stiffness @ R)
    stiffest = np.einsum("ij,ij->j", R, R) * np.abs(model.stiffness).max()
    assert np.abs(energy).max() < 1e-15 * stiffest.max(), energy  # round-off of K
    lowest = np.sort(eigsh(model.stiffness, 8, model.mass, sigma=-1e3, which="LM")[0])
    assert np.abs(lowest[:6]).max() < 1e-5 * lowest[6]


@pytest.mark.parametrize("surface", ["half cylinder", "twisted"])
def test_the_order_of_the_nodes_changes_nothing(surface):
    mesh = grid(surface, 3, 3, distort=0.2)
    cells = mesh.cell_blocks[0].nodes.copy()
    rng = np.random.default_rng(7)
    around = [1, 2, 3, 0, 5, 6, 7, 4, 8]
    for cell in range(len(cells)):
        for _ in range(rng.integers(4)):
            cells[cell] = cells[cell][around]
    again = Mesh(mesh.nodes, 2, {"body": (Cells("quad9", cells[rng.permutation(len(cells))]),)})
    one, other = (shell_model(m, STEEL, 0.01) for m in (mesh, again))
    assert np.abs(one.stiffness - other.stiffness).max() < 1e-12 * np.abs(one.stiffness).max()
    assert np.abs(one.mass - other.mass).max() < 1e-13 * np.abs(one.mass).max()


def test_fibres_at_an_angle_are_oriented():
    """A strip along its fibres stretches by F / (E1 A), across them by F / (E2 A); without axes they are along x."""
    mesh = grid("plate", 2)
    cells = mesh.connectivity[:, [1, 2, 3, 0, 5, 6, 7, 4, 8]]  # whose first sides are across x
    turned = Mesh(mesh.nodes, 2, {"body": (Cells("quad9", cells),)})
    half = axes_at_angle(np.pi / 4.0)
    for material, modulus in (
        (CARBON, 140e9),
        (Oriented(CARBON, axes_at_angle(0.0)), 140e9),
        (Oriented(CARBON, axes_at_angle(np.pi / 2.0)), 9e9),
        (Oriented(Oriented(CARBON, half), half), 9e9),
    ):
        model = shell_model(turned, material, 0.01)
        x = mesh.nodes
        nu = CARBON.nu12 * modulus / 140e9
        u = np.zeros((len(x), 6))
        u[:, 0], u[:, 1] = x[:, 0], -nu * x[:, 1]
        force = (model.stiffness @ u.ravel()).reshape(-1, 6)
        assert force[np.isclose(x[:, 0], 1.0), 0].sum() == pytest.approx(modulus * 0.01, rel=1e-12)
