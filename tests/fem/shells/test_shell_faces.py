"""Loads on the faces and edges of shells, and shells drawn with their thickness."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.shapes import measures, quadrature, shape
from kanefe.fe_model.thick_shell import layered, thick_skin
from kanefe_fem import Laminate, Material, Ply, ShellFace, recover, shell_body, shell_model, surface_mesh
from kanefe_fem.mesh.surface_grid import joined_surfaces
from shell_meshes import grid

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


@pytest.fixture(scope="module")
def ball():
    """A closed sphere of radius 1, six curved faces of a cube, with normals outward."""

    def side(axis, sign):
        def place(s, r):
            p = [np.zeros_like(s)] * 3
            p[axis], p[(axis + 1) % 3] = sign * np.ones_like(s), sign * np.tan((s - 0.5) * np.pi / 2.0)
            p[(axis + 2) % 3] = np.tan((r - 0.5) * np.pi / 2.0)
            length = np.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2)
            return tuple(x / length for x in p)

        return surface_mesh(place, (2, 2))

    sides = {name: ShellFace(name) for name in ("top", "middle", "bottom")}
    mesh = joined_surfaces([side(axis, sign) for axis in range(3) for sign in (1.0, -1.0)])
    return shell_model(mesh, STEEL, 0.1, offset=0.2, surfaces=sides)


@pytest.mark.parametrize(("side", "radius"), [("top", 1.07), ("middle", 1.02), ("bottom", 0.97)])
def test_a_pressure_on_a_closed_shell_has_no_resultant(ball, side, radius):
    pattern = ball.load_patterns[side]
    assert pattern.measure == pytest.approx(4.0 * np.pi * radius**2, rel=2e-3)  # cells of order 2
    rigid = ball.rigid_modes()
    assert np.abs(rigid.T @ pattern.pressure).max() < 1e-13
    assert np.abs([pattern.pressure_force, pattern.pressure_moment]).max() < 1e-13
    total = rigid.T @ pattern.traction
    np.testing.assert_allclose(total[:3], pattern.measure * np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pattern.first, 0.0, atol=1e-13)
    # work of growing: inward on the top, outward on the bottom
    grown = np.zeros((len(ball.nodes), 6))
    grown[:, :3] = ball.nodes
    sign = 1.0 if side == "bottom" else -1.0
    assert grown.ravel() @ pattern.pressure == pytest.approx(sign * pattern.measure, rel=1e-2)


def test_a_traction_on_a_face_turns_the_nodes():
    """A shear on the top of a plate has the moment of half its thickness."""
    model = shell_model(grid("plate", 2), STEEL, 0.1, surfaces=["body"])
    pattern = model.load_patterns["body"]
    moments = pattern.traction.reshape(-1, 6, 3)[:, 3:].sum(axis=0) @ (1.0, 0.0, 0.0)
    np.testing.assert_allclose(moments, (0.0, 0.05, 0.0), atol=1e-15)


def test_surfaces_by_groups_lines_and_places():
    mesh = grid("plate", 4, 2)
    model = shell_model(
        mesh,
        STEEL,
        0.01,
        surfaces={"all": "body", "left": lambda x: x[:, 0] < 0.51, "end": "tip", "low": ShellFace("bottom")},
    )
    found = {name: (pattern.kind, round(pattern.measure, 12)) for name, pattern in model.load_patterns.items()}
    assert found == {"all": ("surface", 1.0), "left": ("surface", 0.5), "end": ("line", 1.0), "low": ("surface", 1.0)}
    for surfaces, words in (
        (["skin"], "has no group of cells 'skin' for the surface 'skin' of a shell. It has: body"),
        ("body", "surfaces='body' of a shell"),
        ({"a": kf.Near((9.0, 9.0, 9.0), 0.1)}, "no cell has all its corners in the surface 'a'"),
    ):
        with pytest.raises(ModelError, match=words.replace(".", r"\.")):
            shell_model(mesh, STEEL, 0.01, surfaces=surfaces)
    with pytest.raises(ModelError, match="side= of ShellFace must be 'top'"):
        ShellFace("left")


def test_a_pressure_bends_a_plate_and_a_line_load_pulls_it():
    """A clamped strip, nu = 0: pressure on its bottom lifts it as a beam; a load along its tip stretches it."""
    strip = surface_mesh(lambda s, r: (s, 0.1 * r, 0.0 * s), (8, 2))
    soft = Material(E=1e9, nu=0.0, rho=1000.0)
    loads = kf.CraigBampton(modes=2, loads=("under", "tip"))
    body = shell_body(
        strip,
        soft,
        {"root": "clamped", "tip": "average"},
        0.02,
        loads,
        surfaces={"under": ShellFace("bottom"), "edge": "tip"},
    )
    scene = kf.System()
    member = scene.add_flexible_body("strip", body)
    scene.add_pressure(member, "under", 100.0)
    scene.add_line_load(member, "edge", (1e2, 0.0, 0.0))
    rest = kf.equilibrium(scene)
    inertia = 0.1 * 0.02**3 / 12.0
    bent = 10.0 / (8.0 * 1e9 * inertia) + 10.0 / (2.0 * 5.0 / 6.0 * 0.5e9 * 0.002)
    assert rest.position("strip", "tip")[2] == pytest.approx(bent, rel=1e-3)
    forces = recover(rest, "strip").shell_forces()
    inside = rest.history.body("strip").nodes[:, 0] > 0.3  # St Venant, and the modes kept
    np.testing.assert_allclose(forces["N11"][0, inside], 1e2, rtol=0.05)


@pytest.mark.parametrize("surface", ["plate", "half cylinder", "saddle"])
def test_the_thick_skin_is_closed_and_holds_the_volume(surface):
    mesh = grid(surface, 3)
    model = shell_model(mesh, STEEL, 0.06, offset=0.25)
    thick = thick_skin(model.cells, model.elasticity.shell)
    points = model.nodes[thick.nodes] + thick.arms
    volume = 0.0
    for block in thick.cells:
        if block.kind == "quad":
            a, b, c, d = (points[block.nodes[:, i]] for i in range(4))
            volume += sum(np.einsum("mi,mi->", p, np.cross(q, r)) for p, q, r in ((a, b, c), (a, c, d))) / 6.0
        else:
            at, weights = quadrature(block.kind, 6)
            x = points[block.nodes]
            J = np.einsum("pna,mni->mpia", shape(block.kind).gradients(at), x)
            place = np.einsum("pn,mni->mpi", shape(block.kind).values(at), x)
            volume += np.einsum("p,mpi,mpi->", weights, place, np.cross(J[..., 0], J[..., 1])) / 3.0
    mass = model.rigid_modes()[:, 0] @ model.mass @ model.rigid_modes()[:, 0]
    assert volume == pytest.approx(mass / STEEL.rho, rel=2e-2)  # rims are straight, cells of 60 degrees


def test_layers_fill_the_thickness():
    plies = Laminate([Ply(STEEL, 0.01), Ply(STEEL, 0.02)])
    for kind in ("quad9", "triangle6"):
        model = shell_model(grid("plate", 2, kind=kind), plies)
        for by_plies, count in ((True, 2), (False, 1)):
            solid = layered(model.cells, model.elasticity.shell, plies=by_plies)
            points = model.nodes[solid.nodes] + solid.arms
            volumes = np.concatenate([measures(block.kind, points[block.nodes])[0] for block in solid.cells])
            assert volumes.min() > 0.0
            assert volumes.sum() == pytest.approx(0.03, rel=1e-12)
            assert len(points) == 2 * count * len(model.elasticity.shell.places.node)
