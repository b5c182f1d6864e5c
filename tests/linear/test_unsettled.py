"""What is out of balance where a scene is linearised is told, and what is not is not."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.linear.unsettled import REPORTED, UnsettledWarning
from kanefe_fem import Material, Rectangle, beam_body, straight_beam
from linear_scenes import GRAVITY

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
ROD = beam_body(
    straight_beam(1.0, Rectangle(0.004, 0.03), ALUMINIUM, elements=4),
    {"root": "clamped", "tip": "rigid"},
    kf.CraigBampton(modes=2),
)


def pole() -> kf.System:
    """A flexible pole upright on a cart: straight at the start, and not yet pressed together."""
    scene = kf.System(gravity=GRAVITY)
    cart = scene.add_rigid_body("cart", 1.0, joint=kf.Prismatic("x"))
    hinge = scene.add_rigid_body("hinge", 0.05, 1e-5, parent=cart, joint=kf.Revolute("y"))
    scene.add_flexible_body("pole", ROD, parent=hinge, orientation=kf.rotation_about("y", -np.pi / 2))
    return scene


def test_a_pole_that_is_about_to_be_pressed_is_told() -> None:
    with pytest.warns(UnsettledWarning, match=r"along pole: eta \d+ remains.*equilibrium\(scene\)\.linearise\(\)"):
        start = kf.linearise(pole())
    assert start.imbalance.ratio > 0.1
    assert "out of balance" in str(start)
    assert "out of balance" in str(start.modes())
    balance = kf.equilibrium(pole()).linearise()
    assert balance.imbalance.ratio < 1e-9
    assert "out of balance" not in str(balance) + str(balance.modes())
    mass, carts = ROD.mass, 1.05 + ROD.mass
    # a rigid rod on a hinge on a cart; its own bending makes the pole slower by some 1e-4
    inertia = mass / 3.0 + 1e-5 - (0.5 * mass) ** 2 / carts
    closed = np.sqrt(0.5 * mass * 9.81 / inertia)
    assert balance.modes().eigenvalues.real.max() == pytest.approx(closed, rel=1e-3)
    assert start.modes().eigenvalues.real.max() < 0.95 * closed


def falling() -> kf.System:
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("stone", 2.0, (1, 2, 2.5), com=(0.1, 0.2, 0.0), joint=kf.Free(position=(0, 0, 3)))
    return scene


def falling_rod() -> kf.System:
    scene = kf.System(gravity=GRAVITY)
    scene.add_flexible_body("rod", ROD, joint=kf.Free())
    return scene


def pushed() -> kf.System:
    """A cart that is pushed along, with nothing on it: nothing resists it."""
    scene = kf.System()
    cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
    scene.add_force(cart, (3.0, 0.0, 0.0))
    return scene


def spinning() -> kf.System:
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("top", 1.0, (0.1, 0.1, 0.2), joint=kf.Spherical(angular_velocity=(0, 0, 30.0)))
    return scene


def driven() -> kf.System:
    scene = kf.System()
    hub = scene.add_frame("hub", joint=kf.Revolute("z", motion=kf.Motion.steady(20.0)))
    scene.add_rigid_body("disc", 1.0, 0.1, parent=hub, joint=kf.Revolute("x"))
    return scene


@pytest.mark.parametrize("build", [falling, falling_rod, pushed, spinning, driven], ids=lambda build: build.__name__)
def test_free_and_steady_motion_is_in_balance(build: Callable[[], kf.System]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", UnsettledWarning)
        # round-off of forces that cancel in full
        assert kf.linearise(build()).imbalance.ratio < 1e-9


@pytest.mark.parametrize("share", [0.3 * REPORTED, 3.0 * REPORTED])
def test_what_is_left_over_is_measured_by_what_acts(share: float) -> None:
    scene = kf.System(gravity=GRAVITY)
    spring = kf.CoordinateForce(stiffness=100.0)
    scene.add_rigid_body("ball", 2.0, joint=kf.Prismatic("z", position=-0.1962 * (1.0 + share), forces=spring))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = kf.linearise(scene)
    assert abs(found.imbalance.force) == pytest.approx(share * 19.62, rel=1e-6)
    # the weight and the spring, each by its size
    assert found.imbalance.ratio == pytest.approx(share / (2.0 + share), rel=1e-6)
    assert [issubclass(one.category, UnsettledWarning) for one in told] == [True] * (share / 2.0 > REPORTED)


def test_a_campbell_diagram_about_starts_is_told_once() -> None:
    def build(speed: float) -> kf.System:
        scene = kf.System()
        shaft = scene.add_frame("shaft", joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        spring = kf.CoordinateForce(stiffness=1e4)
        scene.add_point("point", 1.0, parent=shaft, joint=kf.Prismatic("x", position=0.1, forces=spring))
        return scene

    with pytest.warns(UnsettledWarning, match=r"campbell at [12]0 rad/s.*Remedy: balance=True") as told:
        kf.campbell(build, [10.0, 20.0], modes=1, balance=False)
    assert [one.filename for one in told] == [__file__]


def test_a_campbell_diagram_is_looked_at_at_all_speeds() -> None:
    def build(speed: float) -> kf.System:
        scene = kf.System(gravity=GRAVITY)
        shaft = scene.add_frame("shaft", joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        spring = kf.CoordinateForce(stiffness=1e4, rest=9.81 / 1e4 if speed else 0.0)  # carried, but not at rest
        scene.add_point("point", 1.0, parent=shaft, joint=kf.Prismatic("z", forces=spring))
        return scene

    with pytest.warns(UnsettledWarning, match=r"campbell at 0 rad/s"):
        kf.campbell(build, [0.0, 20.0], modes=1, balance=False)


def test_a_shape_that_is_off_by_round_off_is_balanced() -> None:
    """Nothing acts on it: against no force would what is left over be small."""
    scene = kf.System()
    scene.add_flexible_body("rod", ROD)
    state = scene.freeze().initial_state
    assert kf.linearise(scene, start=state + 1e-17).imbalance.ratio < 1e-9
    with pytest.warns(UnsettledWarning, match="remains"):
        assert kf.linearise(scene, start=state + 1e-9).imbalance.ratio > REPORTED


def test_a_load_that_ends_later_is_no_motion_of_a_scene_at_rest():
    """What its end changes of small motions is 1e-6 of their rates: nothing moves that modes could depend on."""
    model = straight_beam(0.6, Rectangle(0.065, 0.012), ALUMINIUM, elements=6)
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=4), kf.ModalDamping(0.01))
    scene = kf.System(gravity=(0, 0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, 0.005, joint=kf.Revolute("z"))
    scene.add_flexible_body("arm", body, parent=hub, at=(0.05, 0, 0))
    scene.add_torque(hub, lambda t: 4.0 if t < 0.2 else 0.0)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="modes of a moving state")
        kf.linearise(scene.copy()).modes()
        kf.equilibrium(scene, t=0.5).linearise().modes()  # as the README of a new project says
