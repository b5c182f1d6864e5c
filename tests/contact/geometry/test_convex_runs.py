"""Runs of convex shapes that lie and rock on each other's faces."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.loads.action import End

G, MASS = 9.81, 1.0


def cylinder_on_a_box(normal, friction=None, tilt: float = 0.02) -> kf.System:
    """Return a cylinder that falls on a box with one end of its side first."""
    scene = kf.System(gravity=(0, 0, -G))
    table = scene.add_surface("table", scene.ground, shapes.Box((1.0, 1.0, 0.2)), at=(0, 0, -0.1))
    free = kf.Free(position=(0, 0, 0.06), orientation=kf.rotation_about("y", tilt))
    body = scene.add_rigid_body("cylinder", MASS, (5e-4, 2e-3, 2e-3), joint=free)
    skin = scene.add_surface("skin", body, shapes.Cylinder(0.05, 0.2, "x"))
    scene.add_contact("c", skin, table, normal=normal, friction=friction)
    return scene


def test_a_cylinder_rocks_on_a_box_without_losing_energy():
    """Its ends hit the table in turn: steps are not cut at places that jump, and the energy is accounted for."""
    scene = cylinder_on_a_box(kf.HuntCrossley(1e6, damping=0.5))
    result = scene.simulate((0.0, 0.15), rtol=1e-7)
    assert result.status.kind == "finished"
    assert len(result.events["c touch"]) > 5
    # m g h is 0.1 J
    assert abs(result.energy.balance_error).max() < 1e-6
    assert result.statistics["steps"] < 2000


def test_a_cylinder_lies_on_a_box():
    """Both ends of its side carry half."""
    scene = cylinder_on_a_box(kf.HuntCrossley(1e6, damping=0.5), kf.Coulomb(0.3), tilt=0.0)
    rest = kf.equilibrium(scene)
    assert rest.load("c")[3] == pytest.approx(MASS * G, rel=1e-6)
    assert rest.load("c")[5] == pytest.approx(MASS * G / 1e6, rel=1e-3)


def test_impacts_with_a_restitution_end():
    result = cylinder_on_a_box(kf.Restitution(1e6, 0.5), kf.Coulomb(0.3)).simulate((0.0, 0.1))
    assert result.status.kind == "finished"
    assert np.all(np.isfinite(result.position("cylinder")))


def test_energy_of_a_face_that_changes_is_told_to_be_of_the_contact():
    """A can that tumbles loses some per cent at any tolerance: a smaller one is no remedy."""
    scene = kf.System(gravity=(0, 0, -G))
    table = scene.add_surface("table", scene.ground, shapes.Box((2.0, 2.0, 0.1)))
    start = kf.Free(position=(0, 0, 0.3), orientation=(0.97, 0.2, 0.1, 0.05), velocity=(0.5, 0, 0))
    can = scene.add_rigid_body("can", 0.4, (5e-4, 5e-4, 2e-4), joint=start)
    skin = scene.add_surface("skin", can, shapes.Cylinder(0.03, 0.12, "z"))
    scene.add_contact("c", skin, table, normal=kf.HuntCrossley(1e5, damping=0.3), friction=kf.Coulomb(0.4))
    with pytest.warns(kf.SimulationWarning, match="contact 'c', where the face that both shapes share changes"):
        scene.simulate((0.0, 1.0))


def test_places_that_carry_nothing_turn_back():
    """The twist of an anchor without a share of the contact comes back by stiffness over damping, as stretches do."""
    friction = kf.Coulomb(0.3, stiffness=1e4, damping=20.0, torsional=0.02)
    (contact,) = cylinder_on_a_box(kf.HuntCrossley(1e6), friction).freeze().loads
    still = np.eye(3), np.zeros(3), np.zeros(3)
    states = 1e-3 * np.arange(1.0, 1.0 + len(contact.initial_states))
    for height in (1.0, -0.01):  # far above, and in the table, where few places carry
        action = contact.action(0.0, [End(np.array((0, 0, z)), *still) for z in (0.0, height)], states)
        shares = [
            touch.share for touch in contact.touches([End(np.array((0, 0, z)), *still) for z in (0.0, height)], states)
        ]
        idle = [i for i, share in enumerate(shares) if share == 0.0]
        assert idle
        for i in idle:
            at = contact.turning(i)
            np.testing.assert_allclose(
                action.rates[at], -1e4 / 20.0 * states[at], rtol=1e-14
            )  # a quotient and a product
    assert np.isfinite(action.rates).all()
