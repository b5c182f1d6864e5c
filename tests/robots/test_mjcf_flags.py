"""MJCF: what the flags of <option> switch off, and welds with anchors; accelerations are MuJoCo's."""

from __future__ import annotations

import importlib
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.robots.scene import NotTakenWarning

pytestmark = pytest.mark.mjcf

INERTIAL = '<inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .1 .1"/>'
CHAIN = """<mujoco><option density="DENSITY"><flag FLAGS/></option><worldbody><body name="a" gravcomp="COMPENSATION">
<joint name="x" axis="0 1 0" JOINT/>INERTIAL
<body name="b" pos=".5 0 0"><joint name="y" axis="0 1 0"/>INERTIAL</body></body>
</worldbody>MORE</mujoco>"""
EQUALITY = '<equality><joint joint1="x" joint2="y"/></equality>'
Q, U = (0.3, 0.3), (0.8, 0.8)


def written(folder: Path, text: str, **parts: str) -> Path:
    parts = {"DENSITY": "0", "COMPENSATION": "0", "FLAGS": "", "JOINT": "", "MORE": "", "INERTIAL": INERTIAL} | parts
    for word, part in parts.items():
        text = text.replace(word, part)
    path = folder / "flags.xml"
    path.write_text(text, encoding="utf-8")
    return path


def mujocos(path: Path, q: tuple[float, ...], u: tuple[float, ...]) -> np.ndarray:
    mujoco = importlib.import_module("mujoco")
    peer = mujoco.MjModel.from_xml_path(str(path))
    state = mujoco.MjData(peer)
    state.qpos[:], state.qvel[:] = q, u
    mujoco.mj_forward(peer, state)
    return np.array(state.qacc)


@pytest.mark.parametrize(
    ("off", "parts"),
    [
        (("gravity",), {}),
        (("spring",), {"JOINT": 'stiffness="30 2 1"'}),
        (("damper",), {"JOINT": 'damping="2 1 1"'}),
        (("frictionloss",), {"JOINT": 'frictionloss="2"'}),
        (("limit",), {"JOINT": 'range="-10 10"'}),
        (("equality",), {"MORE": EQUALITY}),
        (("constraint",), {"MORE": EQUALITY, "JOINT": 'frictionloss="2" range="-10 10"'}),
        (("spring", "damper"), {"COMPENSATION": "1", "DENSITY": "1000"}),
    ],
)
def test_flags_switch_off_what_they_do_in_mujoco(off: tuple[str, ...], parts: dict[str, str], tmp_path: Path) -> None:
    path = written(tmp_path, CHAIN, FLAGS=" ".join(f'{flag}="disable"' for flag in off), **parts)
    with warnings.catch_warnings():
        warnings.simplefilter("error", NotTakenWarning)
        model = kf.read_mjcf(path).freeze()
    y = np.array(model.initial_state)
    y[:4] = *Q, *U
    right = mujocos(path, Q, U)
    # round-off of two bodies
    assert model.rhs(0.0, y)[2:4] == pytest.approx(right, abs=1e-12 * abs(right).max())


def test_what_a_flag_switches_off_is_no_warning(tmp_path: Path) -> None:
    parts = {
        "INERTIAL": f'{INERTIAL}<geom size=".1"/>',
        "MORE": '<actuator><motor name="drive" joint="x"/></actuator>'
        '<equality><joint name="bent" joint1="x" joint2="y" polycoef="0 1 1 0 0"/></equality>',
    }
    path = written(tmp_path, CHAIN, FLAGS='actuation="disable" constraint="disable"', **parts)
    with warnings.catch_warnings():
        warnings.simplefilter("error", NotTakenWarning)
        scene = kf.read_mjcf(path)
    assert scene.not_taken["actuators that are off"] == ("drive",)
    assert scene.not_taken["equalities that are off"] == ("bent",)
    with pytest.warns(NotTakenWarning, match="flags: sleep"):
        kf.read_mjcf(written(tmp_path, CHAIN, FLAGS='sleep="enable"'))


WELDED = f"""<mujoco><worldbody><body name="a"><freejoint/>{INERTIAL}</body>
<body name="b" pos="1 2 3" euler="0 0 90"><freejoint/>{INERTIAL}</body></worldbody><equality>MORE</equality></mujoco>"""


@pytest.mark.parametrize("bodies", ['body1="a" body2="b"', 'body1="b"', 'body1="b" body2="a"'])
def test_a_weld_with_an_anchor_holds_the_pose_of_the_file(bodies: str, tmp_path: Path) -> None:
    model = kf.read_mjcf(written(tmp_path, WELDED, MORE=f'<weld {bodies} anchor=".1 .2 .3"/>')).freeze()
    peer = importlib.import_module("mujoco").MjModel.from_xml_path(str(tmp_path / "flags.xml"))
    # round-off of the anchor's places
    assert model.initial_state[:14] == pytest.approx(peer.qpos0, abs=1e-14)


def test_relpose_of_a_weld_is_the_pose_of_its_anchor(tmp_path: Path) -> None:
    weld = '<weld body1="a" body2="b" anchor=".1 .2 .3" relpose="1 2 3 1 0 0 1"/>'
    scene = kf.read_mjcf(written(tmp_path, WELDED, MORE=weld))
    mujoco = importlib.import_module("mujoco")
    peer = mujoco.MjModel.from_xml_path(str(tmp_path / "flags.xml"))
    state = mujoco.MjData(peer)
    mujoco.mj_forward(peer, state)
    a, b = scene._constraints[0].a, scene._constraints[0].b
    places = [state.body(n).xpos + state.body(n).xmat.reshape(3, 3) @ end.point for n, end in (("a", a), ("b", b))]
    # round-off of places of some metres
    assert places[0] - places[1] == pytest.approx(state.efc_pos[:3], abs=1e-14)
    assert abs(state.efc_pos[:3]).max() > 0.1


def test_a_weld_without_moments_holds_places_only(tmp_path: Path) -> None:
    weld = '<weld body1="a" body2="b" torquescale="0"/>'
    scene = kf.read_mjcf(written(tmp_path, WELDED, MORE=weld))
    assert len(scene._constraints[0].rows) == 3
