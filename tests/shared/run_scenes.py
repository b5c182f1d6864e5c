"""Scenes that every method of integration runs, and the methods that choose their steps."""

import kanefe as kf
from kanefe.integrate.methods.table import METHODS, own_methods
from scenes import lattice_body

ADAPTIVE = [name for name in own_methods() if METHODS[name].has_error_control]


def double_pendulum() -> kf.System:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    first = scene.add_rigid_body("first", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z", position=-0.3))
    scene.add_rigid_body("second", 0.5, 0.05, com=(0.4, 0, 0), parent=first, at=(1, 0, 0), joint=kf.Revolute("z"))
    return scene


def tumbling() -> kf.System:
    scene = kf.System()
    scene.add_rigid_body(
        "body", 1.0, (0.3, 0.5, 0.7), joint=kf.Free(angular_velocity=(0.1, 3.0, 0.2), velocity=(1, 0, 0))
    )
    return scene


def soft_arm() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -2.0))
    arm = scene.add_flexible_body(
        "arm", lattice_body(1, reduction=kf.CraigBampton(modes=1), damping=kf.ModalDamping(0.2)), joint=kf.Revolute("y")
    )
    scene.add_rigid_body("tip", 0.5, 0.02, parent=arm.interface("tip"))
    return scene


SCENES = {"double pendulum": double_pendulum, "tumbling": tumbling, "soft arm": soft_arm}
