"""Stresses of a shell with stiffeners, and of a shell and a solid in one mesh, against beams in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError
from kanefe.views.player.page import page_of
from kanefe.views.player.skins import skin_of
from kanefe_fem import (
    Material,
    Orthotropic,
    Rectangle,
    Section,
    Stiffener,
    Strengths,
    box_mesh,
    recover,
    shell_body,
    surface_mesh,
)
from kanefe_fem.recovery.rib_fields import UNIAXIAL, RibFields
from kanefe_fem.recovery.scalars import SCALARS
from kanefe_fem.verification.joined_shells import on_box, with_side
from player_pages import body_of, placed, read_page

pytestmark = pytest.mark.fenicsx

PLAIN = Material(E=70e9, nu=0.0, rho=2700.0)  # without contraction, beams in closed form are exact
LENGTH, WIDTH, THICK = 0.4, 0.05, 0.01
STATICS = kf.CraigBampton(modes=0)
RIB = Rectangle(width=0.004, height=0.03)
MOMENT, FORCE = 30.0, 40.0


def strip(start=0.0, cells=4, across=2):
    return surface_mesh(lambda s, r: (start + (LENGTH - start) * s, WIDTH * (r - 0.5), 0.0 * s), (cells, across))


def at_rest(body, name, load):
    scene = kf.System()
    arm = scene.add_flexible_body("part", body)
    load(scene, arm.interface(name))
    return kf.equilibrium(scene)


def ribbed(section=RIB, cells=4, sheet=PLAIN):
    mesh = strip(cells=cells)
    mesh = with_side(mesh, "rib", np.abs(mesh.nodes[:, 1]) < 1e-9)
    rib = Stiffener(section, PLAIN, offset="above" if section is RIB else 0.02)
    return shell_body(mesh, sheet, {"root": "clamped", "tip": "rigid"}, THICK, STATICS, beams={"rib": rib})


def half_and_half():
    box = box_mesh((LENGTH / 2, WIDTH, THICK), (6, 2, 2), start=(0.0, -WIDTH / 2, -THICK / 2))
    mesh = on_box(box, {"sheet": strip(LENGTH / 2, across=3)})
    interfaces = {"root": "clamped", "sheet.tip": "average"}
    return shell_body(mesh, {"block": PLAIN, "sheet": PLAIN}, interfaces, {"sheet": THICK}, STATICS)


def bend(scene, tip):
    scene.add_torque(tip, (0.0, MOMENT, 0.0))


def pull(scene, tip):
    scene.add_force(tip, (FORCE, 0.0, 0.0))


@pytest.fixture(scope="module")
def bent():
    return at_rest(ribbed(), "tip", bend)


AREA, OWN = np.array((WIDTH * THICK, 0.004 * 0.03)), np.array((WIDTH * THICK**3, 0.004 * 0.03**3)) / 12.0
RISE = (THICK + 0.03) / 2.0
CENTRE = RISE * AREA[1] / AREA.sum()
CURVATURE = MOMENT / (70e9 * (OWN.sum() + AREA.prod() / AREA.sum() * RISE**2))


def bending(z):
    """Return the stress at a height above the shell: e = z k_y about the common neutral axis."""
    return 70e9 * CURVATURE * (z - CENTRE)


def test_an_eccentric_rib_has_the_forces_of_a_t_beam(bent):
    fields = recover(bent, "part", material="rib")
    found = fields.section_forces(stations=3)
    assert found.groups == ("rib",) * 4
    np.testing.assert_allclose(found.positions[:, :, 2], RISE)
    expected = {"N": AREA[1] * bending(RISE), "My": 70e9 * OWN[1] * CURVATURE}
    for name in ("N", "Vy", "Vz", "T", "My", "Mz"):
        np.testing.assert_allclose(found[name], expected.get(name, 0.0), atol=1e-7 * expected["N"])
    stress = fields.fibre_stress()
    assert stress.shape == (1, 4, 2, 16)
    ends = bending(THICK / 2.0), bending(THICK / 2.0 + 0.03)
    np.testing.assert_allclose((stress.min(), stress.max()), sorted(ends), rtol=1e-7)
    sheet = recover(bent, "part").shell_forces()
    np.testing.assert_allclose(sheet["N11"] * WIDTH, -found["N"][0, 0, 0], rtol=1e-6)


def test_fibres_of_a_rib_that_bends_sideways_have_the_sign_of_their_side():
    rest = at_rest(ribbed(), "tip", lambda scene, tip: scene.add_torque(tip, (0.0, 0.0, MOMENT)))
    fields = recover(rest, "part", material="rib")
    curvature = MOMENT / (THICK * WIDTH**3 + 0.03 * 0.004**3) * 12.0 / 70e9
    y = rest.history.body("part").elasticity.ribs.fibres[0, :, 0]
    expected = np.broadcast_to(-70e9 * curvature * y, (4, 2, 16))
    np.testing.assert_allclose(fields.fibre_stress()[0], expected, atol=1e-8 * expected.max())
    np.testing.assert_allclose(fields.section_forces()["Mz"], 70e9 * curvature * 0.03 * 0.004**3 / 12.0, rtol=1e-8)


def test_the_worst_at_a_node_is_that_of_the_rib_beside_it(bent):
    top = bending(THICK / 2.0 + 0.03)
    on_line = np.abs(recover(bent, "part").envelope().positions[:, 1]) < 1e-9
    for quantity, expected in (("von_mises", top), ("max_shear", top / 2.0), ("max_principal", top)):
        worst = recover(bent, "part").envelope(quantity)
        np.testing.assert_allclose(worst.values[on_line], expected, rtol=1e-6)
        own = recover(bent, "part", material="rib").scalar(quantity)[0]
        np.testing.assert_array_equal(np.isfinite(own), on_line)
        np.testing.assert_allclose(own[on_line], expected, rtol=1e-6)
    np.testing.assert_allclose(recover(bent, "part", face="top").von_mises, abs(bending(THICK / 2.0)), rtol=1e-6)
    cells = recover(bent, "part").scalar("von_mises", "cells")[0]
    np.testing.assert_allclose(cells[-4:], top, rtol=1e-6)
    np.testing.assert_allclose(recover(bent, "part", material="body").von_mises, abs(bending(-THICK / 2.0)), rtol=1e-6)


def test_the_sheet_beside_a_rib_fails_where_it_is_compressed():
    """In one direction Tsai and Wu's index is the stress over the strength of its sign."""
    strengths = Strengths(Xt=400e6, Xc=100e6, Yt=400e6, Yc=100e6, S=80e6)
    sheet = Orthotropic(
        E1=70e9, E2=70e9, E3=70e9, nu12=0.0, nu13=0.0, nu23=0.0, G12=35e9, G13=35e9, G23=35e9, rho=2700.0,
        strengths=strengths,
    )  # fmt: skip
    rest = at_rest(ribbed(sheet=sheet), "tip", bend)
    for name in ("tsai_wu", "max_stress"):
        worst = recover(rest, "part").envelope(name)
        np.testing.assert_allclose(worst.values, -bending(-THICK / 2.0) / 100e6, rtol=1e-6)
    below, middle, above = (recover(rest, "part", face=face) for face in ("bottom", "middle", "top"))
    for fields, z in ((below, -THICK / 2.0), (middle, 0.0), (above, THICK / 2.0)):
        np.testing.assert_allclose(fields.von_mises, abs(bending(z)), rtol=1e-6)
        np.testing.assert_allclose(fields.stress_in_layer()[..., 0], bending(z), rtol=1e-6)
        np.testing.assert_allclose(fields.gauge((0.2, 0.01, z), (1, 0, 0)), bending(z) / 70e9, rtol=1e-6)


