"""Scenes of runs: two that bounce, one that swings."""

import kanefe as kf


def bouncing_ball() -> kf.System:
    """Return a ball that bounces on a stiff floor."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    ball = scene.add_rigid_body("ball", 1.0, 0.004, joint=kf.Free(position=(0.0, 0.0, 0.3)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane())
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("feet", skin, floor, normal=kf.HuntCrossley(1e5), friction=kf.Coulomb(0.3))
    return scene


def bouncing_brick() -> kf.System:
    """Return a brick that falls on an edge of it, bounces and slides, by rigid contacts."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    start = kf.Free(position=(0.0, 0.0, 0.3), orientation=kf.rotation_about("y", 0.3), velocity=(1.0, 0.0, 0.0))
    brick = scene.add_rigid_body("brick", 1.0, 0.004, joint=start)
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane())
    corners = kf.shapes.Points([(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    skin = scene.add_surface("skin", brick, corners)
    scene.add_contact("feet", skin, floor, normal=kf.Rigid(0.4), friction=kf.Coulomb(0.3))
    return scene


def swinging_rod(**joint: object) -> kf.System:
    """Return a pendulum."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", 1.0, 1.0 / 12.0, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z", **joint))
    return scene
