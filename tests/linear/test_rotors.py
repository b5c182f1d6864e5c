"""Rotors against closed forms: critical speeds, whirl, limits of stability, and bearings over the speed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import kanefe as kf
from two_discs import PUBLISHED, rotor_of_two_discs, seen_from_the_ground

MASS, STIFFNESS, INTERNAL, EXTERNAL = 5.0, 2e5, 40.0, 25.0
RATE = np.sqrt(STIFFNESS / MASS)


def jeffcott_seen_from_the_shaft(speed: float) -> kf.System:
    """Return a disc on a shaft without mass, whose damping turns with it; that of the bearings stays."""
    scene = kf.System()
    shaft = scene.add_frame("shaft", joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
    spring = kf.CoordinateForce(STIFFNESS, damping=INTERNAL)
    slide = scene.add_frame("slide", parent=shaft, joint=kf.Prismatic("y", forces=spring))
    disc = scene.add_rigid_body("disc", MASS, 0.01, parent=slide, joint=kf.Prismatic("z", forces=spring))
    scene.add(kf.Bearing("film", (scene.ground, disc), np.zeros((2, 2)), EXTERNAL * np.eye(2)))
    return scene


def jeffcott_seen_from_the_ground(speed: float) -> kf.System:
    """Return the same: what damps in the shaft circulates in proportion to its speed."""
    scene = kf.System()
    slide = scene.add_frame("slide", joint=kf.Prismatic("y"))
    disc = scene.add_point("disc", MASS, parent=slide, joint=kf.Prismatic("z"))
    spin = kf.Revolute("x", motion=kf.Motion.steady(speed))
    shaft = scene.add_rigid_body("shaft", 1.0, 0.01, joint=spin)
    cross, at = INTERNAL * np.array(((0.0, 1.0), (-1.0, 0.0))), (0.0, 150.0, 600.0)
    scene.add(
        kf.Bearing(
            "shaft and film",
            (scene.ground, disc, shaft),
            [STIFFNESS * np.eye(2) + s * cross for s in at],
            3 * [(INTERNAL + EXTERNAL) * np.eye(2)],
            speeds=at,
        )
    )
    return scene


@pytest.mark.parametrize("build", [jeffcott_seen_from_the_shaft, jeffcott_seen_from_the_ground])
def test_internal_damping_drives_the_forward_whirl_beyond_a_limit(build):
    """Genta, Dynamics of Rotating Systems (2005), section 4.3: w (1 + c_external / c_internal)."""
    diagram = kf.campbell(build, np.linspace(0.0, 600.0, 7))
    (onset,) = diagram.stability_limits()
    assert onset.speed == pytest.approx(RATE * (1.0 + EXTERNAL / INTERNAL), rel=1e-9)
    assert onset.begins


def forward_whirl(speed: float) -> complex:
    """Return the eigenvalue of the forward whirl of the Jeffcott rotor, seen from the shaft, 1/s.

    With r = y + i z seen from the ground, m r'' + (c_i + c_e) r' + (k - i W c_i) r = 0 (Genta, section 4.3).
    """
    roots = np.roots((MASS, INTERNAL + EXTERNAL, STIFFNESS - 1j * speed * INTERNAL))
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


def overhung(speed: float) -> kf.System:
    """Return a disc at the end of a cantilever without mass, by its stiffness at the end."""
    scene = kf.System()
    end = scene.add_frame("end", joint=kf.Free())
    spin = kf.Revolute("x", motion=kf.Motion.steady(speed))
    scene.add_rigid_body("disc", 10.0, (0.2, 0.1, 0.1), parent=end, joint=spin)
    scene.add_bushing("shaft", scene.ground, end, stiffness=cantilever())
    return scene


LENGTH, BENDING = 0.5, 8e3


def cantilever() -> np.ndarray:
    """Return the stiffness of the end of a cantilever along x: 1e9 N/m along it, 1e7 N m/rad about it, and bending."""
    a, b, c = BENDING * np.array((12.0 / LENGTH**3, 6.0 / LENGTH**2, 4.0 / LENGTH))
    K = np.diag((1e9, a, a, 1e7, c, c))
    K[1, 5] = K[5, 1] = -b
    K[2, 4] = K[4, 2] = b
    return K


def test_an_overhung_disc_splits_by_its_gyroscopic_moment():
    """With r = y + i z and the tilt of it, [[a - m w^2, b], [b, c - J w^2 + P W w]] is singular."""
    a, b, c = BENDING * np.array((12.0 / LENGTH**3, -6.0 / LENGTH**2, 4.0 / LENGTH))
    m, J, P = 10.0, 0.1, 0.2

    def whirls(speed):
        # (a - m w^2) (c - J w^2 + P W w) - b^2
        return np.sort(np.roots((m * J, -m * P * speed, -(m * c + a * J), a * P * speed, a * c - b**2)).real)

    def criticals(sense):
        # w = sense * W
        squares = np.roots((m * (J - sense * P), -(m * c + a * (J - sense * P)), a * c - b**2)).real
        return [(np.sqrt(square), "forward" if sense > 0 else "backward") for square in squares if square > 0.0]

    diagram = kf.campbell(overhung, np.linspace(0.0, 1500.0, 6))
    lateral = diagram.eigenvalues[:, :4].imag
    for speed, row in zip(diagram.speeds, lateral, strict=True):
        np.testing.assert_allclose(np.sort(np.abs(row)), np.sort(np.abs(whirls(speed))), rtol=1e-9)
    expected = sorted(criticals(1) + criticals(-1))
    for damped in (True, False):
        found = diagram.critical_speeds(order=1, damped=damped)
        assert [one.speed for one in found] == pytest.approx([speed for speed, _ in expected], rel=1e-9)
        assert [one.sense for one in found] == [sense for _, sense in expected]
        assert [abs(one.whirl) for one in found] == pytest.approx([1.0] * len(found), abs=1e-6)


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


def test_an_unbalance_whirls_backward_between_the_critical_speeds_of_an_anisotropic_bearing():
    """Of y and z one is above and one below its resonance there: f / (k - m W^2 + i c W) has two signs."""
    scene = kf.System()
    disc = scene.add_rigid_body("disc", MASS, 0.01, joint=kf.Free())
    K = np.diag((STIFFNESS, 1.5 * STIFFNESS))
    scene.add(kf.Bearing("film", (scene.ground, disc), K, EXTERNAL * np.eye(2)))
    small = kf.linearise(scene, inputs=("force disc y", "force disc z"), outputs=("position disc y", "position disc z"))
    first, second = RATE, RATE * np.sqrt(1.5)
    speeds = np.array((0.5 * first, 0.5 * (first + second), 1.5 * second))
    y, z = (small.frequency_response(speeds / (2.0 * np.pi)).response @ np.array((1.0, -1j))).T
    np.testing.assert_allclose(y, 1.0 / (K[0, 0] - MASS * speeds**2 + 1j * speeds * EXTERNAL), rtol=1e-10)
    assert np.sign((y * z.conj()).imag).tolist() == [1.0, -1.0, 1.0]  # forward, backward, forward


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


def test_two_discs_on_a_flexible_shaft_whirl_as_published():
    """To 1e-4: published ones are of as many beams, of another shear coefficient and rotary inertia."""
    speed = 4000.0 * np.pi / 30.0
    seen = seen_from_the_ground(kf.equilibrium(rotor_of_two_discs(speed)).linearise(outputs=()).modes(), speed)
    for value in PUBLISHED:
        assert seen[np.abs(seen - value).argmin()] == pytest.approx(value, rel=1e-4)
