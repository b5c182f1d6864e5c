"""Normal forces by tables: monotone, smooth, with the energy of their force."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.storage.digest import digest

DEPTHS, FORCES = (1e-3, 2e-3, 2.5e-3, 4e-3), (10.0, 12.0, 80.0, 300.0)


def test_a_table_is_monotone_and_smooth_and_straight_beyond_its_end():
    law = kf.TableLaw(DEPTHS, FORCES)
    at = np.linspace(1e-9, 6e-3, 6001)
    force = np.array([law.pressed(d, 0.0, 1.0, 0.0).force for d in at])
    slope = np.array([law.slope(d, 1.0) for d in at])
    energy = np.array([law.pressed(d, 0.0, 1.0, 0.0).potential for d in at])
    np.testing.assert_allclose([law.pressed(d, 0.0, 1.0, 0.0).force for d in DEPTHS], FORCES, rtol=1e-12)
    assert np.all(np.diff(force) >= 0.0)
    middle = 0.5 * (at[1:] + at[:-1])
    h = at[1] - at[0]
    np.testing.assert_allclose(np.diff(force) / h, [law.slope(d, 1.0) for d in middle], atol=2e-4 * slope.max())
    np.testing.assert_allclose(np.diff(energy) / h, 0.5 * (force[1:] + force[:-1]), atol=2e-6 * force.max())
    assert slope[-1] == pytest.approx(slope[np.searchsorted(at, 4e-3)], rel=1e-12)
    assert np.abs(np.diff(slope)).max() < 0.02 * slope.max()  # it does not jump


def test_tables_with_the_same_end_are_two_laws():
    """A checkpoint of one is no checkpoint of the other."""
    soft, hard, again = (kf.TableLaw((1e-3, 2e-3), (force, 40.0)) for force in (10.0, 20.0, 10.0))
    assert soft == again != hard
    assert digest(law=soft) == digest(law=again) != digest(law=hard)


def test_a_straight_table_is_a_spring():
    """And its damping is that of Hunt and Crossley's law, to the last digits of a run."""
    found = []
    for law in (kf.TableLaw((1.0, 2.0), (1e4, 2e4), damping=0.2), kf.HuntCrossley(1e4, 0.2)):
        scene = kf.System()
        wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("z"))
        mass = scene.add_point("mass", 1.0, joint=kf.Prismatic("z", position=1e-3, speed=-1.0))
        scene.add_contact("impact", mass, wall, normal=law)
        found.append(scene.simulate((0.0, 0.1), rtol=1e-9).velocity("mass")[-1, 2])
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert found[1] < 1.0


def test_a_ball_bounces_from_a_pad_and_comes_to_rest_in_it():
    """What is kept of energy is that of the table; at rest the pad holds the weight."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_point("ball", 2.0, joint=kf.Prismatic("z", position=0.02))
    law = kf.TableLaw(DEPTHS, FORCES, damping=1.0)
    scene.add_contact("c", ball, floor, normal=law)
    result = scene.simulate((0.0, 3.0), rtol=1e-9)
    assert abs(result.energy.balance_error).max() < 1e-7
    depth = -float(result.position("ball")[-1, 2])
    assert law.pressed(depth, 0.0, 1.0, 0.0).force == pytest.approx(2.0 * 9.81, rel=1e-3)
    held = kf.equilibrium(scene)
    assert held.load("c")[3] == pytest.approx(2.0 * 9.81, rel=1e-9)
