"""URDF: accelerations are Pinocchio's, stored beside the files; what is wrong, or not taken, is named."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.results.surface_outline import outlines
from kanefe.robots.scene import NotTakenWarning, OddInertiaWarning
from robot_states import accelerations, difference

HERE = Path(__file__).parent
REFERENCE = json.loads((HERE / "pinocchio.json").read_text(encoding="utf-8"))
ROBOTS = [name for name in REFERENCE if name != "provenance"]
pytestmark = pytest.mark.urdf


def read(name: str, **choices: object) -> kf.RobotScene:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotTakenWarning)
        return kf.read_urdf(HERE / f"{name}.urdf", **choices)


def write(folder: Path, *elements: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(f"<robot name='r'>{''.join(elements)}</robot>", encoding="utf-8")
    return path


def link(name: str, mass: float = 1.0, moments: tuple[float, float, float] = (0.1, 0.1, 0.1)) -> str:
    ixx, iyy, izz = moments
    inertia = f"<inertia ixx='{ixx}' iyy='{iyy}' izz='{izz}'/>"
    return f"<link name='{name}'><inertial><mass value='{mass}'/>{inertia}</inertial></link>"


def joint(name: str, kind: str, parent: str, child: str, more: str = "") -> str:
    return f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{more}</joint>"


@pytest.mark.parametrize("name", ROBOTS)
def test_accelerations_are_pinocchios(name: str) -> None:
    scene = read(name, base=kf.Free() if "base" in REFERENCE[name]["state"] else None, joint_forces=False)
    found = accelerations(scene, REFERENCE[name]["state"])
    # round-off of some hundred operations a body
    assert difference(found, REFERENCE[name]["accelerations"]) < 1e-12


def test_what_is_not_taken_is_named() -> None:
    """Limits and collision shapes, which nearly every file has, are listed and not warned of."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", NotTakenWarning)
        scene = kf.read_urdf(HERE / "arm.urdf")
    with pytest.warns(NotTakenWarning, match="damping of joints: ") as told:
        kf.read_urdf(HERE / "arm.urdf", joint_forces=False)
    assert len(told) == 1
    assert Path(told[0].filename) == Path(__file__)
    assert scene.not_taken["collision shapes, which touch nothing"] == ("carriage",)
    assert scene.not_taken["limits of joints (limit_stiffness= takes them)"] == ("slide", "shoulder", "elbow", "wrist")
    assert scene.not_taken["limits of effort and velocity"] == ("slide", "shoulder", "elbow", "wrist")
    assert scene.not_taken["visuals"] == ("carriage",)
    assert scene.not_taken["transmission"] == ("shoulder drive",)
    assert scene.not_taken["gazebo"] == ("tool",)
    assert "damping of joints" not in scene.not_taken


def test_forces_and_limits_of_joints_are_taken() -> None:
    scene = read("arm", limit_stiffness=1e5, limit_damping=10.0, positions={"shoulder": 0.4})
    slide = scene._entries[1].joint.forces
    assert (slide.damping, slide.friction, tuple(slide.limits)) == (20.0, 4.0, (-0.5, 0.5))
    shoulder = scene._entries[3].joint
    assert (shoulder.position, shoulder.forces.damping, shoulder.forces.limit_stiffness) == (0.4, 0.5, 1e5)
    assert not any("limits of joints" in kind for kind in scene.not_taken)
    result = scene.simulate((0.0, 0.05), rtol=1e-6)
    assert result.status.is_finished
    assert result.joint_coordinates(scene.joints["shoulder"])[0] == pytest.approx(0.4)


def test_without_joint_forces_they_are_named() -> None:
    scene = read("arm", joint_forces=False)
    assert scene.not_taken["friction of joints"] == ("slide",)
    assert scene.not_taken["damping of joints"] == ("slide", "shoulder")


def test_a_mimic_keeps_to_its_joint_in_a_run() -> None:
    scene = read("gripper", positions={"close": 0.01})
    scene.add_motor(scene.body("finger"), 0.5)
    result = scene.simulate((0.0, 0.2), rtol=1e-8)
    close, thumb, wheel = (
        result.joint_coordinates(scene.joints[n])[:, 0] for n in ("close", "thumb_close", "wheel_turn")
    )
    assert abs(close[-1] - close[0]) > 1e-3
    assert thumb == pytest.approx(close, abs=1e-9)
    assert wheel == pytest.approx(0.2 - 40.0 * close, abs=1e-7)


