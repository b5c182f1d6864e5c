"""Scenes that every method of integration runs, and which methods there are."""

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.methods.table import METHODS, own_methods
from kanefe.integrate.stepper import Stepper
from kanefe.tree.scene_state import SceneState
from scenes import lattice_body

ADAPTIVE = [name for name in own_methods() if METHODS[name].has_error_control]
needs_sundials = pytest.mark.skipif(
    find_spec("sksundae") is None, reason="scikit-sundae is not installed: pip install 'kanefe[sundials]'"
)
PLUGGED = [
    pytest.param(name, marks=needs_sundials if name.startswith("sundials") else ())
    for name, method in METHODS.items()
    if method.is_plugged
]


def double_pendulum() -> kf.System:
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    first = scene.add_rigid_body("first", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z", position=-0.3))
    scene.add_rigid_body("second", 0.5, 0.05, com=(0.4, 0, 0), parent=first, at=(1, 0, 0), joint=kf.Revolute("z"))
    return scene


def thrown_pendulum() -> Model:
    """Return a double pendulum on a ball joint, thrown."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    upper = scene.add_rigid_body("upper", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y", speed=1.0))
    hinge = kf.Spherical(angular_velocity=(0.5, 1.0, 2.0))
    scene.add_rigid_body("lower", 1.0, (0.1, 0.2, 0.3), com=(0.5, 0, 0), joint=hinge, parent=upper, at=(1, 0, 0))
    return scene.freeze()


def check_snapshot(make: Callable[[], Stepper], end: float, steps: int) -> None:
    """Compare a run to its end with one that is left after some steps and taken up by another stepper: to the bit."""
    whole, first, second = make(), make(), make()
    times, states = np.array([end]), np.empty((1, len(whole.state())))
    assert whole.integrate_through(times, states, 10**6) == 1
    assert first.integrate_through(times, np.empty_like(states), steps) == 0
    second.resume(first.snapshot())
    assert second.integrate_through(times, states, 10**6) == 1
    np.testing.assert_array_equal(second.state(), whole.state())


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


def falling_ball(height: float = 1.0, speed: float = 0.0) -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_point("ball", 0.1, joint=kf.Prismatic("z", position=height, speed=speed))
    return scene


def height_of_ball(t: float, state: SceneState) -> float:
    return float(state.position("ball")[2])


def bounced(restitution: float) -> Callable[[float, SceneState], np.ndarray]:
    """Return the action of an event that turns the first speed of a scene round."""

    def bounce(t: float, state: SceneState) -> np.ndarray:
        y = state.vector
        y[1] *= -restitution
        return y

    return bounce


def floor(restitution: float) -> kf.Event:
    """Return the event at which `falling_ball` bounces."""
    return kf.Event("floor", height_of_ball, direction=-1, action=bounced(restitution))
