"""Assemblies from STEP: parts and their masses, proposed joints, what does not fit, and scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
import step_files
from fem_meshes import STEEL
from kanefe.errors import FileError, ModelError
from kanefe_fem import Assembly, Material, read_step
from step_files import write_step

pytestmark = pytest.mark.gmsh

KNOWN: dict[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "hinge": (("fork", "arm", "pin"), {"pin in fork": "cylindrical", "pin in arm": "cylindrical"}),
    "shaft_with_play": (("bearing", "shaft"), {"shaft in bearing": "revolute"}),
    "slider": (("slot", "box"), {"slot on box": "prismatic"}),
    "decoys": (("low", "high", "shaft", "rod"), {"low on high": "planar"}),
    "turned_hinge": (("fork", "arm", "pin"), {"pin in fork": "cylindrical", "pin in arm": "cylindrical"}),
}
"""Names of the parts and kinds of the joints of assemblies of `step_files`."""


def assembly_of(name: str, folder: Path, **keywords: Any) -> Assembly:
    names = KNOWN[name][0]
    path = folder / f"{name}.step"
    if not path.exists():
        write_step(path, getattr(step_files, name), names=names)
    return read_step(path, **{"materials": 7850.0} | keywords)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder in which each file is written once."""
    return tmp_path_factory.mktemp("assemblies")


@pytest.fixture(scope="module")
def hinge(folder: Path) -> Assembly:
    return assembly_of("hinge", folder)


@pytest.mark.parametrize("name", KNOWN)
def test_the_joints_of_known_assemblies_are_proposed_and_no_others(folder, name):
    found = assembly_of(name, folder, overlaps=False)
    assert {joint.name: joint.kind for joint in found.joints.values()} == KNOWN[name][1]
    assert tuple(found.parts) == KNOWN[name][0]


def test_a_proposed_joint_has_its_axis_radius_play_and_certainty(hinge, folder):
    pin = hinge.joints["pin in arm"]
    assert pin.point == pytest.approx([0.0, 0.0, 0.022], abs=1e-9)  # the middle of the arm's eye
    assert pin.axis == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)
    assert (pin.radius, pin.play) == (pytest.approx(0.004), pytest.approx(0.0, abs=1e-9))
    assert pin.certainty == "likely"
    shaft = assembly_of("shaft_with_play", folder, overlaps=False).joints["shaft in bearing"]
    assert shaft.play == pytest.approx(1e-4, rel=1e-6)
    assert shaft.certainty == "possible"  # a flange lies on the bearing: a bolt would too
    assert "a hinge with a shoulder, or a bolt" in str(shaft)


