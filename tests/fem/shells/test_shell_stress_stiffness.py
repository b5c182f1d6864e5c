"""Geometric stiffness of shells: a rigid turn of a loaded shell turns the forces at its nodes and costs no energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from kanefe.fe_model.model import FiniteElementModel
from kanefe_fem import Laminate, Material, Orthotropic, Ply, Rectangle, Stiffener, box_mesh, shell_model, surface_mesh
from kanefe_fem.verification.joined_shells import on_box, with_side
from shell_meshes import SURFACES, grid

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CARBON = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0)
UNEVEN = Laminate([Ply(CARBON, 0.006, 0.3), Ply(STEEL, 0.002), Ply(CARBON, 0.004, -1.0)])


def loaded(model: FiniteElementModel, held: int = 6) -> np.ndarray:
    """Return displacements under forces and moments at one end, of a shell that is held at the other."""
    nodes = np.asarray(model.nodes)
    group, other = model.groups["root"].nodes, model.groups["tip"].nodes
    free = np.setdiff1d(np.arange(model.size), (6 * group[:, None] + np.arange(held)).ravel())
    force = np.zeros((len(nodes), 6))
    force[other] = (1e3, 2e3, -3e3, 200.0, -100.0, 300.0)
    u = np.zeros(model.size)
    u[free] = splu(model.stiffness[free][:, free].tocsc()).solve(force.ravel()[free])
    return u


def check_turns(model: FiniteElementModel) -> None:
    u = loaded(model)
    forces = (model.stiffness @ u).reshape(-1, 6)
    softer = model.stress_stiffness(u)
    assert abs(softer - softer.T).max() < 1e-12 * abs(softer).max()
    for axis, motion in enumerate(model.rigid_modes(np.zeros(3)).T[3:]):
        turn = np.eye(3)[axis]
        # of a rotation vector a dead moment turns by half
        expected = np.hstack((np.cross(turn, forces[:, :3]), 0.5 * np.cross(turn, forces[:, 3:])))
        # round-off of K u, whose forces are far below those of the entries of K
        np.testing.assert_allclose((softer @ motion).reshape(-1, 6), expected, atol=1e-8 * np.abs(forces).max())


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize(("material", "offset"), [(STEEL, 0.0), (UNEVEN, 0.5)], ids=["steel", "laminate"])
def test_a_turn_of_a_loaded_shell_turns_its_forces(surface, material, offset):
    check_turns(shell_model(grid(surface, 3, 2, distort=0.2), material, 0.012, offset=offset))


@pytest.mark.parametrize("surface", ["saddle", "twisted"])
def test_so_does_one_of_triangles(surface):
    mesh = grid(surface, 3, 2, distort=0.2, kind="triangle6")
    model = shell_model(mesh, STEEL, 0.012)
    assert any(block.kind == "triangle6" for block in model.cells)
    check_turns(model)


@pytest.mark.parametrize("offset", ["above", 0.0])
def test_so_does_one_with_a_stiffener_beside_it(offset):
    mesh = grid("half cylinder", 3, 2)
    mesh = with_side(mesh, "rib", np.abs(mesh.nodes[:, 2] - 0.5) < 1e-9)
    rib = Stiffener(Rectangle(0.004, 0.05), STEEL, offset)
    check_turns(shell_model(mesh, STEEL, 0.012, beams={"rib": rib}))


def test_a_turn_of_a_shell_on_a_solid_does_the_work_of_its_forces():
    """Between turns alone: a seam that is stretched across has no part in the motion of second order."""
    box = box_mesh((0.2, 0.05, 0.01), (4, 2, 1), start=(0.0, -0.025, -0.005))
    sheet = surface_mesh(lambda s, r: (0.2 + 0.2 * s, 0.05 * (r - 0.5), 0.0 * s), (4, 3))
    model = shell_model(on_box(box, {"sheet": sheet}), {"block": STEEL, "sheet": STEEL}, {"sheet": 0.01})
    model = replace(model, groups={**model.groups, "tip": model.groups["sheet.tip"]})
    u = loaded(model, held=3)
    forces = (model.stiffness @ u).reshape(-1, 6)[:, :3]
    R = model.rigid_modes(np.zeros(3))[:, 3:]
    moved = R.T.reshape(3, -1, 6)[:, :, :3]
    expected = np.array([[np.sum(a * np.cross(axis, forces)) for axis in np.eye(3)] for a in moved])
    found = R.T @ model.stress_stiffness(u) @ R
    np.testing.assert_allclose(found, 0.5 * (expected + expected.T), atol=1e-9 * np.abs(expected).max())


def test_a_compression_does_not_tip_motions_that_the_stiffness_hardly_sees():
    """Product of two Legendre polynomials a cell, along the load: assumed strains of it vanish."""
    mesh = surface_mesh(lambda s, r: (np.cos(s), np.sin(s), 0.3 * r), (6, 3))
    model = shell_model(mesh, Material(E=70e9, nu=0.0, rho=2700.0), 0.01)
    x = np.asarray(model.nodes)
    pushed = np.zeros((len(x), 6))
    pushed[:, 2] = -1e-4 * x[:, 2]
    zigzag = np.zeros((len(x), 6))
    for cell in mesh.cell_blocks[0].nodes:
        zigzag[cell, 2] = (1.0, 1.0, 1.0, 1.0, -0.5, -0.5, -0.5, -0.5, 0.25)
    softer = -zigzag.ravel() @ model.stress_stiffness(pushed.ravel()) @ zigzag.ravel()
    stiffness = zigzag.ravel() @ model.stiffness @ zigzag.ravel()
    assert abs(softer) < 5e-4 * stiffness  # 1e-4, the strain of the load: by the share that is integrated in full
