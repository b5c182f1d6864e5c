"""A flexible body in the place of a link: matched to its joints, the scene as by hand; what does not fit is told."""

from __future__ import annotations

import functools
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.robots.flexible_link import LinkMassWarning
from kanefe.robots.scene import NotTakenWarning
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

pytestmark = pytest.mark.urdf
ARM = Path(__file__).with_name("arm.urdf")
QUARTER = kf.rotation_about("z", 0.5 * math.pi)


@functools.cache
def beam(length: float, density: float = 2700.0) -> kf.FlexibleBody:
    model = straight_beam(length, Rectangle(0.04, 0.06), Material(E=70e9, nu=0.3, rho=density), elements=4)
    interfaces = {"root": "clamped", "tip": "rigid"}
    return beam_body(model, interfaces, reduction=kf.CraigBampton(modes=2))


def read(**choices: object) -> kf.RobotScene:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotTakenWarning)
        return kf.read_urdf(ARM, joint_forces=False, **choices)


def by_hand(link: str, body: kf.FlexibleBody, orientation: np.ndarray) -> kf.System:
    """Return the scene of the rigid arm, whose bodies are added again one by one, with a beam for one of them."""
    rigid, scene = read(), kf.System(gravity=(0, 0, -9.81))
    for entry in rigid._entries:
        parent = scene.body(rigid._entries[entry.parent].name) if entry.parent >= 0 else None
        at, turn = entry.at, entry.axes
        if parent is not None and parent.name == link:
            turned = kf.System().ground.frame(orientation=orientation).axes
            at, turn = (0, 0, 0), turned.T @ turn  # the joint is at the tip, whose axes are those of the mesh
            parent = parent.interface("tip")
        place = {"parent": parent, "joint": entry.joint, "at": at, "orientation": turn}
        if entry.name != link:
            scene.add_rigid_body(entry.name, entry.rigid.mass, entry.rigid.inertia, com=entry.rigid.com, **place)
        elif np.allclose(orientation, (1, 0, 0, 0)):
            scene.add_flexible_body(link, body, **place)
        else:
            scene.add_flexible_body(link, body, parent=scene.add_frame("joint", **place), orientation=orientation)
    return scene


@pytest.mark.parametrize(
    ("link", "length", "orientation"), [("upper_arm", 0.35, (1, 0, 0, 0)), ("forearm", 0.25, QUARTER)]
)
def test_a_beam_in_the_place_of_a_link_is_the_scene_by_hand(link: str, length: float, orientation: np.ndarray) -> None:
    body = beam(length)
    given = body if link == "upper_arm" else kf.FlexibleLink(body, orientation=orientation)
    models = read(flexible={link: given}).freeze(), by_hand(link, body, orientation).freeze()
    rng = np.random.default_rng(3)
    y = models[0].initial_state + 1e-3 * rng.normal(size=len(models[0].initial_state))
    ours, hand = (model.rhs(0.0, y) for model in models)
    assert len(y) == 2 * (5 + 8)
    # stiff modes times amplitudes of 1e-3 m are large beside gravity
    assert ours == pytest.approx(hand, abs=1e-9 * abs(hand).max())


def test_an_interface_may_be_named() -> None:
    short = kf.FlexibleLink(beam(0.25), interfaces={"forearm": "tip"})  # the elbow is 0.1 m off
    scene = read(flexible={"upper_arm": short})
    where = scene.freeze().kinematics("forearm", 0.0, scene.copy().freeze().initial_state).position
    assert where == pytest.approx(read().freeze().kinematics("forearm", 0.0, read().freeze().initial_state).position)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(kf.ModelError, match=r"'upper_arm' carries 'forearm' at \(0.35, 0, 0\) m .* tip at \(0.25, "):
        read(flexible={"upper_arm": beam(0.25)})
    with pytest.raises(kf.ModelError, match=r"its joint is at .* no interface fixed there is near"):
        read(flexible={"upper_arm": kf.FlexibleLink(beam(0.35), at=(0.1, 0, 0))})
    with pytest.raises(kf.ModelError, match=r"name 'tool', which it does not carry. It carries forearm"):
        read(flexible={"upper_arm": kf.FlexibleLink(beam(0.35), interfaces={"tool": "tip"})})
    with pytest.raises(kf.ModelError, match="at of a flexible link must be three"):
        read(flexible={"upper_arm": kf.FlexibleLink(beam(0.35), at=(0.1, 0))})


def test_a_body_of_another_mass_is_told() -> None:
    with pytest.warns(LinkMassWarning, match=r"'upper_arm' has 2.5 kg in the file, the body in its place 6.55"):
        read(flexible={"upper_arm": beam(0.35, 7800.0)})


@pytest.mark.mjcf
def test_a_range_of_compensation_at_a_flexible_link_is_named(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(
        """<mujoco><worldbody><body name="arm" gravcomp="1">
        <joint name="j" axis="0 1 0" actuatorgravcomp="true" actuatorfrcrange="-1 1"/>
        <inertial pos=".17 0 0" mass="2" diaginertia=".1 .1 .1"/></body></worldbody>
        <actuator><motor joint="j"/></actuator></mujoco>"""
    )
    with pytest.warns(NotTakenWarning, match="range of compensation by actuators at flexible links: j"):
        kf.read_mjcf(tmp_path / "arm.xml", flexible={"arm": beam(0.35)})
