"""Runs that the tests of results share, each made once."""

from functools import cache

import numpy as np

import kanefe as kf
from kanefe.kane.assemble import accelerations
from kanefe.states.state import State
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material

SOFT = Material(E=2e9, nu=0.3, rho=1200.0)


def beam_arm(elements: int = 6, damping: object = None) -> kf.FlexibleBody:
    """Return a cantilever along x, 1 m long, whose two softest modes swing at some hertz."""
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=elements)
    interfaces = {"root": "clamped", "tip": "rigid"}
    return kf.flexible_body(beam, interfaces, reduction=kf.CraigBampton(modes=1), damping=damping)


@cache
def pendulum() -> kf.Result:
    """A uniform rod, hinged at its end, that falls from horizontal."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", mass=2.0, inertia=(0.01, 2 / 12, 2 / 12), com=(0.5, 0, 0), joint=kf.Revolute("z"))
    return scene.simulate((0.0, 1.0), rtol=1e-10, output_step=0.02)


@cache
def turntable() -> kf.Result:
    """A table driven with angle sin(3 t), and a mass fixed on it 0.5 m off the axis."""
    scene = kf.System()
    motion = kf.Motion(lambda t: np.sin(3 * t), lambda t: 3 * np.cos(3 * t), lambda t: -9 * np.sin(3 * t))
    table = scene.add_rigid_body("table", mass=5.0, inertia=0.4, joint=kf.Revolute("z", motion=motion))
    scene.add_rigid_body("load", mass=2.0, inertia=0.1, parent=table, at=(0.5, 0, 0))
    return scene.simulate((0.0, 1.0), rtol=1e-10, output_step=0.02)


@cache
def four_bar() -> kf.Result:
    """Two rods that hang from the ground, joined by a third whose far end closes a loop."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    rods = {"mass": 1.0, "inertia": 0.01, "com": (0.0, -0.25, 0.0)}
    left = scene.add_rigid_body("left", **rods, joint=kf.Revolute("z", position=0.4))
    right = scene.add_rigid_body("right", **rods, joint=kf.Revolute("z", position=0.4), at=(1.0, 0.0, 0.0))
    level = kf.Revolute("z", position=-0.4)
    bar = scene.add_rigid_body("bar", mass=2.0, inertia=0.1, parent=left, at=(0.0, -0.5, 0.0), joint=level)
    scene.add_loop_joint("pin", kf.Revolute("z"), bar.frame(at=(1.0, 0.0, 0.0)), right.frame(at=(0.0, -0.5, 0.0)))
    return scene.simulate((0.0, 0.2), output_step=0.02)


@cache
def robot() -> kf.Result:
    """A hub with a motor, a damped flexible arm off its centre, and a body at the arm's tip, under gravity."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", mass=4.0, inertia=(0.02, 0.02, 0.03), joint=kf.Revolute("z"))
    turned = (np.cos(0.2), 0.0, 0.0, np.sin(0.2))
    body = beam_arm(damping=kf.ModalDamping(0.05))
    arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0.02), orientation=turned)
    scene.add_rigid_body("tip", mass=0.2, inertia=2e-4, com=(0.02, 0, 0), parent=arm.interface("tip"))
    scene.add_torque(hub, lambda t: 2.0 * np.sin(6 * t))
    return scene.simulate((0.0, 0.4), rtol=1e-5, method="generalised-alpha", output_step=0.01)


@cache
def at_rest() -> kf.Result:
    """A heavy cantilever that starts in equilibrium."""
    body, gravity = beam_arm(), (0.0, 0.0, -9.81)

    def scene(eta: np.ndarray | None) -> kf.System:
        system = kf.System(gravity=gravity)
        system.add_flexible_body("arm", body, modal_coordinates=eta)
        return system

    # with unit modal mass the accelerations from rest are the generalised weights, which do not depend on eta
    model = scene(None).freeze()
    weights = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
    k = body.free_count
    sag = np.linalg.solve(body.stiffness[:k, :k], weights)
    return scene(sag).simulate((0.0, 0.05), rtol=1e-8, method="generalised-alpha", output_step=0.01)
