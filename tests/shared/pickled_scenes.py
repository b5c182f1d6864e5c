"""Scenes that can be pickled: what they hold of functions stands in this module, where another process finds it."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from typing import Any

import numpy as np

import kanefe as kf
from loop_scenes import four_bar
from run_scenes import soft_arm
from scenes import lattice_body
from steel_beams import steel_beam


def angle(t: float) -> float:
    return 0.3 * math.sin(3.0 * t)


def rate(t: float) -> float:
    return 0.9 * math.cos(3.0 * t)


def acceleration(t: float) -> float:
    return -2.7 * math.sin(3.0 * t)


def push(t: float) -> np.ndarray:
    return np.array([math.cos(t), 0.5, 0.0])


def drag(t: float, state: Any) -> np.ndarray:
    return np.asarray(-0.3 * state.velocity("bob"))


def law(length: float, speed: float) -> float:
    return 2.0 * length**2 + 0.5 * speed


def bushing_law(displacement: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    return -displacement * abs(displacement) - 0.3 * speeds


def flexible() -> kf.System:
    """Return an arm on a hinge, in the paper's angles, with an unreduced one of few coordinates at its tip."""
    scene = kf.System(gravity=(0.0, 0.0, -2.0), slopes="tait-bryan")
    body = lattice_body(1, reduction=kf.CraigBampton(modes=2), damping=kf.ModalDamping(0.2))
    arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("y"))
    scene.add_rigid_body("tip", 0.5, 0.02, parent=arm.interface("tip"))
    scene.add_force(arm.interface("tip"), push, follows=True)
    return scene


def driven(motion: kf.Motion) -> kf.System:
    """Return a driven hub with a pendulum."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", motion=motion))
    scene.add_rigid_body(
        "bob", 1.0, 0.1, com=(0.5, 0.0, 0.0), at=(0.3, 0.0, 0.0), parent=hub, joint=kf.Revolute("z", position=0.3)
    )
    return scene


def sprung() -> kf.System:
    """Return two bodies with springs and bushings of every kind, forces in axes of their own, stops and friction."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    force = kf.CoordinateForce(2.0, 0.1, limits=(-0.2, 0.2), limit_stiffness=1e3, friction=0.1)
    cart = scene.add_rigid_body("cart", 2.0, 0.1, joint=kf.Prismatic("x", forces=force))
    bob = scene.add_rigid_body("bob", 1.0, (0.1, 0.2, 0.3), joint=kf.Free(position=(0.0, 0.0, -0.5)))
    scene.add_spring("linear", cart, bob, stiffness=30.0, damping=0.4)
    scene.add_spring("table", cart, bob.frame(at=(0.1, 0, 0)), force=([0.1, 0.5, 4.0], [-1.0, 0.5, 2.0]))
    scene.add_spring("law", scene.ground.frame(at=(1, 0, 0)), bob.frame(at=(0, 0.1, 0)), force=law)
    scene.add_bushing("mount", cart, bob, stiffness=(1.0, 2.0, 3.0), damping=(0.1, 0.0, 0.2))
    scene.add_bushing("own", scene.ground, bob, law=bushing_law)
    scene.add(kf.Rope("rope", (cart, scene.ground.frame(at=(1, 0, 1)), bob), axial_stiffness=1e3, breaking_load=50.0))
    scene.add_force(bob.frame(orientation=(1.0, 0.5, 0.0, 0.0)), push, follows=True)
    scene.add_force(bob, drag)
    scene.add_motor(cart, rate)
    return scene


def unreduced() -> kf.System:
    """Return a hinged beam in sparse matrices."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("arm", kf.flexible_body(steel_beam(60), {"root": "clamped"}), joint=kf.Revolute("y"))
    return scene


SCENES: dict[str, Callable[[], kf.System]] = {
    "flexible": flexible,
    "flexible, rotation vectors": soft_arm,
    "loop": four_bar,
    "driven, steady": lambda: driven(kf.Motion.steady(2.0, 0.1)),
    "driven, table": lambda: driven(kf.Motion.table(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9) ** 2)),
    "driven, functions": lambda: driven(kf.Motion(angle, rate, acceleration)),
    "driven, compiled": lambda: driven(kf.Motion(angle, rate, acceleration).compiled()),
    "springs": sprung,
    "unreduced": unreduced,
}


def fingerprint(scene: kf.System) -> str:
    """Return a hash of the states of a short run."""
    result = scene.simulate((0.0, 0.02), rtol=1e-5, output_step=0.01)
    result.raise_for_status()
    run = result.run
    assert run is not None
    parts = (run.trajectory.coordinates, run.trajectory.speeds, run.trajectory.dissipated, run.trajectory.work)
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()