@pytest.mark.parametrize(
    ("given", "driver", "follower"),
    [({}, 0.0, 0.3), ({"d": 0.0}, 0.0, 0.3), ({"d": 0.4}, 0.4, 1.1), ({"f": 1.1}, 0.4, 1.1), ({"f": 0.0}, -0.15, 0.0)],
)
def test_what_mimics_follows_and_what_is_given_stays(
    tmp_path: Path, given: dict[str, float], driver: float, follower: float
) -> None:
    """Zero is a place as any other, and a default that others follow."""
    mimic = "<mimic joint='d' multiplier='2' offset='.3'/>"
    joints = joint("d", "continuous", "base", "a"), joint("f", "continuous", "base", "b", mimic)
    scene = kf.read_urdf(write(tmp_path, link("base"), link("a"), link("b"), *joints), positions=given)
    assert scene.freeze().initial_coordinates == pytest.approx([driver, follower], abs=1e-15)
    assert not scene.start_report().mended


def test_a_joint_that_mimics_itself_is_refused(tmp_path: Path) -> None:
    """It was held where it was."""
    path = write(tmp_path, link("a"), link("b"), joint("j", "revolute", "a", "b", "<mimic joint='j'/>"))
    with pytest.raises(kf.FileError, match=r"joint 'j' mimics itself. Remedy"):
        kf.read_urdf(path)


def test_a_planar_joint_moves_across_its_axis(tmp_path: Path) -> None:
    tilted = "<origin xyz='0 0 1' rpy='0 0 0.3'/><axis xyz='0 1 0'/>"
    path = write(tmp_path, link("a"), link("b", moments=(0.1, 0.2, 0.25)), joint("p", "planar", "a", "b", tilted))
    scene = kf.read_urdf(path, gravity=(1.0, 2.0, -9.0))
    model = scene.freeze()
    motion = model.kinematics("b", 0.0, model.initial_state)
    assert motion.position == pytest.approx([0, 0, 1])
    # the axes of the link are those of the file: those of "a" turned by 0.3 about z
    along = np.array((-np.sin(0.3), np.cos(0.3), 0.0))
    after = scene.copy().simulate((0.0, 1.0), rtol=1e-9).position("b")[-1] - (0, 0, 1)
    assert after @ along == pytest.approx(0.0, abs=1e-12)
    free = np.array((1.0, 2.0, -9.0)) - along * ((1.0, 2.0, -9.0) @ along)
    assert after == pytest.approx(0.5 * free, abs=1e-9)
    assert motion.rotation[:, 1] == pytest.approx(along)


def test_floating_joints_and_slashes_in_names(tmp_path: Path) -> None:
    path = write(tmp_path, link("world"), link("my/stone"), joint("f/j", "floating", "world", "my/stone"))
    scene = kf.read_urdf(path)
    assert scene.joints["f.j"] == "my.stone"
    fallen = scene.simulate((0.0, 1.0)).position("my.stone")[-1]
    assert fallen == pytest.approx([0, 0, -0.5 * 9.81], abs=1e-6)


HINGE = joint("j", "revolute", "base", "a")


@pytest.mark.parametrize(
    "shape",
    [
        "<collision><geometry><capsule radius='.1' length='.2'/></geometry></collision>",  # of bullet3
        "<collision><geometry><plane normal='0 0 1'/></geometry></collision>",
        "<visual><geometry><d:ellipsoid xmlns:d='http://drake.mit.edu' a='1' b='1' c='1'/></geometry></visual>",
        "<visual><geometry/></visual>",
        "<visual><origin xyz='0 0 0'/></visual>",
    ],
)
def test_shapes_that_are_never_used_need_not_be_known(shape: str, tmp_path: Path) -> None:
    path = write(tmp_path, link("base"), link("a").replace("</link>", f"{shape}</link>"), HINGE)
    scene = kf.read_urdf(path)
    assert scene.joints["j"] == "a"
    assert scene.freeze().mass_matrix(0.0, scene.freeze().initial_state).shape == (1, 1)


def test_inertia_about_one_axis_is_taken_where_the_link_turns_about_others(tmp_path: Path) -> None:
    """Placeholders of converters; scenes of the user's own refuse them."""
    path = write(tmp_path, link("base"), link("a", moments=(0.0, 0.1, 0.0)), joint("j", "floating", "base", "a"))
    tip = link("b") + joint("k", "fixed", "a", "b")
    path.write_text(path.read_text(encoding="utf-8").replace("</robot>", f"{tip}</robot>"), encoding="utf-8")
    with pytest.warns(OddInertiaWarning, match="link 'a'"):
        scene = kf.read_urdf(path)
    momenta = scene.freeze().mass_matrix(0.0, scene.copy().freeze().initial_state)
    assert momenta[3:, 3:] == pytest.approx(np.diag((0.1, 0.2, 0.1)))