def test_parts_have_the_masses_of_their_solids(hinge):
    pin = hinge.parts["pin"]
    mass = 7850.0 * np.pi * 0.004**2 * 0.024
    assert pin.mass == pytest.approx(mass, rel=1e-9)
    along, across = mass * 0.004**2 / 2, mass * (3 * 0.004**2 + 0.024**2) / 12
    assert pin.inertia == pytest.approx(np.diag([across, along, across]), abs=1e-9 * across)
    assert pin.center == pytest.approx([0.0, 0.0, 0.022], abs=1e-12)
    corners = pin.vertices[pin.triangles]
    inside = np.einsum("mx,mx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert inside == pytest.approx(pin.volume, rel=0.05)  # twelve sides for the circle, from inside
    assert inside > 0.0


def test_materials_by_part_and_for_all_others(folder):
    found = assembly_of("hinge", folder, materials={"pin": STEEL, "*": 2700.0}, overlaps=False)
    densities = {name: part.density for name, part in found.parts.items()}
    assert densities == {"fork": 2700.0, "arm": 2700.0, "pin": STEEL.rho}


def test_a_group_of_faces_cannot_have_the_name_of_a_joint(folder):
    tip = {"pin in arm": kf.OnPlane((0.054, 0, 0), (1, 0, 0))}
    with pytest.raises(ModelError, match="'pin in arm' is a proposed joint, whose faces are a group already"):
        assembly_of("hinge", folder, materials=STEEL, flexible=["arm"], size=0.02, faces=tip, overlaps=False)


def test_what_does_not_fit_is_told(tmp_path):
    path = write_step(
        tmp_path / "odd.step",
        lambda occ: (step_files.two_boxes(occ), occ.addBox(8, 0, 0, 4, 4, 4), occ.addSphere(50, 0, 0, 5)),
        names=("long", "cube", "wedge", "ball"),
    )
    found = read_step(path, 1000.0)
    assert [one.parts for one in found.overlaps] == [("long", "wedge")]
    assert found.overlaps[0].volume == pytest.approx(32e-9, rel=1e-6)
    ((name, nearest, distance),) = found.alone
    assert (name, nearest) == ("ball", "cube")
    assert distance == pytest.approx(np.linalg.norm([30, 5, 5]) * 1e-3 - 0.005, rel=0.1)  # by points on the faces
    text = str(found)
    assert "long and wedge: overlap by 32 mm3" in text
    assert "ball: no plane or cylinder of it meets a part; cube is at most" in text


def test_a_scene_of_the_taken_joints_swings_as_a_pendulum(hinge):
    """The arm alone about the pin, from level: its first acceleration is that of a physical pendulum."""
    scene = hinge.scene("fork", {"pin in fork": "fixed", "pin in arm": "revolute"})
    arm = hinge.parts["arm"]
    lever = arm.center - np.array([0.0, 0.0, 0.022])
    turning = arm.inertia[1, 1] + arm.mass * (lever @ lever)
    result = scene.simulate((0.0, 0.01), rtol=1e-10)
    expected = arm.mass * 9.81 * lever[0] / turning
    assert abs(result.joint_speeds("arm")[-1, 0]) == pytest.approx(expected * 0.01, rel=1e-3)  # it barely turns
    assert {surface.name for surface in result.surfaces} == {"fork", "arm", "pin"}  # what pages draw


def test_loops_are_closed_by_what_is_taken_beyond_a_tree(tmp_path):
    def four_bars(occ: Any) -> None:
        """Two posts on a base, and a plate with a pin in each of its two holes."""
        posts = [(3, occ.addCylinder(x, 5, 5, 0, 0, 12, 2)) for x in (5, 55)]
        occ.fuse([(3, occ.addBox(0, 0, 0, 60, 10, 5))], posts)
        for x in (5, 55):
            bar = occ.addBox(x - 4, 1, 6, 8, 40, 4)
            holes = [(3, occ.addCylinder(x, y, 0, 0, 0, 20, 2)) for y in (5, 35)]
            occ.cut([(3, bar)], holes)
        pins = [(3, occ.addCylinder(x, 35, 5.5, 0, 0, 6, 2)) for x in (5, 55)]
        occ.fuse([(3, occ.addBox(0, 31, 11, 60, 8, 4))], pins)

    path = write_step(tmp_path / "bars.step", four_bars, names=("base", "left", "right", "coupler"))
    found = read_step(path, 2700.0, overlaps=False)
    names = {"base in left", "base in right", "coupler in left", "coupler in right"}
    assert {n for n, joint in found.joints.items() if joint.kind == "cylindrical"} == names
    report = found.scene("base", dict.fromkeys(sorted(names), "revolute")).freeze().constraint_report()
    assert report.degrees_of_freedom == 1


@pytest.mark.fenicsx
def test_a_flexible_part_is_a_body_with_its_joints_as_interfaces(folder):
    materials = {"arm": STEEL, "*": 7850.0}
    found = assembly_of("hinge", folder, materials=materials, flexible=["arm"], size=0.008, overlaps=False)
    assert set(found.parts["arm"].mesh.facets) == {"pin in arm"}
    scene = found.scene("fork", {"pin in fork": "fixed", "pin in arm": "revolute"}, reduction=kf.CraigBampton(modes=2))
    arm = next(entry for entry in scene._entries if entry.name == "arm").flexible
    assert arm.mass == pytest.approx(found.parts["arm"].mass, rel=1e-3)  # parabolas on a hole of a few sides


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"materials": {"pim": 1.0, "*": 2.0}}, "names 'pim'.*Did you mean 'pin'"),
        ({"materials": {"*": 0.0}}, r"density of '\*' is 0\.0"),
        ({"materials": {"*": "steel"}}, "a Material, or a density"),
        ({"flexible": ["arm"], "size": 0.01}, "'arm' needs a Material with E, nu and rho, not 7850"),
        ({"flexible": ["crank"], "size": 0.01}, "no part called 'crank'"),
        ({"joined": True}, "read_mesh"),
        ({"materials": {"arm": Material(E=1e9, nu=0.3, rho=1e3), "*": 1e3}, "flexible": "arm"}, "needs a size"),
    ],
)
def test_bad_input_is_named(folder, keywords, message):
    with pytest.raises(ModelError, match=message):
        assembly_of("hinge", folder, **keywords)


def test_other_files_and_parts_without_material_are_refused(tmp_path, folder, hinge):
    (tmp_path / "part.stl").write_text("solid")
    with pytest.raises(FileError, match="no STEP or BREP file"):
        read_step(tmp_path / "part.stl")
    found = assembly_of("slider", folder, materials=None, overlaps=False)
    assert "no material, 5." in str(found) or "no material" in str(found)
    with pytest.raises(ModelError, match="'slot' has no material, and so no mass"):
        found.scene("slot", ["slot on box"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("forks", ["pin in fork"]), "no part called 'forks'.*Did you mean 'fork'"),
        (("fork", ["arm in pin"]), "no joint 'arm in pin' is proposed"),
        (("fork", {"pin in fork": "welded"}), "is welded, which is no joint"),
        (("fork", ["pin in fork"]), "no joint that is taken reaches 'arm' from 'fork'.*take 'pin in arm'"),
    ],
)
def test_joints_that_cannot_be_taken_are_named(hinge, arguments, message):
    with pytest.raises(ModelError, match=message):
        hinge.scene(*arguments)
    assert hinge.scene("fork", ["pin in fork"], without=["arm"]).freeze()
