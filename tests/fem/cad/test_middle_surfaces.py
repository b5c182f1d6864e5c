"""Middle surfaces of thin solids: area times thickness is the volume, areas are closed forms, the rest is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.shapes import measures
from kanefe_fem import Material, read_mesh, shell_body, shell_model, solid_body
from kanefe_fem.cad.middle import middle_volume
from kanefe_fem.mesh.checks import MeshWarning
from step_files import two_boxes, write_step

pytestmark = pytest.mark.gmsh

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
CURVED = 1e-4
"""Of area, relative: parabolas along a quarter of a turn in two cells."""


def extruded(occ: Any, points: list[tuple[float, float]], width: float = 40.0) -> Any:
    """Extrude a polygon of the x-z plane along y."""
    tags = [occ.addPoint(x, 0, z) for x, z in points]
    lines = [occ.addLine(one, other) for one, other in zip(tags, tags[1:] + tags[:1], strict=True)]
    return occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, width, 0)


def plate_with_hole(occ: Any) -> None:
    plate = occ.addBox(0, 0, 0, 100, 60, 2)
    occ.cut([(3, plate)], [(3, occ.addCylinder(50, 30, -1, 0, 0, 4, 10))])


def bent(occ: Any) -> list[tuple[int, int]]:
    """A sheet of 2 mm, 40 wide, bent by 90 degrees with an inner radius of 3."""
    places = [(0, 0), (60, 0), (65, 5), (65, 50), (63, 50), (63, 5), (60, 2), (0, 2)]
    p, centre = [occ.addPoint(x, 0, z) for x, z in places], occ.addPoint(60, 0, 5)
    around = [
        occ.addCircleArc(p[i], centre, p[i + 1]) if i in (1, 5) else occ.addLine(p[i], p[(i + 1) % 8]) for i in range(8)
    ]
    return occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(around)]))], 0, 40, 0)  # type: ignore[no-any-return]


def bent_and_turned(occ: Any) -> None:
    (solid,) = [each for each in bent(occ) if each[0] == 3]
    occ.rotate([solid], 10, 20, 30, 1, 2, 3, 0.7)


def bent_with_holes(occ: Any) -> None:
    """With a hole in each flange, and one through the bend."""
    (solid,) = [each for each in bent(occ) if each[0] == 3]
    holes = [occ.addCylinder(30, 20, -1, 0, 0, 4, 6), occ.addCylinder(62, 20, 35, 4, 0, 0, 5)]
    occ.cut([solid], [(3, one) for one in (*holes, occ.addCylinder(68, 30, -3, -10, 0, 10, 3))])


def tube(occ: Any) -> None:
    occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 100, 20))], [(3, occ.addCylinder(0, 0, 0, 0, 0, 100, 18))])


def box_of_walls(occ: Any) -> None:
    occ.cut([(3, occ.addBox(0, 0, 0, 100, 60, 40))], [(3, occ.addBox(2, 2, 2, 96, 56, 36))])


def sharp_of_two_thicknesses(occ: Any) -> None:
    extruded(occ, [(0, 0), (60, 0), (60, 50), (57, 50), (57, 2), (0, 2)])


def z_profile(occ: Any) -> None:
    extruded(occ, [(0, 0), (60, 0), (60, 48), (100, 48), (100, 50), (58, 50), (58, 2), (0, 2)])


LENGTH, WIDTH, HEIGHT, THIN = 119.30946213382057, 33.07045173388401, 44.452309284168194, 1.5074079431055027


def sharp_at_uneven_places(occ: Any) -> None:
    """Of two boxes, whose sides are off their planes by round-off: found by a random scene."""
    occ.fuse([(3, occ.addBox(0, 0, 0, LENGTH, WIDTH, THIN))], [(3, occ.addBox(0, 0, 0, THIN, WIDTH, HEIGHT))])


@pytest.mark.parametrize(
    ("build", "area", "tolerance"),
    [
        (plate_with_hole, 6000.0 - 100.0 * np.pi, CURVED),
        (bent, 40.0 * (60.0 + 2.0 * np.pi + 45.0), CURVED),
        (bent_and_turned, 40.0 * (60.0 + 2.0 * np.pi + 45.0), CURVED),
        (tube, 100.0 * 38.0 * np.pi, CURVED),
        (box_of_walls, 2.0 * (98 * 58 + 98 * 38 + 58 * 38), 1e-12),
        (sharp_of_two_thicknesses, 40.0 * (58.5 + 49.0), 1e-12),
        (z_profile, 40.0 * (59.0 + 48.0 + 41.0), 1e-12),
        (sharp_at_uneven_places, WIDTH * (LENGTH + HEIGHT - THIN), 1e-12),
    ],
)
def test_areas_are_closed_forms_and_the_middle_is_half_the_thickness_deep(tmp_path, build, area, tolerance):
    path = write_step(tmp_path / "part.step", build)
    mesh = read_mesh(path, size=0.006, midsurface=True)
    assert (mesh.order, mesh.dimension) == (2, 2)
    found = sum(float(measures(b.kind, mesh.nodes[b.nodes])[0].sum()) for b in mesh.cell_blocks)
    assert found == pytest.approx(1e-6 * area, rel=tolerance)
    assert "area times thickness" in mesh.provenance["middle surface"]
    solid = read_mesh(path, size=0.006, order=2)
    from_solid = float(sum(measures(b.kind, solid.nodes[b.nodes])[0].sum() for b in solid.cell_blocks))
    # corners of three walls have t^3 / 3 too little, a miter of two thicknesses nothing
    assert middle_volume(mesh) == pytest.approx(from_solid, rel=4e-4 if build is box_of_walls else 2e-4)


def test_a_bend_is_half_way_between_its_cylinders(tmp_path):
    mesh = read_mesh(write_step(tmp_path / "part.step", bent), size=0.006, midsurface=True)
    on_bend = (mesh.nodes[:, 0] > 0.0601) & (mesh.nodes[:, 2] < 0.0049)
    radius = np.hypot(mesh.nodes[on_bend, 0] - 0.06, mesh.nodes[on_bend, 2] - 0.005)
    assert on_bend.sum() > 10
    assert radius == pytest.approx(0.004, rel=1e-9)


def test_groups_and_thicknesses(tmp_path):
    path = write_step(tmp_path / "part.step", sharp_of_two_thicknesses)
    mesh = read_mesh(path, size=0.01, midsurface=True)
    assert mesh.thickness == pytest.approx({"part 2 mm": 2e-3, "part 3 mm": 3e-3}, rel=1e-12)
    assert "thickness part 2 mm 2 mm, part 3 mm 3 mm" in str(mesh)
    faces = {"root": kf.OnPlane((0, 0, 0), (1, 0, 0)), "wall": kf.OnPlane((0.06, 0, 0), (1, 0, 0))}
    mesh = read_mesh(path, size={"*": 0.01, "wall": 0.005}, midsurface=True, faces=faces)
    assert set(mesh.cells) == {"wall", "part"}
    assert set(mesh.facets) == {"root"}
    assert mesh.thickness == pytest.approx({"wall": 3e-3, "part": 2e-3}, rel=1e-12)
    assert sum(len(b.nodes) for b in mesh.cells["wall"]) > 1.5 * sum(len(b.nodes) for b in mesh.cells["part"])
    edge = mesh.nodes[np.unique(mesh.facets["root"][0].nodes)]
    assert edge[:, [0, 2]] == pytest.approx(np.tile([0.0, 1e-3], (len(edge), 1)), abs=1e-12)
    assert len(mesh.with_groups({"top": kf.OnPlane((0, 0, 0.05), (0, 0, 1))}).facets["top"])


def wedge(occ: Any) -> None:
    extruded(occ, [(0, 0), (60, 0), (60, 3), (0, 1)])


def stepped(occ: Any) -> None:
    extruded(occ, [(0, 0), (60, 0), (60, 3), (30, 3), (30, 2), (0, 2)])


def tee(occ: Any) -> None:
    occ.fuse([(3, occ.addBox(0, 0, 0, 100, 60, 2))], [(3, occ.addBox(49, 0, 2, 2, 60, 40))])


def dome(occ: Any) -> None:
    occ.cut([(3, occ.addSphere(0, 0, 0, 50, angle1=0))], [(3, occ.addSphere(0, 0, 0, 48, angle1=0))])


def pillar_on_plate(occ: Any) -> None:
    occ.fuse([(3, occ.addBox(0, 0, 0, 100, 60, 2))], [(3, occ.addCone(50, 30, 2, 0, 0, 20, 8, 5))])


def tapered_at_one_end(occ: Any) -> None:
    extruded(occ, [(0, 0), (100, 0), (130, 0.4), (130, 1.6), (100, 2), (0, 2)])


@pytest.mark.parametrize(
    ("build", "reason"),
    [
        (lambda occ: occ.addBox(0, 0, 0, 10, 10, 10), r"not thin: 10 mm thick, with a middle surface of 100 mm2"),
        (wedge, r"thickness under the plane face at \(0\.03, 0\.02, 0\.002\) m varies from 1\.2\d* mm to 2\.8\d* mm"),
        (stepped, r"at \(0\.03, 0\.02, 0\) m is 2 mm at one place and 3 mm at another"),
        (tee, r"branches, as a T does: the plane face at"),
        (dome, r"the face at \(0, 0, 0\.025\) m is neither a plane nor a cylinder"),
        (pillar_on_plate, r"plane face at \(0\.05, 0\.03, 0\) m is 2 mm at one place and 22 mm at another"),
        (tapered_at_one_end, r"thickness under the plane face .* varies from .* mm to .* mm, and it is too wide"),
    ],
)
def test_what_is_no_sheet_is_refused_with_the_face_and_the_reason(tmp_path, build, reason):
    path = write_step(tmp_path / "part.step", build)
    with pytest.raises(MeshError, match=rf"part\.step: no middle surface of 'part': .*{reason}.*Remedy: mesh it as"):
        read_mesh(path, size=0.01, midsurface=True)


def test_chamfers_and_countersinks_are_told_by_the_volume(tmp_path):
    def countersunk(occ: Any) -> None:
        hole, cone = occ.addCylinder(20, 15, -1, 0, 0, 4, 3), occ.addCone(20, 15, 0.5, 0, 0, 1.5, 3, 4.5)
        occ.cut([(3, occ.addBox(0, 0, 0, 40, 30, 2))], [(3, hole), (3, cone)])

    # the larger side is meshed, with the hole of 3 mm: what the cone takes beside it is too much
    cone = np.pi * 1.5 * (9.0 + 13.5 + 20.25) / 3.0 - np.pi * 1.5 * 9.0
    lost = 100.0 * cone / (1200.0 * 2.0 - 18.0 * np.pi - cone)
    with pytest.warns(MeshWarning, match=rf"times its thickness has \+{lost:.2g} % of volume.*chamfered"):
        read_mesh(write_step(tmp_path / "part.step", countersunk), size=0.004, midsurface=True)


@pytest.mark.parametrize(
    ("keywords", "error", "message"),
    [
        ({}, ModelError, r"needs a size of the cells.*such as size="),
        (
            {"size": 1e-3},
            MeshError,
            r"cells at the fold at .* smaller than half the thickness of [23] mm.*larger size=",
        ),
        ({"size": 0.01, "midsurface": 1}, ModelError, r"midsurface"),
        ({"size": 0.01, "faces": {"all": lambda x: np.ones(len(x), bool)}}, MeshError, r"a name for each thickness"),
    ],
)
def test_bad_input_is_named(tmp_path, keywords, error, message):
    path = write_step(tmp_path / "part.step", sharp_of_two_thicknesses)
    with pytest.raises(error, match=message):
        read_mesh(path, **{"midsurface": True, **keywords})


def test_two_sides_of_a_sheet_are_one_group(tmp_path):
    path = write_step(tmp_path / "part.step", bent)
    faces = {"top": kf.OnPlane((0, 0, 0.002), (0, 0, 1)), "below": kf.OnPlane((0, 0, 0), (0, 0, 1))}
    with pytest.raises(MeshError, match=r"'top' and 'below' are two sides of one sheet.*Remedy: one of them"):
        read_mesh(path, size=0.01, midsurface=True, faces=faces)


@pytest.mark.fenicsx
def test_a_shell_takes_the_thickness_of_its_mesh(tmp_path):
    mesh = read_mesh(write_step(tmp_path / "part.step", sharp_of_two_thicknesses), size=0.02, midsurface=True)
    model = shell_model(mesh, STEEL)
    assert model.mass_field.mass.sum() == pytest.approx(7850.0 * middle_volume(mesh), rel=1e-12)
    assert model.provenance["thickness_m"] == pytest.approx(dict(mesh.thickness), rel=1e-12)
    thicker = shell_model(mesh, STEEL, {"part 2 mm": 4e-3})
    assert thicker.provenance["thickness_m"] == pytest.approx({"part 2 mm": 4e-3, "part 3 mm": 3e-3}, rel=1e-12)


@pytest.mark.fenicsx
@pytest.mark.slow
@pytest.mark.parametrize("build", [plate_with_hole, bent_with_holes])
def test_frequencies_are_those_of_the_solid(tmp_path, build):
    path = write_step(tmp_path / "part.step", build)
    faces = {"root": kf.OnPlane((0, 0, 0), (1, 0, 0))}
    reduction = kf.CraigBampton(modes=6)
    surface = read_mesh(path, size=0.006, per_turn=16, midsurface=True, faces=faces)
    shell = shell_body(surface, STEEL, {"root": "clamped"}, reduction=reduction)
    volume = read_mesh(path, size=0.0025, order=2, faces=faces)
    solid = solid_body(volume, STEEL, {"root": "clamped"}, reduction)
    # the hole through the bend is not square to the sheet
    assert shell.mass == pytest.approx(solid.mass, rel=1e-4 if build is plate_with_hole else 3e-3)
    # one tetrahedron through the thickness is 0.2 to 0.4 % too stiff: 1.5 mm gives -0.1 to -0.5 %
    assert shell.frequencies == pytest.approx(solid.frequencies, rel=0.008)


def test_several_parts_have_a_middle_surface_each(tmp_path):
    path = write_step(tmp_path / "parts.step", two_boxes, names=("one", "two"))
    with pytest.raises(MeshError, match=r"middle surface is of one part, and these are 2"):
        read_mesh(path, size=0.01, midsurface=True, joined=True)
