"""Great numbers in linear analyses end in an error of kanefe: not in one of LAPACK, and not in a search without end."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from good_results import path
from good_scenes import hanging, scene
from kanefe.linear.equilibrium.stiffness import rank_of
from kanefe.linear.modes.eigenpairs import eigenpairs


@pytest.mark.filterwarnings("ignore::kanefe.linear.unsettled.UnsettledWarning", "ignore::kanefe.errors.AccuracyWarning")
def test_a_search_of_unresisted_motions_ends() -> None:
    made = scene()
    made.add_torque(made.body("one"), lambda t: (0.0, 0.0, 1e200))
    found, plain = (kf.linearise(one).modes() for one in (made, scene()))
    assert not found.is_rigid.all()
    resisted = ~found.is_rigid
    assert found.frequencies[resisted] == pytest.approx(plain.frequencies[resisted], rel=1e-9)


@pytest.mark.parametrize("torque", [1e30, 1e60, 1e140])
def test_what_a_spring_resists_is_not_lost_beside_a_great_torque(torque: float) -> None:
    made = hanging()
    made.add_torque(made.body("rod"), (0.0, 0.0, torque))
    spring = kf.CoordinateForce(stiffness=100.0)
    made.add_rigid_body("ball", 2.0, 0.1, joint=kf.Prismatic("x", forces=spring))
    found = kf.linearise(made).modes()
    assert list(found.is_rigid) == [True, False]
    assert found.frequencies[1] == pytest.approx(np.sqrt(50.0) / (2.0 * np.pi), rel=1e-12)


def test_a_scene_without_resisted_motions_has_modes() -> None:
    made = hanging()
    made.add_torque(made.body("rod"), (0.0, 0.0, 1e140))
    assert kf.linearise(made).modes().is_rigid.all()  # its weight is lost in the round-off of the torque


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_matrices_that_overflow_are_refused(value: float) -> None:
    with pytest.raises(kf.SimulationError, match="the state matrix overflows"):
        eigenpairs(np.array([[0.0, 1.0], [value, 0.0]]), np.ones(2))
    with pytest.raises(kf.SimulationError, match="the stiffness overflows"):
        rank_of(np.diag([1.0, value]))


def test_a_path_is_asked_for_a_factor_just_before_its_begin() -> None:
    assert np.allclose(path().at(-1e-150).q, path().at(0.0).q, rtol=0.0, atol=1e-12)  # the stop itself


def test_a_scene_that_rolls_has_no_rest_by_raising_its_loads() -> None:
    made = kf.System(gravity=(0.0, -9.81, 0.0))
    ball = made.add_rigid_body("ball", 1.0, 1.0, joint=kf.Free((0.0, 0.0, 0.1)))
    made.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z"))
    made.add_rolling_ball("rolls", ball, 0.1)
    with pytest.raises(kf.SimulationError, match="no equilibrium"):
        kf.equilibrium(made)
