"""MJCF: MuJoCo's own accelerations and places, equalities in a run, and what is not taken or refused."""

from __future__ import annotations

import importlib
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.results.surface_outline import outlines
from kanefe.robots import _mujoco
from kanefe.robots.scene import NotTakenWarning

pytestmark = pytest.mark.mjcf

MACHINE = """<mujoco model="machine"><compiler angle="degree"/><option gravity="0.3 -0.2 -9.81"/>
<asset><mesh name="hull" file="there_is_none.stl"/></asset><default><joint damping="0.5"/></default>
<worldbody><geom type="plane" size="1 1 1"/>
<body name="craft" pos="0.2 0.1 1" quat="1 .2 .3 .4"><freejoint name="flight"/>
 <inertial pos="0 0 .1" mass="1" fullinertia="1 1.1 1.2 .1 0 0.05"/><geom type="mesh" mesh="hull"/>
 <body name="arm" pos=".3 0 .1" euler="10 20 30">
  <joint name="swing" axis="0 1 .2" pos="0.1 .02 -.03" ref="30" stiffness="2" springref="10" RANGE/>
  <joint name="slide" type="slide" axis="1 .3 0" ref="0.1" stiffness="30" springref=".05" pos=".1 .1 .2"/>
  <joint name="twist" axis="0 0 1" pos="0 -.05 .02" ARMATURE/>
  <geom type="box" size=".1 .2 .05" pos=".1 0 0" euler="0 0 20"/>
  <body name="ball" pos=".2 0 0"><joint name="socket" type="ball" damping="0" pos="0 .03 .01"/>
   <geom type="capsule" size=".03" fromto="0 0 0 .2 .1 0"/>
   <body name="tip" pos=".2 .1 0"><geom type="sphere" size=".04"/></body></body></body></body>
<body pos="1 1 1" gravcomp="1"><joint axis="1 0 0"/><geom size=".1" pos="0 .2 0"/></body>
</worldbody>MORE</mujoco>"""

PAIR = """<mujoco><worldbody>
<body name="a"><joint name="first" axis="0 1 0" ref="FIRST"/>
 <inertial pos=".2 0 0" mass="1" diaginertia=".01 .01 .01"/></body>
<body name="b" pos="1 0 0"><joint name="second" axis="0 1 0"/>
 <inertial pos=".2 0 0" mass="1" diaginertia=".01 .01 .01"/></body>
</worldbody><equality>EQUALITY</equality></mujoco>"""


def write(folder: Path, text: str, **parts: str) -> Path:
    for word in ("RANGE", "ARMATURE", "MORE", "FIRST", "EQUALITY"):
        text = text.replace(word, parts.get(word.lower(), "0" if word == "FIRST" else ""))
    path = folder / "machine.xml"
    path.write_text(text, encoding="utf-8")
    return path


def read(path: Path, **choices: object) -> kf.RobotScene:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotTakenWarning)
        return kf.read_mjcf(path, **choices)


def test_accelerations_and_places_are_mujocos(tmp_path: Path) -> None:
    path = write(tmp_path, MACHINE)
    model = read(path).freeze()
    mujoco = importlib.import_module("mujoco")
    peer = importlib.import_module("kanefe.robots._mujoco").compiled(path).model
    state = mujoco.MjData(peer)
    rng = np.random.default_rng(0)
    q = model.initial_state[: peer.nq] + rng.uniform(-0.5, 0.5, peer.nq)
    assert model.initial_state[: peer.nq] == pytest.approx(peer.qpos0, abs=1e-15)
    for first in (3, 10):  # Euler parameters of the craft and of the ball
        q[first : first + 4] /= np.linalg.norm(q[first : first + 4])
    u = rng.uniform(-1.0, 1.0, peer.nv)
    state.qpos[:], state.qvel[:] = q, u
    mujoco.mj_forward(peer, state)
    y = np.concatenate((q, u))
    # both to round-off of sums of some ten bodies
    assert model.rhs(0.0, y)[peer.nq :] == pytest.approx(state.qacc, abs=1e-12 * abs(state.qacc).max())
    for name in ("arm", "ball", "tip"):
        motion, number = model.kinematics(name, 0.0, y), peer.body(name).id
        assert motion.position == pytest.approx(state.xpos[number], abs=1e-14)
        assert motion.rotation == pytest.approx(state.xmat[number].reshape(3, 3), abs=1e-14)


