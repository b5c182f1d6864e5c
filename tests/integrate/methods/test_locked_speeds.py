"""Errors of joint speeds are measured without vibrations: by closed laws, by counts; and where that is left out."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy

import kanefe as kf
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.locked_speeds import has_locked_speeds, locked_speeds
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.scales import modal_frequencies
from kanefe.tree.tangents import constant_tangents
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
REACH = 2.4
"""What the tip of the arm sweeps, m."""


def arm(damping: float = 0.0) -> kf.System:
    """Return two beams on hinges, with a weight, that swing by more than a radian."""
    shape = straight_beam(0.6, Rectangle(0.03, 0.01), ALUMINIUM, elements=6)
    damped = kf.ModalDamping(damping) if damping else None
    link = beam_body(shape, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=4), damping=damped)
    scene = kf.System(gravity=(0, 0, -9.81))
    upper = scene.add_flexible_body("upper", link, joint=kf.Revolute("y", position=0.3))
    lower = scene.add_flexible_body("lower", link, parent=upper.interface("tip"), joint=kf.Revolute("y", position=0.5))
    scene.add_rigid_body("weight", 0.3, 1e-3, parent=lower.interface("tip"))
    return scene


def with_more(add: Callable[[kf.System, Any], None]) -> kf.System:
    """Return the arm with a body beside it, and what is added to that."""
    scene = arm()
    add(scene, scene.add_rigid_body("more", 1.0, 0.1, joint=kf.Revolute("z")))
    return scene


def test_a_vibration_leaves_nothing_and_a_turn_of_a_joint_itself() -> None:
    dynamics = Dynamics(arm().freeze())
    model, y = dynamics.model, dynamics.initial_state(0.0)[:-QUADRATURES]
    m, joints = model.free_count, modal_frequencies(model) == 0.0
    found = locked_speeds(dynamics, 0.0, y, True)
    assert found is not None
    assert found.every == 0.0
    np.testing.assert_array_equal(found.joint_of_speed > 0.0, joints)
    rows = found.rows[found.joint_of_speed[joints].astype(int) - 1]
    assert not rows[:, joints].any()
    M, (K, _) = dynamics.route.mass_matrix(0.0, y)[:m, :m], constant_tangents(model)
    squares, shapes = scipy.linalg.eigh(K, M)
    shakes = shapes[:, squares > 1.0]
    assert shakes.shape[1] == m - joints.sum()
    left = shakes[joints] + rows @ shakes
    assert np.abs(left).max() < 1e-11 * np.abs(shakes[joints]).max()


@pytest.mark.parametrize(("method", "damping", "share"), [("radau5", 0.0, 0.5), ("extrapolation", 0.01, 0.8)])
def test_the_tolerance_is_kept_by_fewer_evaluations(
    method: str, damping: float, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    exact = arm(damping).simulate((0.0, 0.5), method="radau5", rtol=1e-10, output_step=0.01)
    counts = {}
    for name, measure in (("locked", locked_speeds), ("plain", lambda *_: None)):
        monkeypatch.setattr("kanefe.integrate.methods.kernel_memory.locked_speeds", measure)
        run = arm(damping).simulate((0.0, 0.5), method=method, rtol=1e-7, output_step=0.01)
        assert np.abs(run.position("weight") - exact.position("weight")).max() < 10.0 * 1e-7 * REACH
        counts[name] = run.statistics["evaluations"]
    assert counts["locked"] < share * counts["plain"]


def test_what_samples_see_counts_for_the_time_they_hold_it() -> None:
    def hold(t: float, reads: np.ndarray, memory: dict[str, object]) -> float:
        return -20.0 * (reads[0] - 0.3) - 0.1 * reads[1]

    def held(every: float) -> kf.System:
        scene = arm(0.01)
        reads = "joint_coordinates upper", "joint_speeds upper"
        scene.add_controller("hold", hold, every=every, reads=reads, drives="motor upper")
        return scene

    dynamics = Dynamics(held(1e-3).freeze())
    assert locked_speeds(dynamics, 0.0, dynamics.initial_state(0.0)[:-QUADRATURES], True).every == 1e-3
    exact, run = (
        held(1e-3).simulate((0.0, 0.1), method=method, rtol=rtol, output_step=0.01).position("weight")
        for method, rtol in (("dop853", 1e-10), ("radau5", 1e-6))
    )
    assert np.abs(run - exact).max() < 10.0 * 1e-6 * REACH


def nothing(scene: kf.System, body: Any) -> None:
    pass


def stops(scene: kf.System, body: Any) -> None:
    force = kf.CoordinateForce(limits=(-1.0, 1.0), limit_stiffness=1e5)
    scene.add_rigid_body("door", 1.0, 0.1, joint=kf.Revolute("z", forces=force))


def law(scene: kf.System, body: Any) -> None:
    scene.add_torque(body, lambda t, state: -1e-3 * state.joint_speeds("more")[0])


def closes(scene: kf.System, body: Any) -> None:
    scene.add_loop_joint("pin", kf.Spherical(), scene.ground, body)


def rests(scene: kf.System, body: Any) -> None:
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane(normal=(0, 0, 1)))
    ball = scene.add_surface("ball", body, kf.shapes.Sphere(0.05))
    scene.add_contact("touch", ball, floor, normal=kf.KelvinVoigt(1e4))


@pytest.mark.parametrize(
    ("add", "is_locked"), [(nothing, True), (stops, False), (law, False), (closes, False), (rests, False)]
)
def test_what_may_turn_on_a_small_speed_keeps_it(add: Callable[[kf.System, Any], None], is_locked: bool) -> None:
    assert has_locked_speeds(with_more(add).freeze()) == is_locked


@pytest.mark.parametrize(("damping", "is_locked"), [(0.0, False), (0.01, True)])
def test_a_method_that_lets_vibrations_grow_sees_those_that_nothing_damps(damping: float, is_locked: bool) -> None:
    assert has_locked_speeds(arm(damping).freeze(), is_damping=False) == is_locked
