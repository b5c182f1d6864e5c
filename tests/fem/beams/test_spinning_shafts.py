"""Whirl of shafts of beams against closed forms: the cases' shaft of slices, and plain beams in the spinning frame."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification.rotors import spin_eigenvalues
from kanefe.equations.model import Model
from kanefe_fem import Material, SolidCircle, beam_body, straight_beam
from kanefe_fem.verification.rotors import DENSITY, DIAMETER, LENGTH, YOUNG, critical_speeds, flat_shaft, rayleigh_shaft
from kanefe_fem.verification.two_discs import rotor_of_two_discs

A = DENSITY * math.pi * DIAMETER**2 / 4
B = DENSITY * math.pi * DIAMETER**4 / 64 * (math.pi / LENGTH) ** 2
STIFFNESS = YOUNG * math.pi * DIAMETER**4 / 64 * (math.pi / LENGTH) ** 4
"""Of the first mode: translating mass, rotary inertia rho I k^2 and E I k^4, each over the length."""


def whirl(spin: float, stiffening: float) -> np.ndarray:
    """Return the moduli of the roots of ``(A + B) w^2 + 2 A W w + (A - stiffening B) W^2 - E I k^4``."""
    return np.sort(np.abs(np.roots([A + B, 2 * A * spin, (A - stiffening * B) * spin**2 - STIFFNESS])))


def plain_shaft(spin: float) -> Model:
    """Return the shaft of beams with all their rotary inertia, as one body."""
    steel = Material(E=YOUNG, nu=0.3, rho=DENSITY)
    beams = straight_beam(LENGTH, SolidCircle(DIAMETER), steel, elements=16, theory="euler-bernoulli")
    ends = {"root": kf.Interface(fixed=("x", "y", "z", "rx")), "tip": kf.Interface(fixed=("x", "y", "z", "rx"))}
    scene = kf.System()
    body = beam_body(beams, ends, reduction=kf.CraigBampton(modes=12))
    scene.add_flexible_body("shaft", body, joint=kf.Revolute("x", motion=kf.Motion.steady(spin)))
    return scene.freeze()


@pytest.mark.parametrize("spin", [50.0, 400.0, 600.0])
def test_slices_turn_by_finite_rotations(spin):
    """The closed form in the spinning frame: 12 slices miss it by 6e-7 at most, near the critical speed."""
    np.testing.assert_allclose(spin_eigenvalues(rayleigh_shaft(spin))[:2].imag, whirl(spin, 1.0), rtol=1e-6)


@pytest.mark.parametrize("spin", [400.0, 600.0])
def test_a_field_of_first_order_has_no_stiffening_by_tilted_sections(spin):
    """Mass, Coriolis and centrifugal terms of the beams are exact, the second-order tilt is not among them.

    Twelve modes bring the still shaft within 1e-6; near the critical speed the slow root feels that 20 times as much.
    """
    found = spin_eigenvalues(plain_shaft(spin))[:2].imag
    np.testing.assert_allclose(found, whirl(spin, 0.0), rtol=5e-5)
    assert np.abs(found / whirl(spin, 1.0) - 1.0).max() > 5e-4


def test_critical_speeds_are_where_the_slow_whirl_stands_still():
    critical = critical_speeds(rayleigh_shaft(0.0), rayleigh_shaft(300.0), 300.0)[0]
    assert critical == pytest.approx(math.sqrt(STIFFNESS / (A - B)), rel=1e-6)
    slow = [spin_eigenvalues(rayleigh_shaft(critical * factor))[0].imag for factor in (0.999, 1.001)]
    assert max(slow) < 0.002 * critical  # d w / d spin is about -1


def test_flat_shaft_has_the_two_frequencies():
    """Sixteen Hermite elements and eight modes: frequencies come out 3e-6 too high."""
    np.testing.assert_allclose(spin_eigenvalues(flat_shaft(0.0))[:2].imag, [100.0, 120.0], rtol=1e-5)


def unbalanced(speed: float, offset: float) -> kf.System:
    """Return the rotor of two discs, whose critical speeds are near 85 and 250 rad/s, with 0.1 kg off its axis."""
    scene = rotor_of_two_discs(speed)
    shaft = scene.body("shaft")
    scene.add_bushing("drive", scene.body("turning"), shaft.interface("left"), stiffness=(1e6, 0, 0, 1e4, 0, 0))
    disc = shaft.interface("one")
    scene.add_rigid_body("lump", 0.1, (1e-5, 1e-5, 1e-5), com=(0.0, offset, 0.0), parent=disc)
    return scene


@pytest.mark.parametrize("speed", [60.0, 150.0, 400.0])
def test_an_unbalanced_rotor_is_in_balance_beyond_its_critical_speeds(speed):
    """Bent as the balanced one is by the force of the unbalance, m e W^2, in the spinning frame.

    In oil that spins with it it would run away from its axis, beyond the valid range of its stiffening.
    """
    offset = 1e-5
    force = 0.1 * offset * speed**2
    small = kf.equilibrium(unbalanced(speed, 0.0)).linearise(inputs="force lump y", outputs="position lump y")
    expected = force * small.frequency_response([0.0]).response[0, 0, 0].real
    found = kf.equilibrium(unbalanced(speed, offset))
    # to first order in the bow: it is below 1e-6 of the length
    assert found.position("lump")[1] == pytest.approx(expected, rel=1e-4)
    assert found.linearise().modes().is_stable


def test_an_unbalanced_rotor_has_the_critical_speed_of_the_balanced_one():
    """Where it has no balance, being bowed without bound."""
    speeds = np.linspace(50.0, 150.0, 3)
    (expected,), found = (
        [one.speed for one in kf.campbell(lambda w, e=e: unbalanced(w, e), speeds, modes=1).critical_speeds(order=0.0)]
        for e in (0.0, 1e-6)
    )
    # the force that is left over, of 1e-6 of the length as lever, splits it by as little
    assert len(found) > 0
    np.testing.assert_allclose(found, expected, rtol=1e-5)
