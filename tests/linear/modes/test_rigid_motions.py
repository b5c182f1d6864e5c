"""Rigid motions are those that nothing resists: found by rank, however slow others are beside fast ones."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from good_scenes import beam
from kanefe_fem import Material, SolidCircle, beam_body
from kanefe_fem.beams.body import beam_model
from linear_scenes import GRAVITY


def rotor(density: float, damping: float) -> kf.System:
    """A disc on a shaft of given density (kg/m3) in bearings that are springs and dampers (N s/m)."""
    places = np.linspace(0.0, 0.6, 9)
    model = beam_model(
        np.column_stack((places, 0 * places, 0 * places)),
        [(i, i + 1) for i in range(8)],
        SolidCircle(0.01),
        Material(E=210e9, nu=0.3, rho=density),
        groups={"left": 0, "disc": 4, "right": 8},
    )
    ties = {"left": "rigid", "right": "rigid", "disc": "rigid"}
    shaft = beam_body(model, ties, kf.CraigBampton(modes=2), kf.ModalDamping(0.01) if damping else None)
    scene = kf.System()
    body = scene.add_flexible_body("shaft", shaft, joint=kf.Free())
    scene.add_rigid_body("disc", 5.0, (0.02, 0.01, 0.01), parent=body.interface("disc"))
    for side, x in (("left", 0.0), ("right", 0.6)):
        k = (2e6, 2e6, 2e6, 50, 0, 0)
        c = (damping, damping, damping, damping / 800, 0, 0)
        scene.add_bushing(side, scene.ground.frame(at=(x, 0, 0)), body.interface(side), stiffness=k, damping=c)
    return scene


@pytest.mark.parametrize("damping", [0.0, 800.0])
def test_a_shaft_nearly_without_mass_has_the_modes_of_a_light_one(damping: float) -> None:
    found = {}
    for density in (100.0, 1.0):
        modes = kf.linearise(rotor(density, damping)).modes()
        assert not modes.is_rigid.any()
        found[density] = modes.natural_frequencies[modes.frequencies > 0.0][:5]
    # in proportion to the mass of the shaft, of which 100 kg/m3 is a thousandth of the disc's
    np.testing.assert_allclose(found[1.0], found[100.0], rtol=2e-3)


def test_no_critical_speed_comes_of_what_was_taken_for_rigid() -> None:
    def turning(speed: float) -> kf.System:
        scene = rotor(1.0, 800.0)
        scene.add_frame("turning", joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
        return scene

    diagram = kf.campbell(turning, np.array((0.0, 20.0)), modes=3, balance=False)
    assert diagram.critical_speeds() == []
    assert not any(modes.is_rigid.any() for modes in diagram.modes)


def test_a_motion_under_gravity_alone_is_resisted_and_one_across_it_is_not() -> None:
    for axis, rigid in (("z", True), ("y", False)):
        scene = kf.System(gravity=GRAVITY)
        stiff = kf.CoordinateForce(stiffness=1e12)
        scene.add_rigid_body("fast", 1e-3, joint=kf.Prismatic("x", forces=stiff))
        scene.add_rigid_body("slow", 1.0, 1e3, com=(0.0, 0.0, -1e-3), joint=kf.Revolute(axis))
        modes = kf.linearise(scene).modes()
        assert modes.is_rigid.tolist() == [rigid, False]
        # 1e-3 m over 1000 kg m2: six minutes beside 3e7 rad/s
        slow = 0.0 if rigid else np.sqrt(9.81e-3 / (1e3 + 1e-6)) / 2 / np.pi
        assert modes.frequencies[0] == pytest.approx(slow, rel=1e-6)


def test_free_damped_and_spinning_motions_that_nothing_resists_are_counted_once() -> None:
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("stone", 1.0, (1, 2, 2.5), com=(0.1, 0.2, 0), joint=kf.Free())
    scene.add_rigid_body("braked", 1.0, 2.0, joint=kf.Revolute("z", forces=kf.CoordinateForce(damping=1.0)))
    scene.add_rigid_body("wheel", 1.0, 2.0, joint=kf.Revolute("x", speed=5.0))
    modes = kf.linearise(scene, start=None).modes()
    assert int(modes.is_rigid.sum()) == 8
    assert modes.eigenvalues[~modes.is_rigid] == pytest.approx([-0.5])


def test_a_slow_growth_beside_fast_modes_is_seen() -> None:
    scene = kf.System()
    scene.add_rigid_body("fast", 1e-6, joint=kf.Prismatic("x", forces=kf.CoordinateForce(1e12, damping=1e3)))
    scene.add_rigid_body("slow", 1.0, joint=kf.Prismatic("x", forces=kf.CoordinateForce(1.0)))
    cart = scene.add_rigid_body("grows", 1.0, joint=kf.Prismatic("x", forces=kf.CoordinateForce(1.0)))
    scene.add_force(cart, lambda t, state: (0.2 * state.joint_speeds("grows")[0], 0.0, 0.0))
    modes = kf.linearise(scene).modes()
    assert not modes.is_stable
    assert modes.eigenvalues[modes.grows].real == pytest.approx(0.1, rel=1e-6)


# level it is not in equilibrium, and its few modes miss its deformation
@pytest.mark.filterwarnings("ignore::kanefe.linear.unsettled.UnsettledWarning", "ignore::kanefe.errors.AccuracyWarning")
def test_a_soft_motion_is_not_lost_beside_a_free_body() -> None:
    def found(*, beside: bool) -> kf.Modes:
        made = kf.System(gravity=(0.0, -9.81, 0.0))
        made.add_flexible_body("beam", beam(), joint=kf.Revolute("z"))
        if beside:
            made.add_rigid_body("slide", 1.0, 0.1, joint=kf.Prismatic("x"))
        return kf.linearise(made).modes()

    alone, both = found(beside=False), found(beside=True)
    # level, only its axial stretch by its weight resists: 5e-7 of the highest frequency, whose square is 3e-13
    assert list(both.is_rigid) == [True] + [False] * 9
    assert both.frequencies[1:] == pytest.approx(alone.frequencies, rel=1e-3)
