"""Doors and gates with more hinges on an axis than it needs: they change no motion, and no equilibrium."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.literal.route import LiteralRoute
from kanefe.tree.model_data import QUADRATURES

HINGES = (lambda _: kf.Spherical(), lambda axis: kf.Cylindrical(axis), lambda axis: kf.Revolute(axis))

SAME = 1e-9
"""Difference of angles (rad), and of eigenvalues over the largest: a redundant row leaves round-off of its own size."""


def gate(seed: int, is_hinged: bool) -> kf.System:
    """Return one or two leaves, the second on the ground or on the first, with one to three more hinges if asked."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0, 0, -9.81))
    carrier, base = scene.ground, rng.uniform(-10.0, 10.0, 3)
    for number in range(rng.integers(1, 3)):
        axis = np.array((*rng.uniform(-0.4, 0.4, 2), 1.0))
        axis /= np.linalg.norm(axis)
        springs = kf.CoordinateForce(stiffness=rng.uniform(60.0, 400.0), damping=5.0)
        joint = kf.Revolute(tuple(axis), position=rng.uniform(-0.3, 0.3), forces=springs)
        leaf = scene.add_rigid_body(
            f"leaf {number}",
            rng.uniform(5.0, 40.0),
            rng.uniform(0.5, 5.0),
            com=tuple(rng.uniform(-1.0, 1.0, 3)),
            joint=joint,
            parent=carrier,
            at=tuple(base),
        )
        for hinge in range(rng.integers(1, 4)):
            place, kind = rng.uniform(0.3, 3.0) * axis, HINGES[rng.integers(3)](tuple(axis))
            ends = carrier.frame(at=tuple(base + place)), leaf.frame(at=tuple(place))
            if is_hinged:
                scene.add_loop_joint(f"hinge {number}.{hinge}", kind, *ends)
        carrier, base = (scene.ground, leaf)[rng.integers(2)], rng.uniform(-2.0, 2.0, 3)
    return scene


def rest_of(seed: int, is_hinged: bool) -> kf.Equilibrium:
    """Return the equilibrium of such a gate."""
    return kf.equilibrium(gate(seed, is_hinged))


def assert_same_rest(seed: int) -> None:
    """Compare the angles of all leaves."""
    alone, hinged = (rest_of(seed, is_hinged).state for is_hinged in (False, True))
    np.testing.assert_allclose(hinged, alone, rtol=0, atol=SAME)


@pytest.mark.parametrize("seed", range(6))
def test_redundant_hinges_change_no_equilibrium(seed: int) -> None:
    assert_same_rest(seed)


@pytest.mark.slow
def test_of_two_hundred_gates_none_differs() -> None:
    for seed in range(200):
        assert_same_rest(seed)


def test_nor_any_small_motion() -> None:
    alone, hinged = (rest_of(3, is_hinged).linearise().modes().eigenvalues for is_hinged in (False, True))
    np.testing.assert_allclose(hinged, alone, rtol=0, atol=SAME * abs(alone).max())


def test_nor_a_motion_of_either_route() -> None:
    alone, hinged = (gate(4, is_hinged).freeze() for is_hinged in (False, True))
    want = alone.rhs(0.0, alone.initial_state)
    for route in (hinged.route, LiteralRoute(hinged)):
        found = route.evaluate(0.0, np.append(hinged.initial_state, np.zeros(QUADRATURES))).rates[:-QUADRATURES]
        np.testing.assert_allclose(found, want, rtol=0, atol=SAME * abs(want).max())


def test_a_hinge_that_is_slightly_off_the_axis_holds_the_door_as_in_a_run() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    axis = (0.05, 0.12, 1.0)
    springs = kf.CoordinateForce(stiffness=30.0, damping=5.0)
    door = scene.add_rigid_body("door", 20.0, 1.0, com=(0.4, 0, 0.9), joint=kf.Revolute(axis, forces=springs))
    beside = tuple(1.7 * np.array(axis) + (1e-6, 0.0, 0.0))
    scene.add_loop_joint("upper", kf.Spherical(), scene.ground.frame(at=beside), door.frame(at=beside))
    assert abs(kf.equilibrium(scene).joint_coordinates("door")[0]) < 1e-9
    with pytest.raises(ModelError, match="nothing in the scene can move"):
        kf.linearise(scene)
