"""Loads that are too large to compute with."""

from __future__ import annotations

import math

import pytest

import kanefe as kf
from kanefe.errors import SimulationError


def block(kind: str, force: object) -> kf.System:
    """Return a block that a force pulls along a rail with friction, a winch, or a rigid floor."""
    scene = kf.System(gravity=(0, 0, -9.81))
    if kind == "winch":
        body = scene.add_point("block", 1.0, joint=kf.Translation(position=(1, 0, 0)))
        tension = ((0.0, 1.0), (10.0, 20.0))
        winch = kf.Winch("w", (scene.ground, body), tension=tension, stiffness=1e4, speed=1.0, damping=100.0)
        scene.add(winch)
    elif kind == "rail":
        rail = kf.Prismatic("x", friction=kf.JointFriction(0.2, static=0.3, stribeck_speed=0.01))
        body = scene.add_rigid_body("block", 1.0, 0.1, joint=rail)
    else:
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        body = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free(position=(0, 0, 0.25)))
        ball = scene.add_surface("ball", body, kf.shapes.Sphere(0.1))
        scene.add_contact("touch", ball, floor, normal=kf.Rigid(0.3), friction=kf.Coulomb(0.3))
    scene.add_force(body, force)
    return scene


@pytest.mark.parametrize("kind", ["winch", "rail", "floor"])
@pytest.mark.parametrize("force", [1e160, 1e300])
def test_the_load_is_named(kind: str, force: float) -> None:
    with pytest.raises(SimulationError, match=rf"the force on 'block'.* is 1e\+{round(math.log10(force))}"):
        kf.equilibrium(block(kind, (force, 0.0, 0.0)))


def test_a_load_that_grows_in_the_search_is_named() -> None:
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=1.0)
    block = scene.add_rigid_body("block", 1.0, 0.1, joint=kf.Prismatic("x", forces=spring))
    scene.add_force(block, lambda t, state: (1.0 if state.position("block")[0] < 0.1 else 1e200, 0.0, 0.0))
    with pytest.raises(SimulationError, match=r"the force on 'block'.* is 1e\+200"):
        kf.equilibrium(scene)


def test_it_is_named_in_paths_too() -> None:
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=1.0)
    block = scene.add_rigid_body("block", 1.0, 0.1, joint=kf.Prismatic("x", forces=spring))
    scene.add_force(block, (1e160, 0.0, 0.0))
    with pytest.raises(SimulationError, match=r"the force on 'block'.* is 1e\+160"):
        kf.equilibrium_path(scene)
