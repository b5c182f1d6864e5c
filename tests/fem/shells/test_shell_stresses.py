"""Stresses of shells: through the thickness, by plies, at folds, by gauges; section forces; what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.shell_stack import ShellStack
from kanefe_fem import (
    Laminate,
    Material,
    Orthotropic,
    Ply,
    Strengths,
    box_mesh,
    recover,
    shell_body,
    shell_model,
    solid_body,
    surface_mesh,
)
from kanefe_fem.mesh.surface_grid import joined_surfaces
from kanefe_fem.recovery.scalars import max_stress, tsai_wu
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.shell_forces import shell_forces
from kanefe_fem.recovery.shell_points import ShellStrains
from kanefe_fem.shells.sections import section
from shell_meshes import grid

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CARBON = Orthotropic.transversely_isotropic(
    E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0,
    strengths=Strengths(Xt=1500e6, Xc=1200e6, Yt=50e6, Yc=200e6, S=70e6),
)  # fmt: skip
UNEVEN = Laminate([Ply(CARBON, 0.006, 0.3), Ply(STEEL, 0.002), Ply(CARBON, 0.004, -1.0)])
ONE = np.ones((1, 1))


def fields(model, motion, face=None, ply=None):
    """Return the fields of a displacement (n, 6) of a model."""
    return ShellStrainFields(
        ShellStrains(model.nodes, motion.reshape(-1, 1), model.cells, model.elasticity.shell), "b", face, ply
    )


def bent_and_stretched(x, e, k):
    """Return the displacement of a plate in the x-y plane with constant strains 11, 22, 12 and curvatures."""
    E, C = (np.array([[a[0], a[2] / 2.0], [a[2] / 2.0, a[1]]]) for a in (e, k))
    moved = np.zeros((len(x), 6))
    moved[:, :2] = x[:, :2] @ E
    moved[:, 2] = -0.5 * np.einsum("ni,ij,nj->n", x[:, :2], C, x[:, :2])
    slope = x[:, :2] @ C  # b = C x = theta x n
    moved[:, 3], moved[:, 4] = -slope[:, 1], slope[:, 0]
    return moved


@pytest.mark.parametrize("kind", ["quad9", "triangle6"])
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_plies_of_a_plate_have_the_stresses_of_lamination_theory(kind, offset):
    mesh = grid("plate", 3, 2, distort=0.2, kind=kind)
    model = shell_model(mesh, UNEVEN, offset=offset)
    e, k = np.array([1e-4, -3e-5, 2e-5]), np.array([2e-2, 1e-2, -3e-2])
    moved = bent_and_stretched(np.asarray(model.nodes), e, k)
    of = section(UNEVEN, offset)
    t = UNEVEN.thickness
    largest = 140e9 * (np.abs(e).max() + t * np.abs(k).max())
    for number, layer in enumerate(of.layers):
        for face, height in (("bottom", layer.bottom), ("top", layer.top)):
            stress = layer.plane @ (e + height * t * k)
            found = fields(model, moved, face, number).evaluate("stress", "nodes", ONE)[0]
            expected = np.zeros(6)
            expected[[0, 1, 5]] = stress
            np.testing.assert_allclose(found, np.tile(expected, (len(model.nodes), 1)), atol=1e-9 * largest)
    forces = shell_forces(fields(model, moved), np.zeros(1), ONE)
    A, B, D = (t ** (p + 1) * of.stiffness(p) for p in range(3))
    N, M = A @ e + B @ k, B @ e + D @ k
    for name, value in zip(("N11", "N22", "N12"), N, strict=True):
        np.testing.assert_allclose(forces[name], value, atol=1e-9 * np.abs(N).max())
    for name, value in zip(("M11", "M22", "M12"), M - offset * t * N, strict=True):
        np.testing.assert_allclose(forces[name], value, atol=1e-9 * np.abs(M).max())


def test_stresses_turn_with_the_shell():
    """A turned shell with turned displacements has turned stresses, and the same scalars."""
    rng = np.random.default_rng(3)
    mesh, model = grid("saddle", 3), shell_model(grid("saddle", 3), STEEL, 0.01)
    moved = 1e-5 * rng.standard_normal((len(model.nodes), 6))
    A = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    A *= np.linalg.det(A)
    other = shell_model(replace(mesh, nodes=np.asarray(mesh.nodes) @ A.T), STEEL, 0.01)
    turned = np.hstack((moved[:, :3] @ A.T, moved[:, 3:] @ A.T))
    for face in ("top", "middle", "bottom"):
        one, two = (
            fields(m, u, face).evaluate("stress", "nodes", ONE)[0] for m, u in ((model, moved), (other, turned))
        )
        tensor = [[0, 5, 4], [5, 1, 3], [4, 3, 2]]
        np.testing.assert_allclose(two[:, tensor], A @ one[:, tensor] @ A.T, atol=1e-9 * np.abs(one).max())
    one, two = (fields(m, u).scalar("von_mises", "cells", ONE) for m, u in ((model, moved), (other, turned)))
    np.testing.assert_allclose(one, two, rtol=1e-9)


def test_a_rigid_turn_has_no_stress():
    model = shell_model(grid("twisted", 3, 3, distort=0.2), STEEL, 0.3)
    R = model.rigid_modes()
    for column in R.T:
        found = fields(model, column.reshape(-1, 6), "top").evaluate("stress", "nodes", ONE)
        assert np.abs(found).max() < 1e-11 * STEEL.E


def test_a_grown_cylinder_has_the_strain_of_each_radius():
    """Radial growth w of a cylinder: w / (R + z) around, zero along; t / R is 0.2."""
    model = shell_model(grid("half cylinder", 24, 1), STEEL, 0.1)
    x = np.asarray(model.nodes)
    moved = np.zeros((len(x), 6))
    moved[:, :2] = 2e-4 * x[:, :2]
    for face, radius in (("bottom", 0.45), ("middle", 0.5), ("top", 0.55)):
        strain = fields(model, moved, face).evaluate("strain", "cells", ONE)[0]
        grown = 1e-4 / radius * (1.0 - 0.3 / 0.7)  # the thickness shrinks by nu / (1 - nu) of it
        np.testing.assert_allclose(strain[:, 0] + strain[:, 1], grown, rtol=2e-3, err_msg=face)  # cells of 7.5 degrees


@pytest.fixture(scope="module")
def hanging():
    """A cantilever strip of 1 m with 1 N at its tip, at rest."""
    strip = surface_mesh(lambda s, r: (s, 0.1 * r, 0.0 * s), (8, 2))
    soft = Material(E=1e9, nu=0.0, rho=1000.0)
    body = shell_body(
        strip, soft, {"root": "clamped", "tip": "rigid"}, 0.02, kf.CraigBampton(modes=2, loads=("tip",)), cache=False
    )
    scene = kf.System()
    scene.add_force(scene.add_flexible_body("strip", body).interface("tip"), (0.0, 0.0, 1.0))
    return kf.equilibrium(scene)


def test_a_cantilever_has_the_stresses_of_beams(hanging):
    top, middle = (recover(hanging, "strip", face=face) for face in ("top", "middle"))
    x = hanging.history.body("strip").nodes[:, 0]
    bending = -(1.0 - x) / (0.1 * 0.02**2 / 6.0)
    np.testing.assert_allclose(top.stress_at_nodes()[0][:, 0], bending, atol=5e-3 * np.abs(bending).max())
    np.testing.assert_allclose(middle.stress_at_nodes()[0][:, 4], 1.5 / (0.1 * 0.02), rtol=1e-6)
    both = recover(hanging, "strip")
    assert both.envelope().peak == pytest.approx(np.abs(bending).max(), rel=5e-3)
    assert both.von_mises.shape == (1, len(x))
    forces = both.shell_forces()
    np.testing.assert_allclose(forces["M11"][0], -(1.0 - x) / 0.1, atol=0.05)
    np.testing.assert_allclose(forces["Q1"][0], 10.0, rtol=1e-6)
    np.testing.assert_allclose(both.shell_forces(along=(0, 1, 0))["M22"], forces["M11"], atol=1e-9)


def test_a_gauge_is_on_a_face(hanging):
    strain = -0.5 / (0.1 * 0.02**2 / 6.0) / 1e9
    on_top, below = recover(hanging, "strip", face="top"), recover(hanging, "strip", face="bottom")
    assert on_top.gauge((0.5, 0.05, 0.0), (1, 0, 0))[0] == pytest.approx(strain, rel=5e-3)
    assert below.gauge((0.5, 0.05, 0.0), (1, 0, 0))[0] == pytest.approx(-strain, rel=5e-3)
    both = recover(hanging, "strip")
    assert both.gauge((0.5, 0.05, 0.01), (1, 0, 0)) == on_top.gauge((0.5, 0.05, 0.0), (1, 0, 0))
    rosette = both.rosette((0.5, 0.05, -0.01), (1, 0, 0), (0, 0, -1))
    np.testing.assert_allclose(rosette, [[-strain, -0.5 * strain, 0.0]], atol=5e-3 * abs(strain))
    with pytest.raises(ModelError, match=r"a gauge of the shell 'strip' is on a face of it\. Remedy"):
        both.gauge((0.5, 0.05, 0.0), (1, 0, 0))


def test_a_file_keeps_the_stresses(hanging, tmp_path):
    scene = kf.System()
    strip = scene.add_flexible_body("strip", hanging.history.body("strip").flexible)
    scene.add_force(strip.interface("tip"), (0.0, 0.0, 1.0))
    result = scene.simulate((0.0, 1e-3), output_step=1e-3)
    result.save(tmp_path / "run.h5")
    again = recover(kf.load_result(tmp_path / "run.h5"), "strip")
    assert again.envelope().peak == recover(result, "strip").envelope().peak > 0.0


def test_what_is_refused(hanging):
    with pytest.raises(ModelError, match=r"the stress of the shell 'strip' differs through its thickness\. Remedy"):
        recover(hanging, "strip").stress_at_nodes()
    with pytest.raises(ModelError, match=r"face= of recover must be"):
        recover(hanging, "strip", face="left").envelope()
    with pytest.raises(ModelError, match=r"ply=2 of 'strip', whose sections have 1 at most"):
        recover(hanging, "strip", ply=2).envelope()
    with pytest.raises(ModelError, match=r"no material of 'strip' has strengths"):
        recover(hanging, "strip").envelope("tsai_wu")
    with pytest.raises(ModelError, match=r"not at 'gauss' points"):
        recover(hanging, "strip", face="top").stress_at_cells("gauss")
    with pytest.raises(ModelError, match=r"along=\(0, 0, 1\) is across the surface of 'strip'"):
        recover(hanging, "strip").shell_forces(along=(0, 0, 1))
    with pytest.raises(ModelError, match=r"has section forces|is not made of beams"):
        recover(hanging, "strip").section_forces()
    box = solid_body(box_mesh((1.0, 0.1, 0.1), (2, 1, 1)), STEEL, {"root": "clamped"}, kf.CraigBampton(modes=1))
    scene = kf.System()
    scene.add_flexible_body("box", box)
    with pytest.raises(ModelError, match="'box' is no shell and has no face or ply"):
        recover(kf.equilibrium(scene), "box", face="top")


def test_folds_keep_both_sides():
    """An angle pulled along one strip: its stress there, none in the other, and the larger at the fold."""
    strips = [
        surface_mesh(lambda s, r: (s, r, 0.0 * s), (2, 2)),
        surface_mesh(lambda s, r: (s, 0.0 * s, r), (2, 2)),
    ]
    model = shell_model(joined_surfaces(strips), Material(E=1.0, nu=0.0, rho=1.0), 0.02)
    moved = np.zeros((len(model.nodes), 6))
    y, z = np.asarray(model.nodes)[:, 1:].T
    moved[:, 1] = y
    worst = fields(model, moved).scalar("max_principal", "nodes", ONE)[0]
    np.testing.assert_allclose(worst[(z == 0.0) & (y > 0.0)], 1.0, atol=1e-9)
    np.testing.assert_allclose(worst[(z == 0.0) & (y == 0.0)], 1.0, atol=1e-9)
    forces = shell_forces(fields(model, moved), np.zeros(1), ONE, along=(1, 0, 0))
    flat = np.abs(forces.axes[:, 2, 2]) > 0.9
    np.testing.assert_allclose(forces["N22"][0, flat], 0.02, atol=1e-12)
    np.testing.assert_allclose(forces["N22"][0, ~flat], 0.0, atol=1e-12)


def test_failure_indices_are_one_at_failure():
    strengths = CARBON.strengths.array()
    for component, values in ((0, (1500e6, -1200e6)), (1, (50e6, -200e6)), (5, (70e6, -70e6))):
        for value in values:
            stress = np.zeros(6)
            stress[component] = value
            assert tsai_wu(stress, strengths) == pytest.approx(1.0, rel=1e-12)
            assert max_stress(0.5 * stress, strengths) == pytest.approx(0.5, rel=1e-12)
    with pytest.raises(ModelError, match=r"interaction = 1\.5 must be between"):
        Strengths(Xt=1.0, Xc=1.0, Yt=1.0, Yc=1.0, S=1.0, interaction=1.5)
    with pytest.raises(ModelError, match="Xc"):
        Strengths(Xt=1.0, Xc=-1.0, Yt=1.0, Yc=1.0, S=1.0)
    with pytest.raises(ModelError, match="strengths=5"):
        replace(CARBON, strengths=5)


def test_the_worst_ply_counts():
    """The index of a laminate is that of the ply where it is largest."""
    model = shell_model(grid("plate", 2), UNEVEN)
    moved = bent_and_stretched(np.asarray(model.nodes), np.array([1e-3, 0.0, 0.0]), np.array([2e-2, 0.0, 0.0]))
    worst = fields(model, moved).scalar("tsai_wu", "nodes", ONE)
    plies = [fields(model, moved, None, ply).scalar("tsai_wu", "nodes", ONE) for ply in (0, 1, 2)]
    np.testing.assert_array_equal(worst, np.fmax.reduce(plies))
    assert np.isnan(plies[1]).all()  # steel without strengths
    assert isinstance(model.elasticity.shell, ShellStack)
