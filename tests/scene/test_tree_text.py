"""A scene in words, found again by name, and thawed by a copy."""

import numpy as np
import pytest

import kanefe as kf
from scenes import lattice_body


def crane() -> kf.System:
    """Return a driven mast that carries a flexible boom with a hook, which is pulled and hangs on a spring."""
    scene = kf.System(gravity=(0, 0, -9.81))
    motion = kf.Motion.steady(0.2)
    mast = scene.add_rigid_body("mast", 5.0, 1.0, joint=kf.Revolute("z", motion=motion))
    boom = scene.add_flexible_body("boom", lattice_body(0), parent=mast, at=(0, 0, 1))
    hook = scene.add_point("hook", 0.5, parent=boom.interface("tip"), joint=kf.Translation())
    scene.add_force(hook, (1.0, 0.0, 0.0))
    scene.add_spring("rope", scene.ground, hook, stiffness=10.0)
    scene.add_distance("stay", mast, hook, 1.5)
    return scene


def test_inertia_names_its_point_where_that_is_not_the_origin() -> None:
    scene = kf.System()
    scene.add_rigid_body("rod", 2.0, 0.1, com=(0, 0, -1), joint=kf.Revolute("y"))
    scene.add_rigid_body("ball", 2.0, 0.1, joint=kf.Free())
    scene.add_rigid_body("bob", 2.0, com=(0, 0, -1), joint=kf.Spherical())
    assert str(scene).splitlines()[2:] == [
        "├─ rod (rigid, 2 kg, inertia about its centre of mass (0, 0, -1) m), revolute y",
        "├─ ball (rigid, 2 kg), free",
        "└─ bob (rigid, 2 kg), spherical",
    ]


def test_a_scene_prints_as_a_tree():
    lines = str(crane()).splitlines()
    assert lines[0] == "scene of 3 bodies, 1 flexible, gravity (0, 0, -9.81) m/s2"
    assert lines[2] == "└─ mast (rigid, 5 kg), revolute z; angle driven"
    assert lines[3].startswith("   └─ boom (flexible, ")
    assert lines[3].endswith(" modes), fixed")
    assert lines[4] == "      └─ at 'tip': hook (rigid, 0.5 kg), translation"
    assert lines[5] == "            acted on by the force on 'hook'"
    assert "  spring 'rope' between the ground and 'hook'" in lines
    assert "  distance 'stay' between 'mast' and 'hook'" in lines


def test_a_frozen_scene_thaws_by_a_copy_and_stays_as_it_is():
    scene = kf.System()
    scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
    scene.freeze()
    with pytest.raises(kf.ModelError, match=r"the scene was frozen.*scene.copy\(\)"):
        scene.add_force(scene.body("cart"), (1.0, 0.0, 0.0))
    pulled = scene.copy()
    with pytest.raises(kf.ModelError, match="belongs to another system"):
        pulled.add_force(scene.body("cart"), (1.0, 0.0, 0.0))
    pulled.add_force(pulled.body("cart"), (1.0, 0.0, 0.0))
    pulled.add_point("ball", 1.0, parent=pulled.body("cart"), joint=kf.Translation())
    assert pulled.simulate((0.0, 1.0)).position("cart")[-1, 0] == pytest.approx(0.25, rel=1e-9)
    assert "force" not in str(scene)
    assert "ball" not in str(scene)
    assert np.all(scene.simulate((0.0, 1.0)).position("cart") == 0.0)


def test_a_body_is_found_by_its_name():
    scene = crane()
    assert scene.body("boom").interface("tip").label == "'tip' of 'boom'"
    with pytest.raises(kf.ModelError, match=r"no body called 'jib'\. It has: mast, boom, hook"):
        scene.body("jib")


def test_joints_with_fewer_speeds_than_coordinates_print():
    scene = kf.System()
    scene.add_rigid_body("stone", 1.0, 1.0, joint=kf.Free())
    scene.add_rigid_body("top", 1.0, 1.0, joint=kf.Spherical())
    assert str(scene).splitlines()[2:] == ["├─ stone (rigid, 1 kg), free", "└─ top (rigid, 1 kg), spherical"]


def test_a_chain_longer_than_python_recurses_is_told() -> None:
    scene = kf.System()
    parent = None
    for number in range(1500):
        parent = scene.add_rigid_body(f"l{number}", 1.0, 0.1, parent=parent, joint=kf.Fixed())
    assert "l1499 (rigid, 1 kg), fixed" in str(scene)
    assert "scene of 1500 bodies" in scene._repr_html_()
