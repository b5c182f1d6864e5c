"""Springs, dampers and compensation of gravity of MJCF: accelerations are MuJoCo's, or what is not taken is named."""

from __future__ import annotations

import importlib
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.robots.scene import NotTakenWarning

INERTIAL = '<inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .1 .1"/>'
HINGE = '<joint axis="0 1 0" {}/>'
BALL = '<joint type="ball" pos=".1 .2 .1" stiffness="3" damping="1"/>'
mjcf = pytest.mark.mjcf


def written(folder: Path, bodies: str, more: str = "") -> Path:
    path = folder / "forces.xml"
    path.write_text(f"<mujoco><worldbody>{bodies}</worldbody>{more}</mujoco>", encoding="utf-8")
    return path


def one_body(joint: str, attribute: str = "") -> str:
    return f'<body name="a" {attribute} pos=".1 0 .2" euler="10 20 30">{joint}{INERTIAL}</body>'


def compare(path: Path) -> None:
    """Compare accelerations with MuJoCo's on both sides of the initial place, moving."""
    mujoco = importlib.import_module("mujoco")
    peer = mujoco.MjModel.from_xml_path(str(path))
    model = kf.read_mjcf(path).freeze()
    for side in (1.0, -1.0):
        state, rng = mujoco.MjData(peer), np.random.default_rng(1)
        state.qvel[:] = rng.uniform(-1.5, 1.5, peer.nv)
        mujoco.mj_integratePos(peer, state.qpos, side * rng.uniform(0.2, 0.6, peer.nv), 1.0)
        mujoco.mj_forward(peer, state)
        ours = model.rhs(0.0, np.concatenate((state.qpos, state.qvel)))[peer.nq : peer.nq + peer.nv]
        # round-off of two bodies
        assert ours == pytest.approx(state.qacc, abs=1e-12 * max(1.0, abs(state.qacc).max()))


CUBIC = 'damping="1 2 3" stiffness="1 2 3" springref="20"'
LAWS = [
    *(one_body(HINGE.format(law)) for law in (CUBIC, 'stiffness="-1" ref="10"')),
    *(
        one_body(f'<joint type="{kind}" {law}/>')
        for kind in ("ball", "free")
        for law in (
            'stiffness="3" damping="1"',
            'stiffness="-1"',
            'stiffness="1 2 3"',
            'damping="1 2 3"',
            'stiffness="-1" damping="-.5"',
        )
    ),
    *(one_body(HINGE.format(""), f'gravcomp="{part}"') for part in (0.5, 2, -1)),
    one_body(HINGE.format(""), 'gravcomp="-1"') + f'<body gravcomp=".3">{HINGE.format("")}{INERTIAL}</body>',
    f"<body>{HINGE.format('')}{INERTIAL}{one_body(BALL)}</body>",
]