def test_odd_inertia_is_taken_with_a_warning(tmp_path: Path) -> None:
    path = write(tmp_path, link("base"), link("a", moments=(0.1, 0.1, 0.3)), joint("j", "continuous", "base", "a"))
    with pytest.warns(OddInertiaWarning, match="link 'a' has principal moments"):
        scene = kf.read_urdf(path)
    assert scene._entries[1].rigid.inertia[2, 2] == 0.3


def test_a_converters_round_off_is_a_point(tmp_path: Path) -> None:
    path = write(tmp_path, link("base"), link("a", moments=(0.0, 0.0, -1e-20)), joint("j", "fixed", "base", "a"))
    assert not kf.read_urdf(path)._entries[1].rigid.inertia.any()


@pytest.mark.parametrize("limits", ["", "lower='0.5' upper='0.5'"])
def test_equal_limits_are_no_stops_and_keep_no_others_from_being_some(limits: str, tmp_path: Path) -> None:
    """Zeros stand where a file gives only effort and velocity: MuJoCo reads them as no limits."""
    other = joint("k", "revolute", "a", "b", "<limit lower='-1' upper='1' effort='9' velocity='9'/>")
    equal = joint("j", "revolute", "base", "a", f"<limit {limits} effort='9' velocity='9'/>")
    path = write(tmp_path, link("base"), link("a"), link("b"), equal, other)
    with pytest.warns(NotTakenWarning, match="limits without a range between them: j"):
        scene = kf.read_urdf(path, limit_stiffness=1e4)
    forces = [entry.joint.forces for entry in scene._entries[1:]]
    assert forces[0] is None
    assert forces[1].limits == (-1.0, 1.0)


