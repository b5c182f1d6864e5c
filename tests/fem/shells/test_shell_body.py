"""Shell bodies: what is refused, thickness by group and place, bodies in scenes, stiffening by spin."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe.bodies.inner_rotations import inner_rotations
from kanefe.errors import AccuracyWarning, MeshError, ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import shape
from kanefe.tree.bending import _reach
from kanefe_fem import (
    Laminate,
    Material,
    Oriented,
    Ply,
    box_mesh,
    read_mesh,
    shell_body,
    shell_model,
    solid_body,
    solid_model,
    surface_mesh,
)
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.mesh import Mesh
from shell_meshes import grid

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


@pytest.mark.parametrize(
    ("thickness", "words"),
    [
        (None, "group 'body' has no thickness"),
        (0.0, "thickness of group 'body' is 0.0"),
        (-1e-3, "positive number of metres"),
        (float("nan"), "positive number of metres"),
        ("2 mm", "positive number of metres"),
        (lambda x: np.zeros(len(x)), "no positive finite number"),
        (lambda x: 1e-3, "no positive finite number"),
    ],
)
def test_a_thickness_that_is_none_is_refused(thickness, words):
    with pytest.raises(ModelError, match=words):
        shell_model(grid("plate", 1), STEEL, thickness)


def turned(mesh, which):
    """The mesh with the nodes of some cells in the other order."""
    table = np.array(mesh.connectivity)
    table[which] = table[which][:, shape(mesh.kind).reversal()]
    return Mesh(mesh.nodes, 2, {"body": (Cells(mesh.kind, table),)}, facets=mesh.facets)


@pytest.mark.parametrize(("which", "side"), [([], 1.0), (slice(None), -1.0), ([0, 3], 1.0), (slice(2, None), -1.0)])
def test_offsets_and_pressures_go_by_the_normals_of_most_cells(which, side):
    mesh = turned(surface_mesh(lambda s, r: (s, 0.5 * r, 0.0 * s), (4, 2)), which)
    told = len(which) if isinstance(which, list) else 2 if which.start else 0
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MeshWarning)
        model = shell_model(mesh, STEEL, 0.02, offset=0.5, surfaces=("body",))
    words = [str(one.message) for one in caught if one.category is MeshWarning]
    assert [f"{told} cells have their normal on the other side" in one for one in words] == ([True] if told else [])
    assert all("offset=, surfaces= go by the normals of most" in one for one in words)
    assert model.provenance["cells turned"] == told
    weights = model.mass_field.mass @ np.ones(len(model.mass_field.points))
    centre = weights @ np.asarray(model.mass_field.points) / weights.sum()
    assert centre == pytest.approx([0.5, 0.25, side * 0.01], rel=1e-12)
    assert model.load_patterns["body"].pressure_force == pytest.approx([0.0, 0.0, -side * 0.5], abs=1e-14)


def test_a_plane_solid_is_the_same_from_below():
    mesh = surface_mesh(lambda s, r: (s, 0.5 * r, 0.0 * s), (3, 2))
    above, below = (solid_model(one, STEEL, plane="stress", thickness=0.1) for one in (mesh, turned(mesh, slice(None))))
    assert abs(above.stiffness - below.stiffness).max() <= 1e-12 * abs(above.stiffness).max()


def test_what_is_no_shell_is_refused():
    with pytest.raises(MeshError, match=r"has volumes, and a shell is a surface. Remedy: solid_body"):
        shell_model(box_mesh((1.0, 1.0, 0.1), (1, 1, 1)), STEEL, 0.1)
    with pytest.raises(MeshError, match="shell_body"):
        solid_model(grid("saddle", 1), STEEL, plane="stress", thickness=0.1)
    stack = Laminate([Ply(STEEL, 1e-3), Ply(STEEL, 1e-3)])
    with pytest.raises(ModelError, match=r"is 0.003 m, but its plies make 0.002 m"):
        shell_model(grid("plate", 1), stack, 3e-3)
    across = np.array([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
    with pytest.raises(ModelError, match="axis 1 of the material of group 'body' is across the surface"):
        shell_model(grid("plate", 1), Oriented(STEEL, across), 1e-3)
    with pytest.raises(ModelError, match="offset of group 'body'"):
        shell_model(grid("plate", 1), STEEL, 1e-3, offset=float("inf"))
    with pytest.raises(ModelError, match=r"fold=20 rad .* Remedy: radians"):
        shell_model(grid("plate", 1), STEEL, 1e-3, fold=20.0)
    with pytest.warns(AccuracyWarning, match=r"offset of group 'body' is 0.0005 of its thickness.* no length in m"):
        shell_model(grid("plate", 1), STEEL, 1e-3, offset=5e-4)


def test_cells_without_area_and_folded_cells_are_refused():
    mesh = grid("saddle", 2)
    nodes = np.array(mesh.nodes)
    nodes[mesh.cell_blocks[0].nodes[0]] = nodes[mesh.cell_blocks[0].nodes[0, 0]]
    with pytest.raises(MeshError, match=r"Jacobian vanishes in cell 0 of group 'body'"):
        shell_model(Mesh(nodes, 2, mesh.cells), STEEL, 0.01)
    nodes = np.array(mesh.nodes)
    corner = mesh.cell_blocks[0].nodes[0]
    nodes[corner[8]] = nodes[corner[1]] + 0.3 * (nodes[corner[1]] - nodes[corner[0]])
    with pytest.raises(MeshError, match=r"changes its sign inside cell 0"):
        shell_model(Mesh(nodes, 2, mesh.cells), STEEL, 0.01)


@pytest.mark.fenicsx
def test_thickness_by_group_and_by_place_weighs():
    mesh = grid("plate", 4, 2)
    cells = mesh.cell_blocks[0].nodes
    left = np.asarray(mesh.nodes)[cells[:, 8], 0] < 0.5
    groups = {"left": (Cells("quad9", cells[left]),), "right": (Cells("quad9", cells[~left]),)}
    two = Mesh(mesh.nodes, 2, groups)
    both = {"left": STEEL, "right": STEEL}
    model = shell_model(two, both, {"left": 1e-3, "right": lambda x: 1e-3 + 2e-3 * (x[:, 0] - 0.5)})
    mass = model.rigid_modes().T @ model.mass @ model.rigid_modes()
    assert mass[0, 0] == pytest.approx(7850.0 * (0.5e-3 + 0.5 * 1.5e-3), rel=1e-12)
    with pytest.raises(ModelError, match="group 'right' has no thickness"):
        shell_model(two, both, {"left": 1e-3})
    with pytest.raises(ModelError, match="a thickness is given for 'middle'"):
        shell_model(two, both, {"left": 1e-3, "right": 1e-3, "middle": 1e-3})
    with pytest.raises(ModelError, match="an offset is given for 'middle'"):
        shell_model(two, both, 1e-3, offset={"middle": 0.5})


@pytest.mark.fenicsx
def test_without_a_reduction_modes_follow_from_the_body():
    """Of a shell and of a solid; of the shell against all its degrees of freedom, which only None keeps."""
    sheet, ends = surface_mesh(lambda s, r: (0.4 * s, 0.2 * r, 0.0 * s), (4, 2)), {"root": "clamped", "tip": "average"}
    body, whole = (shell_body(sheet, STEEL, ends, 2e-3, **more) for more in ({}, {"reduction": None}))
    bar = solid_body(box_mesh((0.4, 0.03, 0.02), (4, 1, 1)), STEEL, {"root": "clamped"})
    for made in (body, bar):
        assert "reduced to" in str(made)
        assert made.provenance["reduction"]["error_estimate"]["value"] <= 0.01
    limit = body.provenance["reduction"]["error_estimate"]["up_to_frequency"]
    exact = whole.frequencies[whole.frequencies < limit]
    assert len(exact) > 1
    assert body.frequencies[: len(exact)] == pytest.approx(exact, rel=1e-3)
    assert body.free_count < 0.2 * whole.free_count


@pytest.mark.fenicsx
def test_a_strip_bends_as_a_beam():
    """Tip of a cantilever, nu = 0: F L^3 / (3 E I) + F L / (k G A)."""
    soft = Material(E=1e9, nu=0.0, rho=1000.0)
    length, width, t = 1.0, 0.1, 0.02
    strip = surface_mesh(lambda s, r: (length * s, 0.0 * s, width * r), (8, 1))
    body = shell_body(strip, soft, {"root": "clamped", "tip": "rigid"}, t)
    scene = kf.System()
    tip = scene.add_flexible_body("strip", body).interface("tip")
    scene.add_force(tip, (0.0, 1.0, 0.0))
    rest = kf.equilibrium(scene)
    found = rest.position("strip", "tip")[1]
    inertia = width * t**3 / 12.0
    expected = length**3 / (3e9 * inertia) + length / (5.0 / 6.0 * 0.5e9 * width * t)
    assert found == pytest.approx(expected, rel=1e-4)


GEO = """SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 1, 0, 0, 0.2};
Delete { Volume{1}; }
Physical Surface("tube") = {1};
Physical Curve("root") = {2};
Mesh.MeshSizeMax = 0.1;
"""


@pytest.mark.gmsh
@pytest.mark.fenicsx
def test_a_tube_from_gmsh_has_the_frequencies_of_its_refinement(tmp_path):
    """Curved sides stay curved; frequencies of a free tube against 4,800 cells: 33.378, 35.583 Hz, each twice."""
    path = tmp_path / "tube.geo"
    path.write_text(GEO)
    with pytest.warns(UserWarning, match="belong to no physical group"):
        mesh = read_mesh(path, order=2)
    body = shell_body(mesh, STEEL, {}, 2e-3, reduction=kf.CraigBampton(modes=4))
    assert body.mass == pytest.approx(STEEL.rho * 2e-3 * 0.4 * np.pi, rel=1e-4)
    assert body.frequencies[:4] == pytest.approx((33.378, 33.378, 35.583, 35.583), rel=0.05)


@pytest.mark.fenicsx
def test_a_pretwisted_blade_is_valid_as_far_as_a_flat_one():
    """Its inertia grows with one sign of the twist and falls with the other, which is no error."""

    def reaches(twist: float) -> list[float]:
        def place(s, r):
            return 0.05 + 0.4 * s, 0.08 * (r - 0.5) * np.cos(twist * s), 0.08 * (r - 0.5) * np.sin(twist * s)

        statics = kf.CraigBampton(modes=4, loads=("centrifugal",))
        blade = shell_body(
            surface_mesh(place, (6, 2)), STEEL, {"root": "clamped"}, 2e-3, statics, stiffening="inertial"
        )
        inner = inner_rotations(blade)
        found = []
        for eta in (sign * np.eye(blade.free_count)[mode] for mode in range(3) for sign in (1.0, -1.0)):
            turned = inner.largest(eta)[1]
            size = 0.004 / np.linalg.norm(turned)
            found.append(_reach(blade, size * eta, size * turned, inner))
        return found

    flat, twisted = reaches(0.0), reaches(0.2)
    assert min(twisted) > 0.9 * min(flat) > 0.09
    np.testing.assert_allclose(twisted[::2], twisted[1::2], rtol=1e-9)


@pytest.mark.fenicsx
def test_too_few_modes_for_buckling_are_told():
    """A strip tips at 1.031 times the closed form, which has free warping; four modes bend in the wrong plane."""
    mesh = surface_mesh(lambda s, r: (s, 0.0 * s, 0.05 * (r - 0.5)), (12, 1))
    plain = Material(E=70e9, nu=0.0, rho=2700.0)

    def found(modes: int) -> kf.Buckling:
        held = {"root": "clamped", "tip": "average"}
        strip = shell_body(mesh, plain, held, 2e-3, kf.CraigBampton(modes=modes), stiffening="full")
        scene = kf.System()
        scene.add_force(scene.add_flexible_body("strip", strip).interface("tip"), (0.0, 0.0, -1.0))
        return kf.buckling(scene)

    with pytest.warns(AccuracyWarning, match="upper half of the modes"):
        few = found(4)
    enough = found(16)
    assert enough.change_by_modes < 0.01 < 0.2 < few.change_by_modes
    assert "of the modes of bodies lowers the first by" in str(enough)
    closed = 4.0126 * 70e9 * 0.05 * 2e-3**3 / np.sqrt(12.0 * 6.0)
    assert enough.factors[0] == pytest.approx(1.031 * closed, rel=0.02)  # coarse cells
    assert few.factors[0] > 1.2 * enough.factors[0]
