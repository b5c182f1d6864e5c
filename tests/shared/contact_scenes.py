"""Scenes of a surface that another touches, in random states, on both routes."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes

LAW = kf.HuntCrossley(2e4, damping=0.4)

FRICTION = {
    "none": None,
    "one": kf.Coulomb(0.4, stiffness=3e4, damping=20.0),
    "static": kf.Coulomb(0.3, static=0.5, stiffness=3e4, damping=20.0),
    "stribeck": kf.Coulomb(0.3, static=0.5, stribeck_speed=0.2, stiffness=3e4, damping=20.0),
    "spinning": kf.Coulomb(0.4, torsional=0.05, stiffness=3e4, damping=20.0),
    "rolling": kf.Coulomb(0.4, rolling=0.02, stiffness=3e4, damping=20.0),
    "turning": kf.Coulomb(0.3, static=0.5, torsional=0.05, rolling=0.02, stiffness=3e4, damping=20.0),
    "bristles": kf.LuGre(3e2, 2.0, 0.1, coulomb=0.3, static=0.5, stribeck_speed=0.2),
    "two": kf.Coulomb((0.3, 0.5), along=(1.0, 1.0, 0.0), stiffness=3e4, damping=20.0),
}


def scene_of(
    touched: shapes.SurfaceShape, touching: shapes.SurfaceShape, normal=LAW, friction=None, belt=(0.0, 0.0, 0.0)
):
    scene = kf.System(gravity=(0, 0, -9.81))
    table = scene.add_rigid_body("table", 3.0, (0.2, 0.3, 0.4), joint=kf.Free())
    thing = scene.add_rigid_body("thing", 1.0, (0.1, 0.12, 0.08), com=(0.05, 0, 0), joint=kf.Free())
    top = scene.add_surface("top", table, touched, at=(0.1, 0, 0), orientation=kf.rotation_about("y", 0.2))
    skin = scene.add_surface("skin", thing, touching, at=(0, 0.02, 0))
    scene.add_contact("contact", skin, top, normal=normal, friction=friction, surface_velocity=belt)
    return scene


def random_state(model, seed: int, offset) -> np.ndarray:
    """Return a state in which the thing is near `offset` from the table; anchors stretched."""
    rng = np.random.default_rng(seed)
    q, u, z = model.parts(model.initial_state.copy())
    q[:] = 0.0
    for at in (0, 7):
        e = np.array((1.0, 0, 0, 0)) + 0.3 * rng.standard_normal(4)
        q[at + 3 : at + 7] = e / np.linalg.norm(e)
    q[7:10] = offset
    z[:] = 1e-3 * rng.standard_normal(len(z)) if len(z) else z
    return np.concatenate((q, rng.standard_normal(len(u)), z, (0.0, 0.0)))


def assert_routes_agree(scene, seeds, distances, least: int = 1, atol: float = 1e-9):
    model = scene.freeze()
    assert model.route.name == "order n"
    seen = 0
    for seed in seeds:
        direction = np.random.default_rng(seed + 100).standard_normal(3)
        direction[2] = abs(direction[2])
        offset = distances[seed % len(distances)] * direction / np.linalg.norm(direction)
        y = random_state(model, seed, offset)
        theirs = model.literal.evaluate(0.0, y).rates
        np.testing.assert_allclose(model.route.evaluate(0.0, y).rates, theirs, rtol=1e-10, atol=atol)
        ours, literal = model.route.energy(0.0, y), model.literal.energy(0.0, y)
        assert ours.total == pytest.approx(literal.total, rel=1e-12, abs=1e-2 * (atol - 1e-9))
        seen += bool(abs(theirs[-2]) > 0.0)
    assert seen >= least, "no state was in contact"
