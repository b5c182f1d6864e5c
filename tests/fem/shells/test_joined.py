"""Shells with stiffeners and with solids: rigid motions, mass, beams in closed form, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe_fem import (
    LumpedMass,
    LumpedSpring,
    Material,
    Rectangle,
    Section,
    Stiffener,
    box_mesh,
    read_mesh,
    shell_body,
    shell_model,
    surface_mesh,
)
from kanefe_fem.verification.joined_shells import compliance, on_box, with_side

pytestmark = pytest.mark.fenicsx

PLAIN = Material(E=70e9, nu=0.0, rho=2700.0)  # without contraction, beams in closed form are exact
LENGTH, WIDTH, THICK = 0.4, 0.05, 0.01
STATICS = kf.CraigBampton(modes=0)


def strip(start: float = 0.0, cells: int = 4, height: float = 0.0, across: int = 2):
    return surface_mesh(
        lambda s, r: (start + (LENGTH - start) * s, WIDTH * (r - 0.5), height + 0.0 * s), (cells, across)
    )


def ribbed(cells: int = 8):
    mesh = strip(cells=cells)
    return with_side(mesh, "rib", np.abs(mesh.nodes[:, 1]) < 1e-9)


def half_and_half(across: int = 2):
    """Return half a solid and half a shell, of cells that do not fit each other."""
    box = box_mesh((LENGTH / 2, WIDTH, THICK), (4, 2, 1), start=(0.0, -WIDTH / 2, -THICK / 2))
    return on_box(box, {"sheet": strip(LENGTH / 2, across=across)})


def check_rigid(model: FiniteElementModel, mass: float) -> None:
    R = model.rigid_modes()
    assert abs(model.stiffness @ R).max() < 1e-14 * abs(model.stiffness).max()
    np.testing.assert_allclose(np.diag(R.T @ (model.mass @ R))[:3], mass, rtol=1e-12)


@pytest.mark.parametrize(
    ("offset", "orientation"), [("above", None), ("below", None), ((0.0, 0.0, 0.02), (0.0, 0.0, 1.0))]
)
def test_an_eccentric_stiffener_bends_as_a_t_beam(offset, orientation):
    height, width = 0.03, 0.004
    rib = Stiffener(Rectangle(width, height), PLAIN, offset, orientation)
    model = shell_model(ribbed(), PLAIN, THICK, beams={"rib": rib})
    areas = np.array((WIDTH * THICK, width * height))
    check_rigid(model, 2700.0 * LENGTH * areas.sum())
    body = shell_body(ribbed(), PLAIN, {"root": "clamped", "tip": "rigid"}, THICK, STATICS, beams={"rib": rib})
    own = WIDTH * THICK**3 / 12.0 + width * height**3 / 12.0
    stiffness = 70e9 * (own + areas.prod() / areas.sum() * 0.02**2)
    # a tip held against turning by a rigid frame only moves as a whole: it is free to turn here
    expected = LENGTH**3 / (3.0 * stiffness)
    assert compliance(body, "tip")[2, 2] == pytest.approx(expected, rel=0.02)  # shear of the rib is not in the formula
    assert f"0.02 m off, {2700.0 * LENGTH * areas[1]:.4g} kg" in str(body)


def test_half_a_solid_and_half_a_shell_bend_as_one_beam():
    mesh, materials = half_and_half(3), {"block": PLAIN, "sheet": PLAIN}
    model = shell_model(mesh, materials, {"sheet": THICK})
    half = 2700.0 * LENGTH / 2 * WIDTH * THICK
    assert f"solid block: {half:.4g} kg; on it 3 edges and 0 cells of the shell" in model.provenance["told"]
    check_rigid(model, 2700.0 * LENGTH * WIDTH * THICK)
    body = shell_body(mesh, materials, {"root": "clamped", "sheet.tip": "average"}, {"sheet": THICK}, STATICS)
    area, G = WIDTH * THICK, 35e9
    found = np.diag(compliance(body, "sheet.tip"))
    for axis, inertia in ((1, THICK * WIDTH**3 / 12.0), (2, WIDTH * THICK**3 / 12.0)):
        expected = LENGTH**3 / (3.0 * 70e9 * inertia) + LENGTH / (5.0 / 6.0 * G * area)
        assert found[axis] == pytest.approx(expected, rel=2e-3)
    assert found[0] == pytest.approx(LENGTH / (70e9 * area), rel=1e-6)


def test_a_sheet_on_the_face_of_a_solid_bends_with_it():
    box = box_mesh((LENGTH, WIDTH, THICK), (6, 1, 1), start=(0.0, -WIDTH / 2, -THICK))
    mesh = on_box(box, {"sheet": strip(cells=6, across=1)})
    materials, thickness = {"block": PLAIN, "sheet": PLAIN}, {"sheet": 2e-3}
    model = shell_model(mesh, materials, thickness, offset={"sheet": 0.5})
    check_rigid(model, 2700.0 * LENGTH * WIDTH * (THICK + 2e-3))
    assert model.provenance["seams"]["cells"] == 6
    interfaces = {"root": "clamped", "tip": "average"}
    body = shell_body(mesh, materials, interfaces, thickness, STATICS, offset={"sheet": 0.5})
    expected = LENGTH**3 / (3.0 * 70e9 * WIDTH * (THICK + 2e-3) ** 3 / 12.0)
    assert compliance(body, "tip")[2, 2] == pytest.approx(expected, rel=0.01)


def test_a_wall_on_a_block_follows_it():
    """The foot of a wall is on a face of the block: sway of the block's face is sway and tilt of the wall."""
    box = box_mesh((0.1, WIDTH, 0.1), (3, 2, 3), start=(-0.05, -WIDTH / 2, -0.1))
    wall = surface_mesh(lambda s, r: (0.0 * s, WIDTH * (r - 0.5), 0.2 * s), (4, 2))
    mesh = on_box(box, {"wall": wall})
    stiff = Material(E=7e12, nu=0.0, rho=27000.0)
    materials, thickness = {"block": stiff, "wall": PLAIN}, {"wall": THICK}
    model = shell_model(mesh, materials, thickness)
    check_rigid(model, (27000.0 * 0.1 * 0.1 + 2700.0 * 0.2 * THICK) * WIDTH)
    body = shell_body(mesh, materials, {"bottom": "clamped", "wall.tip": "average"}, thickness, STATICS)
    expected = 0.2**3 / (3.0 * 70e9 * WIDTH * THICK**3 / 12.0) + 0.2 / (5.0 / 6.0 * 35e9 * WIDTH * THICK)
    assert compliance(body, "wall.tip")[0, 0] == pytest.approx(expected, rel=4e-3)


