"""What a prompt shows of a scene's parts: a line, and no tables of numbers."""

import kanefe as kf
from result_scenes import beam_arm


def test_parts_of_a_scene_are_shown_in_a_line():
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 1.0, joint=kf.Revolute("z"))
    body = beam_arm()
    arm = scene.add_flexible_body("arm", body, parent=hub)
    assert repr(hub) == "RigidBody('hub')"
    assert repr(hub.frame((1.0, 0.0, 0.0))) == "Frame('hub' at (1, 0, 0))"
    assert repr(arm.interface("tip")) == "Frame('tip' of 'arm')"
    assert repr(scene.ground) == "Frame(the ground)"
    assert repr(scene.freeze()) == "Model('hub', 'arm'; 8 speeds)"
    assert "7 nodes" in repr(body)
    assert "root (fixed), tip" in repr(body)
    assert len(repr(body)) < 200