REFUSED = {
    "no link": ((), "has no links"),
    "two roots": ((link("base"), link("a")), "2 links that no joint carries: base, a. Remedy"),
    "ring": ((link("base"), link("a"), HINGE, joint("k", "fixed", "a", "base")), "has no root"),
    "ring beside the root": (
        (link("r"), link("base"), link("a"), HINGE, joint("k", "fixed", "a", "base")),
        "a, base carry each other in a ring",
    ),
    "two parents": (
        (link("base"), link("b"), link("a"), HINGE, joint("k", "fixed", "b", "a")),
        "link 'a' is the child of joints 'j' and 'k'",
    ),
    "unknown link": ((link("base"), HINGE), "child of joint 'j' is 'a', and there is no such link"),
    "link twice": ((link("base"), link("base")), "two links called 'base'"),
    "joint twice": (
        (link("base"), link("a"), link("b"), HINGE, joint("j", "fixed", "a", "b")),
        "two joints called 'j'",
    ),
    "unknown kind": (
        (link("base"), link("a"), joint("j", "ball", "base", "a")),
        "joint 'j' is 'ball'. Joints of URDF are",
    ),
    "axis": (
        (link("base"), link("a"), joint("j", "revolute", "base", "a", "<axis xyz='0 0 0'/>")),
        "axis of joint 'j'",
    ),
    "no mass moves": ((link("base"), "<link name='a'/>", HINGE), "joint 'j' moves link 'a', and nothing from there on"),
    "inertia": (
        (link("base"), link("a", moments=(-0.1, 0.1, 0.1)), HINGE),
        "link 'a' has principal moments -0.1, 0.1, 0.1 kg m2, and none may be negative",
    ),
    "nan": ((link("base"), link("a", moments=(float("nan"), 0.1, 0.1)), HINGE), "link 'a' has principal moments nan"),
    "mass": (
        (link("base"), link("a", mass=-1.0), link("b"), HINGE, joint("k", "fixed", "a", "b")),
        "mass of body 'a'|nothing",
    ),
    "no moment": (
        (link("base"), "<link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1'/></inertial></link>", HINGE),
        "the inertia of link 'a' has no izz",
    ),
    "mimic": (
        (link("base"), link("a"), joint("j", "revolute", "base", "a", "<mimic joint='k'/>")),
        "joint 'j' mimics 'k', and there is no such joint",
    ),
    "damping": (
        (link("base"), link("a"), joint("j", "revolute", "base", "a", "<dynamics damping='much'/>")),
        "damping of joint 'j' is 'much', no number",
    ),
    "negative damping": (
        (link("base"), link("a"), joint("j", "revolute", "base", "a", "<dynamics damping='-1'/>")),
        "joint 'j': damping of a joint coordinate",
    ),
    "no parent": ((link("base"), "<joint name='j' type='fixed'/>"), "not a complete URDF file"),
    "xacro": (("<xacro:include xmlns:xacro='urn:xacro' filename='y'/>",), "macros of xacro. Remedy"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_bad_file_is_refused_by_name(case: str, tmp_path: Path) -> None:
    elements, message = REFUSED[case]
    with pytest.raises(kf.KanefeError, match=message):
        kf.read_urdf(write(tmp_path, *elements))


def test_a_file_that_is_no_urdf_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    with pytest.raises(kf.FileError, match="there is no file"):
        kf.read_urdf(path)
    path.write_text("<robot name='r'><link name='a'>")
    with pytest.raises(kf.FileError, match="truncated or not XML"):
        kf.read_urdf(path)
    path.write_text("<mujoco/>")
    with pytest.raises(kf.FileError, match="read_mjcf reads MJCF"):
        kf.read_urdf(path)


def test_unknown_joints_and_links_of_the_caller_are_refused() -> None:
    with pytest.raises(kf.ModelError, match=r"has no joint 'ankle'. It has: slide, waist"):
        read("arm", positions={"ankle": 0.1})
    with pytest.raises(kf.ModelError, match="robot 'arm' has no link 'leg'"):
        read("arm", flexible={"leg": None})
    with pytest.raises(kf.ModelError, match="link 'forearm' is to become 3"):
        read("arm", flexible={"forearm": 3})
    with pytest.raises(kf.ModelError, match=r"base must be a joint, .*, not 'free'"):
        read("arm", base="free")
    with pytest.raises(kf.ModelError, match="positions must be a dict of joints and numbers"):
        read("arm", positions=3)
    with pytest.raises(kf.ModelError, match="that of joint 'shoulder' must be a finite number"):
        read("arm", positions={"shoulder": np.nan})
    with pytest.raises(kf.ModelError, match="flexible must be a dict"):
        read("arm", flexible=["forearm"])


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"limit_stiffness": -1.0}, "limit_stiffness must be > 0, or None for no stops, not -1.0"),
        ({"limit_stiffness": 1e4, "limit_damping": -1.0}, "limit_damping must be >= 0, not -1.0"),
        ({"limit_damping": 1.0}, "limit_damping without limit_stiffness does nothing"),
        ({"limit_stiffness": 1e4}, "limit_stiffness does nothing: no joint of .*robot.urdf has limits"),
    ],
)
def test_stops_that_no_joint_takes_are_refused(choices: dict[str, float], message: str, tmp_path: Path) -> None:
    path = write(tmp_path, link("a"), link("b"), joint("turns", "continuous", "a", "b"))
    with pytest.raises(kf.ModelError, match=message):
        kf.read_urdf(path, **choices)


def test_visuals_are_drawn_where_they_stand(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    corners = "v 0 0 0\nv 10 0 0\nv 0 20 0\nv 0 0 30\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (tmp_path / "meshes" / "wedge.obj").write_text(corners)
    mesh = "<visual><origin xyz='1 0 0' rpy='0 0 1.5707963267948966'/><geometry>{}</geometry></visual></link>"
    wedge = "<mesh filename='package://arm/meshes/wedge.obj' scale='0.01 0.01 0.01'/>"
    path = write(
        tmp_path,
        link("a").replace("</link>", mesh.format("<box size='0.1 0.2 0.3'/>")),
        link("b").replace("</link>", mesh.format(wedge)),
        link("c").replace("</link>", mesh.format("<mesh filename='gone.stl'/>")),
        joint("j", "revolute", "a", "b", "<axis xyz='0 0 1'/>"),
        joint("k", "fixed", "b", "c"),
    )
    scene = kf.read_urdf(path)
    box, drawn = outlines(scene.freeze())
    assert (box.body, drawn.body) == ("a", "b")
    assert np.ptp(box.vertices, axis=0) == pytest.approx([0.2, 0.1, 0.3], abs=1e-12)  # a quarter turn about z
    assert drawn.vertices == pytest.approx(np.array([[1, 0, 0], [1, 0.1, 0], [0.8, 0, 0], [1, 0, 0.3]]), abs=1e-12)
    assert scene.not_taken["visuals"] == ("c",)
    assert kf.read_urdf(path, looks=False).freeze().surfaces == ()