def test_what_is_not_taken_is_named(tmp_path: Path) -> None:
    more = (
        '<actuator><motor name="drive" joint="twist"/></actuator>'
        '<sensor><jointpos name="angle" joint="twist"/></sensor>'
        '<tendon><fixed name="cord"><joint joint="twist" coef="1"/></fixed></tendon>'
        '<equality><tendon name="knot" tendon1="cord"/></equality>'
        '<contact><exclude body1="arm" body2="ball"/></contact>'
        f'<keyframe><key name="home" qpos="{"0 " * 15}"/></keyframe>'
    )
    path = write(tmp_path, MACHINE, range='range="-90 90"', armature='armature="0.1" frictionloss="0.2"', more=more)
    with pytest.warns(NotTakenWarning, match="actuators: drive; tendons: cord") as told:
        scene = kf.read_mjcf(path)
    assert len(told) == 1
    named = scene.not_taken
    assert scene.body("twist").system._entries[3].joint.forces.armature == 0.1
    assert named["limits of joints (limit_stiffness= takes them)"] == ("swing",)
    assert named["shapes, which touch nothing"] == ("world", "craft", "arm", "ball", "tip", "unnamed")
    assert (named["sensors"], named["keyframes"]) == (("angle",), ("home",))
    assert scene.body("twist").system._entries[3].joint.forces.friction == 0.2
    assert scene.joints["twist"] == "twist"
    assert not scene._entries[-1].has_gravity


def test_joint_and_gravity_options(tmp_path: Path) -> None:
    path = write(tmp_path, MACHINE, range='range="-90 90"')
    scene = read(path, positions={"slide": 0.3}, gravity=(0, 0, 0), joint_forces=False, limit_stiffness=100.0)
    assert scene.gravity.tolist() == [0, 0, 0]
    swing, slide = (scene._entries[n].joint for n in (1, 2))
    assert swing.forces.limits == pytest.approx((-np.pi / 2, np.pi / 2))
    assert (slide.position, slide.forces) == (0.3, None)
    assert scene.not_taken["stiffness of joints"] == ("swing", "slide")
    with pytest.raises(kf.ModelError, match=r"has no joint 'knee'. It has: flight, swing"):
        read(path, positions={"knee": 1.0})


def test_coupled_joints_follow_the_polynomial(tmp_path: Path) -> None:
    equality = '<joint joint1="first" joint2="second" polycoef="0.1 -2 0 0 0"/>'
    result = read(write(tmp_path, PAIR, equality=equality, first="17.2")).simulate((0.0, 0.3), rtol=1e-9)
    first, second = (result.joint_coordinates(name)[:, 0] for name in ("a", "b"))
    assert abs(second[-1]) > 0.01
    assert first - np.deg2rad(17.2) == pytest.approx(0.1 - 2.0 * second, abs=1e-9)


def test_a_joint_that_follows_another_starts_where_that_puts_it(tmp_path: Path) -> None:
    equality = '<joint joint1="first" joint2="second" polycoef="0.2 1 0 0 0"/>'
    for given, second in (({}, 0.0), ({"second": 0.0}, 0.0), ({"second": 0.1}, 0.1)):
        scene = read(write(tmp_path, PAIR, equality=equality), positions=given)
        start = {one.body: one.value for one in scene.start_report().coordinates}
        turned = start[scene.joints["second"]]
        assert turned == pytest.approx(second, abs=0.0)


def test_a_lone_joint_is_held(tmp_path: Path) -> None:
    scene = read(write(tmp_path, PAIR, equality='<joint joint1="first" polycoef="0.2 0 0 0 0"/>'))
    assert scene.simulate((0.0, 0.1)).joint_coordinates("a")[:, 0] == pytest.approx(0.2, abs=1e-9)


def test_connected_bodies_stay_connected(tmp_path: Path) -> None:
    equality = '<connect name="pin" body1="b" body2="a" anchor="-0.4 0 0.3"/>'
    scene = read(write(tmp_path, PAIR, equality=equality))
    ends = scene._constraints[0].a, scene._constraints[0].b
    assert [end.point.tolist() for end in ends] == [[-0.4, 0, 0.3], [0.6, 0, 0.3]]
    model = scene.freeze()
    assert model.constraint_report().degrees_of_freedom == 0


def test_welded_bodies_move_as_one(tmp_path: Path) -> None:
    scene = read(write(tmp_path, PAIR, equality='<weld name="glue" body1="a" body2="b"/>'))
    assert scene.freeze().constraint_report().degrees_of_freedom == 0
    pose = scene._constraints[0].a
    assert pose.point == pytest.approx([1, 0, 0])


SITES = """<mujoco><asset><material name="red" rgba="1 0 0 1"/></asset><default><site DEFAULT/></default><worldbody>
<site name="wall" pos=".6 .1 .2" euler="10 20 30"/>
<body name="a" euler="0 40 0"><joint name="first" axis="0 1 0"/><site name="end" pos=".4 0 .1" euler="0 30 0" OWN/>
 <inertial pos=".2 0 0" mass="1" diaginertia=".01 .01 .01"/></body>
</worldbody><equality>EQUALITY</equality></mujoco>"""