def test_a_rib_knows_the_error_of_its_lines(bent):
    """Pure bending is exact; a force at the tip bends by a cubic, whose curvature lines of two points have exactly."""
    assert recover(bent, "part", material="rib").envelope().mesh_error < 1e-6
    fields = recover(bent, "part", material="rib")._fields()
    table, x = fields.ribs.table, np.asarray(fields.nodes)[:, 0]
    motion = np.zeros((len(x), 6))
    motion[:, 4] = -(x**3) / 3.0  # strain -x^2 z, whose best points are exact
    bare = RibFields(fields.nodes, motion.reshape(-1, 1), table, fields.ribs.ribs, ("rib",))
    (patch,) = bare.patches(int(table.ravel()[x[table].argmax()]), np.ones((1, 1)))
    at_tip = bare.stress(np.array((0.0, 1.0)), np.ones((1, 1)))[0]
    exact = 70e9 * LENGTH**2 * (THICK / 2.0 + 0.03)
    assert patch.error == pytest.approx(exact - np.abs(at_tip).max(), rel=1e-6)


def test_scalars_of_fibres_are_those_of_a_tensor():
    stress = np.array((-3.0, 0.0, 5.0))
    tensors = stress[:, None] * np.eye(6)[0]
    for quantity, law in UNIAXIAL.items():
        np.testing.assert_allclose(law(stress), SCALARS[quantity](tensors), atol=1e-15)
    assert UNIAXIAL.keys() == SCALARS.keys()