def test_stiffeners_and_solids_stiffen_by_prestress():
    """Energy of the geometric stiffness of a pulled strip: N w'^2 / 2 of a rotation of the whole."""
    rib = Stiffener(Rectangle(0.004, 0.03), PLAIN, "above")
    for model, area in (
        (shell_model(ribbed(4), PLAIN, THICK, beams={"rib": rib}), WIDTH * THICK + 0.004 * 0.03),
        (shell_model(half_and_half(), {"block": PLAIN, "sheet": PLAIN}, {"sheet": THICK}), WIDTH * THICK),
    ):
        pulled = np.zeros((len(model.nodes), 6))
        pulled[:, 0] = 1e-6 * model.nodes[:, 0]
        turn = model.rigid_modes()[:, 4]
        energy = turn @ (model.stress_stiffness(pulled.ravel()) @ turn)
        assert energy == pytest.approx(70e9 * 1e-6 * area * LENGTH, rel=1e-9)


def test_masses_and_springs_are_on_shells():
    plate = strip(cells=2)
    lumped = [LumpedMass("tip", mass=0.5), LumpedSpring("tip", stiffness=(0.0, 0.0, 1e4))]
    bare, loaded = (
        shell_body(plate, PLAIN, {"root": "clamped"}, THICK, kf.CraigBampton(modes=3), lumped=own)
        for own in ((), lumped)
    )
    assert loaded.mass == pytest.approx(bare.mass + 0.5)
    assert loaded.frequencies[0] < 0.6 * bare.frequencies[0]
    with pytest.raises(ModelError, match="lumped="):
        shell_model(plate, PLAIN, THICK, lumped=[0.5])


