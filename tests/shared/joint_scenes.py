"""A joint in the middle of a scene: between bodies that move, with springs, loops and flexible bodies around it."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from kanefe.equations.model import Model
from random_scenes import elastic_body


def scene_of(joint: kf.Joint, *, is_flexible: bool = False) -> kf.System:
    """Return a scene with the joint between two bodies; flexible: what it carries, and a rod that closes a loop."""
    scene = kf.System(gravity=(0.3, -1.0, -9.81))
    base = scene.add_rigid_body("base", 2.0, (0.1, 0.2, 0.3), joint=kf.Revolute((1, 2, 3), position=0.3, speed=0.8))
    where = {"joint": joint, "parent": base, "at": (0.1, 0.3, -0.2), "orientation": (0.9, 0.1, -0.3, 0.2)}
    if is_flexible:
        outer = scene.add_flexible_body("slider", elastic_body("damped modes", 1), **where).interface("tip")
    else:
        outer = scene.add_rigid_body("slider", 1.0, (0.02, 0.05, 0.04), com=(0.1, -0.2, 0.3), **where)
    tip = scene.add_rigid_body("tip", 0.5, 0.01, parent=outer, at=(0.1, 0.2, 0.1), joint=kf.Universal("x", "z"))
    scene.add_spring("spring", scene.ground, tip, stiffness=30.0, damping=0.5, rest_length=0.1)
    if is_flexible:
        far = scene.add_rigid_body("far", 0.3, 0.02, joint=kf.Free(position=(0.5, 1.5, 0.3)))
        scene.add_distance("rod", far, tip, 1.2)
    return scene


def assert_routes_agree(model: Model, t: float = 0.0) -> None:
    """Compare the rates and energies of the literal and of the compiled route at the start of a scene."""
    assert model.route.name == "order n"
    y = np.concatenate((model.initial_state, (0.0, 0.0)))
    rates, wanted = model.route.evaluate(t, y).rates, model.literal.evaluate(t, y).rates
    # sums of a few hundred products, in another order
    np.testing.assert_allclose(rates, wanted, rtol=0, atol=1e-12 * abs(wanted).max())
    np.testing.assert_allclose(model.route.energy(t, y).total, model.literal.energy(t, y).total, rtol=1e-13)
