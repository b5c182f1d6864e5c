"""Mass of shells: that of the volume between its faces, at a fold too; inertia of a run."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import quadrature, shape
from kanefe.reduction import flexible_body
from kanefe_fem import Laminate, Material, Ply, shell_model
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.directors import directors
from shell_meshes import grid

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def inertia(points, masses):
    """Return mass, first and second moments of points."""
    return masses.sum(), masses @ points, np.einsum("p,pi,pj->ij", masses, points, points)


def volume(mesh, heights, densities):
    """Moments of the volume of a mesh of nine-node cells, by points through it: x + z n, directors as the product's."""
    block = mesh.cell_blocks[0]
    found = directors(np.asarray(mesh.nodes), mesh.cell_blocks, np.radians(20.0))
    x, n = mesh.nodes[block.nodes], found.normal[found.of_cells[0]]
    element = shape("quad9")
    points, weights = quadrature("quad9", 11)
    N, G = element.values(points), element.gradients(points)
    z, w = np.polynomial.legendre.leggauss(5)
    total = [0.0, np.zeros(3), np.zeros((3, 3))]
    for bottom, top, rho in zip(heights[:-1], heights[1:], densities, strict=True):
        for place, share in zip(z, w, strict=True):
            height = bottom + (top - bottom) * (1.0 + place) / 2.0
            lifted = x + height * n
            tangents = np.einsum("pna,mni->mpai", G, lifted)
            n_at = np.einsum("pn,mni->mpi", N, n)
            dV = np.einsum("mpi,mpi->mp", np.cross(tangents[:, :, 0], tangents[:, :, 1]), n_at) * weights
            masses = rho * share * (top - bottom) / 2.0 * dV
            found_at = np.einsum("pn,mni->mpi", N, lifted)
            for i, part in enumerate(inertia(found_at.reshape(-1, 3), masses.ravel())):
                total[i] = total[i] + part
    return total


def moments(field):
    """Moments of a mass field: rows of its mass matrix summed, and products between points."""
    masses = np.asarray(field.mass.sum(axis=1)).ravel()
    return masses.sum(), masses @ field.points, field.points.T @ (field.mass @ field.points)


@pytest.mark.fenicsx
@pytest.mark.parametrize("surface", ["plate", "half cylinder", "saddle", "twisted"])
def test_mass_and_inertia_are_those_of_the_volume(surface):
    mesh = grid(surface, 5, 4, distort=0.1)
    t = 0.02
    model = shell_model(mesh, STEEL, t)
    found = moments(model.mass_field)
    expected = volume(mesh, (-t / 2.0, t / 2.0), (STEEL.rho,))
    assert model.provenance["shell"]["mass_kg"] == {"body": pytest.approx(found[0], rel=1e-12)}
    assert found[0] == pytest.approx(expected[0], rel=1e-10)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-10 * expected[0])
    np.testing.assert_allclose(found[2], expected[2], atol=1e-10 * expected[0])


@pytest.mark.fenicsx
def test_a_plate_has_its_rotary_inertia():
    model = shell_model(grid("plate", 2), STEEL, 0.1)
    R = model.rigid_modes((0.5, 0.5, 0.0))
    J = R.T @ model.mass @ R
    mass = STEEL.rho * 0.1
    assert J[:3, :3] == pytest.approx(mass * np.eye(3), rel=1e-13, abs=1e-9)
    expected = mass / 12.0 * np.array((1.0 + 0.01, 1.0 + 0.01, 2.0))
    assert np.diag(J)[3:] == pytest.approx(expected, rel=1e-13)


@pytest.mark.fenicsx
def test_layers_and_offsets_move_the_centre_of_mass():
    light = Material(E=1e9, nu=0.3, rho=1000.0)
    stack = Laminate([Ply(STEEL, 0.01), Ply(light, 0.03)])
    mesh = grid("plate", 2)
    model = shell_model(mesh, stack, offset=0.5)
    R = model.rigid_modes((0.5, 0.5, 0.0))
    J = R.T @ model.mass @ R
    mass = 78.5 + 30.0
    assert J[0, 0] == pytest.approx(mass, rel=1e-12)
    assert J[0, 4] == pytest.approx(78.5 * 0.005 + 30.0 * 0.025, rel=1e-12)
    through = STEEL.rho * 0.01**3 / 3.0 + 1000.0 * (0.04**3 - 0.01**3) / 3.0
    assert J[3, 3] == pytest.approx(mass / 12.0 + through, rel=1e-12)


@pytest.mark.fenicsx
def test_a_fold_has_the_mass_of_its_two_strips():
    flat = grid("plate", 3, 2)
    up = np.asarray(flat.nodes)[:, [2, 1, 0]]
    nodes = np.concatenate((flat.nodes, up))
    cells = flat.cell_blocks[0].nodes
    twice = np.concatenate((cells, cells + len(up)))
    _, first, again = np.unique(nodes.round(9), axis=0, return_index=True, return_inverse=True)
    mesh = Mesh(nodes[first], 2, {"body": (Cells("quad9", again.ravel()[twice]),)})
    model = shell_model(mesh, STEEL, 0.02)
    R = model.rigid_modes()
    J = R.T @ model.mass @ R
    mass, t = STEEL.rho * 0.02, 0.02
    assert J[0, 0] == pytest.approx(2.0 * mass, rel=1e-13)
    assert J[4, 4] == pytest.approx(2.0 * mass * (1.0 / 3.0 + t**2 / 12.0), rel=1e-12)


@pytest.mark.fenicsx
def test_a_free_shell_keeps_its_momentum():
    model = shell_model(grid("half cylinder", 4, 3), STEEL, 0.01)
    body = flexible_body(model, {}, reduction=kf.CraigBampton(modes=6))
    scene = kf.System()
    scene.add_flexible_body("shell", body, joint=kf.Free(velocity=(0.1, 0.0, 0.2), angular_velocity=(1.0, 2.0, 0.5)))
    result = scene.simulate((0.0, 0.5), rtol=1e-9)
    angular = result.momentum.angular
    drift = np.abs(angular - angular[0]).max() / np.linalg.norm(angular[0])
    assert drift < 1e-8  # of the tolerance
    assert np.linalg.norm(angular[0]) > 1.0
