"""Keyframes of MJCF: the scene starts where MuJoCo puts the model, and what else a keyframe sets is named."""

from __future__ import annotations

import importlib
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.robots.scene import NotTakenWarning

pytestmark = pytest.mark.mjcf

INERTIAL = '<inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .1 .1"/>'
ROBOT = f"""<mujoco>ASSET<worldbody><body name="target" mocap="true" pos="1 0 0"/>
<body name="base" pos="0 0 1"><freejoint name="flight"/>{INERTIAL}SHAPE
<body name="arm"><joint name="swing" axis="0 1 0" ref="20"/><joint name="slide" type="slide" axis="1 0 0"/>{INERTIAL}
<body name="tip"><joint name="socket" type="ball"/>{INERTIAL}</body></body></body></worldbody>
<actuator><general joint="swing" dyntype="integrator"/></actuator>
<keyframe><key name="rest"/>
<key name="home" qpos="1 2 3 1 1 0 0 .3 .2 2 0 0 1" qvel="1 2 3 4 5 6 7 8 9 10 11" ctrl="CTRL" act="1" time="4"
 mpos="0 3 0" mquat="1 0 0 1"/><key qpos="0 0 0 0 0 0 0 .3 .2 0 0 0 0"/>OTHER</keyframe></mujoco>"""
FROM_FILES = {
    "ASSET": '<asset><mesh name="hull" file="there_is_none.stl"/></asset>',
    "SHAPE": '<geom type="mesh" mesh="hull"/>',
}
"""What makes the reader remove all elements that it does not read."""


def written(folder: Path, text: str = ROBOT, **parts: str) -> Path:
    for word, part in ({"ASSET": "", "SHAPE": "", "CTRL": "3", "OTHER": ""} | parts).items():
        text = text.replace(word, part)
    path = folder / "keys.xml"
    path.write_text(text, encoding="utf-8")
    return path


def read(path: Path, **choices: object) -> kf.RobotScene:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotTakenWarning)
        return kf.read_mjcf(path, **choices)


def mujocos(path: Path, number: int) -> tuple[np.ndarray, object]:
    """Return MuJoCo's state at a keyframe: coordinates, speeds."""
    mujoco = importlib.import_module("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, number)
    mujoco.mj_forward(model, data)
    return np.concatenate((data.qpos, data.qvel)), data.body("target")


@pytest.mark.parametrize("others", [{}, FROM_FILES, {"OTHER": '<key name="wrong" qpos="1 2 3"/>'}])
@pytest.mark.parametrize(("key", "number"), [("home", 1), (1, 1), (0, 0), (2, 2)])
def test_a_scene_starts_at_a_keyframe(key: str | int, number: int, others: dict[str, str], tmp_path: Path) -> None:
    model = read(written(tmp_path, **others), key=key).freeze()
    right, target = mujocos(written(tmp_path), number)
    # Euler parameters are normalised twice
    assert model.initial_state[: right.size] == pytest.approx(right, abs=1e-15)
    found = model.kinematics("target", 0.0, model.initial_state)
    assert found.position == pytest.approx(target.xpos, abs=1e-15)
    assert found.rotation == pytest.approx(target.xmat.reshape(3, 3), abs=1e-15)


def test_positions_change_single_joints_of_a_keyframe(tmp_path: Path) -> None:
    path = written(tmp_path)
    right, _ = mujocos(path, 1)
    places = {"flight": (0, 0, 1, 1, 0, 0, 0), "slide": -1.0, "socket": (0, 1, 0, 0)}
    right[:7], right[8], right[9:13] = places["flight"], -1.0, places["socket"]
    assert read(path, key="home", positions=places).freeze().initial_state[: right.size] == pytest.approx(right)


def test_what_a_keyframe_sets_of_actuators_is_named(tmp_path: Path) -> None:
    for others in ({}, FROM_FILES):
        with pytest.warns(NotTakenWarning, match="actuators at the keyframe: ctrl, act"):
            scene = kf.read_mjcf(written(tmp_path, **others), key="home")
        assert scene.not_taken["keyframes"] == ("rest", "unnamed")
        assert scene.not_taken["time of the keyframe"] == ("4 s",)
    assert read(written(tmp_path, CTRL="0"), key="home").not_taken["actuators at the keyframe"] == ("act",)
    for key in (None, "rest"):
        assert "actuators at the keyframe" not in read(written(tmp_path), key=key).not_taken
    off = '<option><flag actuation="disable"/></option>'
    assert "actuators at the keyframe" not in read(written(tmp_path, ASSET=off), key="home").not_taken


def test_an_unknown_keyframe_is_refused_with_those_that_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log into the working directory
    path = written(tmp_path)
    known = re.escape("0 ('rest'), 1 ('home'), 2 (without a name)")
    for key in ("hom", "", 3, -1):
        with pytest.raises(kf.ModelError, match=f"has no keyframe {key!r}. It has: {known}"):
            kf.read_mjcf(path, key=key)
    with pytest.raises(kf.ModelError, match=r"has no keyframe 0\. It has: none"):
        kf.read_mjcf(written(tmp_path, f"<mujoco><worldbody><body>{INERTIAL}</body></worldbody></mujoco>"), key=0)
    with pytest.raises(kf.ModelError, match="key"):
        kf.read_mjcf(path, key=True)
    with pytest.raises(kf.ModelError, match="qvel of the keyframe has a number that is not finite"):
        read(written(tmp_path, OTHER=f'<key name="wrong" qvel="{"nan " * 11}"/>'), key="wrong")
    for what, count in (("qpos", 13), ("qvel", 11), ("mpos", 3), ("mquat", 4)):
        with pytest.raises(kf.FileError, match=f"{what} of the keyframe of .* 2 numbers, and the model has {count}"):
            kf.read_mjcf(written(tmp_path, OTHER=f'<key name="wrong" {what}="1 2"/>'), key="wrong")


def test_what_equalities_hold_starts_near_a_keyframe(tmp_path: Path) -> None:
    """The one that leads stays; of a keyframe in three digits, the one that follows moves a little."""
    bodies = "".join(f'<body><joint name="{name}" axis="0 1 0"/>{INERTIAL}</body>' for name in "ab")
    text = f"""<mujoco><worldbody>{bodies}</worldbody><equality><joint joint1="a" joint2="b" polycoef="0 2 0 0 0"/>
    </equality><keyframe><key qpos=".667 .3333333" qvel=".2 .1"/></keyframe></mujoco>"""
    start = read(written(tmp_path, text), key=0).freeze().initial_state
    # round-off of the solver's residual of the coupling
    assert start[:4] == pytest.approx((0.6666666, 0.3333333, 0.2, 0.1), abs=1e-15)
