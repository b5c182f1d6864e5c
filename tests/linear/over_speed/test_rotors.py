"""Rotors beyond the cases of `kanefe verify`: standing whirls, negative speeds, overdamped modes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import kanefe as kf
from kanefe.checks.verification.rotors import (
    BENDING,
    DISC,
    EXTERNAL,
    INTERNAL,
    REACH,
    STIFFNESS,
    jeffcott_seen_from_the_shaft,
    overhung,
)
from kanefe.linear.small_motions import SmallMotions


def forward_whirl(speed: float) -> complex:
    """Return the eigenvalue of the forward whirl of the Jeffcott rotor, seen from the shaft, 1/s.

    With r = y + i z seen from the ground, m r'' + (c_i + c_e) r' + (k - i W c_i) r = 0, see R01 of `kanefe verify`.
    """
    roots = np.roots((DISC, INTERNAL + EXTERNAL, STIFFNESS - 1j * speed * INTERNAL))
    return complex(roots[roots.imag.argmax()]) - 1j * speed


def test_a_damped_whirl_stands_still_in_the_frame_that_spins():
    """Its sign is that of the closed form also right beside the speed, from wherever it is followed."""
    at = brentq(lambda speed: forward_whirl(speed).imag, 100.0, 300.0, xtol=1e-12)
    speeds = at + np.array((-150.0, -1e-3, 0.0, 1e-3, 2e-3, 150.0, 400.0))
    diagram = kf.campbell(jeffcott_seen_from_the_shaft, speeds)
    expected = np.array([forward_whirl(speed) for speed in speeds])
    # to 1e-9 of the largest eigenvalue: twofold ones are known to half their digits, of which 7 remain here
    np.testing.assert_allclose(diagram.eigenvalues[:, 0], expected, atol=1e-6)
    (standing,) = diagram.critical_speeds(order=0)
    assert standing.speed == pytest.approx(at, rel=1e-9)
    assert standing.sense == ""


@pytest.mark.parametrize(("build", "order"), [(overhung, 1.0), (jeffcott_seen_from_the_shaft, 0.0)])
def test_a_rotor_that_turns_the_other_way_is_critical_at_the_same_speeds(build, order):
    speeds = np.linspace(30.0, 1500.0, 7)

    def told(speeds):
        return [(one.speed, one.sense) for one in kf.campbell(build, speeds).critical_speeds(order)]

    forward = told(speeds)
    backward = [(-speed, sense) for speed, sense in forward][::-1]
    assert len(forward) > 0
    for grid, expected in ((-speeds[::-1], backward), (np.append(-speeds[::-1], speeds), backward + forward)):
        found = told(grid)
        assert [speed for speed, _ in found] == pytest.approx([speed for speed, _ in expected], rel=1e-9)
        assert [sense for _, sense in found] == [sense for _, sense in expected]


def test_an_overdamped_mode_is_none_and_a_damped_one_is_found_where_it_is():
    """On a grid of any width: 5000 N/m and 99 N s/m at 1 kg cross at sqrt(5000 - 49.5^2) rad/s."""

    def build(speed):
        scene = kf.System()
        scene.add_rigid_body("rotor", 1.0, 0.1, joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
        for name, damping in (("mass", 99.0), ("slow", 1e4)):
            spring = kf.CoordinateForce(stiffness=5000.0, damping=damping)
            scene.add_point(name, 1.0, joint=kf.Prismatic("y", forces=spring))
        return scene

    for count in (2, 21):
        diagram = kf.campbell(build, np.linspace(0.0, 400.0, count))
        assert diagram.eigenvalues.shape == (count, 1)
        (damped,) = diagram.critical_speeds(order=1)
        assert damped.speed == pytest.approx(np.sqrt(5000.0 - 49.5**2), rel=1e-9)
        assert damped.damping_ratio == pytest.approx(49.5 / np.sqrt(5000.0), rel=1e-9)
        undamped = {round(one.speed, 6) for one in diagram.critical_speeds(order=1, damped=False)}
        assert undamped == {round(np.sqrt(5000.0), 6)}


def test_arms_of_a_governor_fly_out_though_they_balance_along_its_shaft():
    """They diverge there beyond sqrt(g / l), and go to cos(angle) = g / (l W^2): of a start beside the shaft."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    shaft = scene.add_frame("shaft", joint=kf.Revolute("z", motion=kf.Motion.steady(6.0)))
    hinge = kf.Revolute("y", position=0.01)
    scene.add_rigid_body("arm", 1.0, 0.0, com=(0.0, 0.0, -0.5), parent=shaft, joint=hinge)
    angle = kf.equilibrium(scene).joint_coordinates("arm")[0]
    assert angle == pytest.approx(np.arccos(9.81 / (0.5 * 36.0)), rel=1e-9)


@pytest.mark.parametrize("damping", [100.0, 300.0, 1000.0])
def test_whirls_that_split_from_one_frequency_keep_their_sign(damping):
    """At rest both senses mix, with shapes that are neither round nor across each other; none of them stands still."""

    def build(speed):
        scene = overhung(speed)
        C = np.diag((0.0, 1.0, 1.0, 0.0, 0.01, 0.01))
        scene.add_bushing("damper", scene.ground, scene.body("end"), damping=damping * C)
        return scene

    diagram = kf.campbell(build, np.linspace(0.0, 400.0, 21))
    assert diagram.eigenvalues.imag.min() > 0.0
    assert diagram.correlations.min() > 0.7


def test_modes_are_followed_through_rest_where_they_are_twofold():
    """Roots of the quartic of R02 never meet: in their order they are the curves, over speeds of both signs."""
    a, b, c = BENDING * np.array((12.0 / REACH**3, -6.0 / REACH**2, 4.0 / REACH))
    m, J, P = 10.0, 0.1, 0.2
    speeds = np.linspace(-300.0, 300.0, 5)
    quartics = [(m * J, -m * P * speed, -(m * c + a * J), a * P * speed, a * c - b**2) for speed in speeds]
    curves = np.abs(np.sort([np.roots(quartic).real for quartic in quartics], axis=1))
    diagram = kf.campbell(overhung, speeds, modes=4)
    for column in np.abs(diagram.eigenvalues[:, :4].imag).T:
        errors = np.abs(curves / column[:, None] - 1.0).max(axis=0)
        assert errors.min() < 1e-9


def test_modes_that_come_later_are_not_drawn_before():
    """Beyond rest a whirl falls below the fast one that is followed from the first speed on."""
    diagram = kf.campbell(overhung, np.linspace(-600.0, 600.0, 5), modes=3)
    late = diagram.numbers < 0
    assert late.any()
    assert np.array_equal(np.isnan(diagram.frequencies), late)
    assert np.array_equal(np.isnan(diagram.eigenvalues.imag), late)


def test_a_speed_at_which_the_start_is_in_balance_takes_one_set_of_small_motions(monkeypatch):
    """What the search for a balance looks at is what is linearised; the fastest speed is also looked at later on."""
    made = []
    begin = SmallMotions.__init__
    monkeypatch.setattr(SmallMotions, "__init__", lambda self, *given: (made.append(1), begin(self, *given))[1])
    counts = []
    for count in (10, 30):
        made.clear()
        kf.campbell(jeffcott_seen_from_the_shaft, np.linspace(10.0, 600.0, count))
        counts.append(len(made))
    assert counts[1] - counts[0] == 20