def test_the_skin_the_stress_and_files_have_the_same_points(bent, tmp_path):
    """Points on the rib, drawn beside the sheet, have the stress of their height."""
    shape, fields = bent.history.body("part"), recover(bent, "part")
    skin = skin_of(shape)
    stress = fields.stress_of(fields.eta)[0]
    assert len(stress) == len(skin.points)
    np.testing.assert_allclose(stress[:, 0], bending(skin.points[:, 2]), atol=1e-6 * bending(0.035))
    assert skin.points[:, 2].max() == pytest.approx(THICK / 2.0 + 0.03)
    edges = skin.points[skin.triangles]
    volume = np.einsum("ti,ti->", edges[:, 0], np.cross(edges[:, 1], edges[:, 2])) / 6.0
    assert volume == pytest.approx(LENGTH * AREA.sum(), rel=1e-9)
    pyvista = pytest.importorskip("pyvista")
    fields.to_vtk(tmp_path / "part.pvd", quantities=("von_mises", "stress"), scale=0.0)
    grid = pyvista.read(next(tmp_path.rglob("body0*.vtu")))
    np.testing.assert_allclose(grid["stress xx [Pa]"], bending(grid.points[:, 2]), atol=1e-6 * bending(0.035))
    np.testing.assert_allclose(grid["von mises [Pa]"], np.abs(bending(grid.points[:, 2])), atol=1e-6 * bending(0.035))


def test_half_a_solid_and_half_a_shell_are_pulled_and_bent_as_one():
    body = half_and_half()
    x = np.asarray(body.nodes)[:, 0]
    rest = at_rest(body, "sheet.tip", pull)
    for fields in (recover(rest, "part"), recover(rest, "part", face="top")):
        np.testing.assert_allclose(fields.von_mises[0], FORCE / AREA[0], rtol=1e-6)
    only = recover(rest, "part", material="block").stress_at_nodes()[0, :, 0]
    np.testing.assert_array_equal(np.isnan(only), np.arange(len(x)) < np.isnan(only).sum())
    np.testing.assert_allclose(only[np.isfinite(only)], FORCE / AREA[0], rtol=1e-6)
    in_cells = [recover(rest, "part", material=name).envelope(at="cells").values for name in ("sheet", "block")]
    is_sheet = np.arange(len(in_cells[0])) < 12
    np.testing.assert_array_equal(np.isfinite(in_cells), (is_sheet, ~is_sheet))
    rest = at_rest(body, "sheet.tip", lambda scene, tip: scene.add_force(tip, (0.0, 0.0, FORCE)))
    fields = recover(rest, "part", face="top")
    stress, z = fields.stress_at_nodes()[0, :, 0], np.asarray(body.nodes)[:, 2]
    height = np.where(np.isfinite(only), z, THICK / 2.0)
    expected = -FORCE * (LENGTH - x) * height / (WIDTH * THICK**3 / 12.0)
    away = (np.abs(x - LENGTH / 2.0) > THICK) & (x > THICK)
    np.testing.assert_allclose(stress[away], expected[away], atol=0.01 * np.abs(expected).max())
    strain = fields.gauge((0.1, 0.0, THICK / 2.0), (1, 0, 0)), fields.gauge((0.3, 0.0, THICK / 2.0), (1, 0, 0))
    arms = np.array((0.3, 0.1))
    np.testing.assert_allclose(np.ravel(strain), -FORCE * arms * 6.0 / (WIDTH * THICK**2 * 70e9), rtol=0.01)


