"""Scenes of runs: one that bounces, one that swings."""

import kanefe as kf


def bouncing_ball() -> kf.System:
    """Return a ball that bounces on a stiff floor."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    ball = scene.add_rigid_body("ball", 1.0, 0.004, joint=kf.Free(position=(0.0, 0.0, 0.3)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane())
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("feet", skin, floor, normal=kf.HuntCrossley(1e5), friction=kf.Coulomb(0.3))
    return scene


def swinging_rod(**joint: object) -> kf.System:
    """Return a pendulum."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z", **joint))
    return scene