@pytest.mark.parametrize("place", ["OWN", "DEFAULT"])
def test_materials_of_sites_are_no_matter(place: str, tmp_path: Path) -> None:
    text = SITES.replace(place, 'material="red"').replace("OWN", "").replace("DEFAULT", "")
    model = read(write(tmp_path, text)).freeze()
    assert model.rhs(0.0, model.initial_state)[1] == pytest.approx(0.2 * 9.81 * np.cos(np.radians(40)) / 0.05)


def test_materials_of_meshes_are_no_matter(tmp_path: Path) -> None:
    points = " ".join(f"{x} {y} {z}" for x in (0, 0.1) for y in (0, 0.2) for z in (0, 0.3))
    text = f"""<mujoco><asset><material name="red" rgba="1 0 0 1"/><mesh name="box" vertex="{points}" material="red"/>
    </asset><worldbody><body name="a"><joint axis="0 1 0"/><geom type="mesh" mesh="box"/></body></worldbody></mujoco>"""
    scene = read(write(tmp_path, text))
    # vertices are in single precision
    assert scene._entries[0].rigid.mass == pytest.approx(0.1 * 0.2 * 0.3 * 1000.0, rel=1e-6)


@pytest.mark.parametrize(("kind", "turns"), [("connect", False), ("weld", True)])
def test_equalities_of_sites_join_the_frames_of_sites(kind: str, turns: bool, tmp_path: Path) -> None:
    equality = f'<{kind} name="pin" site1="end" site2="wall"/>'
    text = SITES.replace("OWN", "").replace("DEFAULT", "")
    scene = read(write(tmp_path, text, equality=equality))
    mujoco = importlib.import_module("mujoco")
    peer = mujoco.MjModel.from_xml_path(str(tmp_path / "machine.xml"))
    assert "equalities of other kinds" not in scene.not_taken
    held = scene._constraints[0]
    assert len(held.rows) == (6 if turns else 3)
    for end, site in ((held.a, "end"), (held.b, "wall")):
        number = peer.site(site).id
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, peer.site_quat[number])
        assert end.point == pytest.approx(peer.site_pos[number], abs=1e-15)
        assert np.asarray(end.axes) == pytest.approx(axes.reshape(3, 3), abs=1e-15)


def test_names_of_joints_may_be_those_of_bodies(tmp_path: Path) -> None:
    inertial = '<inertial pos="0 0 -.1" mass="1" diaginertia=".01 .01 .01"/>'
    path = write(
        tmp_path,
        f"""<mujoco><worldbody><body name="tail"><joint name="tail" axis="0 1 0"/><joint name="fin" axis="1 0 0"/>
        <joint name="twist" axis="0 0 1"/>{inertial}<body name="fin" pos="0 0 -.2">{inertial}
        <joint name="fin joint" axis="0 1 0"/><joint name="last" axis="1 0 0"/></body></body></worldbody></mujoco>""",
    )
    scene = read(path)
    assert scene.joints == {
        "tail": "tail joint",
        "fin": "fin joint",
        "twist": "tail",
        "fin joint": "fin joint joint",
        "last": "fin",
    }


@pytest.mark.parametrize("place", ["0 0 0", ".1 0 0"])
def test_a_joint_may_have_the_name_of_its_body(place: str, tmp_path: Path) -> None:
    body = f'<body name="arm"><joint name="arm" pos="{place}"/><geom size=".1" pos=".2 0 0"/></body>'
    scene = read(write(tmp_path, f"<mujoco><worldbody>{body}</worldbody></mujoco>"))
    assert set(scene.joints) == {"arm"}


def test_equalities_that_are_off_or_of_other_kinds_are_named(tmp_path: Path) -> None:
    equality = (
        '<connect name="loose" body1="b" body2="a" anchor="0 0 0" active="false"/>'
        '<joint name="bent" joint1="first" joint2="second" polycoef="0 1 3 0 0"/>'
    )
    with pytest.warns(NotTakenWarning, match="equalities of other kinds: bent"):
        scene = kf.read_mjcf(write(tmp_path, PAIR, equality=equality))
    assert scene.not_taken["equalities that are off"] == ("loose",)


