"""Contacts of shells: balls touch at either face, half a thickness from the middle, and friction acts at the face."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import Material, shell_body, surface_mesh
from kanefe_fem.mesh.surface_grid import joined_surfaces

pytestmark = pytest.mark.fenicsx

T, RADIUS = 0.02, 0.05
STIFF = Material(E=210e9, nu=0.3, rho=7850.0)


def plate(offset: float = 0.0):
    """Return a thick plate, clamped all around, with a node in its middle."""

    def sides(x):
        return (np.abs(x[:, :2]) > 0.2 - 1e-9).any(axis=1)

    mesh = surface_mesh(lambda s, r: (0.4 * (s - 0.5), 0.4 * (r - 0.5), 0.0 * s), (4, 4))
    held = {"sides": kf.Interface("all", at=sides)}
    return shell_body(mesh, STIFF, held, T, kf.CraigBampton(modes=3), offset=offset)


def with_ball(side: float, offset: float, normal, gap: float = 1e-4) -> tuple[kf.System, float]:
    """Return a plate, and a ball that falls on its top (1) or bottom (-1); and the height at which they touch."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81 * side))
    member = scene.add_flexible_body("plate", plate(offset))
    touching = offset * T + side * (T / 2.0 + RADIUS)
    ball = scene.add_rigid_body(
        "ball", 0.1, 1e-4, joint=kf.Prismatic("z", position=touching + side * gap), at=(0.0, 0.0, 0.0)
    )
    surface = scene.add_surface("skin", ball, kf.shapes.Sphere(RADIUS))
    place = member.patch(kf.InBox((-0.15, -0.15, -1.0), (0.15, 0.15, 1.0)), most=30)
    scene.add_contact("hit", place, surface, normal=normal)
    return scene, touching


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("offset", "normal"), [(0.5, kf.HuntCrossley(1e7)), (0.0, kf.Rigid(restitution=0.0))])
def test_a_ball_falls_on_either_face(side, offset, normal):
    scene, touching = with_ball(side, offset, normal)
    result = scene.simulate((0.0, 0.02))
    deepest = side * (result.position("ball")[:, 2] - touching)
    assert deepest.min() < 1e-9
    # a fall of 0.1 mm: m g h = k x^2 / 2 with the share of a point in k, and as much by the plate; 10 mm to the middle
    assert deepest.min() > -5e-5
    assert deepest[0] == pytest.approx(1e-4, rel=1e-9)


def test_friction_acts_at_the_face():
    """A strip lies on a moving floor: the moment at its root is that of friction at the bottom face."""
    mesh = surface_mesh(lambda s, r: (0.3 * s, 0.05 * (r - 0.5), 0.0 * s), (6, 1))
    strip = shell_body(mesh, STIFF, {"root": "clamped"}, T, kf.CraigBampton(modes=4))
    depth, mu = 1e-6, 0.5
    scene = kf.System()
    member = scene.add_flexible_body("strip", strip)
    floor = scene.add_surface("floor", scene.ground.frame(at=(0.0, 0.0, -T / 2.0 + depth)), kf.shapes.Plane())
    scene.add_contact(
        "drag",
        member.patch("tip"),
        floor,
        normal=kf.HuntCrossley(1e6),
        friction=kf.Coulomb(mu),
        surface_velocity=(0.1, 0.0, 0.0),
    )
    rest = kf.equilibrium(scene)
    force, moment = np.split(-rest.coupling_force("strip", "root"), 2)
    assert force[0] == pytest.approx(mu * force[2], rel=1e-6)
    assert force[2] > 0.1
    assert moment[1] == pytest.approx(-0.3 * force[2] - T / 2.0 * force[0], rel=1e-4)  # of the bent strip


def test_a_fold_has_a_ball_on_each_side_and_shares_add_up():
    strips = [
        surface_mesh(lambda s, r: (0.1 * s, 0.1 * r, 0.0 * s), (2, 2)),
        surface_mesh(lambda s, r: (0.0 * s, 0.1 * r, 0.1 * s), (2, 2)),
    ]
    held = {"root": kf.Interface("all", at=kf.OnPlane((0.1, 0.0, 0.0), (1.0, 0.0, 0.0)))}
    angle = shell_body(joined_surfaces(strips), STIFF, held, T, kf.CraigBampton(modes=2), offset=0.5)
    scene = kf.System()
    member = scene.add_flexible_body("angle", angle)
    patch = member.patch(kf.InBox((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), most=100)
    fold = [i for i, frame in enumerate(patch.frames) if np.hypot(*frame.interface_frame.position[[0, 2]]) < 1e-9]
    assert len(fold) == 5
    for i in fold:
        centres = np.array([ball.centre for ball in patch.balls if ball.point == i])
        assert sorted(np.abs(centres).argmax(axis=1)) == [0, 2]
        np.testing.assert_allclose(np.linalg.norm(centres, axis=1), T / 2.0)
    assert all(ball.radius == pytest.approx(T / 2.0) for ball in patch.balls)
    floor = scene.add_surface("floor", scene.ground.frame(at=(0.0, 0.0, -1.0)), kf.shapes.Plane())
    scene.add_contact("on floor", patch, floor, normal=kf.HuntCrossley(1e6))
    probes = scene.freeze().loads[0].probes
    assert sum(probe.share for _, probe in probes) == pytest.approx(1.0)
    assert len(probes) == len(patch.frames) + 5