@mjcf
@pytest.mark.parametrize("bodies", LAWS)
def test_forces_of_joints_are_mujocos(bodies: str, tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", NotTakenWarning)
        compare(written(tmp_path, bodies))


def geared_tree(seed: int) -> str:
    """Return a tree of bodies on hinges, slides and balls with rotors, with two joints in some, and one that flies."""
    rng = np.random.default_rng(seed)

    def body(depth: int) -> str:
        joints = ""
        kinds = ("ball",) if rng.uniform() < 0.4 else rng.choice(["hinge", "slide"], int(rng.integers(1, 3)))
        for kind in kinds:
            x, y, z = rng.standard_normal(3)
            rotor, c = rng.uniform(0.0, 0.5, 2)
            joints += f'<joint type="{kind}" axis="{x} {y} {z}" armature="{rotor}" damping="{c}"/>'
        a, b, c = rng.uniform(-0.3, 0.3, 3)
        inner = body(depth - 1) + (body(0) if depth > 1 else "") if depth else ""
        return f'<body pos="{a} {b} {c}" euler="{90 * a} {200 * b} {100 * c}">{joints}{INERTIAL}{inner}</body>'

    flying = f'<body pos="0 0 1"><joint type="free" armature="{rng.uniform(0.1, 0.5)}"/>{INERTIAL}{body(1)}</body>'
    return body(3) + flying


@mjcf
@pytest.mark.parametrize("seed", range(6))
def test_rotors_turn_with_their_joints_as_in_mujoco(seed: int, tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", NotTakenWarning)
        compare(written(tmp_path, geared_tree(seed)))


MOTOR = '<actuator><motor joint="j"/></actuator>'
OFF = '<option><flag actuation="disable"/></option>'
HANDED = '<body name="a" gravcomp="1"><joint name="j" axis="0 1 0" actuatorgravcomp="true" {}/>{}</body>'


@mjcf
@pytest.mark.filterwarnings("ignore::kanefe.robots.scene.NotTakenWarning")
@pytest.mark.parametrize("more", ["", MOTOR, MOTOR + OFF])
def test_compensation_by_actuators_acts_where_there_are_some(more: str, tmp_path: Path) -> None:
    compare(written(tmp_path, HANDED.format("", INERTIAL), more))


INSIDE = f"""<body pos=".3 .1 0" gravcomp="1.5"><joint type="slide" axis="1 2 3" ref=".1" pos=".1 0 .2" SECOND/>
<joint axis="1 0 1" pos=".1 .2 0" ref="20"/>{INERTIAL}</body>"""
RANGES = 'actuatorfrcrange="-1 1"', 'actuatorfrcrange="-.2 40"', ""


@mjcf
@pytest.mark.filterwarnings("ignore::kanefe.robots.scene.NotTakenWarning")
@pytest.mark.parametrize("more", ["", MOTOR, MOTOR + OFF])
@pytest.mark.parametrize("first", RANGES)
@pytest.mark.parametrize("second", ['actuatorgravcomp="true" actuatorfrcrange="-3 3"', 'actuatorfrcrange="-3 3"'])
def test_compensation_is_clamped_to_the_range_of_actuators(first: str, second: str, more: str, tmp_path: Path) -> None:
    path = written(tmp_path, HANDED.format(first, INERTIAL + INSIDE.replace("SECOND", second)), more)
    compare(path)
    assert not any("compensation" in kind for kind in kf.read_mjcf(path).not_taken)


@mjcf
def test_compensation_that_free_and_ball_joints_hand_on_is_named_where_others_do_not(tmp_path: Path) -> None:
    inner = f"<body name='b' gravcomp='1'><joint axis='0 0 1'/>{INERTIAL}</body>"
    ball = f"<body name='a' gravcomp='1'><joint type='ball' actuatorgravcomp='true'/>{INERTIAL}{inner}</body>"
    with pytest.warns(NotTakenWarning, match="compensation of gravity by actuators of free and ball joints: b"):
        kf.read_mjcf(written(tmp_path, ball))
    compare(written(tmp_path, ball.replace(inner, "")))


@mjcf
def test_without_joint_forces_those_of_all_joints_are_named(tmp_path: Path) -> None:
    joints = "<joint name='p' axis='0 1 0' damping='1 2 3'/>", "<joint name='b' type='ball' stiffness='1'/>"
    path = written(tmp_path, "".join(f"<body>{joint}{INERTIAL}</body>" for joint in joints))
    with pytest.warns(NotTakenWarning):
        scene = kf.read_mjcf(path, joint_forces=False)
    assert (scene.not_taken["damping of joints"], scene.not_taken["stiffness of joints"]) == (("p",), ("b",))


@mjcf
def test_friction_of_balls_and_yield_are_named(tmp_path: Path) -> None:
    joints = "<joint name='b' type='ball' frictionloss='1'/>"
    with pytest.warns(NotTakenWarning, match="friction of free and ball joints: b"):
        kf.read_mjcf(written(tmp_path, one_body(joints)))
    with pytest.warns(NotTakenWarning, match="springs of joints that yield: y"):
        kf.read_mjcf(written(tmp_path, one_body("<joint name='y' axis='0 1 0' stiffness='1' springyield='1'/>")))


@mjcf
def test_equal_laws_are_compiled_once(tmp_path: Path) -> None:
    """Numba takes about a second for each."""
    joint = HINGE.format(CUBIC)
    bodies = f"<body>{joint}{INERTIAL}<body>{joint}{INERTIAL}</body></body>"
    scene = kf.read_mjcf(written(tmp_path, bodies))
    first, second = (entry.joint_loads[0].function for entry in scene._entries)
    assert first.function is second.function
    assert first.reads != second.reads
    assert scene.simulate((0.0, 0.1)).status.is_finished


LINK = '<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'


@pytest.mark.urdf
@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_damping_of_floating_and_planar_joints_acts_on_each_speed(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    ends = '<parent link="base"/><child link="a"/><axis xyz="0 0 1"/>'
    joint = f'<joint name="j" type="{kind}">{ends}<dynamics damping="2" friction="FRICTION"/></joint>'
    text = f'<robot name="r"><link name="base"/>{LINK}{joint}</robot>'
    path.write_text(text.replace("FRICTION", "0"))
    model = kf.read_urdf(path, gravity=(0, 0, 0)).freeze()
    speeds = 6 if kind == "floating" else 3
    y = np.array(model.initial_state)
    y[-speeds:] = np.arange(1.0, 1.0 + speeds)
    # mass and moments are 1; round-off of the inertia's factors
    assert model.rhs(0.0, y)[-speeds:] == pytest.approx(-2.0 * y[-speeds:], abs=1e-14)
    path.write_text(text.replace("FRICTION", "1"))
    with pytest.warns(NotTakenWarning, match="friction of floating and planar joints: j"):
        kf.read_urdf(path)
    with pytest.warns(NotTakenWarning, match="damping of joints: j"):
        kf.read_urdf(path, joint_forces=False)
