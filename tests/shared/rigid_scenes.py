"""Random scenes of rigid contacts between what floats, bends, is driven and closes loops, in random states."""

from __future__ import annotations

import numpy as np

import kanefe as kf
from kanefe import shapes
from kanefe.equations.model import Model
from scenes import lattice_body, random_inertia, unit_axis

FRICTION = (
    None,
    kf.Coulomb(0.3),
    kf.Coulomb(0.3, static=0.45),
    kf.Coulomb(0.2, static=0.4, stribeck_speed=0.3),
    kf.Stribeck(0.2, breakaway=0.3, stribeck_speed=0.2, exponent=1.0, viscous=0.05),
)


def _hills(rng: np.random.Generator) -> shapes.HeightField:
    places = np.linspace(-4.0, 4.0, 9)
    return shapes.HeightField(places, places, 0.2 * rng.standard_normal((9, 9)))


def _touched(rng: np.random.Generator) -> tuple[shapes.SurfaceShape, tuple[float, float, float]]:
    """Return a surface, and how fast it runs as a belt."""
    kind = rng.integers(5)
    if kind == 0:
        return shapes.Sphere(0.4), (0.0, 0.0, 0.0)
    if kind == 1:
        return _hills(rng), (0.0, 0.0, 0.0)
    if kind == 2:
        return shapes.Plane((0.3, -0.2, 1.0)), (0.0, 0.0, 0.0)
    return shapes.Plane("z"), (0.3, -0.2, 0.0) if kind == 3 else (0.0, 0.0, 0.0)


def _touching(rng: np.random.Generator, is_flat: bool) -> shapes.SurfaceShape:
    kind = rng.integers(4 if is_flat else 3)
    if kind == 0:
        return shapes.Sphere(0.2)
    if kind == 1:
        return shapes.Points(0.3 * rng.standard_normal((int(rng.integers(1, 5)), 3)))
    if kind == 2:
        return shapes.Points(0.3 * rng.standard_normal((2, 3)), radius=0.05)
    return shapes.Torus(0.3, 0.1)


def _swing(rng: np.random.Generator) -> kf.Motion:
    """Return a motion that compiled code knows, of half a second."""
    return kf.Motion.table(np.linspace(0.0, 0.5, 6), 0.1 * rng.standard_normal(6))


def rigid_scene(seed: int) -> Model:
    """Return a scene of 1 to 4 rigid contacts between random frames, far from each other as it starts."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3))
    deck = scene.add_rigid_body(
        "deck", 3.0, random_inertia(rng), joint=kf.Revolute(unit_axis(rng), motion=_swing(rng)), at=(0, 0, -20)
    )
    ground = scene.ground
    frames = [deck, ground]  # from below
    for i in range(int(rng.integers(1, 4))):
        joint = kf.Free(position=(0, 0, 20.0 * (i + 1)))
        frames.append(scene.add_rigid_body(f"thing {i}", 1.0, random_inertia(rng), com=(0.1, 0, 0.05), joint=joint))
    if rng.random() < 0.4:
        arm = scene.add_flexible_body(
            "arm", lattice_body(seed), parent=deck, at=(0, 0, 9), joint=kf.Universal("y", "z")
        )
        frames.insert(1, arm.interface("tip"))
    if rng.random() < 0.4:
        cranks = [
            scene.add_rigid_body(f"crank {i}", 1.0, 0.1, com=(0, 0.5, 0), at=(i, 0, 100), joint=kf.Revolute("z"))
            for i in range(2)
        ]
        coupler = scene.add_rigid_body(
            "coupler", 1.0, 0.1, com=(0.5, 0, 0), parent=cranks[0], at=(0, 1, 0), joint=kf.Revolute("z")
        )
        scene.add_loop_joint("pin", kf.Revolute("z"), coupler.frame(at=(1, 0, 0)), cranks[1].frame(at=(0, 1, 0)))
        frames.append(coupler)
    for number in range(int(rng.integers(1, 5))):
        a, b = sorted(rng.choice(len(frames), 2, replace=False))
        if frames[a] is deck and frames[b] is ground:
            b += 1  # neither is free to answer a force
        surface, belt = _touched(rng)
        touched = scene.add_surface(f"surface {number}", frames[a], surface, at=0.1 * rng.standard_normal(3))
        touching = _touching(rng, isinstance(surface, shapes.Plane))
        skin = scene.add_surface(f"skin {number}", frames[b], touching, at=0.1 * rng.standard_normal(3))
        law = kf.Rigid(rng.uniform(), impact=("newton", "poisson", "stronge", "stronge")[int(rng.integers(4))])
        friction = FRICTION[int(rng.integers(1 if any(belt) else 0, len(FRICTION)))]
        scene.add_contact(f"contact {number}", skin, touched, normal=law, friction=friction, surface_velocity=belt)
    return scene.freeze()


def rigid_state(model: Model, seed: int) -> np.ndarray:
    """Return a state (q, u, z) with bodies near each other, and contacts open, sticking and slipping by chance."""
    rng = np.random.default_rng(seed)
    q, u, z = (part.copy() for part in model.parts(model.initial_state))
    q[:] = 0.1 * rng.standard_normal(len(q))
    for body in model.bodies:
        at, speeds = body.free_coordinates()
        if len(at):
            q[at] = body.joint.advance(model.initial_coordinates[at], rng.standard_normal(len(speeds)))
        if body.flexible:
            q[body.flexible.eta] = 0.02 * rng.standard_normal(len(q[body.flexible.eta]))
    u[:] = rng.standard_normal(len(u))
    for number, load in enumerate(model.rigid_contacts):
        contact, own = model.rigid_contact(number), z[model.load_states[load]]
        for i in range(len(contact.probes)):
            closed = 2 if contact.friction is None else int(rng.choice((1, 2)))
            status = closed if rng.random() < 0.4 else 0  # of many closed at once the forces are shared
            kept = rng.standard_normal(3) * 10.0 ** rng.choice((-9.0, -3.0, 0.0))
            contact.with_status(own, i, status, kept, rng.standard_normal(3))
    return np.concatenate((q, u, z))


def stack(count: int, drop: float) -> kf.System:
    """Return boxes above each other, each with four corners above the top of the one below."""
    scene = kf.System(gravity=(0, 0, -9.81))
    below = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    for i in range(count):
        place = (0.003 * (-1) ** i, 0, 0.1 + 0.2 * i + drop * (i + 1))
        box = scene.add_rigid_body(f"box {i}", 1.0, 0.01, joint=kf.Free(position=place))
        corners = shapes.Points([(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
        skin = scene.add_surface(f"corners {i}", box, corners)
        scene.add_contact(f"c{i}", skin, below, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
        below = scene.add_surface(f"top {i}", box, shapes.Plane("z"), at=(0, 0, 0.1))
    return scene
