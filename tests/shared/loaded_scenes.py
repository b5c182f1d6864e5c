"""Scenes with every joint force, drive, spring and load, and the rates of their energies and momenta."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import elastic_energy, gravity_energy, kinetic_energy, momenta
from kanefe.states.state import State
from scenes import derivatives, lattice_body, path, random_inertia, swing, unit_axis

T = 0.4

# Accelerations of the modes are some 1e3: order-8 differences need steps below 1e-3 to see none of their powers.
STEP = 3e-4


def force_of(rng: np.random.Generator, limited: bool = False) -> kf.CoordinateForce:
    """Return a force with everything in it but friction; with limits, the coordinate 0 is beyond the upper one."""
    k, c, armature = rng.uniform(0.5, 2.0, 3)
    stops: dict[str, Any] = {"limits": (-9.0, -3.0), "limit_stiffness": 7.0, "limit_damping": 0.3} if limited else {}
    return kf.CoordinateForce(k, c, rng.uniform(-0.5, 0.5), armature=0.1 * armature, **stops)


def place(rng: np.random.Generator) -> dict[str, Any]:
    return {"at": rng.uniform(-0.3, 0.3, 3), "orientation": rng.standard_normal(4)}


def tree(seed: int, gravity: bool = True, joint_forces: bool = True) -> tuple[kf.System, dict[str, Any]]:
    """Return a scene of every scalar joint, some coordinates driven, with a flexible body; and its frames by name."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3) if gravity else (0.0, 0.0, 0.0))
    bodies: dict[str, Any] = {}

    def body(name: str, joint: kf.Joint, parent: Any, **options: Any) -> Any:
        com = rng.uniform(-0.2, 0.2, 3)
        bodies[name] = scene.add_rigid_body(
            name,
            rng.uniform(0.5, 2.0),
            random_inertia(rng),
            com=com,
            parent=parent,
            joint=joint,
            **place(rng),
            **options,
        )
        return bodies[name]

    def forces(*limited: bool) -> Any:
        return tuple(force_of(rng, x) if joint_forces else None for x in limited)

    hub = body("hub", kf.Free(), None)
    scene.add_rotor(hub, unit_axis(rng), 0.02, 30.0)
    sleeve = body("sleeve", kf.Cylindrical(unit_axis(rng), motion=(None, swing(rng)), forces=forces(False, False)), hub)
    body("cardan", kf.Universal("x", "y", motion=(swing(rng), None), forces=forces(False, False)), sleeve)
    body("plate", kf.Planar(motion=(None, None, swing(rng)), forces=forces(True, False, False)), hub, gravity=False)
    bodies["bob"] = scene.add_point(
        "bob", 0.4, parent=sleeve, joint=kf.Translation(position=(0.5, 0.2, -0.4), forces=(None, *forces(False, True)))
    )
    arm = scene.add_flexible_body(
        "arm",
        lattice_body(seed, reduction=kf.CraigBampton(modes=2), damping=kf.ModalDamping(0.1)),
        parent=hub,
        joint=kf.Revolute(unit_axis(rng), forces=forces(True)[0]),
        **place(rng),
    )
    bodies["tip"], bodies["node"] = arm.interface("tip"), arm.node(3)
    body("nut", kf.Screw("z", lead=0.3, forces=forces(False)[0]), bodies["tip"].frame(**place(rng)))
    return scene, bodies


def add_connections(scene: kf.System, bodies: dict[str, Any], seed: int, ground: bool) -> None:
    """Add springs and bushings of every kind, between the bodies or also to the ground."""
    rng = np.random.default_rng(seed + 100)

    def frame(name: str) -> Any:
        return bodies[name].frame(**place(rng))

    fast = lambda length, rate: 2.0 * length**2 + 0.5 * rate * abs(rate)  # noqa: E731
    scene.add_spring("linear", frame("hub"), frame("tip"), stiffness=3.0, damping=0.4, rest_length=0.2)
    scene.add_spring("table", frame("nut"), bodies["bob"], force=([0.1, 0.5, 4.0], [-1.0, 0.5, 2.0]), damping=0.2)
    scene.add_spring("law", bodies["node"], frame("cardan"), force=fast)
    scene.add_bushing(
        "soft", frame("plate"), frame("tip"), stiffness=rng.uniform(1, 3, 6), damping=rng.uniform(0, 1, 6)
    )
    scene.add_bushing("three", frame("hub"), bodies["node"], stiffness=(1.0, 2.0, 3.0), damping=(0.1, 0.0, 0.2))
    scene.add_bushing("own", frame("sleeve"), frame("nut"), law=lambda d, rate: -d * abs(d) - 0.3 * rate)
    if ground:
        scene.add_spring("anchor", scene.ground.frame(at=(1, 2, 3)), frame("plate"), stiffness=2.0, damping=0.3)
        scene.add_bushing("mount", frame("cardan"), scene.ground.frame(**place(rng)), stiffness=rng.uniform(1, 3, 6))


def add_controls(scene: kf.System, bodies: dict[str, Any]) -> None:
    """Add forces, torques and motors that read the state."""
    scene.add_force(
        bodies["tip"], lambda t, state: -state.velocity("arm", "tip") * np.cos(t), point=(0.1, 0.2, 0.0), follows=True
    )
    scene.add_torque(bodies["plate"], lambda t, state: state.rotation("hub") @ state.angular_velocity("hub"))
    scene.add_motor(bodies["cardan"], lambda t, state: -2.0 * state.joint_coordinates("cardan")[1], coordinate=1)
    scene.add_motor(bodies["sleeve"], lambda t: np.sin(t))
    scene.add_force(bodies["hub"], lambda t, state: state.position("nut", point=(1, 0, 0)) - state.position("bob"))


def everything(seed: int) -> Model:
    """Return a scene with every joint, force, drive, spring and control, and a flexible body."""
    scene, bodies = tree(seed)
    add_connections(scene, bodies, seed, ground=True)
    add_controls(scene, bodies)
    return scene.freeze()


def along(model: Model, t: float, q: np.ndarray, u: np.ndarray) -> Callable[[Callable[..., Any]], np.ndarray]:
    """Return what differentiates ``quantity(model, t, q, u)`` by time along the motion at a state."""
    du = accelerations(State(model, t, q, u))
    moved = path(model, q, u, du)
    return lambda quantity: derivatives(lambda s: np.asarray(quantity(model, t + s, moved(s), u + s * du)), STEP)[0]


def total_energy(model: Model, t: float, q: np.ndarray, u: np.ndarray) -> float:
    return (
        kinetic_energy(State(model, t, q, u)) + elastic_energy(State(model, t, q)) + gravity_energy(State(model, t, q))
    )


def all_momenta(model: Model, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.concatenate(momenta(State(model, t, q, u)))
