"""Inertia about one axis alone: enough for what turns about it, refused for what can turn otherwise."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError


def chain(inertia: object, second: kf.Joint | None = None, axis: str = "z") -> kf.System:
    scene = kf.System(gravity=(9.81, 0, 0) if axis == "z" else (0, 0, 9.81))
    a = scene.add_rigid_body("a", 1.0, inertia, com=(0.5, 0, 0), joint=kf.Revolute(axis, position=0.4))
    joint = kf.Revolute(axis) if second is None else second
    scene.add_rigid_body("b", 2.0, inertia, com=(0.3, 0, 0), parent=a, at=(1, 0, 0), joint=joint)
    return scene


@pytest.mark.parametrize(("axis", "inertia"), [("z", (0, 0, 0.2)), ("y", (0, 0.2, 0))])
def test_a_chain_in_a_plane_moves_as_with_all_moments(axis, inertia):
    given, whole = (chain(x, axis=axis).simulate((0.0, 0.5), rtol=1e-9) for x in (inertia, 0.2))
    for name in "ab":
        np.testing.assert_allclose(given.position(name), whole.position(name), rtol=0, atol=1e-12)
    np.testing.assert_allclose(given.energy.kinetic, whole.energy.kinetic, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("second", [kf.Revolute("x"), kf.Universal("z", "x"), kf.Free(), kf.Spherical()], ids=str)
def test_what_can_turn_out_of_its_plane_is_refused(second):
    with pytest.raises(ModelError, match=r"body 'b' has inertia about \[0.0, 0.0, 1.0\] alone.*about all three"):
        chain((0, 0, 0.2), second).freeze()


def test_so_is_what_hangs_on_something_that_turns_out_of_it():
    scene = kf.System()
    a = scene.add_rigid_body("a", 1.0, 0.1, joint=kf.Revolute("y"))
    scene.add_rigid_body("b", 1.0, (0, 0, 0.2), parent=a, joint=kf.Revolute("z"))
    with pytest.raises(ModelError, match="body 'b'"):
        scene.freeze()