def test_what_does_not_meet_is_refused():
    box = box_mesh((LENGTH / 2, WIDTH, THICK), (2, 1, 1), start=(0.0, -WIDTH / 2, -THICK / 2))
    materials, thickness = {"block": PLAIN, "sheet": PLAIN}, {"sheet": THICK}
    apart = on_box(box, {"sheet": strip(LENGTH / 2 + 0.01, across=1)})
    with pytest.raises(MeshError, match="the shell meets the solids nowhere"):
        shell_model(apart, materials, thickness)
    lying = on_box(box, {"sheet": strip(0.1, cells=1, across=1, height=THICK / 2)})
    with pytest.raises(MeshError, match="of that lies on the solid"):
        shell_model(lying, materials, thickness)
    with pytest.raises(MeshError, match="a material for the groups of facets that are shells"):
        shell_model(apart, PLAIN, THICK)
    with pytest.raises(ModelError, match="the group 'block' has no material"):
        shell_model(half_and_half(), {"sheet": PLAIN}, thickness)
    dropped = apart.with_order(2)
    with pytest.raises(MeshError, match="'sheet' of facets is empty"):
        shell_model(dropped, materials, thickness)


@pytest.mark.gmsh
def test_a_geometry_with_a_wall_on_a_block_is_read_with_both(tmp_path):
    pytest.importorskip("gmsh")
    source = tmp_path / "wall.geo"
    source.write_text(
        """SetFactory("OpenCASCADE");
Box(1) = {-0.05, -0.03, -0.05, 0.1, 0.06, 0.05};
Rectangle(100) = {0, -0.03, 0, 0.15, 0.06};
Rotate {{0, 1, 0}, {0, 0, 0}, -Pi/2} { Surface{100}; }
BooleanFragments{ Volume{1}; Delete; }{ Surface{100}; Delete; }
Physical Volume("block") = {1};
wall() = Surface In BoundingBox{-0.001, -0.031, -0.001, 0.001, 0.031, 0.151};
Physical Surface("wall") = {wall()};
Mesh.MeshSizeMax = 0.05;
"""
    )
    materials, thickness = {"block": PLAIN, "wall": PLAIN}, {"wall": 4e-3}
    for mesh in (read_mesh(source), read_mesh(source, order=2)):
        model = shell_model(mesh, materials, thickness)
        assert model.provenance["seams"]["edges"] > 0
        check_rigid(model, 2700.0 * (0.1 * 0.06 * 0.05 + 0.15 * 0.06 * 4e-3))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"section": 3.0, "material": PLAIN}, "the section of a stiffener"),
        ({"section": Rectangle(0.01, 0.01)}, "the material of a stiffener is None"),
        ({"section": Rectangle(0.01, 0.01), "material": PLAIN, "offset": "beside"}, "offset='beside'"),
        ({"section": Rectangle(0.01, 0.01), "material": PLAIN, "offset": (0.0, np.nan, 0.0)}, "offset="),
        ({"section": Rectangle(0.01, 0.01), "material": PLAIN, "orientation": (0.0, 0.0, 0.0)}, "orientation="),
    ],
)
def test_a_stiffener_that_is_none_is_refused(arguments, words):
    with pytest.raises(ModelError, match=words):
        Stiffener(**arguments)


def test_a_stiffener_that_does_not_fit_the_shell_is_refused():
    rib = Stiffener(Rectangle(0.01, 0.01), PLAIN)
    with pytest.raises(MeshError, match="no group of lines 'web'"):
        shell_model(strip(cells=1), PLAIN, THICK, beams={"web": rib})
    along = Stiffener(Rectangle(0.01, 0.01), PLAIN, orientation=(1.0, 0.0, 0.0))
    with pytest.raises(ModelError, match="along the local z"):
        shell_model(ribbed(2), PLAIN, THICK, beams={"rib": along})
    numbers = Section(A=1e-4, I_y=1e-9, I_z=1e-9, J=1e-9)
    with pytest.raises(ModelError, match="needs the shape of its section"):
        shell_model(ribbed(2), PLAIN, THICK, beams={"rib": Stiffener(numbers, PLAIN, "above")})