def test_pages_and_files_have_the_stresses_of_ribs(tmp_path):
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("part", ribbed())
    result = scene.simulate((0.0, 0.01), output_step=0.005)
    fields = recover(result, "part")
    told = read_page(page_of(result, stress=fields).html)
    part = body_of(told, "part")["parts"][0]
    shown = np.tensordot(part["amplitudes"][-1] * part["stress_factors"], part["stresses"].astype(float), axes=1)
    expected = fields.stress_of(fields.eta[-1:])[0]
    np.testing.assert_allclose(shown, expected, atol=2e-4 * np.abs(expected).max())  # 16 bits
    moved = placed(told, part, 2) - placed(told, part, 0)
    on_top = skin_of(result.body("part")).points[:, 2] > THICK
    assert np.abs(moved[on_top, 2]).max() > 0.9 * np.abs(moved[:, 2]).max()  # the rib moves with the sheet
    result.save(tmp_path / "run.h5")
    first, second = (recover(one, "part", material="rib") for one in (result, kf.load_result(tmp_path / "run.h5")))
    assert np.abs(first.fibre_stress()).max() > 0.0
    curve = kf.fatigue.SNCurve(1e5, 1e6, 5, 5)
    whole = fields.damage(curve, floor=0.0)
    with pytest.warns(AccuracyWarning, match="leaves its stiffeners out"):
        parts = [recover(result, "part", face=face).damage(curve, floor=0.0) for face in ("top", "bottom")]
    of_rib = first.damage(curve, floor=0.0)
    every = [*(part.values for part in parts), of_rib.values]
    np.testing.assert_allclose(whole.values, np.nanmax(every, axis=0), rtol=1e-12)
    histories = first.fibre_stress().reshape(len(result.times), -1).T
    one_by_one = max(kf.fatigue.damage(history, curve).total for history in histories)
    assert of_rib.peak == pytest.approx(one_by_one, rel=1e-9)
    np.testing.assert_array_equal(first.fibre_stress(), second.fibre_stress())
    np.testing.assert_array_equal(first.von_mises, second.von_mises)


@pytest.mark.parametrize(
    ("material", "call", "words"),
    [
        ("web", lambda f: f, "no material of the group 'web'. It has: body, rib"),
        ("rib", lambda f: f.stress_at_nodes(), r"'rib' of 'part' is of beams.*section_forces"),
        ("rib", lambda f: f.scalar("tsai_wu"), "no tsai_wu of 'rib', which is no shell"),
        ("rib", lambda f: f.stress_in_layer(), "'rib' of 'part' is no shell and has no layers"),
        ("rib", lambda f: f.gauge((0.1, 0.0, 0.0), (1, 0, 0)), "no cell with a surface has this material"),
        ("body", lambda f: f.section_forces(), "'body' of 'part' has no beams. Remedy: one of rib"),
        (None, lambda f: f.section_forces(inertia=True), "a shell with stiffeners. Remedy: leave out inertia"),
        (2, lambda f: f, "material 2 of body 'part' is none of 0 to 1"),
    ],
)
def test_what_there_is_not_is_refused(bent, material, call, words):
    with pytest.raises(ModelError, match=words):
        call(recover(bent, "part", material=material))


def test_a_stiffener_has_no_face(bent):
    with pytest.raises(ModelError, match="material='rib' of 'part' is no shell and has no face"):
        recover(bent, "part", material="rib", face="top")


def test_sections_without_shape_are_told():
    numbers = Section(A=1.2e-4, I_y=9e-9, I_z=1.6e-10, J=6e-10)
    rest = at_rest(ribbed(numbers), "tip", bend)
    with pytest.warns(AccuracyWarning, match="stiffeners rib of 'part' have constants but no shape"):
        fields = recover(rest, "part", material="rib")
    assert fields.section_forces()["N"].min() == pytest.approx(AREA[1] * bending(RISE), rel=1e-6)
    with pytest.raises(ModelError, match="'rib' has constants but no shape"):
        fields.scalar("von_mises")