def test_flexes_are_left_out_with_their_points(tmp_path: Path) -> None:
    """Loose points would fall; the body to which they are pinned stays."""
    arm = '<body name="arm"><joint axis="0 1 0"/><inertial pos=".1 0 0" mass="1" diaginertia=".1 .1 .1"/>{}</body>'
    cloth = """<flexcomp name="cloth" type="grid" count="3 3 3" spacing=".1 .1 .1" mass="1" dim="3" radius=".01" {}>
    <pin id="0 1"/></flexcomp>"""
    keys = '</worldbody><keyframe><key name="home"/></keyframe></mujoco>'
    for dof in ("", 'dof="radial"', 'dof="trilinear"'):
        path = write(tmp_path, f"<mujoco><worldbody>{arm.format(cloth.format(dof))}{keys}")
        with pytest.warns(NotTakenWarning, match="flexes: cloth"):
            scene = kf.read_mjcf(path)
        assert [entry.name for entry in scene._entries] == ["arm"]
        with pytest.raises(kf.FileError, match="has flexes, of whose points its keyframes have numbers too"):
            kf.read_mjcf(path, key="home")


def test_bad_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "machine.xml"
    with pytest.raises(kf.FileError, match="there is no file"):
        kf.read_mjcf(path)
    for text, message in (
        ("<mujoco><worldbody>", r"MuJoCo's parser refuses .*machine.xml: .*Remedy: check the file"),
        ("<mujoco><worldbody><body><joint type='knee'/></body></worldbody></mujoco>", "invalid keyword: 'knee'"),
        ("<mujoco><worldbody><body name='a'><joint/></body></worldbody></mujoco>", "mass and inertia of moving bodies"),
        ("<mujoco><worldbody/></mujoco>", "has no bodies"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(kf.KanefeError, match=message):
            kf.read_mjcf(path)


def test_an_older_mujoco_is_named_with_its_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.import_module("mujoco"), "__version__", "3.10.2")
    with pytest.raises(kf.MissingDependency, match=r"needs mujoco 4\.0 or newer \(3\.10\.2 is here\)"):
        kf.read_mjcf(write(tmp_path, MACHINE))


def test_inertia_from_a_mesh_that_is_missing_is_asked_for(tmp_path: Path) -> None:
    inertial = '<inertial pos="0 0 .1" mass="1" fullinertia="1 1.1 1.2 .1 0 0.05"/>'
    with pytest.raises(kf.FileError, match="give the body an <inertial>, then no mesh is needed"):
        kf.read_mjcf(write(tmp_path, MACHINE.replace(inertial, "")))


ACTED_ON = """
<mujoco>
  <asset>
    <texture name="grid" type="2d" builtin="checker" width="8" height="8"/><material name="grid" texture="grid"/>
  </asset>
  <worldbody>
    <geom type="plane" size="1 1 1" material="grid"/>
    <body name="arm">
      <joint name="hinge" axis="0 1 0" damping="0.2"/><geom type="capsule" size="0.1 0.3" mass="2"/>
    </body>
  </worldbody>
  <tendon><fixed name="cable"><joint joint="hinge" coef="1"/></fixed></tendon>
  <actuator><motor joint="hinge"/></actuator>
  <sensor><jointpos joint="hinge"/></sensor>
  {key}
</mujoco>
"""


@pytest.mark.parametrize("key", ["", '<keyframe><key name="wrong" qpos="1 2 3"/></keyframe>'], ids=["right", "wrong"])
def test_what_is_not_read_is_removed_only_where_it_has_to_be(key, tmp_path, monkeypatch):
    """The parser takes longer for each removal, the larger the file is."""
    removed, remove = [], _mujoco._delete
    monkeypatch.setattr(_mujoco, "_delete", lambda spec, parts: (removed.extend(parts), remove(spec, parts)))
    path = tmp_path / "arm.xml"
    path.write_text(ACTED_ON.format(key=key))
    model = _mujoco.compiled(path).model
    assert model.dof_damping.tolist() == [0.2]
    assert model.body_mass.tolist() == [0.0, 2.0]
    assert (len(removed) > 0) == bool(key)
    assert model.neq == 0


def test_shapes_are_drawn_and_where_a_body_has_visuals_these_alone(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><geom type="plane" size="1 1 1"/>
      <body name="arm" pos="0 0 1"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 1 0 0" size="0.1"/>
        <body name="tip" pos="1 0 0"><joint axis="0 1 0"/><geom type="sphere" size="0.3"/>
          <geom type="box" size="0.1 0.2 0.3" pos="0 0 0.5" contype="0" conaffinity="0" mass="0"/>
        </body></body></worldbody></mujoco>"""
    scene = read(write(tmp_path, text))
    arm, tip = outlines(scene.freeze())
    assert (arm.body, tip.body) == ("arm", "tip")
    assert arm.vertices.min(axis=0) == pytest.approx([-0.1, -0.1, -0.1], abs=2e-3)  # circles of forty sides
    assert arm.vertices.max(axis=0) == pytest.approx([1.1, 0.1, 0.1], abs=2e-3)
    assert tip.vertices.min(axis=0) == pytest.approx([-0.1, -0.2, 0.2], abs=1e-12)
    assert read(tmp_path / "machine.xml", looks=False).freeze().surfaces == ()
